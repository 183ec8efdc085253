# SPDX-License-Identifier: BSD-3-Clause
# KdStream::pcl: the parts of PCL that are used here, if PCL is installed. KDSTREAM_PCL_VERSION is PCL's version, or
# empty. This is a function, and does not use PCL's own targets, because these bring all of VTK with Qt, compiler flags
# and definitions. The headers are system headers, because they cause warnings.
set(KDSTREAM_PCL_COMPONENTS common kdtree octree search io features surface)

function(kdstream_find_pcl)
  set(KDSTREAM_PCL_VERSION "" PARENT_SCOPE)
  set(CMAKE_DISABLE_FIND_PACKAGE_VTK TRUE) # the parts that are used here work without it
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
    # The options that PCL was compiled with determine the memory layout of its matrices.
    target_compile_options(KdStream::pcl INTERFACE ${PCL_COMPILE_OPTIONS})
    target_include_directories(KdStream::pcl SYSTEM INTERFACE ${PCL_INCLUDE_DIRS})
  endif()
  set(KDSTREAM_PCL_VERSION "${PCL_VERSION}" PARENT_SCOPE)
  message(STATUS "Point clouds through PCL: ${PCL_VERSION}")
endfunction()
