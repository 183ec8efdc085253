# SPDX-License-Identifier: BSD-3-Clause
# What the preset `web` needs of Debian's header-only libraries: links to their folders, in a folder of their own, since
# /usr/include itself must stay unseen (it holds the machine's C library, not emscripten's).
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

# Of several -O emcc heeds the smallest, so there must be one only.
foreach(language C CXX)
  set(CMAKE_${language}_FLAGS_MINSIZEREL "-DNDEBUG")
endforeach()

# Small: no exceptions (no input of ours throws), no run-time types, one unit for the optimiser. The compiler inlines
# nothing that is not marked so (em++ 3.1.6 asks for that by itself at -Oz, 3.1.69 no longer): each function is there when
# the module is parted by their names (PartWasm.cmake). wasm-opt inlines after that.
add_compile_options(-Oz -fno-inline-functions -flto -fno-exceptions -fno-rtti -mbulk-memory)
add_link_options(-Oz -flto -mbulk-memory)
