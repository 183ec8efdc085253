# SPDX-License-Identifier: BSD-3-Clause
# Builds the examples against the installation that TestInstall has made, and checks their output.
include("${CMAKE_CURRENT_LIST_DIR}/Expect.cmake")

foreach(example IN ITEMS PartitionPicture Stores Classes ClassPictures Offscreen StreamViewer Testing/Snippets)
  file(REMOVE_RECURSE "${WORK}/${example}")
  configure_against("${WORK}/installed" "${SOURCE}/${example}" "${WORK}/${example}")
endforeach()

# The tutorial's project as it stands, with the source file that it names.
file(READ "${SOURCE}/../doc/tutorials/filters-in-a-pipeline.md" text)
string(REPLACE ";" "<semicolon>" text "${text}")
if(NOT text MATCHES "\n```cmake\n([^`]*)```")
  message(FATAL_ERROR "doc/tutorials/filters-in-a-pipeline.md has no CMake any more")
endif()
string(REPLACE "<semicolon>" ";" commands "${CMAKE_MATCH_1}")
file(REMOVE_RECURSE "${WORK}/Tutorial")
file(WRITE "${WORK}/Tutorial/CMakeLists.txt" "${commands}")
file(COPY "${SOURCE}/Classes/Coarsen.cxx" DESTINATION "${WORK}/Tutorial")
configure_against("${WORK}/installed" "${WORK}/Tutorial" "${WORK}/Tutorial/build")
set(screen "${XVFB_RUN}" -a -s "-screen 0 1024x768x24 +extension GLX")

run("${PROBE}" make-mesh "${WORK}/sphere.ply")
run(${screen} "${WORK}/PartitionPicture/PartitionPicture" "${WORK}/sphere.ply" "${WORK}/partitions.png")
run("${PROBE}" check-picture "${WORK}/partitions.png" 7)
# The same program without a screen.
run("${CMAKE_COMMAND}" -E env --unset=DISPLAY KDSTREAM_OFFSCREEN=auto
  "${WORK}/PartitionPicture/PartitionPicture" "${WORK}/sphere.ply" "${WORK}/without-screen.png")
run("${PROBE}" check-picture "${WORK}/without-screen.png" 7)

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

expect("^k-d tree 16 1850 1851 " "${WORK}/Classes/ComparePartitions" "${WORK}/sphere.ply")
expect("^(19[0-9][0-9]|20[0-9][0-9]) triangles" "${WORK}/Classes/Coarsen" "${WORK}/sphere.ply" "${WORK}/coarse.ply" 2000)
run("${BUILD}/bin/kdstream-generate" statue "${WORK}/statue.obj" --vertices 3000 --picture-side 64 --quiet)
run("${WORK}/installed/bin/kdstream-build" "${WORK}/statue.obj" -o "${WORK}/statue.kds" --quiet)
expect("^[0-9]+ triangles, a picture of [0-9]+ x" "${WORK}/Classes/TexturedPartition" "${WORK}/statue.kds" 0)
if(EXISTS "${WORK}/Classes/PointsToSurface")
  expect("^[0-9]+ triangles" "${WORK}/Classes/PointsToSurface" "${WORK}/coarse.ply" "${WORK}/surface.ply")
endif()

# Without a screen: runs the example's own tests, with each backend. A test whose baseline is a different picture must
# fail, and say so.
run("${CTEST}" --test-dir "${WORK}/Offscreen" --output-on-failure)
run("${PROBE}" make-picture "${WORK}/grey.png" 300)
run("${CMAKE_COMMAND}" -S "${SOURCE}/Offscreen" -B "${WORK}/Offscreen" "-DBASELINE=${WORK}/grey.png")
execute_process(COMMAND "${CTEST}" --test-dir "${WORK}/Offscreen" --output-on-failure RESULT_VARIABLE status OUTPUT_VARIABLE said)
if(status EQUAL 0 OR NOT said MATCHES "difference: [^\n]*/pictures/SpherePicture.difference.png"
    OR NOT EXISTS "${WORK}/Offscreen/pictures/SpherePicture.difference.png")
  message(FATAL_ERROR "a wrong picture: ${status}\n${said}")
endif()

# The program that compares pictures ignores alpha, and refuses pictures that it cannot compare.
foreach(components IN ITEMS 1 3 4)
  run("${PROBE}" make-picture "${WORK}/grey${components}.png" 300 ${components})
endforeach()
function(expect_comparison status pattern picture baseline tolerance)
  execute_process(COMMAND "${WORK}/installed/${LIBDIR}/kdstream/kdstream_compare_pictures" "${WORK}/${picture}" "${WORK}/${baseline}"
    "${tolerance}" "${WORK}/comparison.difference.png" RESULT_VARIABLE was OUTPUT_VARIABLE said ERROR_VARIABLE said COMMAND_ECHO STDOUT)
  if(NOT was EQUAL status OR NOT said MATCHES "${pattern}")
    message(FATAL_ERROR "${was}, not ${status}; '${said}', not '${pattern}'")
  endif()
endfunction()
foreach(components IN ITEMS 3 4)
  expect_comparison(0 "differs by 0 " grey4.png grey${components}.png 0)
  expect_comparison(1 "is not an 8-bit RGB or RGBA picture: it has 1 components of unsigned char" grey${components}.png grey1.png 1000)
endforeach()
expect_comparison(1 "is not an 8-bit RGB" grey1.png grey1.png 1000)
foreach(tolerance IN ITEMS ten 10x -1 nan "")
  expect_comparison(2 "tolerance must be a number" grey3.png grey3.png "${tolerance}")
endforeach()
