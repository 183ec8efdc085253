# SPDX-License-Identifier: BSD-3-Clause
# libkdstream: all that the VTK modules need, once, as a shared library under them; the programs link the same parts as static
# libraries. It exports what KdStreamApi.map lists.
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
# After the objects nothing is missing that the parts have: what is linked here is what they link.
target_link_libraries(kdstream PRIVATE ${parts})
set_target_properties(kdstream PROPERTIES LINKER_LANGUAGE CXX
  VERSION "${PROJECT_VERSION}" SOVERSION "${KDSTREAM_SOVERSION}" INSTALL_RPATH "${KDSTREAM_LIBRARY_RPATH}")
kdstream_export_only(kdstream "${PROJECT_SOURCE_DIR}/cmake/KdStreamApi.map")
add_library(KdStream::kdstream ALIAS kdstream)
target_include_directories(kdstream INTERFACE "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>")

if(KDSTREAM_BUILD_PARAVIEW)
  # Linked to ParaView's VTK, it is the plugin's own, and lies beside it.
  set_target_properties(kdstream PROPERTIES OUTPUT_NAME kdstream-paraview)
  install(TARGETS kdstream LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}/${PARAVIEW_PLUGIN_SUBDIR}/KdStream" COMPONENT paraview)
else()
  install(TARGETS kdstream EXPORT KdStream LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT libraries
    NAMELINK_COMPONENT development)
endif()
