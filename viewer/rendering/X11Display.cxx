// Whether there is an X server to draw on: asked before VTK is, which aborts the program if there
// is none.
#include "viewer/rendering/BackendWindows.h"

#include <cstdlib>
#include <string>

#include <X11/Xlib.h>
#undef Status

namespace kdstream
{

Result<void> CheckX11Display()
{
  const char* name = std::getenv("DISPLAY");
  if (!name || !*name)
  {
    return Error{ ErrorCode::NotFound, "X11: the environment variable DISPLAY is not set" };
  }
  Display* display = XOpenDisplay(name);
  if (!display)
  {
    return Error{ ErrorCode::NotFound, std::string("X11: no server answers at DISPLAY=") + name };
  }
  int opcode = 0;
  int event = 0;
  int error = 0;
  const bool hasGlx = XQueryExtension(display, "GLX", &opcode, &event, &error) != 0;
  XCloseDisplay(display);
  if (!hasGlx)
  {
    return Error{ ErrorCode::NotFound,
      std::string("X11: the server at DISPLAY=") + name + " has no GLX extension" };
  }
  return {};
}

}
