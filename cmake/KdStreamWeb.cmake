# SPDX-License-Identifier: BSD-3-Clause
# The header-only libraries of Debian that the preset `web` needs: links to their folders, in a separate folder.
# /usr/include itself must not be searched, because it contains the machine's C library, not emscripten's.
set(headers "${CMAKE_BINARY_DIR}/headers")
file(MAKE_DIRECTORY "${headers}")
foreach(name xxhash.h)
  if(NOT EXISTS "/usr/include/${name}")
    message(FATAL_ERROR "/usr/include/${name} is missing (Debian: libxxhash-dev)")
  endif()
  file(CREATE_LINK "/usr/include/${name}" "${headers}/${name}" SYMBOLIC)
endforeach()
add_library(kdstream_web_headers INTERFACE)
target_include_directories(kdstream_web_headers SYSTEM INTERFACE "${headers}")

# If there are several -O options, emcc uses the smallest, so there must be only one.
foreach(language C CXX)
  set(CMAKE_${language}_FLAGS_MINSIZEREL "-DNDEBUG")
endforeach()

# Makes the code small: no exceptions (no input of ours throws), no run-time types, one unit for the optimiser. The
# compiler inlines only functions that are marked inline (em++ 3.1.6 does this by itself at -Oz, 3.1.69 no longer does).
# So each function is still there when PartWasm.cmake splits the module by the functions' names. wasm-opt inlines after
# that.
add_compile_options(-Oz -fno-inline-functions -flto -fno-exceptions -fno-rtti -mbulk-memory)
add_link_options(-Oz -flto -mbulk-memory)
