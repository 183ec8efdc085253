# SPDX-License-Identifier: BSD-3-Clause
# Functions that TestInstall and TestExamples share.
function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

function(run_in folder)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY "${folder}" COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# Runs a program; its output must match the pattern.
function(expect pattern)
  execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY OUTPUT_VARIABLE said)
  if(NOT said MATCHES "${pattern}")
    message(FATAL_ERROR "'${said}' does not match '${pattern}'")
  endif()
endfunction()

# Configures and builds the project in `source` against an installed KdStream.
function(configure_against prefix source build)
  run("${CMAKE_COMMAND}" -S "${source}" -B "${build}" -G "${GENERATOR}"
    "-DCMAKE_PREFIX_PATH=${prefix}" "-DCMAKE_BUILD_TYPE=${CONFIGURATION}"
    "-DCMAKE_CXX_COMPILER=${COMPILER}" "-DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}" ${ARGN})
  run("${CMAKE_COMMAND}" --build "${build}")
endfunction()

# Checks what LD_DEBUG=bindings has written in `folder`: our libraries and programs bind only to symbols that another of
# our libraries exports, never to a copy that a program happens to contain.
function(check_bindings folder)
  file(GLOB told "${folder}/bindings.*")
  if(NOT told)
    message(FATAL_ERROR "LD_DEBUG told nothing in ${folder}")
  endif()
  foreach(file IN LISTS told)
    file(STRINGS "${file}" lines REGEX "binding file .* to [^ ]*(libkdstream|libvtkKdStream|/kdstream-|/mixed)")
    foreach(line IN LISTS lines)
      string(REGEX MATCH "binding file ([^ ]+) .* to ([^ ]+) .*symbol `([^']+)'" line "${line}")
      set(from "${CMAKE_MATCH_1}")
      set(to "${CMAKE_MATCH_2}")
      set(symbol "${CMAKE_MATCH_3}")
      if(NOT from MATCHES "libkdstream|libvtkKdStream|/kdstream-|/mixed" OR from STREQUAL to)
        continue()
      elseif(to MATCHES "libkdstream\\.|libvtkKdStream" AND symbol MATCHES "^_Z(N|NK|TV|TVN|TI|TIN|TS|TSN)(8kdstream|[0-9]+vtk)")
        continue()
      elseif(NOT to MATCHES "\\.so" AND NOT symbol MATCHES "kdstream|vtkKd|boost|4asio")
        continue() # data of system libraries that the linker has copied into the program
      endif()
      message(FATAL_ERROR "${from} binds ${symbol} to ${to}")
    endforeach()
  endforeach()
endfunction()
