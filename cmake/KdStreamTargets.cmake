# SPDX-License-Identifier: BSD-3-Clause
# How targets are made here: warnings, language, sanitizers, export, tests. All targets are made in this way.

set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/bin")
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/lib")
set(CMAKE_ARCHIVE_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/lib")
find_program(KDSTREAM_CCACHE ccache)
if(KDSTREAM_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER "${KDSTREAM_CCACHE}")
endif()
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()

# Installed programs and libraries find our libraries wherever the prefix is, relative to themselves. VTK and other
# libraries outside the system's folders are found where they were linked.
file(RELATIVE_PATH KDSTREAM_PROGRAM_RPATH "${CMAKE_INSTALL_FULL_BINDIR}" "${CMAKE_INSTALL_FULL_LIBDIR}")
set(KDSTREAM_PROGRAM_RPATH "$ORIGIN/${KDSTREAM_PROGRAM_RPATH}")
set(KDSTREAM_LIBRARY_RPATH "$ORIGIN")
set(CMAKE_INSTALL_RPATH_USE_LINK_PATH ON)
# Libraries of the same minor version have the same ABI.
set(KDSTREAM_SOVERSION "${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}")
configure_file("${CMAKE_CURRENT_LIST_DIR}/Version.h.in" "${PROJECT_BINARY_DIR}/include/kdstream/Version.h" @ONLY)
if(UNIX AND NOT APPLE AND NOT EMSCRIPTEN)
  set(KDSTREAM_ELF TRUE)
endif()

# g++ 12's SLP vectoriser drops the rounding of double(float(x)) when it handles two values at once: a value that should
# be a float stays a double. Lossless coordinates depend on this rounding (TestPieceCodec fails without this line).
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  add_compile_options(-fno-tree-slp-vectorize)
endif()

# With the sanitizers' checks, code compiles in less than half of the time if it is not optimised. So only these
# libraries, which do the computing, are optimised, and tests that are loops.
set(KDSTREAM_COMPUTING kdstream_core kdstream_codec kdstream_texture kdstream_meshio kdstream_build kdstream_outofcore
  kdstream_baselines kdstream_baselinestores kdstream_fixtures kdstream_model kdstream_page kdstream_protocol
  kdstream_store kdstream_tiles)

# Configures one of our targets: C++20, strict warnings, no fused multiply-add (the same bits everywhere:
# doc/design.md#deterministic).
# kdstream_configure_target(target [FEATURES PRIVATE cxx_std_17]): with FEATURES, a language other than C++20.
function(kdstream_configure_target target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "FEATURES")
  if(NOT arg_FEATURES)
    set(arg_FEATURES PUBLIC cxx_std_20)
  endif()
  target_compile_features(${target} ${arg_FEATURES})
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wshadow -Wconversion -ffp-contract=off)
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    target_compile_options(${target} PRIVATE -Wno-restrict) # warns wrongly about "text" + string: GCC bug 105651
  elseif(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    # It takes any function that has a temporary as an argument and returns a reference for one that returns the temporary.
    target_compile_options(${target} PRIVATE -Wno-dangling-reference)
  endif()
  if(CMAKE_UNITY_BUILD AND CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    # The unit is not a header, although another one includes it.
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
  endif()
  if(KDSTREAM_WARNINGS_AS_ERRORS)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
  if(KDSTREAM_SANITIZERS)
    target_compile_options(${target} PRIVATE -fsanitize=${KDSTREAM_SANITIZERS} -fno-sanitize-recover=all)
    if(KDSTREAM_UNCHECKED)
      target_compile_options(${target} PRIVATE -fno-sanitize=${KDSTREAM_UNCHECKED})
    endif()
    if(NOT target IN_LIST KDSTREAM_COMPUTING)
      target_compile_options(${target} PRIVATE -O0)
    endif()
    if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
      # With the sanitizers' checks in between, g++ wrongly takes many variables for uninitialised.
      target_compile_options(${target} PRIVATE -Wno-maybe-uninitialized)
      if(KDSTREAM_SANITIZERS MATCHES thread)
        # This sanitizer does not support the fences in Asio's headers. The data that it checks is also ordered by
        # mutexes.
        target_compile_options(${target} PRIVATE -Wno-tsan)
      endif()
    endif()
    target_link_options(${target} PUBLIC -fsanitize=${KDSTREAM_SANITIZERS})
  endif()
  # A program keeps the symbols of its static libraries to itself; otherwise libraries that it loads would bind to them.
  get_target_property(type ${target} TYPE)
  if(KDSTREAM_ELF AND type STREQUAL "EXECUTABLE" AND NOT KDSTREAM_SANITIZERS)
    target_link_options(${target} PRIVATE LINKER:--exclude-libs,ALL)
  endif()
endfunction()

# The shared library exports only what the linker's version script `map` names, and must have no undefined symbols.
function(kdstream_export_only target map)
  if(KDSTREAM_ELF)
    target_link_options(${target} PRIVATE "LINKER:--version-script,${map}" LINKER:--no-undefined)
    set_property(TARGET ${target} APPEND PROPERTY LINK_DEPENDS "${map}")
  endif()
endfunction()

# For code that waits for people, files or sockets, and for tests. Optimising it fully takes half as long again to
# compile, and nobody would notice the difference.
function(kdstream_optimise_lightly target)
  if(NOT EMSCRIPTEN)
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  endif()
endfunction()

# Installs those of this folder's headers that are to be installed.
function(kdstream_install_headers)
  file(RELATIVE_PATH folder "${PROJECT_SOURCE_DIR}" "${CMAKE_CURRENT_SOURCE_DIR}")
  foreach(header IN LISTS ARGN)
    if("${folder}/${header}" IN_LIST KDSTREAM_INSTALLED_HEADERS)
      set_property(GLOBAL APPEND PROPERTY KDSTREAM_HEADERS "${folder}/${header}")
      cmake_path(GET header PARENT_PATH below)
      install(FILES "${header}" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/kdstream/${folder}/${below}"
        COMPONENT development)
    endif()
  endforeach()
endfunction()

# Adds a static library KdStream::<name>, whose headers are included as "filters/core/tree/KdTree.h". Those of the API
# are installed (KdStreamApi.cmake). NOT_INSTALLED: no library with headers of the API needs this library.
# kdstream_add_library(core SOURCES … HEADERS … [LINK …] [PRIVATE_LINK …] [NOT_INSTALLED])
function(kdstream_add_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "NOT_INSTALLED" "" "SOURCES;HEADERS;LINK;PRIVATE_LINK")
  add_library(kdstream_${name} STATIC ${arg_SOURCES} ${arg_HEADERS})
  add_library(KdStream::${name} ALIAS kdstream_${name})
  kdstream_configure_target(kdstream_${name})
  target_include_directories(kdstream_${name} PUBLIC
    "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>"
    "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/kdstream;${CMAKE_INSTALL_INCLUDEDIR}>")
  target_link_libraries(kdstream_${name} PUBLIC ${arg_LINK} PRIVATE ${arg_PRIVATE_LINK})
  set_target_properties(kdstream_${name} PROPERTIES EXPORT_NAME ${name})
  if(KDSTREAM_ELF)
    # As in kdstream_configure_target, for users' programs and libraries.
    target_link_options(kdstream_${name} INTERFACE "$<INSTALL_INTERFACE:LINKER:--exclude-libs,libkdstream_${name}.a>")
  endif()
  if(arg_NOT_INSTALLED)
    return()
  endif()
  install(TARGETS kdstream_${name} EXPORT KdStream ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
  set_property(GLOBAL APPEND PROPERTY KDSTREAM_LIBRARIES kdstream_${name})
  kdstream_install_headers(${arg_HEADERS})
endfunction()

# Configures a VTK module, for VTK or for a plugin: as kdstream_configure_target does, and linked to libkdstream. Users
# of the module do not see libkdstream: they compile C++17, with VTK only. The module exports its classes vtk* and the
# functions that API names.
# kdstream_configure_module(module [API kdstream::MakeWindow* …])
function(kdstream_configure_module module)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "API")
  _vtk_module_real_target(target ${module})
  kdstream_configure_target(${target} FEATURES PRIVATE cxx_std_20 INTERFACE cxx_std_17)
  vtk_module_include(${module} INTERFACE
    "$<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include>" "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>")
  vtk_module_link(${module} PRIVATE KdStream::kdstream)
  get_target_property(type ${target} TYPE)
  if(NOT type STREQUAL "SHARED_LIBRARY")
    return()
  endif()
  get_target_property(classes ${target} SOURCES)
  list(FILTER classes INCLUDE REGEX "(^|/)vtk[A-Za-z]+\\.cxx$")
  set(exported "")
  foreach(class IN LISTS classes)
    cmake_path(GET class STEM class)
    string(APPEND exported "    ${class}::*; \"vtable for ${class}\"; \"typeinfo for ${class}\"; \"typeinfo name for ${class}\";\n")
  endforeach()
  foreach(function IN LISTS arg_API)
    string(APPEND exported "    ${function};\n")
  endforeach()
  set(map "${CMAKE_CURRENT_BINARY_DIR}/${target}.map")
  file(CONFIGURE OUTPUT "${map}" CONTENT "{\n  global: extern \"C++\" {\n${exported}  };\n  local: *;\n};\n" @ONLY)
  kdstream_export_only(${target} "${map}")
  set_target_properties(${target} PROPERTIES INSTALL_RPATH "${KDSTREAM_LIBRARY_RPATH}")
endfunction()

# Adds a program kdstream-<name>, with a manual page that is made from its --help (not with sanitizers, which would make
# this slow). COMPONENT: the component that only this program belongs to, and so its package (KdStreamPackages.cmake).
find_program(KDSTREAM_AWK awk)
if(NOT KDSTREAM_AWK)
  message(STATUS "Manual pages: left out, there is no awk")
endif()
function(kdstream_add_program name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "COMPONENT" "SOURCES;LINK")
  if(NOT arg_COMPONENT)
    set(arg_COMPONENT programs)
  endif()
  add_executable(kdstream-${name} ${arg_SOURCES})
  kdstream_configure_target(kdstream-${name})
  kdstream_optimise_lightly(kdstream-${name})
  target_link_libraries(kdstream-${name} PRIVATE ${arg_LINK})
  target_include_directories(kdstream-${name} PRIVATE "${PROJECT_BINARY_DIR}/include")
  set_target_properties(kdstream-${name} PROPERTIES INSTALL_RPATH "${KDSTREAM_PROGRAM_RPATH}")
  install(TARGETS kdstream-${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT ${arg_COMPONENT})
  if(NOT KDSTREAM_AWK OR KDSTREAM_SANITIZERS)
    return()
  endif()
  set(page "${CMAKE_BINARY_DIR}/man/kdstream-${name}.1")
  set(script "${PROJECT_SOURCE_DIR}/cmake/ManPage.awk")
  file(MAKE_DIRECTORY "${CMAKE_BINARY_DIR}/man")
  add_custom_command(OUTPUT "${page}"
    COMMAND sh -c "\"$1\" -v program=\"$2\" -v version=\"$3\" -f \"$4\" > \"$5.new\" && mv \"$5.new\" \"$5\"" make-page
      "${KDSTREAM_AWK}" $<TARGET_FILE:kdstream-${name}> "${PROJECT_VERSION}" "${script}" "${page}"
    DEPENDS kdstream-${name} "${script}"
    COMMENT "Writing the manual page of kdstream-${name}"
    VERBATIM)
  add_custom_target(manual-of-${name} ALL DEPENDS "${page}")
  install(FILES "${page}" DESTINATION "${CMAKE_INSTALL_MANDIR}/man1" COMPONENT ${arg_COMPONENT})
endfunction()

# Sets the compile options of a test program, and of the parts that it shares with others. WAITING: as in
# kdstream_add_tests.
function(kdstream_configure_test target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "WAITING" "" "")
  kdstream_configure_target(${target})
  kdstream_optimise_lightly(${target})
  if(KDSTREAM_SANITIZERS AND NOT arg_WAITING)
    target_compile_options(${target} PRIVATE -O1) # most tests are loops
  endif()
  if(KDSTREAM_UNCHECKED) # for speed; what is checked is the library
    target_compile_options(${target} PRIVATE -fno-sanitize=undefined,fuzzer-no-link)
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD_BATCH_SIZE 4)
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    # Wrong warnings, like -Wrestrict.
    target_compile_options(${target} PRIVATE -Wno-array-bounds -Wno-stringop-overflow -Wno-stringop-overread)
  endif()
endfunction()

# Adds the tests of one library: a GoogleTest program made of their sources, and for each source an entry of ctest with
# its name (Testing/Main.cxx runs the tests of one source).
#   kdstream_add_tests(CoreTests LABEL unit TESTS TestKdTree TestRegion LINK KdStream::core …)
# LABEL is unit, render or e2e. SOURCES are shared by the tests. DEPENDS are the programs that they start. LAUNCHER
# starts the tests, for example xvfb-run. KDSTREAM_PROGRAMS is defined as the folder of all programs. Further labels are
# for the sources named after them, or for ALL. HOSTILE: the source reads bytes of strangers, and also runs with the
# address sanitizer. THREADS: it also runs with the thread sanitizer. SLOW names tests (Suite.Name) that only `./dev
# test --all` runs, as an entry of their own. UNSANITIZED names tests of hostile sources that read many bytes, but only
# good ones: with a sanitizer, only --all runs them, too. WAITING: the program mostly waits for sockets and files, and
# is not optimised with the sanitizers' checks. Sources are compiled four at a time, which saves a third of the time.
# ALONE names sources whose helpers have the same names as those of others.
set(KDSTREAM_TESTED_LABEL "" CACHE STRING "Build the tests of this label only, e.g. hostile; empty = all")
set(KDSTREAM_LEFT_OUT_LABELS "" CACHE STRING
  "Tests of these labels are neither built nor run, e.g. hostile;threads, but sources that have UNSANITIZED tests")
add_custom_target(tests) # all test programs, and the programs that they start
if(KDSTREAM_BUILD_TESTING)
  find_package(GTest REQUIRED)
  # A precompiled header can be used by targets with the same compile options: by the tests, but not by libraries.
  foreach(target IN ITEMS kdstream_testing kdstream_testing_waiting)
    add_library(${target} OBJECT "${PROJECT_SOURCE_DIR}/Testing/Main.cxx")
    if(target STREQUAL kdstream_testing)
      kdstream_configure_test(${target})
    else()
      kdstream_configure_test(${target} WAITING)
    endif()
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE OFF)
    target_compile_options(${target} PRIVATE -fPIE)
    target_link_libraries(${target} PUBLIC GTest::gtest)
    target_precompile_headers(${target} PRIVATE "${PROJECT_SOURCE_DIR}/Testing/TestHeaders.h")
  endforeach()
endif()

function(kdstream_add_tests program)
  set(labels HOSTILE THREADS)
  cmake_parse_arguments(PARSE_ARGV 1 arg "WAITING" "LABEL"
    "TESTS;SOURCES;LINK;DEFINITIONS;DEPENDS;ENVIRONMENT;LAUNCHER;SLOW;UNSANITIZED;ALONE;${labels}")
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "kdstream_add_tests(${program}): ${arg_UNPARSED_ARGUMENTS} is not understood")
  endif()
  if(NOT KDSTREAM_BUILD_TESTING)
    return()
  endif()
  set(sources "")
  set(tests "")
  foreach(path IN LISTS arg_TESTS)
    cmake_path(GET path FILENAME test)
    set(labels_of_${test} ${arg_LABEL})
    foreach(label IN LISTS labels)
      if(arg_${label} STREQUAL "ALL" OR test IN_LIST arg_${label})
        string(TOLOWER ${label} lower)
        list(APPEND labels_of_${test} ${lower})
      endif()
    endforeach()
    set(leftOut OFF)
    string(REGEX REPLACE "^Test" "" suite "${test}")
    if(NOT arg_UNSANITIZED MATCHES "(^|;)(Test)?${suite}\\.")
      foreach(label IN LISTS KDSTREAM_LEFT_OUT_LABELS)
        if(label IN_LIST labels_of_${test})
          set(leftOut ON)
        endif()
      endforeach()
    endif()
    if(NOT leftOut AND (KDSTREAM_TESTED_LABEL STREQUAL "" OR KDSTREAM_TESTED_LABEL IN_LIST labels_of_${test}))
      list(APPEND sources ${path}.cxx)
      list(APPEND tests ${test})
      if(test IN_LIST arg_ALONE)
        set_source_files_properties(${path}.cxx PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
      endif()
    endif()
  endforeach()
  if(NOT tests)
    return()
  endif()
  add_executable(${program} ${sources} ${arg_SOURCES})
  set(shared kdstream_testing)
  if(arg_WAITING)
    kdstream_configure_test(${program} WAITING)
    set(shared kdstream_testing_waiting)
  else()
    kdstream_configure_test(${program})
  endif()
  target_precompile_headers(${program} REUSE_FROM ${shared})
  target_include_directories(${program} PRIVATE "${PROJECT_SOURCE_DIR}")
  target_compile_definitions(${program} PRIVATE
    KDSTREAM_PROGRAMS="${CMAKE_RUNTIME_OUTPUT_DIRECTORY}" ${arg_DEFINITIONS})
  target_link_libraries(${program} PRIVATE ${arg_LINK} ${shared})
  add_dependencies(tests ${program})
  if(arg_DEPENDS)
    add_dependencies(${program} ${arg_DEPENDS})
  endif()
  set(without "")
  if(KDSTREAM_TESTED_LABEL AND KDSTREAM_SANITIZERS)
    list(APPEND arg_SLOW ${arg_UNSANITIZED})
  endif()
  list(JOIN arg_SLOW ":" slow)
  if(slow AND KDSTREAM_TESTED_LABEL STREQUAL "")
    add_test(NAME ${program}-slow COMMAND ${arg_LAUNCHER} $<TARGET_FILE:${program}> "--gtest_filter=${slow}")
    set(labels_of_${program}-slow ${arg_LABEL} slow)
    list(APPEND tests ${program}-slow)
  endif()
  if(slow)
    set(without "--gtest_filter=-${slow}")
  endif()
  foreach(test IN LISTS tests)
    if(NOT TEST ${test})
      add_test(NAME ${test} COMMAND ${arg_LAUNCHER} $<TARGET_FILE:${program}> ${test} ${without})
    endif()
    set_tests_properties(${test} PROPERTIES LABELS "${labels_of_${test}}")
    if(arg_ENVIRONMENT)
      set_tests_properties(${test} PROPERTIES ENVIRONMENT "${arg_ENVIRONMENT}")
    endif()
  endforeach()
endfunction()

# Adds a libFuzzer executable to the target `fuzzers`, if KDSTREAM_BUILD_FUZZERS is on. The preset `asan` builds the
# libraries with libFuzzer's coverage and the sanitizers. As a test with the label fuzz, the executable runs its corpus
# (a folder) and the inputs that earlier runs have added in out/fuzz. Then it continues for KDSTREAM_FUZZ_SECONDS.
# kdstream_add_fuzzer(FuzzCodec SOURCES … LINK … [CORPUS …] [DICTIONARY …])
option(KDSTREAM_BUILD_FUZZERS "Build the fuzz targets (clang, preset asan)" OFF)
set(KDSTREAM_FUZZ_SECONDS 5 CACHE STRING "How long a test runs a fuzz target")
function(kdstream_add_fuzzer name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "CORPUS;DICTIONARY" "SOURCES;LINK")
  if(NOT KDSTREAM_BUILD_FUZZERS)
    return()
  endif()
  if(NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    message(FATAL_ERROR "KDSTREAM_BUILD_FUZZERS needs clang: use the preset asan")
  endif()
  add_executable(${name} ${arg_SOURCES})
  kdstream_configure_target(${name})
  target_include_directories(${name} PRIVATE "${PROJECT_SOURCE_DIR}")
  target_link_libraries(${name} PRIVATE ${arg_LINK})
  target_link_options(${name} PRIVATE -fsanitize=fuzzer)
  if(NOT TARGET fuzzers)
    add_custom_target(fuzzers)
  endif()
  add_dependencies(fuzzers ${name})
  set(found "${PROJECT_SOURCE_DIR}/out/fuzz/${name}")
  file(MAKE_DIRECTORY "${found}")
  set(arguments "")
  if(arg_DICTIONARY)
    list(APPEND arguments "-dict=${CMAKE_CURRENT_SOURCE_DIR}/${arg_DICTIONARY}")
  endif()
  list(APPEND arguments "${found}")
  if(arg_CORPUS)
    list(APPEND arguments "${CMAKE_CURRENT_SOURCE_DIR}/${arg_CORPUS}")
  endif()
  add_test(NAME ${name} COMMAND ${name} -max_total_time=${KDSTREAM_FUZZ_SECONDS} -timeout=60 -rss_limit_mb=2500
    -print_final_stats=1 "-artifact_prefix=${found}/" ${arguments})
  math(EXPR most "${KDSTREAM_FUZZ_SECONDS} + 1200")
  set_tests_properties(${name} PROPERTIES LABELS fuzz TIMEOUT ${most})
endfunction()
