# SPDX-License-Identifier: BSD-3-Clause
# For programs that draw without a screen, and tests of their pictures. find_package(KdStream COMPONENTS
# ViewerOffscreen) includes this file (doc/offscreen.md).

# kdstream_enable_offscreen(target): lets an executable make off-screen windows (vtkKdOffscreenRendering), and use the
# environment variable KDSTREAM_OFFSCREEN.
#
# If VTK only knows GLX windows, this links the OpenGL symbols of GlSymbols.cxx into the executable and exports them, so
# that they take precedence over those of the shared libraries (that file explains why). The order of libraries on the
# link line does not matter, because EGL and OSMesa are only opened when the program runs.
function(kdstream_enable_offscreen target)
  get_target_property(type ${target} TYPE)
  if(NOT type STREQUAL "EXECUTABLE")
    message(FATAL_ERROR "kdstream_enable_offscreen(${target}): ${target} is not an executable, which decides whose OpenGL a process calls: "
      "name the executable that links it")
  endif()
  target_sources(${target} PRIVATE $<TARGET_OBJECTS:KdStream::offscreen_start>)
  target_link_libraries(${target} PRIVATE KdStream::ViewerOffscreen)
  target_link_options(${target} PRIVATE "LINKER:--export-dynamic-symbol=gl*")
endfunction()

# kdstream_add_picture_test(NAME test TARGET program BASELINE picture.png [ARGUMENTS argument…] [TOLERANCE 10]
#   [BACKEND auto])
# Adds a test that runs `program`, which writes a picture (PNG), and compares the picture with the baseline. The
# picture's path replaces the argument @PICTURE@ or, if there is none, is the last argument. The program must have been
# given to kdstream_enable_offscreen. Mesa's software renderer draws, so that pictures are the same everywhere.
# TOLERANCE is compared with the thresholded error of vtkImageDifference. The picture and the difference stay in
# pictures/ of the build folder. If the test fails, its message names them, and the command that makes a first or
# changed picture the new baseline.
set(_KDSTREAM_PICTURE_TEST "${CMAKE_CURRENT_LIST_DIR}/KdStreamPictureTest.cmake")
function(kdstream_add_picture_test)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "NAME;TARGET;BASELINE;TOLERANCE;BACKEND" "ARGUMENTS")
  foreach(needed IN ITEMS NAME TARGET BASELINE)
    if(NOT arg_${needed})
      message(FATAL_ERROR "kdstream_add_picture_test needs ${needed}")
    endif()
  endforeach()
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "kdstream_add_picture_test(${arg_NAME}): ${arg_UNPARSED_ARGUMENTS} is not understood")
  endif()
  if(NOT DEFINED arg_TOLERANCE)
    set(arg_TOLERANCE 10)
  endif()
  if(NOT arg_BACKEND)
    set(arg_BACKEND auto)
  endif()
  if(NOT arg_ARGUMENTS MATCHES "@PICTURE@")
    list(APPEND arg_ARGUMENTS "@PICTURE@")
  endif()
  cmake_path(ABSOLUTE_PATH arg_BASELINE)
  set(picture "${CMAKE_CURRENT_BINARY_DIR}/pictures/${arg_NAME}.png")
  list(TRANSFORM arg_ARGUMENTS REPLACE "@PICTURE@" "${picture}")
  add_test(NAME ${arg_NAME} COMMAND "${CMAKE_COMMAND}"
    -D "PICTURE=${picture}" -D "BASELINE=${arg_BASELINE}" -D "TOLERANCE=${arg_TOLERANCE}"
    -D "COMPARE=$<TARGET_FILE:KdStream::compare_pictures>"
    -P "${_KDSTREAM_PICTURE_TEST}" -- $<TARGET_FILE:${arg_TARGET}> ${arg_ARGUMENTS})
  set_tests_properties(${arg_NAME} PROPERTIES LABELS render
    ENVIRONMENT "KDSTREAM_OFFSCREEN=${arg_BACKEND};LIBGL_ALWAYS_SOFTWARE=1")
endfunction()
