# SPDX-License-Identifier: BSD-3-Clause
# Plays RECORDING.recording with the ReplaySession of the native build or of the web build, and compares traces, which
# must be the same. A native trace is compared with that of the recording itself; a trace of WebAssembly, with that of a
# native replay made at the same time.
function(replay trace)
  execute_process(COMMAND ${ARGN} "${RECORDING}.recording" "${trace}" RESULT_VARIABLE code)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "the replay ended with ${code}: ${ARGN} ${RECORDING}.recording")
  endif()
endfunction()

if(BUILD STREQUAL "web")
  set(expected "${RECORDING}.native-for-web")
  replay("${expected}" "${REPLAY}")
  replay("${RECORDING}.web" "${NODE}" --no-experimental-fetch "${WEB_REPLAY}")
else()
  set(expected "${RECORDING}.trace")
  replay("${RECORDING}.native" "${REPLAY}")
endif()
execute_process(COMMAND "${REPLAY}" --compare "${expected}" "${RECORDING}.${BUILD}" RESULT_VARIABLE code)
if(NOT code EQUAL 0)
  message(FATAL_ERROR "the traces differ")
endif()
