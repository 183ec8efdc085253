# SPDX-License-Identifier: BSD-3-Clause
# Debian packages, made by CPack: one for each component of the install rules. `./dev package` makes them with the
# preset `package`.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME kdstream)
set(CPACK_PACKAGE_VENDOR "The KdStream authors")
set(KDSTREAM_MAINTAINER "The KdStream authors <maintainers@kdstream.invalid>" CACHE STRING "Maintainer of packages: Name <address>")
set(CPACK_PACKAGE_CONTACT "${KDSTREAM_MAINTAINER}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# An executable's dependency on libkdstream is added below.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS "${CMAKE_LIBRARY_OUTPUT_DIRECTORY}")
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY "=")

# If there are packages of the same version for several systems, those of the later system count as newer.
set(system "")
if(EXISTS /etc/os-release)
  file(STRINGS /etc/os-release lines REGEX "^(ID|VERSION_ID)=")
  foreach(line IN LISTS lines)
    string(REGEX MATCH "^([A-Z_]+)=\"?([a-z0-9.]+)" line "${line}")
    set(os_${CMAKE_MATCH_1} "${CMAKE_MATCH_2}")
  endforeach()
  string(REGEX REPLACE "^debian$" "deb" os_ID "${os_ID}")
  set(system "+${os_ID}${os_VERSION_ID}")
endif()
set(CPACK_DEBIAN_PACKAGE_RELEASE "1${system}")
set(version "${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}")
set(library "libkdstream${KDSTREAM_SOVERSION}")
set(pcl "libkdstream-pcl${KDSTREAM_SOVERSION}")

# kdstream_package(component PACKAGE name SECTION section [ARCHITECTURE all] [DEPENDS …] [RECOMMENDS …]
#   [SUGGESTS …] SUMMARY "…" DESCRIPTION "…")
set(CPACK_COMPONENTS_ALL "")
function(kdstream_package component)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "PACKAGE;SECTION;ARCHITECTURE;SUMMARY;DESCRIPTION" "DEPENDS;RECOMMENDS;SUGGESTS")
  string(TOUPPER "${component}" key)
  list(APPEND CPACK_COMPONENTS_ALL "${component}")
  set(CPACK_COMPONENTS_ALL "${CPACK_COMPONENTS_ALL}" PARENT_SCOPE)
  set(CPACK_DEBIAN_${key}_PACKAGE_NAME "${arg_PACKAGE}" PARENT_SCOPE)
  set(CPACK_DEBIAN_${key}_FILE_NAME DEB-DEFAULT PARENT_SCOPE)
  set(CPACK_DEBIAN_${key}_PACKAGE_SECTION "${arg_SECTION}" PARENT_SCOPE)
  foreach(relation IN ITEMS DEPENDS RECOMMENDS SUGGESTS)
    list(JOIN arg_${relation} ", " packages)
    set(CPACK_DEBIAN_${key}_PACKAGE_${relation} "${packages}" PARENT_SCOPE)
  endforeach()
  if(arg_ARCHITECTURE)
    set(CPACK_DEBIAN_${key}_PACKAGE_ARCHITECTURE "${arg_ARCHITECTURE}" PARENT_SCOPE)
    set(CPACK_DEBIAN_${key}_PACKAGE_SHLIBDEPS OFF PARENT_SCOPE)
  endif()
  # The description's first line is the summary.
  set(CPACK_DEBIAN_${key}_DESCRIPTION "${arg_SUMMARY}\n${arg_DESCRIPTION}" PARENT_SCOPE)
  set(CPACK_COMPONENT_${key}_DESCRIPTION "${arg_SUMMARY}\n${arg_DESCRIPTION}" PARENT_SCOPE)
endfunction()

if(KDSTREAM_BUILD_PARAVIEW)
  kdstream_package(paraview PACKAGE kdstream-paraview SECTION science DEPENDS paraview
    SUMMARY "plugin for ParaView that reads huge 3D meshes in parts"
    DESCRIPTION "KdStream streams 3D meshes of any size. The plugin opens its stores and\nservers in ParaView, and brings its filters.")
