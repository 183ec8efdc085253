// SPDX-License-Identifier: BSD-3-Clause
#include "viewer/desktop/PictureInk.h"

#include <vtkActor2D.h>
#include <vtkCellArray.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>
#include <vtkUnsignedCharArray.h>

#include <cmath>

namespace kdstream
{

PictureInk::PictureInk(vtkRenderer& model, std::size_t layers)
  : Model(model)
  , Layers(layers)
{
  for (const Shapes& layer : this->Layers)
  {
    const vtkNew<vtkActor2D> actor;
    actor->SetMapper(layer.mapper);
    layer.renderer->AddActor2D(actor);
    layer.renderer->AutomaticLightCreationOff();
    layer.renderer->InteractiveOff();
    layer.renderer->DrawOff();
  }
}

PictureInk::~PictureInk() = default;

void PictureInk::AddTo(vtkRenderWindow& window)
{
  for (const Shapes& layer : this->Layers)
  {
    window.AddRenderer(layer.renderer);
  }
}

void PictureInk::Clear(bool any)
{
  for (Shapes& layer : this->Layers)
  {
    layer.renderer->SetDraw(any);
    layer.renderer->SetLayer(this->Model.GetLayer());
    layer.renderer->PreserveColorBufferOn(); // after SetLayer, which changes it
    layer.renderer->PreserveDepthBufferOff();
    layer.polygons.clear();
    for (const vtkSmartPointer<vtkTextActor>& text : this->Texts)
    {
      layer.renderer->RemoveActor2D(text);
    }
  }
  this->Texts.clear();
}

vtkTextActor& PictureInk::AddText(const std::string& text, double size, const Color& color)
{
  const auto actor = vtkSmartPointer<vtkTextActor>::New();
  actor->SetInput(text.c_str());
  actor->SetTextScaleModeToNone();
  vtkTextProperty& look = *actor->GetTextProperty();
  look.SetFontSize(static_cast<int>(std::lround(size)));
  look.SetColor(color[0] / 255.0, color[1] / 255.0, color[2] / 255.0);
  this->Layers.back().renderer->AddActor2D(actor);
  this->Texts.push_back(actor);
  return *actor;
}

double PictureInk::WidthOf(vtkTextActor& text)
{
  double box[4] = {};
  text.GetBoundingBox(this->Layers.back().renderer, box);
  return box[1] - box[0];
}

void PictureInk::AddPolygon(std::size_t layer, const std::vector<Corner>& corners)
{
  this->Layers[layer].polygons.push_back(corners);
}

void PictureInk::AddRectangle(
  std::size_t layer, Place lower, Place upper, const Rgba& below, const Rgba& above)
{
  this->AddPolygon(layer, { { lower, below }, { { upper.x, lower.y }, below }, { upper, above },
                            { { lower.x, upper.y }, above } });
}

void PictureInk::Finish()
{
  for (Shapes& layer : this->Layers)
  {
    const vtkNew<vtkPoints> points;
    const vtkNew<vtkCellArray> polygons;
    const vtkNew<vtkUnsignedCharArray> colors;
    colors->SetNumberOfComponents(4);
    for (const std::vector<Corner>& polygon : layer.polygons)
    {
      polygons->InsertNextCell(static_cast<int>(polygon.size()));
      for (const Corner& corner : polygon)
      {
        polygons->InsertCellPoint(points->InsertNextPoint(corner.place.x, corner.place.y, 0));
        colors->InsertNextTypedTuple(corner.color.data());
      }
    }
    const vtkNew<vtkPolyData> shapes;
    shapes->SetPoints(points);
    shapes->SetPolys(polygons);
    shapes->GetPointData()->SetScalars(colors);
    layer.mapper->SetInputData(shapes);
  }
}

int PictureInk::Width() const
{
  return this->Layers.back().renderer->GetSize()[0];
}

int PictureInk::Height() const
{
  return this->Layers.back().renderer->GetSize()[1];
}

}
