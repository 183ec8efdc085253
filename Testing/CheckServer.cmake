# SPDX-License-Identifier: BSD-3-Clause
# Checks that a server contains no code that builds: no function of the builders' and readers' libraries is in it. Run
# with -D NM=<nm> -D SERVER=<kdstream-serve> -D LIBRARIES=<archives, a list>.
cmake_minimum_required(VERSION 3.25)

# The names of the functions that a file defines itself (without inline functions, which many files define).
function(functions_of file result)
  execute_process(COMMAND "${NM}" --defined-only "${file}" OUTPUT_VARIABLE symbols ERROR_QUIET COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCHALL " T _Z[A-Za-z0-9_]+" functions "${symbols}")
  set(${result} "${functions}" PARENT_SCOPE)
endfunction()

functions_of("${SERVER}" inServer)
list(LENGTH inServer count)
if(count LESS 100)
  message(FATAL_ERROR "${SERVER}: only ${count} functions found; is it stripped?")
endif()
set(problems "")
foreach(library IN LISTS LIBRARIES)
  functions_of("${library}" inLibrary)
  list(LENGTH inLibrary count)
  if(count LESS 5)
    list(APPEND problems "${library}: only ${count} functions found")
  endif()
  foreach(function IN LISTS inLibrary)
    if(function IN_LIST inServer)
      list(APPEND problems "${library}: ${function} is in the server")
    endif()
  endforeach()
endforeach()
if(problems)
  list(JOIN problems "\n" text)
  message(FATAL_ERROR "${text}")
endif()
