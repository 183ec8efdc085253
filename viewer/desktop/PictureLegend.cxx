// SPDX-License-Identifier: BSD-3-Clause
// The legend of a picture: see PictureLegend.h. Steps:
// 1. add the texts, which determine the legend's width
// 2. draw the background
// 3. draw the bar and its numbers, or a line for each class.
#include "viewer/desktop/PictureLegend.h"

#include "viewer/desktop/LegendText.h"

#include <vtkTextActor.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <cmath>

namespace kdstream
{
namespace
{

constexpr PictureInk::Rgba ground{ 20, 22, 26, 170 };
constexpr Color ink{ 235, 235, 235 };
constexpr double lineHeight = 16, fontSize = 13; // points
constexpr double barLines = 9, marginLines = 0.75;
constexpr double linesAround = 3 + 2 * marginLines; // the title, edges and margins

PictureInk::Rgba Opaque(const Color& color)
{
  return { color[0], color[1], color[2], 255 };
}

}

void PictureLegend::Show(const std::string& name, const ColorLegend& legend, double pixelRatio)
{
  const bool any = !legend.colors.empty() || !legend.classes.empty();
  this->Ink.Clear(any);
  this->Texts.clear();
  if (!any)
  {
    return;
  }
  const double rows =
    legend.classes.empty() ? barLines : static_cast<double>(legend.classes.size());
  this->Line = std::min(lineHeight * pixelRatio, this->Ink.Height() / (rows + linesAround));

  vtkTextActor& title = this->AddText(name);
  double widest = this->Ink.WidthOf(title);
  for (const ColorLegend::Tick& tick : legend.ticks)
  {
    widest =
      std::max(widest, this->Ink.WidthOf(this->AddText(NumberText(tick.value))) + 1.5 * this->Line);
  }
  for (const ColorLegend::Class& each : legend.classes)
  {
    widest = std::max(widest, this->Ink.WidthOf(this->AddText(ClassText(each))) + 1.5 * this->Line);
  }

  const double edge = this->Line / 2, between = marginLines * this->Line;
  const double content = rows * this->Line;
  const Place lower{ this->Ink.Width() - between - widest - 2 * edge, between };
  const Place upper{ this->Ink.Width() - between, between + content + 2 * this->Line + 2 * edge };
  this->Ink.AddRectangle(0, lower, upper, ground, ground);
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
  this->Ink.Finish();
}

// The numbers stand to the left of the bar, so that the bar is at the edge of the picture.
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
    vtkTextActor& text = *this->Texts[i + 1]; // text 0 is the title
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
  vtkTextActor& actor = this->Ink.AddText(text, this->Line * fontSize / lineHeight, ink);
  this->Texts.push_back(&actor);
  return actor;
}

void PictureLegend::AddRectangle(Place lower, Place upper, const Color& below, const Color& above)
{
  this->Ink.AddRectangle(1, lower, upper, Opaque(below), Opaque(above));
}

}
