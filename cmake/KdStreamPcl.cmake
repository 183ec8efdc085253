# SPDX-License-Identifier: BSD-3-Clause
# KdStream::pcl: the parts of PCL that are used here, where PCL is installed; nothing otherwise. In a function, and not by
# PCL's own targets: these bring all of VTK with Qt, compiler flags and definitions along. As system headers, since they
# are not free of warnings. KDSTREAM_PCL_VERSION is PCL's version, or empty.
set(KDSTREAM_PCL_COMPONENTS common kdtree octree search io features surface)

function(kdstream_find_pcl)
  set(KDSTREAM_PCL_VERSION "" PARENT_SCOPE)
  set(CMAKE_DISABLE_FIND_PACKAGE_VTK TRUE) # what is used here works without
  set(CMAKE_FIND_PACKAGE_WARN_NO_MODULE FALSE)
  find_package(PCL 1.11 QUIET COMPONENTS ${KDSTREAM_PCL_COMPONENTS})
  set(libraries "")
  foreach(component IN LISTS KDSTREAM_PCL_COMPONENTS)
    string(TOUPPER ${component} name)
    if(NOT PCL_FOUND OR NOT PCL_${name}_LIBRARY)
      message(STATUS "Point clouds through PCL: left out, PCL's ${component} was not found (Debian: libpcl-dev)")
      return()
    endif()
    list(APPEND libraries "${PCL_${name}_LIBRARY}")
  endforeach()
  if(NOT TARGET KdStream::pcl)
    add_library(KdStream::pcl INTERFACE IMPORTED GLOBAL)
    target_link_libraries(KdStream::pcl INTERFACE ${libraries})
    # How PCL was compiled decides how its matrices lie in memory.
    target_compile_options(KdStream::pcl INTERFACE ${PCL_COMPILE_OPTIONS})
    target_include_directories(KdStream::pcl SYSTEM INTERFACE ${PCL_INCLUDE_DIRS})
  endif()
  set(KDSTREAM_PCL_VERSION "${PCL_VERSION}" PARENT_SCOPE)
  message(STATUS "Point clouds through PCL: ${PCL_VERSION}")
endfunction()
