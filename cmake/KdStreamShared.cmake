# SPDX-License-Identifier: BSD-3-Clause
# libkdstream: everything that the VTK modules need, as one shared library below them. Programs link the same parts as
# static libraries. libkdstream exports the symbols that KdStreamApi.map lists.
set(parts core baselines ranks vtkadapter)
if(KDSTREAM_BUILD_TOOLS)
  list(APPEND parts codec model files store meshio outofcore build parallel)
  if(KDSTREAM_BUILD_SERVER)
    list(APPEND parts texture protocol viewersession conversation client diskcache localclient)
  endif()
endif()
list(TRANSFORM parts PREPEND kdstream_)

set(objects ${parts})
list(TRANSFORM objects REPLACE "(.+)" "$<TARGET_OBJECTS:\\1>")
add_library(kdstream SHARED ${objects})
# All objects of the parts are in the library already; so this only links the libraries that the parts link.
target_link_libraries(kdstream PRIVATE ${parts})
set_target_properties(kdstream PROPERTIES LINKER_LANGUAGE CXX
  VERSION "${PROJECT_VERSION}" SOVERSION "${KDSTREAM_SOVERSION}" INSTALL_RPATH "${KDSTREAM_LIBRARY_RPATH}")
kdstream_export_only(kdstream "${PROJECT_SOURCE_DIR}/cmake/KdStreamApi.map")
add_library(KdStream::kdstream ALIAS kdstream)
target_include_directories(kdstream INTERFACE "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>")

if(KDSTREAM_BUILD_PARAVIEW)
  # This library is linked to ParaView's VTK, so it belongs to the plugin, and is installed beside it.
  set_target_properties(kdstream PROPERTIES OUTPUT_NAME kdstream-paraview)
  install(TARGETS kdstream LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}/${PARAVIEW_PLUGIN_SUBDIR}/KdStream" COMPONENT paraview)
else()
  install(TARGETS kdstream EXPORT KdStream LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT libraries
    NAMELINK_COMPONENT development)
endif()