else()
  kdstream_package(programs PACKAGE kdstream SECTION graphics
    RECOMMENDS "kdstream-view (= ${version})" "kdstream-convert (= ${version})" SUGGESTS "kdstream-doc" "nginx"
    SUMMARY "stream huge 3D meshes to phones, browsers and desktops"
    DESCRIPTION "KdStream streams 3D meshes and point clouds of any size: a picture at\nonce, level of detail by what the screen shows, and the exact original\nwhere one taps.\n.\nThis package has the programs that build, edit and serve stores, and the\npage that a server shows in browsers.")
  set(CPACK_DEBIAN_PROGRAMS_PACKAGE_CONTROL_EXTRA "${PROJECT_SOURCE_DIR}/deploy/packages/postinst;${PROJECT_SOURCE_DIR}/deploy/packages/prerm;${PROJECT_SOURCE_DIR}/deploy/packages/postrm")
  if(TARGET kdstream-view)
    kdstream_package(view PACKAGE kdstream-view SECTION graphics DEPENDS "${library} (= ${version})" RECOMMENDS "kdstream-convert (= ${version})"
      SUMMARY "viewer of huge 3D meshes and KdStream servers"
      DESCRIPTION "A window on stores, meshes and servers of KdStream; also pictures without\na screen, and thumbnails for file managers.")
  endif()
  if(TARGET kdstream-convert)
    set(modules "${library} (= ${version})") # the program uses filters of this library
    if(KDSTREAM_PCL_VERSION)
      list(APPEND modules "${pcl} (= ${version})")
    endif()
    kdstream_package(convert PACKAGE kdstream-convert SECTION graphics DEPENDS ${modules}
      SUMMARY "more mesh formats for KdStream"
      DESCRIPTION "With it kdstream-build reads VTK, glTF, VRML, PCD, LAS and text formats,\nand reconstructs surfaces from point clouds. It needs VTK and the Point\nCloud Library.")
  endif()
  if(TARGET kdstream-build-mpi)
    # Open MPI needs its helper programs to start any program, even with a single rank.
    kdstream_package(mpi PACKAGE kdstream-mpi SECTION science DEPENDS mpi-default-bin
      SUMMARY "builds KdStream stores on several machines"
      DESCRIPTION "kdstream-build-mpi builds a store by the ranks of an MPI job.")
  endif()
  set(depends "${library} (= ${version})")
  if(KDSTREAM_BUILD_VTK)
    kdstream_package(libraries PACKAGE "${library}" SECTION libs
      SUMMARY "VTK modules of KdStream"
      DESCRIPTION "Filters, readers, writers, and an actor for VTK: partitions and simplifies\nhuge meshes, reads and writes stores, shows models of servers.")
    set(triggers "${PROJECT_SOURCE_DIR}/deploy/packages/triggers") # runs ldconfig
    set(CPACK_DEBIAN_LIBRARIES_PACKAGE_CONTROL_EXTRA "${triggers}")
    set(CPACK_DEBIAN_PCL_PACKAGE_CONTROL_EXTRA "${triggers}")
    if(KDSTREAM_PCL_VERSION)
      kdstream_package(pcl PACKAGE "${pcl}" SECTION libs DEPENDS "${library} (= ${version})"
        SUMMARY "VTK module of KdStream for point clouds"
        DESCRIPTION "A VTK filter that reconstructs surfaces by the Point Cloud Library.")
      list(APPEND depends "${pcl} (= ${version})")
    endif()
    list(APPEND depends libvtk9-dev libgl-dev libx11-dev)
  endif()
  kdstream_package(development PACKAGE libkdstream-dev SECTION libdevel
    DEPENDS ${depends} libsqlite3-dev libssl-dev SUGGESTS kdstream-doc
    SUMMARY "headers and libraries of KdStream"
    DESCRIPTION "Headers of the VTK modules and of the C++20 API, static libraries, a CMake\npackage (find_package(KdStream)), and kdstream.pc for pkg-config.")
  kdstream_package(documentation PACKAGE kdstream-doc SECTION doc ARCHITECTURE all
    SUMMARY "documents and examples of KdStream"
    DESCRIPTION "Command line, formats, protocol, tutorials, and examples as projects of\ntheir own.")
endif()

# Copyright, changelog, and other files that Debian requires. The same sources give the same bytes.
set(CPACK_PRE_BUILD_SCRIPTS "${PROJECT_SOURCE_DIR}/cmake/FinishPackages.cmake")
set(CPACK_KDSTREAM_SOURCE "${PROJECT_SOURCE_DIR}")
set(CPACK_KDSTREAM_VERSION "${version}")
include(CPack)
