// SPDX-License-Identifier: BSD-3-Clause
// What the colours of a picture without a window mean: the window's legend, drawn by VTK.
#pragma once

#include "viewer/session/look/ColorLegend.h"

#include <vtkNew.h>
#include <vtkSmartPointer.h>

#include <array>
#include <string>
#include <vector>

class vtkPolyDataMapper2D;
class vtkRenderer;
class vtkRenderWindow;
class vtkTextActor;

namespace kdstream
{

// It has renderers of its own, drawn over the model's; its place is the lower right corner.
class PictureLegend
{
public:
  explicit PictureLegend(vtkRenderer& model);
  ~PictureLegend();
  PictureLegend(const PictureLegend&) = delete;
  PictureLegend& operator=(const PictureLegend&) = delete;

  // After the model's renderer. REQUIRES: before Show.
  void AddTo(vtkRenderWindow& window);

  // name: of the array. A legend of nothing hides it. pixelRatio: pixels a point.
  void Show(const std::string& name, const ColorLegend& legend, double pixelRatio);

private:
  // Pixels, from the lower left corner of the window.
  struct Place
  {
    double x = 0, y = 0;
  };

  void ShowBar(const ColorLegend& legend, Place lower, Place upper);
  void ShowClasses(const ColorLegend& legend, Place upper);
  vtkTextActor& AddText(const std::string& text);
  double WidthOf(vtkTextActor& text);
  void AddRectangle(Place lower, Place upper, const Color& below, const Color& above);

  struct Rectangle
  {
    Place lower, upper;
    std::array<std::uint8_t, 4> below, above; // colours of its edges
  };
  static void Draw(const std::vector<Rectangle>& rectangles, vtkPolyDataMapper2D& mapper);

  vtkRenderer& Model;
  vtkNew<vtkRenderer> Below, Over; // the ground; what is on it, where no depths are in its way
  vtkNew<vtkPolyDataMapper2D> Ground, Shapes;
  std::vector<vtkSmartPointer<vtkTextActor>> Texts;
  std::vector<Rectangle> Rectangles;
  double Line = 0; // height of one, pixels
};

}
