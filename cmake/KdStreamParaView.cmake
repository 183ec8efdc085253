# SPDX-License-Identifier: BSD-3-Clause
# The plugin for ParaView (viewer/paraview). ParaView brings a VTK of its own, and one program cannot contain two. So
# the VTK modules are compiled for ParaView's VTK, based on the same libraries without VTK; nothing else that needs VTK
# is built with it. On Debian 12 paraview-dev cannot be installed together with VTK, so `./dev paraview` builds the
# plugin in a root folder of its own.
if(NOT KDSTREAM_BUILD_PARAVIEW)
  message(STATUS "ParaView's plugin: no, KDSTREAM_BUILD_PARAVIEW is off")
  return()
endif()
foreach(option IN ITEMS KDSTREAM_BUILD_TOOLS KDSTREAM_BUILD_SERVER BUILD_SHARED_LIBS)
  if(NOT ${option})
    message(FATAL_ERROR "KDSTREAM_BUILD_PARAVIEW needs ${option}")
  endif()
endforeach()
find_package(MPI QUIET COMPONENTS C) # ParaView names its target without searching for it
find_package(ParaView QUIET COMPONENTS RemotingCore VTKExtensionsCore WrapClientServer ProcessXML RemotingClientServerStream)
if(NOT ParaView_FOUND)
  message(FATAL_ERROR "KDSTREAM_BUILD_PARAVIEW is on, but ParaView was not found (Debian: paraview-dev, python3-paraview and libopenmpi-dev)"
    " ${ParaView_NOT_FOUND_MESSAGE}")
endif()
message(STATUS "ParaView's plugin: yes, for ParaView ${ParaView_VERSION} on VTK ${VTK_VERSION}")

# Call this when all libraries have been defined.
function(kdstream_add_paraview_plugin)
  set(plugin "${PROJECT_SOURCE_DIR}/viewer/paraview/paraview.plugin")
  paraview_plugin_scan(PLUGIN_FILES "${plugin}" PROVIDES_PLUGINS plugins ENABLE_BY_DEFAULT ON HIDE_PLUGINS_FROM_CACHE ON)
  paraview_plugin_build(PLUGINS ${plugins} LIBRARY_SUBDIRECTORY "${PARAVIEW_PLUGIN_SUBDIR}"
    PLUGINS_COMPONENT paraview INSTALL_HEADERS OFF)
  # ParaView's own path of Open MPI's folder is not for a package: ParaView has loaded MPI before the plugin.
  set_target_properties(${plugins} PROPERTIES INSTALL_RPATH_USE_LINK_PATH OFF)
  if(KDSTREAM_BUILD_TESTING)
    add_subdirectory("${PROJECT_SOURCE_DIR}/viewer/paraview/Testing")
  endif()
endfunction()
