// SPDX-License-Identifier: BSD-3-Clause
// The distances of a picture without a window: the window's lines and figures, drawn by VTK.
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

  // After the model's renderer. REQUIRES: before Show.
  void AddTo(vtkRenderWindow& window) { this->Ink.AddTo(window); }

  // unit: of the model. No distances hide it. pixelRatio: pixels a point.
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
