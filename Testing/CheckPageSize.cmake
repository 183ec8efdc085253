# SPDX-License-Identifier: BSD-3-Clause
# Checks that the page is small. SIZES is the file page.sizes of the preset web (viewer/mobile/web/MakePage.cmake): the
# gzipped bytes that are loaded before the first picture, those of all files, and the version of emscripten's clang.
file(READ "${SIZES}" sizes)
list(GET sizes 0 first)
list(GET sizes 1 bytes)
list(GET sizes 2 compiler)
set(most_first 164900)
set(most_bytes 249000)
if(compiler VERSION_GREATER_EQUAL 16) # Debian 12 has 14; with Debian 13, the same sources give 6 and 13 kB more
  math(EXPR most_first "${most_first} + 7000")
  math(EXPR most_bytes "${most_bytes} + 14000")
endif()
message("${first} bytes before the first picture, ${bytes} together; at most ${most_first} and ${most_bytes} (clang ${compiler})")
if(first GREATER most_first)
  message(FATAL_ERROR "Before the first picture ${first} bytes come, gzipped; it may be ${most_first}")
endif()
if(bytes GREATER most_bytes)
  message(FATAL_ERROR "The page has ${bytes} bytes, gzipped; it may have ${most_bytes}")
endif()
