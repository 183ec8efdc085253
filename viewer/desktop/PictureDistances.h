// SPDX-License-Identifier: BSD-3-Clause
// Draws distances in a picture without a window: the same lines and figures as in a window, but by
// VTK.
#pragma once

#include "viewer/desktop/Distances.h"
#include "viewer/desktop/PictureInk.h"

#include <string>
#include <vector>

namespace kdstream
{

class PictureDistances
{
public:
  explicit PictureDistances(vtkRenderer& model)
    : Ink(model, 4)
  {
  }

  // Call this after the model's renderer has been added. REQUIRES: before Show.
  void AddTo(vtkRenderWindow& window) { this->Ink.AddTo(window); }

  // unit: of the model. If `seen` is empty, nothing is shown. pixelRatio: pixels per point.
  void Show(const std::vector<SeenMeasurement>& seen, const std::string& unit, double pixelRatio);

private:
  using Place = PictureInk::Place;

  void AddEnd(Place at);
  void AddLine(Place from, Place to);
  void AddFigure(Place from, Place to, const std::string& text);

  PictureInk Ink;
  double Ratio = 1;
};

}
