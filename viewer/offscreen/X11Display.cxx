// SPDX-License-Identifier: BSD-3-Clause
// Checks for an X server before VTK does, because VTK ends the program if there is none.
#include "viewer/offscreen/BackendWindows.h"

#include <cstdlib>
#include <string>

#include <X11/Xlib.h>
#undef Status

namespace kdstream
{

void X11Disconnect::operator()(_XDisplay* display) const
{
  XCloseDisplay(display);
}

Result<X11Connection> ConnectToX11()
{
  const char* name = std::getenv("DISPLAY");
  if (!name || !*name)
  {
    return Error{ ErrorCode::NotFound, "X11: the environment variable DISPLAY is not set" };
  }
  X11Connection connection(XOpenDisplay(name));
  if (!connection)
  {
    return Error{ ErrorCode::NotFound, std::string("X11: no server answers at DISPLAY=") + name };
  }
  int opcode = 0;
  int event = 0;
  int error = 0;
  if (!XQueryExtension(connection.get(), "GLX", &opcode, &event, &error))
  {
    return Error{ ErrorCode::NotFound,
      std::string("X11: the server at DISPLAY=") + name + " has no GLX extension" };
  }
  return connection;
}

}
