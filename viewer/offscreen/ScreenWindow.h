// SPDX-License-Identifier: BSD-3-Clause
// A window on the screen. Step "render" of the pipeline picture.
#pragma once

#include "filters/core/Result.h"

#include <vtkRenderWindow.h>
#include <vtkSmartPointer.h>

#include <string>

namespace kdstream
{

// Makes a VTK window of width × height pixels on the X server that DISPLAY names, and shows it. It
// is ready for renderers and an interactor; its edges are smoothed by 4 samples. Each side has 1 …
// 8192 pixels. Threads: as for MakeOffscreenWindow. Errors: NotFound or Unsupported if no window
// can be shown, saying what is missing.
Result<vtkSmartPointer<vtkRenderWindow>> MakeScreenWindow(
  int width, int height, const std::string& title);

}
