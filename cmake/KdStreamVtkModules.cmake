# SPDX-License-Identifier: BSD-3-Clause
# The VTK modules: found, built and exported with everything else as KdStream::<name>. A module is a folder with a
# vtk.module; its tests are in Testing/Cxx.

# Adds a picture test: a program of one source that writes a picture to the file that it is given. The picture is
# compared with ../Data/Baseline/<name>.png, as users' pictures are (viewer/offscreen/KdStreamOffscreen.cmake). It is
# compiled as C++17, because users of the modules may use that.
# kdstream_add_module_picture(TestName LINK …)
function(kdstream_add_module_picture name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "LINK")
  add_executable(${name} ${name}.cxx)
  kdstream_configure_target(${name} FEATURES PRIVATE cxx_std_17)
  target_include_directories(${name} PRIVATE "${PROJECT_SOURCE_DIR}")
  target_link_libraries(${name} PRIVATE ${arg_LINK} VTK::IOImage VTK::RenderingCore VTK::RenderingOpenGL2)
  vtk_module_autoinit(TARGETS ${name} MODULES VTK::RenderingOpenGL2)
  kdstream_enable_offscreen(${name})
  kdstream_add_picture_test(NAME ${name} TARGET ${name} BASELINE "${CMAKE_CURRENT_SOURCE_DIR}/../Data/Baseline/${name}.png")
endfunction()

set(modules filters/Partitioning filters/Simplification viewer/offscreen)
set(requested KdStream::FiltersPartitioning KdStream::FiltersSimplification KdStream::ViewerOffscreen)
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
# INSTALL_EXPORT is the export set of all other libraries, so this call installs and exports them, too.
vtk_module_build(
  MODULES ${provided}
  PACKAGE KdStream
  VERSION "${PROJECT_VERSION}"
  SOVERSION "${KDSTREAM_SOVERSION}"
  INSTALL_EXPORT KdStream
  INSTALL_HEADERS ON
  HEADERS_COMPONENT development
  TARGETS_COMPONENT libraries
  HEADERS_DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/kdstream/vtk"
  CMAKE_DESTINATION "${CMAKE_INSTALL_LIBDIR}/cmake/KdStream"
  TEST_DIRECTORY_NAME NONE
  ENABLE_WRAPPING OFF)

include("${PROJECT_SOURCE_DIR}/viewer/offscreen/KdStreamOffscreen.cmake")
if(KDSTREAM_BUILD_TESTING)
  foreach(module IN LISTS modules)
    add_subdirectory("${module}/Testing/Cxx")
  endforeach()
endif()
