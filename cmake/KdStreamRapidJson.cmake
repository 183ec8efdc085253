# SPDX-License-Identifier: BSD-3-Clause
# RapidJSON::RapidJSON, wherever RapidJSON comes from: its header-only package of old knows only a folder. As system
# headers: they are not free of warnings in C++20.
if(EMSCRIPTEN)
  add_library(RapidJSON::RapidJSON ALIAS kdstream_web_headers)
else()
  find_package(RapidJSON REQUIRED)
  if(NOT TARGET RapidJSON::RapidJSON)
    add_library(RapidJSON::RapidJSON INTERFACE IMPORTED)
    if(RapidJSON_INCLUDE_DIRS)
      target_include_directories(RapidJSON::RapidJSON SYSTEM INTERFACE ${RapidJSON_INCLUDE_DIRS})
    else()
      target_include_directories(RapidJSON::RapidJSON SYSTEM INTERFACE ${RAPIDJSON_INCLUDE_DIRS})
    endif()
    # Its stacks add to null pointers while they are empty.
    if(KDSTREAM_SANITIZERS AND CMAKE_CXX_COMPILER_ID MATCHES "Clang")
      target_compile_options(RapidJSON::RapidJSON INTERFACE -fno-sanitize=pointer-overflow)
    endif()
  endif()
endif()
