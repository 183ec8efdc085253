# SPDX-License-Identifier: BSD-3-Clause
# Checks that every source of tests is named in a CMakeLists.txt, because a forgotten one would never run.
# cmake -D ROOT=… -P CheckTests.cmake
file(GLOB_RECURSE lists LIST_DIRECTORIES false RELATIVE "${ROOT}" "${ROOT}/filters/CMakeLists.txt" "${ROOT}/server/CMakeLists.txt"
  "${ROOT}/viewer/CMakeLists.txt" "${ROOT}/Testing/CMakeLists.txt" "${ROOT}/Data/CMakeLists.txt" "${ROOT}/Examples/CMakeLists.txt")
set(named "")
foreach(list IN LISTS lists)
  file(READ "${ROOT}/${list}" text)
  string(APPEND named "${text}")
endforeach()
foreach(folder IN ITEMS filters server viewer Testing Data)
  file(GLOB_RECURSE sources LIST_DIRECTORIES false RELATIVE "${ROOT}" "${ROOT}/${folder}/Test*.cxx")
  foreach(source IN LISTS sources)
    get_filename_component(name "${source}" NAME_WE)
    if(NOT named MATCHES "[^A-Za-z]${name}[^A-Za-z]")
      message(SEND_ERROR "${source}: no CMakeLists.txt names it, so that it never runs")
    endif()
  endforeach()
endforeach()
