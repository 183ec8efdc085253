// SPDX-License-Identifier: BSD-3-Clause
// What the colours of a picture without a window mean: the window's legend, drawn by VTK.
#pragma once

#include "viewer/desktop/PictureInk.h"
#include "viewer/session/appearance/ColorLegend.h"

#include <string>
#include <vector>

namespace kdstream
{

// Its place is the lower right corner.
class PictureLegend
{
public:
  explicit PictureLegend(vtkRenderer& model)
    : Ink(model, 2)
  {
  }

  // After the model's renderer. REQUIRES: before Show.
  void AddTo(vtkRenderWindow& window) { this->Ink.AddTo(window); }

  // name: of the array. A legend of nothing hides it. pixelRatio: pixels a point.
  void Show(const std::string& name, const ColorLegend& legend, double pixelRatio);

private:
  using Place = PictureInk::Place;

  void ShowBar(const ColorLegend& legend, Place lower, Place upper);
  void ShowClasses(const ColorLegend& legend, Place upper);
  vtkTextActor& AddText(const std::string& text);
  void AddRectangle(Place lower, Place upper, const Color& below, const Color& above);

  PictureInk Ink;
  std::vector<vtkTextActor*> Texts; // the title, then of each tick or class
  double Line = 0;                  // height of a line, pixels
};

}
