// SPDX-License-Identifier: BSD-3-Clause
// Draws text and flat shapes over the model, by VTK, in a picture without a window. In a window
// Dear ImGui does this.
#pragma once

#include "viewer/session/appearance/Palette.h"

#include <vtkNew.h>
#include <vtkSmartPointer.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

class vtkPolyDataMapper2D;
class vtkRenderer;
class vtkRenderWindow;
class vtkTextActor;

namespace kdstream
{

// Layers are drawn one over the other, each by a renderer of its own, without depth tests between
// layers. Within a layer it is undefined which of two overlapping shapes is on top.
class PictureInk
{
public:
  // Pixels, from the lower left corner of the window.
  struct Place
  {
    double x = 0, y = 0;
  };
  using Rgba = std::array<std::uint8_t, 4>;
  struct Corner
  {
    Place place;
    Rgba color;
  };
  // layers: at least 1. Texts are in the last one.
  PictureInk(vtkRenderer& model, std::size_t layers);
  ~PictureInk();
  PictureInk(const PictureInk&) = delete;
  PictureInk& operator=(const PictureInk&) = delete;

  // Call this after the model's renderer has been added. REQUIRES: before anything else.
  void AddTo(vtkRenderWindow& window);

  // Removes everything that was drawn. any: whether something will be drawn next.
  void Clear(bool any);
  // Adds a line of text, `size` pixels high; the caller sets its position. It stays until Clear.
  vtkTextActor& AddText(const std::string& text, double size, const Color& color);
  double WidthOf(vtkTextActor& text); // pixels
  // A convex polygon. layer: from 0 on.
  void AddPolygon(std::size_t layer, const std::vector<Corner>& corners);
  void AddRectangle(
    std::size_t layer, Place lower, Place upper, const Rgba& below, const Rgba& above);
  // Call this after the last polygon.
  void Finish();

  int Width() const;
  int Height() const;

private:
  struct Shapes
  {
    vtkNew<vtkRenderer> renderer;
    vtkNew<vtkPolyDataMapper2D> mapper;
    std::vector<std::vector<Corner>> polygons;
  };

  vtkRenderer& Model;
  std::vector<Shapes> Layers;
  std::vector<vtkSmartPointer<vtkTextActor>> Texts;
};

}
