// SPDX-License-Identifier: BSD-3-Clause
// Pictures of scenes, and how much they differ from the original's (doc/benchmarks.md#views).
#pragma once

#include "viewer/rendering/Picture.h"
#include "viewer/rendering/SurfaceScene.h"
#include "viewer/session/SessionTypes.h"

#include <vtkRenderWindow.h>
#include <vtkSmartPointer.h>

namespace kdstream::bench
{

constexpr int width = 800, height = 480; // of every picture

// Draws scenes 4 x 4 times as fine (2 x 2, each of 4 samples). Otherwise an original with several
// triangles in a pixel would be noise. Ends the program if that is not possible.
class Painter
{
public:
  Painter();
  WindowPicture Draw(const ViewerScene& scene);

private:
  vtkSmartPointer<vtkRenderWindow> Window;
  SurfaceScene Scene;
};

// The share of wrong pixels among the object's pixels (those that differ from `background` in
// either picture). A pixel is wrong if one of its channels differs by more than 8 of 255.
double ShareOfWrong(
  const WindowPicture& picture, const WindowPicture& original, const WindowPicture& background);

// The root mean square of the channels' differences, relative to their range.
double RmsDifference(const WindowPicture& a, const WindowPicture& b);

}
