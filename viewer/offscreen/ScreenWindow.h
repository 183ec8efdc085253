// SPDX-License-Identifier: BSD-3-Clause
// A window that people see. Step "render" of the pipeline picture.
#pragma once

#include "filters/core/Result.h"

#include <vtkRenderWindow.h>
#include <vtkSmartPointer.h>

#include <string>

namespace kdstream
{

// A window of VTK on the X server that DISPLAY names, of width × height pixels, shown, and ready
// for renderers and an interactor, with edges smoothed by 4 samples. Sizes are 1 … 8192 a side.
// Threads: as MakeOffscreenWindow. Errors: NotFound or Unsupported if no window can be shown,
// saying what is missing.
Result<vtkSmartPointer<vtkRenderWindow>> MakeScreenWindow(
  int width, int height, const std::string& title);

}
