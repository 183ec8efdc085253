// SPDX-License-Identifier: BSD-3-Clause
// Pictures of scenes, and how far they are off the original's (doc/benchmarks.md#views).
#pragma once

#include "viewer/rendering/Picture.h"
#include "viewer/rendering/SurfaceScene.h"
#include "viewer/session/SessionTypes.h"

#include <vtkRenderWindow.h>
#include <vtkSmartPointer.h>

namespace kdstream::bench
{

constexpr int width = 800, height = 480; // of every picture

// Draws scenes 4 x 4 times as fine (2 x 2, each of 4 samples), because an original with several
// triangles a pixel would be noise otherwise. Ends the program if that is not possible.
class Painter
{
public:
  Painter();
  WindowPicture Draw(const ViewerScene& scene);

private:
  vtkSmartPointer<vtkRenderWindow> Window;
  SurfaceScene Scene;
};

// Among the object's pixels (those that differ from `background` in either picture): the share with
// a channel that differs by more than 8 of 255.
double ShareOfWrong(
  const WindowPicture& picture, const WindowPicture& original, const WindowPicture& background);

// Root mean square of the channels' differences, of their range.
double RmsDifference(const WindowPicture& a, const WindowPicture& b);

}
