// SPDX-License-Identifier: BSD-3-Clause
// The legend of a picture: see PictureLegend.h. Steps: 1. the texts, which tell how wide it is  2.
// the ground  3. the bar and its numbers, or a line a class.
#include "viewer/desktop/PictureLegend.h"

#include "viewer/desktop/LegendText.h"

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

#include <algorithm>
#include <cmath>
#include <utility>

namespace kdstream
{
namespace
{

constexpr std::array<std::uint8_t, 4> ground{ 20, 22, 26, 170 };
constexpr Color ink{ 235, 235, 235 };
constexpr double lineHeight = 16, fontSize = 13; // points
constexpr double barLines = 9, marginLines = 0.75;
constexpr double linesAround = 3 + 2 * marginLines; // the title, edges and margins

std::array<std::uint8_t, 4> Opaque(const Color& color)
{
  return { color[0], color[1], color[2], 255 };
}

}

PictureLegend::PictureLegend(vtkRenderer& model)
  : Model(model)
{
  for (const auto& [renderer, shapes] :
    { std::pair<vtkRenderer*, vtkPolyDataMapper2D*>(this->Below, this->Ground),
      { this->Over, this->Shapes } })
  {
    const vtkNew<vtkActor2D> actor;
    actor->SetMapper(shapes);
    renderer->AddActor2D(actor);
    renderer->AutomaticLightCreationOff();
    renderer->InteractiveOff();
    renderer->DrawOff();
  }
}

void PictureLegend::AddTo(vtkRenderWindow& window)
{
  window.AddRenderer(this->Below);
  window.AddRenderer(this->Over);
}

PictureLegend::~PictureLegend() = default;

void PictureLegend::Show(const std::string& name, const ColorLegend& legend, double pixelRatio)
{
  const bool any = !legend.colors.empty() || !legend.classes.empty();
  for (vtkRenderer* const renderer : { this->Below.Get(), this->Over.Get() })
  {
    renderer->SetDraw(any);
    renderer->SetLayer(this->Model.GetLayer());
    renderer->PreserveColorBufferOn(); // after SetLayer, which changes it
    renderer->PreserveDepthBufferOff();
  }
  if (!any)
  {
    return;
  }
  for (const vtkSmartPointer<vtkTextActor>& text : this->Texts)
  {
    this->Over->RemoveActor2D(text);
  }
  this->Texts.clear();
  this->Rectangles.clear();
  const double rows =
    legend.classes.empty() ? barLines : static_cast<double>(legend.classes.size());
  const int* const window = this->Over->GetSize();
  this->Line = std::min(lineHeight * pixelRatio, window[1] / (rows + linesAround));

  vtkTextActor& title = this->AddText(name);
  double widest = this->WidthOf(title);
  for (const ColorLegend::Tick& tick : legend.ticks)
  {
    widest =
      std::max(widest, this->WidthOf(this->AddText(NumberText(tick.value))) + 1.5 * this->Line);
  }
  for (const ColorLegend::Class& each : legend.classes)
  {
    widest = std::max(widest, this->WidthOf(this->AddText(ClassText(each))) + 1.5 * this->Line);
  }

  const double edge = this->Line / 2, between = marginLines * this->Line;
  const double content = rows * this->Line;
  const Place lower{ window[0] - between - widest - 2 * edge, between };
  const Place upper{ window[0] - between, between + content + 2 * this->Line + 2 * edge };
  Draw({ { lower, upper, ground, ground } }, *this->Ground);
  title.SetPosition(lower.x + edge, upper.y - edge - this->Line);
  const Place low{ upper.x - edge - this->Line, lower.y + edge };
  if (legend.classes.empty())
  {
    this->ShowBar(legend, low, { upper.x - edge, low.y + content });
  }
  else
  {
    this->ShowClasses(legend, { lower.x + edge, low.y + content });
  }
  Draw(this->Rectangles, *this->Shapes);
}

// Numbers stand to the left of the bar, so that this is at the edge.
void PictureLegend::ShowBar(const ColorLegend& legend, Place lower, Place upper)
{
  const auto count = legend.colors.size() - 1;
  const auto height = [&](double share) { return lower.y + share * (upper.y - lower.y); };
  for (std::size_t i = 0; i < count; ++i)
  {
    const double from = static_cast<double>(i) / static_cast<double>(count);
    const double to = static_cast<double>(i + 1) / static_cast<double>(count);
    this->AddRectangle(
      { lower.x, height(from) }, { upper.x, height(to) }, legend.colors[i], legend.colors[i + 1]);
  }
  for (std::size_t i = 0; i < legend.ticks.size(); ++i)
  {
    const double y = height(legend.ticks[i].share);
    const double half = std::max(this->Line / 32, 0.5);
    this->AddRectangle({ lower.x - this->Line / 3, y - half }, { lower.x, y + half }, ink, ink);
    vtkTextActor& text = *this->Texts[i + 1]; // behind the title
    text.GetTextProperty()->SetJustificationToRight();
    text.GetTextProperty()->SetVerticalJustificationToCentered();
    text.SetPosition(lower.x - this->Line / 2, y);
  }
}

void PictureLegend::ShowClasses(const ColorLegend& legend, Place upper)
{
  for (std::size_t i = 0; i < legend.classes.size(); ++i)
  {
    const double top = upper.y - static_cast<double>(i) * this->Line;
    const Color& color = legend.classes[i].color;
    this->AddRectangle({ upper.x, top - 0.9 * this->Line },
      { upper.x + 0.8 * this->Line, top - 0.1 * this->Line }, color, color);
    vtkTextActor& text = *this->Texts[i + 1];
    text.GetTextProperty()->SetVerticalJustificationToCentered();
    text.SetPosition(upper.x + 1.25 * this->Line, top - this->Line / 2);
  }
}

vtkTextActor& PictureLegend::AddText(const std::string& text)
{
  const auto actor = vtkSmartPointer<vtkTextActor>::New();
  actor->SetInput(text.c_str());
  actor->SetTextScaleModeToNone();
  vtkTextProperty& look = *actor->GetTextProperty();
  look.SetFontSize(static_cast<int>(std::lround(this->Line * fontSize / lineHeight)));
  look.SetColor(ink[0] / 255.0, ink[1] / 255.0, ink[2] / 255.0);
  this->Over->AddActor2D(actor);
  this->Texts.push_back(actor);
  return *actor;
}

double PictureLegend::WidthOf(vtkTextActor& text)
{
  double box[4] = {};
  text.GetBoundingBox(this->Over, box);
  return box[1] - box[0];
}

void PictureLegend::AddRectangle(Place lower, Place upper, const Color& below, const Color& above)
{
  this->Rectangles.push_back({ lower, upper, Opaque(below), Opaque(above) });
}

void PictureLegend::Draw(const std::vector<Rectangle>& rectangles, vtkPolyDataMapper2D& mapper)
{
  const vtkNew<vtkPoints> points;
  const vtkNew<vtkCellArray> quads;
  const vtkNew<vtkUnsignedCharArray> colors;
  colors->SetNumberOfComponents(4);
  for (const Rectangle& each : rectangles)
  {
    const vtkIdType first = points->GetNumberOfPoints();
    points->InsertNextPoint(each.lower.x, each.lower.y, 0);
    points->InsertNextPoint(each.upper.x, each.lower.y, 0);
    points->InsertNextPoint(each.upper.x, each.upper.y, 0);
    points->InsertNextPoint(each.lower.x, each.upper.y, 0);
    quads->InsertNextCell({ first, first + 1, first + 2, first + 3 });
    for (const auto& color : { each.below, each.below, each.above, each.above })
    {
      colors->InsertNextTypedTuple(color.data());
    }
  }
  const vtkNew<vtkPolyData> shapes;
  shapes->SetPoints(points);
  shapes->SetPolys(quads);
  shapes->GetPointData()->SetScalars(colors);
  mapper.SetInputData(shapes);
}

}
