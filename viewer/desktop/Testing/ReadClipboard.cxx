// SPDX-License-Identifier: BSD-3-Clause
// Reads what a user would paste: see ReadClipboard.h.
#include "viewer/desktop/Testing/ReadClipboard.h"

#include <chrono>
#include <thread>

#include <X11/Xlib.h>

namespace kdstream::testing
{

std::string ReadClipboard()
{
  using namespace std::chrono_literals;
  Display* display = XOpenDisplay(nullptr);
  if (!display)
  {
    return {};
  }
  const Window window =
    XCreateSimpleWindow(display, DefaultRootWindow(display), 0, 0, 1, 1, 0, 0, 0);
  const Atom property = XInternAtom(display, "KDSTREAM_TEST", False);
  XConvertSelection(display, XInternAtom(display, "CLIPBOARD", False),
    XInternAtom(display, "UTF8_STRING", False), property, window, CurrentTime);
  std::string text;
  XEvent event;
  bool isAnswered = false;
  for (const auto last = std::chrono::steady_clock::now() + 5s;
       !isAnswered && std::chrono::steady_clock::now() < last; std::this_thread::sleep_for(20ms))
  {
    isAnswered = XCheckTypedWindowEvent(display, window, SelectionNotify, &event) == True;
  }
  if (isAnswered && event.xselection.property == property)
  {
    Atom type = None;
    int format = 0;
    unsigned long size = 0, rest = 0;
    unsigned char* bytes = nullptr;
    XGetWindowProperty(display, window, property, 0, 1 << 16, True, AnyPropertyType, &type, &format,
      &size, &rest, &bytes);
    if (bytes)
    {
      text.assign(reinterpret_cast<const char*>(bytes), size);
      XFree(bytes);
    }
  }
  XCloseDisplay(display);
  return text;
}

}
