# SPDX-License-Identifier: BSD-3-Clause
# The toolchain of the preset `web`: Debian's emscripten, which uses nothing from outside the machine. With a Node that
# is not Debian's, it does not find acorn by itself.
set(ENV{NODE_PATH} /usr/share/nodejs)
include(/usr/share/emscripten/cmake/Modules/Platform/Emscripten.cmake)
set(CMAKE_CXX_LINKER_LAUNCHER "${CMAKE_COMMAND};-E;env;NODE_PATH=/usr/share/nodejs" CACHE STRING "" FORCE)
set(CMAKE_C_LINKER_LAUNCHER "${CMAKE_CXX_LINKER_LAUNCHER}" CACHE STRING "" FORCE)
