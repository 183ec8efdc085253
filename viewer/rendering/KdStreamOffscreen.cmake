# SPDX-License-Identifier: BSD-3-Clause
# kdstream_enable_offscreen(target): lets an executable that links KdStream::rendering make off-screen windows.
#
# Where VTK knows GLX windows only, it links the OpenGL symbols of GlSymbols.cxx into the executable itself and
# exports them, so that they go before those of the shared libraries (that file says why). The order of libraries on
# the link line does not matter, since EGL and OSMesa are opened when the program runs.
function(kdstream_enable_offscreen target)
  if(TARGET kdstream_gl_symbols)
    target_sources(${target} PRIVATE $<TARGET_OBJECTS:kdstream_gl_symbols>)
    set_target_properties(${target} PROPERTIES ENABLE_EXPORTS ON)
  endif()
endfunction()
