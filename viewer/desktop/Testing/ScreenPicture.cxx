// SPDX-License-Identifier: BSD-3-Clause
// What the X server's screen shows: see ScreenPicture.h.
#include "viewer/desktop/Testing/ScreenPicture.h"

#include <memory>
#include <stdexcept>

#include <X11/Xlib.h>
#include <X11/Xutil.h>

namespace kdstream::testing
{

ScreenPicture LookAtScreen(int left, int top, int width, int height)
{
  const std::unique_ptr<Display, decltype(&XCloseDisplay)> display(
    XOpenDisplay(nullptr), XCloseDisplay);
  if (!display)
  {
    throw std::runtime_error("there is no X server");
  }
  const auto free = [](XImage* image) { return XDestroyImage(image); };
  const std::unique_ptr<XImage, decltype(free)> image(
    XGetImage(display.get(), DefaultRootWindow(display.get()), left, top,
      static_cast<unsigned>(width), static_cast<unsigned>(height), AllPlanes, ZPixmap),
    free);
  if (!image)
  {
    throw std::runtime_error("the screen cannot be read");
  }
  ScreenPicture picture{ width, height, {} };
  for (int y = 0; y < height; ++y)
  {
    for (int x = 0; x < width; ++x)
    {
      const unsigned long pixel = XGetPixel(image.get(), x, y); // 24 bits, as xvfb-run was told
      for (const int shift : { 16, 8, 0 })
      {
        picture.rgb.push_back(static_cast<std::uint8_t>(pixel >> shift & 255));
      }
    }
  }
  return picture;
}

}
