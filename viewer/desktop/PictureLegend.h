// SPDX-License-Identifier: BSD-3-Clause
// Draws the legend of a picture without a window: the same as in a window, but by VTK.
#pragma once

#include "viewer/desktop/PictureInk.h"
#include "viewer/session/appearance/ColorLegend.h"

#include <string>
#include <vector>

namespace kdstream
{

// A legend in the lower right corner of the picture.
class PictureLegend
{
public:
  explicit PictureLegend(vtkRenderer& model)
    : Ink(model, 2)
  {
  }

  // Call this after the model's renderer has been added. REQUIRES: before Show.
  void AddTo(vtkRenderWindow& window) { this->Ink.AddTo(window); }

  // name: the array's name. An empty legend is not shown. pixelRatio: pixels per point.
  void Show(const std::string& name, const ColorLegend& legend, double pixelRatio);

private:
  using Place = PictureInk::Place;

  void ShowBar(const ColorLegend& legend, Place lower, Place upper);
  void ShowClasses(const ColorLegend& legend, Place upper);
  vtkTextActor& AddText(const std::string& text);
  void AddRectangle(Place lower, Place upper, const Color& below, const Color& above);

  PictureInk Ink;
  std::vector<vtkTextActor*> Texts; // the title, then one for each tick or class
  double Line = 0;                  // height of a line of text, pixels
};

}
