# SPDX-License-Identifier: BSD-3-Clause
# Splits WASM, a module with the linker's names of functions, in two: FIRST has the functions that are needed until
# there is a picture; MORE has the rest, needs FIRST, and is fetched after it (parts.js). MORE gets the functions that
# the file LATER names, and all functions that only those call. A function that LATER does not name is in FIRST: that
# costs bytes, but nothing fails.
#
# With the compiler that LATER was written for (COMPILER_VERSION below 16: Debian 12), each function that it names must
# exist. Other compilers may merge other functions with their callers; a warning names these, and they only cost bytes.
# At -Oz, em++ has the compiler merge no function with its caller. In folders that are compiled for speed (filters/core,
# filters/codec), -force-attribute forbids it for the two functions there that LATER names.
#
# 1. Split off the functions that LATER names, and drop those that nothing else calls.
# 2. What is left becomes the first part; the whole module is split again accordingly.
#
# Each part calls the other under a name that is a digest of both, so parts of different builds do not link. This needs
# Debian's binaryen: wasm-opt, wasm-split, wasm-metadce.
cmake_policy(VERSION 3.25)
get_filename_component(work "${FIRST}" DIRECTORY)
file(MAKE_DIRECTORY "${work}")

set(features --enable-bulk-memory --enable-mutable-globals)

function(run program)
  execute_process(COMMAND ${program} ${features} ${ARGN} WORKING_DIRECTORY "${work}" OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# Returns the names of a module's functions as a list.
function(read_names wasm result)
  run(wasm-opt "${wasm}" -q "--symbolmap=names.txt" -o names.wasm)
  file(STRINGS "${work}/names.txt" names)
  list(TRANSFORM names REPLACE "^[0-9]+:" "")
  set(${result} "${names}" PARENT_SCOPE)
endfunction()

# Makes a pattern of mangled names. "kdstream::ShownSection" is a class, meaning all its members, or a function. Names
# of exported functions are used as they are.
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

# The functions that the page calls by their names; other exports are for the second part.
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

# Functions without a name (which later versions of binaryen make) have numbers that change in each step; they stay,
# too.
read_names(kept.wasm kept)
set(more ${all})
list(FILTER more EXCLUDE REGEX "^[0-9]+$")
list(REMOVE_ITEM more ${kept})
list(JOIN more "\n" lines)
file(WRITE "${work}/more.txt" "${lines}\n")
run(${split} --split-funcs=@more.txt -o1 first.wasm -o2 more.wasm)
# The linker must not inline functions for their only caller, which may be in the other part; now this is allowed. The
# second -Oz shrinks what the first has inlined.
run(wasm-opt first.wasm -q -Oz -Oz -o "${FIRST}")
run(wasm-opt more.wasm -q -Oz -Oz -o "${MORE}")
