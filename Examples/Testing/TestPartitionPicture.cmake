# SPDX-License-Identifier: BSD-3-Clause
# Installs the build, builds the example against the install tree, and looks at the picture it makes.
function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE "${WORK}")
run("${CMAKE_COMMAND}" --install "${BUILD}" --prefix "${WORK}/installed" --config "${CONFIGURATION}")
run("${CMAKE_COMMAND}" -S "${SOURCE}" -B "${WORK}/build" -G "${GENERATOR}"
  "-DCMAKE_PREFIX_PATH=${WORK}/installed" "-DCMAKE_BUILD_TYPE=${CONFIGURATION}"
  "-DCMAKE_CXX_COMPILER=${COMPILER}" "-DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}")
run("${CMAKE_COMMAND}" --build "${WORK}/build")
run("${PROBE}" make-mesh "${WORK}/sphere.ply")
run("${XVFB_RUN}" -a -s "-screen 0 1024x768x24 +extension GLX"
  "${WORK}/build/PartitionPicture" "${WORK}/sphere.ply" "${WORK}/picture.png")
run("${PROBE}" check-picture "${WORK}/picture.png" 7)
