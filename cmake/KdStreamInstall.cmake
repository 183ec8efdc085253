# SPDX-License-Identifier: BSD-3-Clause
# Install rules: find_package(KdStream) works from an install tree. The targets themselves are installed where they are
# defined. With VTK, vtk_module_build writes the file with all exported targets (KdStreamVtkModules.cmake).
include(CMakePackageConfigHelpers)

set(KDSTREAM_PACKAGE_FOLDER "${CMAKE_INSTALL_LIBDIR}/cmake/KdStream")
if(NOT KDSTREAM_BUILD_VTK)
  install(EXPORT KdStream NAMESPACE KdStream:: FILE KdStream-targets.cmake
    DESTINATION "${KDSTREAM_PACKAGE_FOLDER}" COMPONENT development)
endif()

# The components of find_package, and why a component is missing.
get_property(KDSTREAM_INSTALLED_LIBRARIES GLOBAL PROPERTY KDSTREAM_LIBRARIES)
list(TRANSFORM KDSTREAM_INSTALLED_LIBRARIES REPLACE "^kdstream_" "")
list(JOIN KDSTREAM_INSTALLED_LIBRARIES " " KDSTREAM_INSTALLED_LIBRARIES)
set(KDSTREAM_INSTALLED_MODULES "")
set(KDSTREAM_MISSING_COMPONENTS "")
function(kdstream_component name)
  if(KDSTREAM_BUILD_VTK AND TARGET KdStream::${name})
    set(KDSTREAM_INSTALLED_MODULES "${KDSTREAM_INSTALLED_MODULES} ${name}" PARENT_SCOPE)
    return()
  endif()
  set(reason "")
  foreach(option IN LISTS ARGN)
    if(NOT ${option})
      set(reason "this KdStream was built with ${option} off")
      break()
    endif()
  endforeach()
  if(reason STREQUAL "")
    set(reason "this KdStream was built without PCL (Debian: libpcl-dev)")
  endif()
  string(APPEND KDSTREAM_MISSING_COMPONENTS "set(_kdstream_missing_${name} \"${reason}\")\n")
  set(KDSTREAM_MISSING_COMPONENTS "${KDSTREAM_MISSING_COMPONENTS}" PARENT_SCOPE)
endfunction()
foreach(module IN ITEMS FiltersPartitioning FiltersSimplification FiltersPointCloud ViewerOffscreen)
  kdstream_component(${module} KDSTREAM_BUILD_VTK)
endforeach()
kdstream_component(FiltersIO KDSTREAM_BUILD_VTK KDSTREAM_BUILD_TOOLS)
foreach(module IN ITEMS ViewerSources ViewerActor)
  kdstream_component(${module} KDSTREAM_BUILD_VTK KDSTREAM_BUILD_TOOLS KDSTREAM_BUILD_SERVER)
endforeach()
configure_package_config_file(cmake/KdStreamConfig.cmake.in "${PROJECT_BINARY_DIR}/KdStreamConfig.cmake"
  INSTALL_DESTINATION "${KDSTREAM_PACKAGE_FOLDER}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/KdStreamConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/KdStreamConfig.cmake" "${PROJECT_BINARY_DIR}/KdStreamConfigVersion.cmake"
  DESTINATION "${KDSTREAM_PACKAGE_FOLDER}" COMPONENT development)
install(FILES "${PROJECT_BINARY_DIR}/include/kdstream/Version.h" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/kdstream"
  COMPONENT development)

# For programs without CMake: the static libraries for stores and servers.
file(RELATIVE_PATH KDSTREAM_PC_PREFIX "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
string(REGEX REPLACE "/$" "" KDSTREAM_PC_PREFIX "${KDSTREAM_PC_PREFIX}")
set(KDSTREAM_PC_LIBRARIES "")
foreach(part IN ITEMS localclient client diskcache conversation viewersession catalog store protocol model codec files core)
  if(TARGET kdstream_${part})
    string(APPEND KDSTREAM_PC_LIBRARIES " -lkdstream_${part}")
  endif()
endforeach()
string(STRIP "${KDSTREAM_PC_LIBRARIES}" KDSTREAM_PC_LIBRARIES)
configure_file("${PROJECT_SOURCE_DIR}/cmake/kdstream.pc.in" "${PROJECT_BINARY_DIR}/kdstream.pc" @ONLY)
install(FILES "${PROJECT_BINARY_DIR}/kdstream.pc" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig" COMPONENT development)

# The web page, which the preset `web` has built elsewhere; kdstream-serve finds it here (server/app).
if(KDSTREAM_WEB_BUILD)
  install(DIRECTORY "${KDSTREAM_WEB_BUILD}/page/" DESTINATION "${CMAKE_INSTALL_DATADIR}/kdstream/web" COMPONENT programs)
endif()

install(FILES LICENSE DESTINATION "${CMAKE_INSTALL_DOCDIR}" COMPONENT licence) # packages have a copy of their own

# Documents and examples, with the same links between them as here; only in packages.
set(documents "${CMAKE_INSTALL_DATADIR}/doc/kdstream-doc")
install(FILES README.md CHANGELOG.md CONTRIBUTING.md SECURITY.md DESTINATION "${documents}" COMPONENT documentation EXCLUDE_FROM_ALL)
install(DIRECTORY doc DESTINATION "${documents}" COMPONENT documentation EXCLUDE_FROM_ALL PATTERN site EXCLUDE)
install(DIRECTORY Examples DESTINATION "${documents}" COMPONENT documentation EXCLUDE_FROM_ALL PATTERN Testing EXCLUDE)
install(FILES LICENSE DESTINATION "${documents}" COMPONENT documentation EXCLUDE_FROM_ALL)
include(KdStreamPackages)
