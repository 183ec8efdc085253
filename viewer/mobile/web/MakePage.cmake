# SPDX-License-Identifier: BSD-3-Clause
# Puts the page of the folder SOURCE and the WebAssembly of the folder PARTS into the folder PAGE, compresses each file,
# prints their sizes, and fails where they are more than MOST_BYTES together, or those that a phone must fetch before it sees anything than MOST_FIRST.
# What page.js imports becomes one file with it: each file costs a slow network a round trip. What it fetches later is a
# file each, and imports page.js for what both use.
cmake_policy(VERSION 3.25)

function(pad text width result)
  string(LENGTH "${text}" length)
  math(EXPR missing "${width} - ${length}")
  string(REPEAT " " ${missing} spaces)
  set(${result} "${spaces}${text}" PARENT_SCOPE)
endfunction()

function(print_row name raw compressed)
  pad("${raw}" 9 raw)
  pad("${compressed}" 9 compressed)
  message("${raw} ${compressed}  ${name}")
endfunction()

# Comments and indentation stay at home.
function(copy_stripped name)
  file(READ "${SOURCE}/${name}" text)
  string(REGEX REPLACE "\n[ ]+" "\n" text "\n${text}")
  string(REGEX REPLACE "\n\n+" "\n" text "${text}")
  string(REGEX REPLACE "^\n" "" text "${text}")
  file(WRITE "${PAGE}/${name}" "${text}")
endfunction()

function(minify name)
  # es2022: what browsers with WebGL 2 and bulk memory have.
  execute_process(COMMAND "${ESBUILD}" "${SOURCE}/${name}" --bundle --minify --format=esm --target=es2022 --charset=utf8
    --legal-comments=none --log-level=warning ${ARGN} "--outfile=${PAGE}/${name}" COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE "${PAGE}")
file(MAKE_DIRECTORY "${PAGE}")
file(COPY "${PARTS}/kdstream.wasm" "${PARTS}/kdstream-more.wasm" DESTINATION "${PAGE}" NO_SOURCE_PERMISSIONS)
file(SIZE "${PAGE}/kdstream.wasm" first_bytes)
file(SIZE "${PAGE}/kdstream-more.wasm" rest_bytes)
copy_stripped(index.html)
minify(style.css)
# Fetched when they are first used, or after the first picture.
set(later tools.js notes.js gallery.js legend.js offline.js about.js access.js embedding.js words/de.js words/ar.js)
list(TRANSFORM later PREPEND "--external:./" OUTPUT_VARIABLE externals)
minify(page.js "--define:viewerBytes=${first_bytes}" "--define:restBytes=${rest_bytes}" ${externals})
foreach(name IN LISTS later)
  minify(${name} --external:./page.js)
endforeach()
minify(tools.css)
minify(notes.css)
# For other pages, whose script it is.
execute_process(COMMAND "${ESBUILD}" "${SOURCE}/embed.js" --minify --target=es2022 --charset=utf8 --legal-comments=none
  "--outfile=${PAGE}/embed.js" --log-level=warning COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND "${ZOPFLI}" "${PAGE}/embed.js" COMMAND_ERROR_IS_FATAL ANY)

file(COPY "${SOURCE}/icon.svg" "${SOURCE}/icon.png" "${SOURCE}/manifest.webmanifest" DESTINATION "${PAGE}" NO_SOURCE_PERMISSIONS)

# The service worker knows all the others by their digests, and so is another one whenever any of them is.
set(first index.html style.css page.js kdstream.wasm)
set(files ${first} kdstream-more.wasm ${later} tools.css notes.css icon.svg icon.png manifest.webmanifest)
set(digests)
foreach(name IN LISTS files)
  file(SHA256 "${PAGE}/${name}" digest)
  list(APPEND digests "\"${name}\":\"${digest}\"")
endforeach()
list(JOIN digests "," digests)
string(SHA256 version "${digests}")
string(SUBSTRING "${version}" 0 16 version)
minify(worker.js "--define:pageVersion=\"${version}\"" "--define:pageFiles={${digests}}")

set(sum 0)
set(sum_compressed 0)
set(sum_first 0)
print_row("the page" "bytes" "gzipped")
foreach(name IN LISTS files ITEMS worker.js)
  execute_process(COMMAND "${ZOPFLI}" "${PAGE}/${name}" COMMAND_ERROR_IS_FATAL ANY)
  file(SIZE "${PAGE}/${name}" raw)
  file(SIZE "${PAGE}/${name}.gz" compressed)
  math(EXPR sum "${sum} + ${raw}")
  math(EXPR sum_compressed "${sum_compressed} + ${compressed}")
  if(name IN_LIST first)
    math(EXPR sum_first "${sum_first} + ${compressed}")
  endif()
  print_row("${name}" ${raw} ${compressed})
endforeach()
print_row("together" ${sum} ${sum_compressed})
message("                    ${sum_first} of them before the first picture")
if(sum_first GREATER MOST_FIRST)
  message(FATAL_ERROR "Before the first picture ${sum_first} bytes come, gzipped; it may be ${MOST_FIRST} (KDSTREAM_MOST_FIRST_BYTES)")
endif()
if(sum_compressed GREATER MOST_BYTES)
  message(FATAL_ERROR "The page has ${sum_compressed} bytes, gzipped; it may have ${MOST_BYTES} (KDSTREAM_MOST_PAGE_BYTES)")
endif()
file(TOUCH "${PAGE}/../page.stamp")
