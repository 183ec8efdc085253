# SPDX-License-Identifier: BSD-3-Clause
# The VTK modules: scanned, built and exported with everything else as KdStream::<name>. A module lives in a folder
# with a vtk.module; its tests in Testing/Cxx.

# A picture test, a program with a main of its own that compares with ../Data/Baseline/<name>.png. Compiled as C++17, as
# users of the modules may. It runs in an X server of its own, with Mesa's software renderer.
# kdstream_add_picture_test(TestName LINK …)
function(kdstream_add_picture_test name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "LINK")
  find_program(KDSTREAM_XVFB_RUN xvfb-run REQUIRED)
  add_executable(${name} ${name}.cxx)
  kdstream_configure_target(${name} FEATURES PRIVATE cxx_std_17)
  target_include_directories(${name} PRIVATE "${PROJECT_SOURCE_DIR}")
  target_link_libraries(${name} PRIVATE ${arg_LINK} VTK::TestingRendering)
  vtk_module_autoinit(TARGETS ${name} MODULES VTK::RenderingOpenGL2)
  set(temporary "${CMAKE_BINARY_DIR}/Testing/Temporary")
  file(MAKE_DIRECTORY "${temporary}")
  add_test(NAME ${name} COMMAND "${KDSTREAM_XVFB_RUN}" -a -s "-screen 0 1024x768x24 +extension GLX"
    $<TARGET_FILE:${name}> -D "${CMAKE_CURRENT_SOURCE_DIR}/../Data" -T "${temporary}"
    -V "${CMAKE_CURRENT_SOURCE_DIR}/../Data/Baseline/${name}.png")
  set_tests_properties(${name} PROPERTIES LABELS render ENVIRONMENT "LIBGL_ALWAYS_SOFTWARE=1")
endfunction()

set(modules filters/Partitioning filters/Simplification)
set(requested KdStream::FiltersPartitioning KdStream::FiltersSimplification)
if(KDSTREAM_BUILD_TOOLS)
  list(APPEND modules filters/IO)
  list(APPEND requested KdStream::FiltersIO)
endif()
if(KDSTREAM_BUILD_TOOLS AND KDSTREAM_BUILD_SERVER)
  list(APPEND modules viewer/sources viewer/actor)
  list(APPEND requested KdStream::ViewerSources KdStream::ViewerActor)
endif()
if(KDSTREAM_PCL_VERSION)
  list(APPEND modules filters/PointCloud)
  list(APPEND requested KdStream::FiltersPointCloud)
endif()
list(TRANSFORM modules PREPEND "${PROJECT_SOURCE_DIR}/")
list(TRANSFORM modules APPEND /vtk.module OUTPUT_VARIABLE files)
vtk_module_scan(
  MODULE_FILES ${files}
  REQUEST_MODULES ${requested}
  PROVIDES_MODULES provided
  ENABLE_TESTS OFF)
# INSTALL_EXPORT: the export set of all other libraries, so that this call installs and exports them too.
vtk_module_build(
  MODULES ${provided}
  PACKAGE KdStream
  INSTALL_EXPORT KdStream
  INSTALL_HEADERS ON
  HEADERS_DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/kdstream/vtk"
  CMAKE_DESTINATION "${CMAKE_INSTALL_LIBDIR}/cmake/KdStream"
  TEST_DIRECTORY_NAME NONE
  ENABLE_WRAPPING OFF)

if(KDSTREAM_BUILD_TESTING)
  foreach(module IN LISTS modules)
    add_subdirectory("${module}/Testing/Cxx")
  endforeach()
endif()
