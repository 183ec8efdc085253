// SPDX-License-Identifier: BSD-3-Clause
// The picture that a window shows, as bytes and as a PNG file. Step "render" of the pipeline
// picture.
#pragma once

#include "filters/core/Result.h"

#include <cstdint>
#include <string>
#include <vector>

class vtkRenderWindow;

namespace kdstream
{

struct WindowPicture
{
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb; // 3 bytes per pixel, row by row, the top row first
  bool operator==(const WindowPicture&) const = default;
};

// Draws the window, and returns its pixels, 3 × width × height bytes. Errors: InputOutput if VTK
// returns no pixels.
Result<WindowPicture> Pixels(vtkRenderWindow& window);

// Returns a part of the picture. left, top: its upper left corner. The part must lie within the
// picture.
WindowPicture PartOf(const WindowPicture& picture, int left, int top, int width, int height);
// Places one picture above the other. REQUIRES: equal widths.
WindowPicture Stacked(const WindowPicture& upper, const WindowPicture& lower);

// Writes a PNG file. If this fails, no partial file is left. Errors: InputOutput, with the
// operating system's reason, if the file cannot be written.
Status WritePng(const WindowPicture& picture, const std::string& file);

// Draws the window into a PNG file. Errors: those of Pixels and WritePng.
Status WritePng(vtkRenderWindow& window, const std::string& file);

}
