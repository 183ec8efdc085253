// SPDX-License-Identifier: BSD-3-Clause
// The distances of a picture: see PictureDistances.h. Sizes and colours are those of the window
// (window/ToolsPanel.cxx).
#include "viewer/desktop/PictureDistances.h"

#include <vtkTextActor.h>
#include <vtkTextProperty.h>

#include <cmath>
#include <numbers>

namespace kdstream
{
namespace
{

constexpr Color figureColor{ 255, 209, 102 };
constexpr PictureInk::Rgba lineInk{ 255, 209, 102, 255 }, shadowInk{ 10, 12, 15, 200 };
constexpr double figureSize = 13, figureHeight = 16; // points
constexpr int cornersOfDisc = 24;
// Layers from the lowest to the highest. Texts are above all of them.
constexpr std::size_t shadowLayer = 0, lineLayer = 1, groundLayer = 2;

using Corners = std::vector<PictureInk::Corner>;

Corners DiscAt(PictureInk::Place middle, double radius, const PictureInk::Rgba& color)
{
  Corners corners;
  for (int i = 0; i < cornersOfDisc; ++i)
  {
    const double angle = 2 * std::numbers::pi * i / cornersOfDisc;
    corners.push_back(
      { { middle.x + radius * std::cos(angle), middle.y + radius * std::sin(angle) }, color });
  }
  return corners;
}

// REQUIRES: the ends differ.
Corners LineBetween(
  PictureInk::Place from, PictureInk::Place to, double width, const PictureInk::Rgba& color)
{
  const double length = std::hypot(to.x - from.x, to.y - from.y);
  const double x = (from.y - to.y) / length * width / 2, y = (to.x - from.x) / length * width / 2;
  return { { { from.x + x, from.y + y }, color }, { { from.x - x, from.y - y }, color },
    { { to.x - x, to.y - y }, color }, { { to.x + x, to.y + y }, color } };
}

}

void PictureDistances::Show(
  const std::vector<SeenMeasurement>& seen, const std::string& unit, double pixelRatio)
{
  this->Ratio = pixelRatio;
  this->Ink.Clear(!seen.empty());
  const auto place = [&](const std::array<double, 2>& pixel) {
    return Place{ pixel[0], this->Ink.Height() - pixel[1] };
  };
  for (const SeenMeasurement& each : seen)
  {
    for (const auto& end : { each.from, each.to })
    {
      if (end)
      {
        this->AddEnd(place(*end));
      }
    }
    if (each.from && each.to)
    {
      const Place from = place(*each.from), to = place(*each.to);
      this->AddLine(from, to);
      this->AddFigure(from, to, DistanceText(each.measurement, unit));
    }
  }
  this->Ink.Finish();
}

void PictureDistances::AddEnd(Place at)
{
  this->Ink.AddPolygon(shadowLayer, DiscAt(at, 5 * this->Ratio, shadowInk));
  this->Ink.AddPolygon(lineLayer, DiscAt(at, 4 * this->Ratio, lineInk));
}

void PictureDistances::AddLine(Place from, Place to)
{
  if (from.x != to.x || from.y != to.y)
  {
    this->Ink.AddPolygon(shadowLayer, LineBetween(from, to, 4 * this->Ratio, shadowInk));
    this->Ink.AddPolygon(lineLayer, LineBetween(from, to, 2 * this->Ratio, lineInk));
  }
}

// Writes the text above the middle of the line.
void PictureDistances::AddFigure(Place from, Place to, const std::string& text)
{
  vtkTextActor& words = this->Ink.AddText(text, figureSize * this->Ratio, figureColor);
  const double half = this->Ink.WidthOf(words) / 2, height = figureHeight * this->Ratio;
  const Place foot{ (from.x + to.x) / 2, (from.y + to.y) / 2 + 6 * this->Ratio };
  this->Ink.AddRectangle(groundLayer, { foot.x - half - 4 * this->Ratio, foot.y - this->Ratio },
    { foot.x + half + 4 * this->Ratio, foot.y + height + this->Ratio }, shadowInk, shadowInk);
  words.GetTextProperty()->SetJustificationToCentered();
  words.GetTextProperty()->SetVerticalJustificationToCentered();
  words.SetPosition(foot.x, foot.y + height / 2);
}

}
