# SPDX-License-Identifier: BSD-3-Clause
# Parts WASM, which has the linker's names of its functions, in two: FIRST has what runs until there is a picture, MORE the
# rest, which needs the first and is fetched after it (parts.js). To MORE go the functions that LATER, a file, names, and
# what nothing else calls. So a function that LATER does not know is in FIRST: that costs bytes, not more.
#
# Each of them must be there still for the compiler that the file was written for (COMPILER_VERSION below 16: Debian 12).
# Other compilers merge other functions with their callers: what they merged is named by a warning, and costs bytes only.
# At -Oz em++ has the compiler merge no function with its caller; where it compiles for
# speed (filters/core, filters/codec) -force-attribute says so of the two that LATER names.
#
# 1. Part off what LATER names, and drop what is called by nothing else.
# 2. What is left stays in the first part; the whole is parted anew by that.
#
# Each part tells by the name it calls the other by, a digest of both, that they belong together: others do not link.
# Needs Debian's binaryen: wasm-opt, wasm-split, wasm-metadce.
cmake_policy(VERSION 3.25)
get_filename_component(work "${FIRST}" DIRECTORY)
file(MAKE_DIRECTORY "${work}")

set(features --enable-bulk-memory --enable-mutable-globals)

function(run program)
  execute_process(COMMAND ${program} ${features} ${ARGN} WORKING_DIRECTORY "${work}" OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# The names of a module's functions, a list.
function(read_names wasm result)
  run(wasm-opt "${wasm}" -q "--symbolmap=names.txt" -o names.wasm)
  file(STRINGS "${work}/names.txt" names)
  list(TRANSFORM names REPLACE "^[0-9]+:" "")
  set(${result} "${names}" PARENT_SCOPE)
endfunction()

# "kdstream::ShownSection" is a class, all of whose members it means, or a function: as a pattern of mangled names. What is
# exported is written as it is.
function(to_pattern name result)
  if(NOT name MATCHES "::")
    set(${result} "^${name}$" PARENT_SCOPE)
    return()
  endif()
  string(REPLACE "(anonymous)" "_GLOBAL__N_1" name "${name}")
  string(REPLACE "::" ";" parts "${name}")
  set(pattern "^_ZZ?NK?")
  foreach(part IN LISTS parts)
    string(LENGTH "${part}" length)
    string(APPEND pattern "${length}${part}")
  endforeach()
  set(${result} "${pattern}" PARENT_SCOPE)
endfunction()

read_names("${WASM}" all)
set(later)
set(missing)
file(STRINGS "${LATER}" lines REGEX "^[^#]")
foreach(line IN LISTS lines)
  to_pattern("${line}" pattern)
  set(found ${all})
  list(FILTER found INCLUDE REGEX "${pattern}")
  if(NOT found)
    list(APPEND missing "${line}")
  endif()
  list(APPEND later ${found})
endforeach()

if(missing)
  list(JOIN missing ", " names)
  set(kind FATAL_ERROR)
  if(COMPILER_VERSION VERSION_GREATER_EQUAL 16)
    set(kind WARNING)
  endif()
  message(${kind} "${LATER}: ${WASM} has no ${names}: it has another name now, or the compiler merges it with its caller")
endif()

file(SHA256 "${WASM}" digest)
file(SHA256 "${LATER}" digest_of_later)
string(SHA256 digest "${digest}${digest_of_later}")
string(SUBSTRING "${digest}" 0 8 namespace)
set(split wasm-split "${WASM}" "--placeholder-namespace=${namespace}" "--import-namespace=${namespace}" --export-prefix=%)

list(JOIN later "\n" lines)
file(WRITE "${work}/later.txt" "${lines}\n")
run(${split} -g --split-funcs=@later.txt -o1 probe.wasm -o2 probe-more.wasm)

# What the page calls, by its name; what else is exported is for the second part.
set(called ${all})
list(FILTER called INCLUDE REGEX "^(Viewer[A-Z]|_initialize$)")
set(graph)
set(reached)
foreach(name IN LISTS called ITEMS memory __indirect_function_table)
  list(APPEND graph "{\"name\":\"${name}\",\"export\":\"${name}\"}")
  list(APPEND reached "\"${name}\"")
endforeach()
list(JOIN graph "," graph)
list(JOIN reached "," reached)
file(WRITE "${work}/graph.json" "[{\"name\":\"page\",\"root\":true,\"reaches\":[${reached}]},${graph}]")
run(wasm-metadce probe.wasm -q -g -f graph.json -o kept.wasm)

# What has no name, but a number that changes with each step (functions that later versions of binaryen make), stays too.
read_names(kept.wasm kept)
set(more ${all})
list(FILTER more EXCLUDE REGEX "^[0-9]+$")
list(REMOVE_ITEM more ${kept})
list(JOIN more "\n" lines)
file(WRITE "${work}/more.txt" "${lines}\n")
run(${split} --split-funcs=@more.txt -o1 first.wasm -o2 more.wasm)
# The linker inlines nothing for its only caller, which may be in the other part; now it may be done. The second time makes
# smaller what the first has inlined.
run(wasm-opt first.wasm -q -Oz -Oz -o "${FIRST}")
run(wasm-opt more.wasm -q -Oz -Oz -o "${MORE}")
