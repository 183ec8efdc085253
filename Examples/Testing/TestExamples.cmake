# SPDX-License-Identifier: BSD-3-Clause
# Installs the build, builds the examples against the install tree, and looks at what they make.
function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# What a program says has to match.
function(expect pattern)
  execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY OUTPUT_VARIABLE said)
  if(NOT said MATCHES "${pattern}")
    message(FATAL_ERROR "'${said}' does not match '${pattern}'")
  endif()
endfunction()

file(REMOVE_RECURSE "${WORK}")
run("${CMAKE_COMMAND}" --install "${BUILD}" --prefix "${WORK}/installed" --config "${CONFIGURATION}")
foreach(example IN ITEMS PartitionPicture Stores StreamViewer Testing/Snippets)
  run("${CMAKE_COMMAND}" -S "${SOURCE}/${example}" -B "${WORK}/${example}" -G "${GENERATOR}"
    "-DCMAKE_PREFIX_PATH=${WORK}/installed" "-DCMAKE_BUILD_TYPE=${CONFIGURATION}"
    "-DCMAKE_CXX_COMPILER=${COMPILER}" "-DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}" "-DROOT=${SOURCE}/..")
  run("${CMAKE_COMMAND}" --build "${WORK}/${example}")
endforeach()
set(screen "${XVFB_RUN}" -a -s "-screen 0 1024x768x24 +extension GLX")

run("${PROBE}" make-mesh "${WORK}/sphere.ply")
run(${screen} "${WORK}/PartitionPicture/PartitionPicture" "${WORK}/sphere.ply" "${WORK}/partitions.png")
run("${PROBE}" check-picture "${WORK}/partitions.png" 7)

expect("^29602 points, 59200 triangles" "${WORK}/Stores/MeshInfo" "${WORK}/sphere.ply")
file(MAKE_DIRECTORY "${WORK}/models")
run("${WORK}/Stores/MakeStore" "${WORK}/models/sphere.kds")
foreach(pieces IN ITEMS 1 4)
  expect("\n238400 triangles" "${WORK}/Stores/StoreGhosts" "${WORK}/models/sphere.kds" ${pieces})
endforeach()
run(sh "${CMAKE_CURRENT_LIST_DIR}/with-server" "${WORK}/installed/bin/kdstream-serve" "${WORK}/models"
  ${screen} "${WORK}/Stores/StreamPicture" URL "${WORK}/stream.png")
run("${PROBE}" check-picture "${WORK}/stream.png" 1)
foreach(source IN ITEMS URL "${WORK}/models/sphere.kds")
  run(sh "${CMAKE_CURRENT_LIST_DIR}/with-server" "${WORK}/installed/bin/kdstream-serve" "${WORK}/models"
    ${screen} "${WORK}/StreamViewer/StreamPictures" ${source} "${WORK}/preview.png" "${WORK}/whole.png")
  run("${PROBE}" check-picture "${WORK}/whole.png" 1)
endforeach()
