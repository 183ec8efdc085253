# SPDX-License-Identifier: BSD-3-Clause
# Plays RECORDING.recording by the native or the web build's ReplaySession and compares the trace with what must be the
# same: natively, with the trace of the recording itself; of WebAssembly, with a native replay of the same moment.
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
