# SPDX-License-Identifier: BSD-3-Clause
# Install rules: find_package(KdStream) works from an install tree. The targets themselves are installed where they are
# made; with VTK, vtk_module_build writes the file of all exported targets (KdStreamVtkModules.cmake).
include(CMakePackageConfigHelpers)

set(KDSTREAM_PACKAGE_FOLDER "${CMAKE_INSTALL_LIBDIR}/cmake/KdStream")
if(NOT KDSTREAM_BUILD_VTK)
  install(EXPORT KdStream NAMESPACE KdStream:: FILE KdStream-targets.cmake
    DESTINATION "${KDSTREAM_PACKAGE_FOLDER}")
endif()

# VTK components that exported targets link.
set(KDSTREAM_VTK_DEPENDENCIES
  "CommonCore CommonDataModel CommonExecutionModel CommonMisc IOCore IOImage ParallelCore RenderingCore RenderingOpenGL2 OPTIONAL_COMPONENTS glew")
configure_package_config_file(cmake/KdStreamConfig.cmake.in "${PROJECT_BINARY_DIR}/KdStreamConfig.cmake"
  INSTALL_DESTINATION "${KDSTREAM_PACKAGE_FOLDER}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/KdStreamConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/KdStreamConfig.cmake" "${PROJECT_BINARY_DIR}/KdStreamConfigVersion.cmake"
  DESTINATION "${KDSTREAM_PACKAGE_FOLDER}" COMPONENT development)

# The page, built elsewhere by the preset `web`; kdstream-serve finds it here (server/app).
if(KDSTREAM_WEB_BUILD)
  install(DIRECTORY "${KDSTREAM_WEB_BUILD}/page/" DESTINATION "${CMAKE_INSTALL_DATADIR}/kdstream/web")
endif()

install(FILES LICENSE DESTINATION "${CMAKE_INSTALL_DOCDIR}")
