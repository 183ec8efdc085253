# SPDX-License-Identifier: BSD-3-Clause
# Installs the build to a prefix, and to /usr/local below DESTDIR. Checks that the installation is complete: run paths,
# exported symbols and targets, and every program while the build is hidden. Then a project of its own links against it.
# The prefix is kept for TestExamples.
include("${CMAKE_CURRENT_LIST_DIR}/Expect.cmake")

file(REMOVE_RECURSE "${WORK}")
set(prefix "${WORK}/installed")
set(staged "${WORK}/staged")
run("${CMAKE_COMMAND}" --install "${BUILD}" --prefix "${prefix}" --config "${CONFIGURATION}")
run("${CMAKE_COMMAND}" -E env "DESTDIR=${staged}" "${CMAKE_COMMAND}" --install "${BUILD}" --prefix /usr/local --config "${CONFIGURATION}")

# A build with static libraries is refused before anything is searched for.
execute_process(COMMAND "${CMAKE_COMMAND}" -S "${SOURCE}/.." -B "${WORK}/static" -G "${GENERATOR}" -DBUILD_SHARED_LIBS=OFF
  "-DCMAKE_CXX_COMPILER=${COMPILER}" RESULT_VARIABLE status OUTPUT_QUIET ERROR_VARIABLE said)
string(REGEX REPLACE "[ \n]+" " " said "${said}")
if(status EQUAL 0 OR NOT said MATCHES "BUILD_SHARED_LIBS is off: the VTK modules lie on one shared library")
  message(FATAL_ERROR "a static build: ${status}\n${said}")
endif()

# Programs and libraries find each other relative to their own place, by run paths from $ORIGIN. They find them in this
# prefix, whether or not the build can be hidden below.
foreach(root IN ITEMS "${prefix}" "${staged}/usr/local")
  file(GLOB binaries "${root}/bin/*" "${root}/${LIBDIR}/*.so" "${root}/${LIBDIR}/kdstream/*pictures")
  foreach(binary IN LISTS binaries)
    execute_process(COMMAND "${READELF}" --dynamic --wide "${binary}" OUTPUT_VARIABLE dynamic COMMAND_ERROR_IS_FATAL ANY)
    string(REGEX MATCHALL "\\((RPATH|RUNPATH)\\)[^\n]*" paths "${dynamic}")
    if("${paths}" MATCHES "${BUILD}|${SOURCE}")
      message(FATAL_ERROR "${binary} looks for libraries in ${paths}")
    endif()
    if(NOT dynamic MATCHES "\\(NEEDED\\)[^\n]*\\[lib(kdstream|vtkKdStream)")
      continue()
    endif()
    if(NOT "${paths}" MATCHES "[$]ORIGIN")
      message(FATAL_ERROR "${binary} needs libraries of its own prefix, and looks for them in '${paths}'")
    endif()
    execute_process(COMMAND ldd "${binary}" OUTPUT_VARIABLE found COMMAND_ERROR_IS_FATAL ANY)
    string(REGEX MATCHALL "lib(kdstream|vtkKdStream)[^\n]*" found "${found}")
    foreach(line IN LISTS found)
      string(REGEX REPLACE ".* => ([^ ]*).*" "\\1" place "${line}")
      cmake_path(NORMAL_PATH place)
      cmake_path(IS_PREFIX root "${place}" NORMALIZE isBelow)
      if(NOT isBelow)
        message(FATAL_ERROR "${binary} finds ${line}, not below ${root}")
      endif()
    endforeach()
  endforeach()
endforeach()

# The libraries export the modules' classes and the functions that libkdstream offers them, and nothing else.
file(GLOB libraries "${prefix}/${LIBDIR}/*.so")
foreach(library IN LISTS libraries)
  execute_process(COMMAND "${NM}" --dynamic --demangle --defined-only "${library}" OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX REPLACE "\n$" "" symbols "${symbols}")
  string(REGEX REPLACE "[][;]" "_" symbols "${symbols}")
  string(REPLACE "\n" ";" symbols "${symbols}")
  list(LENGTH symbols count)
  message("${library} exports ${count} symbols")
  set(names "vtk[A-Z]")
  if(library MATCHES "libkdstream")
    set(names "kdstream::")
  elseif(library MATCHES "Offscreen")
    set(names "vtk[A-Z]|kdstream::")
  endif()
  list(FILTER symbols EXCLUDE REGEX "^[0-9a-f]+ [A-Za-z] (vtable for |typeinfo for |typeinfo name for )?(${names})")
  if(symbols OR count EQUAL 0)
    list(JOIN symbols "\n" symbols)
    message(FATAL_ERROR "${library} exports\n${symbols}")
  endif()
endforeach()

# Exported targets contain no folder of this machine.
file(GLOB exported "${prefix}/${LIBDIR}/cmake/KdStream/*.cmake")
foreach(file IN LISTS exported)
  file(STRINGS "${file}" lines REGEX "[\"; ]/(usr|home|work|tmp|opt|root)/|${BUILD}|${SOURCE}")
  if(lines)
    message(FATAL_ERROR "${file} names folders:\n${lines}")
  endif()
endforeach()

# Runs every program in a mount namespace in which the build does not exist (if namespaces are allowed).
execute_process(COMMAND unshare -Urm mount -t tmpfs none "${BUILD}/lib" RESULT_VARIABLE refused OUTPUT_QUIET ERROR_QUIET)
set(hidden "${BUILD}/lib" "${BUILD}/bin")
set(namespace unshare -Urm)
if(NOT refused EQUAL 0)
  message("the build cannot be hidden here: unshare ${refused}")
  set(hidden "")
  set(namespace "")
endif()
foreach(root IN ITEMS "${prefix}" "${staged}/usr/local")
  cmake_path(GET root FILENAME name)
  file(MAKE_DIRECTORY "${WORK}/${name}-files")
  file(COPY_FILE "${SOURCE}/../filters/Partitioning/Testing/Data/Baseline/TestPartitionersPicture.png" "${WORK}/${name}-files/square.png")
  run(${namespace} sh "${CMAKE_CURRENT_LIST_DIR}/try-programs" "${root}/bin" "${WORK}/${name}-files" "${FEATURES}"
    "${CMAKE_CURRENT_LIST_DIR}/with-server" ${hidden})
endforeach()
check_bindings("${WORK}/installed-files")

# A user's project.
configure_against("${prefix}" "${SOURCE}/Testing/Consumer" "${WORK}/Consumer")
run("${CMAKE_COMMAND}" -E env LD_DEBUG=bindings "LD_DEBUG_OUTPUT=${WORK}/Consumer/bindings"
  "${WORK}/Consumer/mixed" "${WORK}/mixed.kds")
check_bindings("${WORK}/Consumer")
