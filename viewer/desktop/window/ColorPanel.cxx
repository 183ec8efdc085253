// SPDX-License-Identifier: BSD-3-Clause
// The window's panels about colours: see ColorPanel.h.
#include "viewer/desktop/window/ColorPanel.h"

#include "viewer/desktop/LegendText.h"
#include "viewer/desktop/window/Panels.h"
#include "viewer/session/appearance/ColorLegend.h"

#include <imgui.h>

#include <algorithm>
#include <string>

namespace kdstream
{
namespace
{

ImU32 Ink(const Color& color)
{
  return IM_COL32(color[0], color[1], color[2], 255);
}

// Lets the user choose the values of the array at the two ends of the colour map.
void DrawRange(const ScalarDescription& scalar, ColorChoice& colors)
{
  const Coloring now = ColoringOf(colors, std::vector<ScalarDescription>{ scalar });
  std::array<double, 2> range{ now.low, now.high };
  ImGui::SetNextItemWidth(ImGui::GetFontSize() * 16);
  const bool changed = ImGui::InputScalarN("from, to", ImGuiDataType_Double, range.data(), 2,
    nullptr, nullptr, "%.6g", ImGuiInputTextFlags_EnterReturnsTrue);
  if (changed && range[0] < range[1])
  {
    colors.range = range;
  }
  if (ImGui::Button("Middle 96 %"))
  {
    colors.range.reset();
  }
  ImGui::SameLine();
  if (ImGui::Button("All values") && scalar.least < scalar.most)
  {
    colors.range = { scalar.least, scalar.most };
  }
}

void DrawAttributeChoice(const ScalarDescription& scalar, ColorChoice& colors)
{
  const bool isMine =
    colors.coloring == SurfaceColoring::Attribute && colors.attribute == scalar.name;
  if (ImGui::RadioButton((scalar.name + "##array").c_str(), isMine) && !isMine)
  {
    colors = { SurfaceColoring::Attribute, scalar.name, colors.map, {} };
  }
  if (!isMine || (!scalar.classes.empty() && !colors.range))
  {
    return;
  }
  ImGui::Indent();
  for (const ColorMap map : allColorMaps)
  {
    if (map != allColorMaps.front())
    {
      ImGui::SameLine();
    }
    if (ImGui::RadioButton(std::string(NameOf(map)).c_str(), colors.map == map))
    {
      colors.map = map;
    }
  }
  DrawRange(scalar, colors);
  ImGui::Unindent();
}

// Draws a column of the legend. Text is to the left of the bar, so that the bar is at the edge.
void DrawBar(const ColorLegend& legend, ImDrawList& drawing, ImVec2 from, ImVec2 to, float line)
{
  const auto count = legend.colors.size() - 1;
  const float height = (to.y - from.y) / static_cast<float>(count);
  for (std::size_t i = 0; i < count; ++i)
  {
    const float bottom = to.y - static_cast<float>(i) * height;
    const ImU32 low = Ink(legend.colors[i]), high = Ink(legend.colors[i + 1]);
    drawing.AddRectFilledMultiColor(
      { from.x, bottom - height }, { to.x, bottom }, high, high, low, low);
  }
  for (const ColorLegend::Tick& tick : legend.ticks)
  {
    const float y = to.y - static_cast<float>(tick.share) * (to.y - from.y);
    const std::string text = NumberText(tick.value);
    const ImVec2 size = ImGui::CalcTextSize(text.c_str());
    drawing.AddLine({ from.x - line / 3, y }, { from.x, y }, ImGui::GetColorU32(ImGuiCol_Text));
    drawing.AddText({ from.x - line / 2 - size.x, y - size.y / 2 },
      ImGui::GetColorU32(ImGuiCol_Text), text.c_str());
  }
}

float WidthOf(const ColorLegend& legend, const std::string& name, float line)
{
  float widest = ImGui::CalcTextSize(name.c_str()).x;
  for (const ColorLegend::Tick& tick : legend.ticks)
  {
    const float text = ImGui::CalcTextSize(NumberText(tick.value).c_str()).x;
    widest = std::max(widest, text + 1.5f * line);
  }
  for (const ColorLegend::Class& each : legend.classes)
  {
    widest = std::max(widest, ImGui::CalcTextSize(ClassText(each).c_str()).x + 1.5f * line);
  }
  return widest;
}

}

void DrawColorChoice(const PanelFacts& facts, ColorChoice& colors)
{
  ImGui::TextUnformatted("Show");
  constexpr std::pair<const char*, SurfaceColoring> choices[] = {
    { "Own colours", SurfaceColoring::Own }, { "Stone", SurfaceColoring::Stone },
    { "Partitions", SurfaceColoring::Partition }, { "Detail", SurfaceColoring::Resolution }
  };
  for (const auto& [label, coloring] : choices)
  {
    if (coloring != SurfaceColoring::Own)
    {
      ImGui::SameLine();
    }
    if (ImGui::RadioButton(label, colors.coloring == coloring))
    {
      colors.coloring = coloring;
    }
  }
  if (facts.model && !facts.model->scalars.empty())
  {
    ImGui::TextUnformatted("Colours by");
    for (const ScalarDescription& scalar : facts.model->scalars)
    {
      DrawAttributeChoice(scalar, colors);
    }
  }
}

void DrawColorLegend(const PanelFacts& facts, const ColorChoice& colors, double below)
{
  const ScalarDescriptions scalars = facts.model ? facts.model->scalars : ScalarDescriptions{};
  const Coloring coloring = ColoringOf(colors, scalars);
  const ColorLegend legend = LegendOf(coloring, scalars);
  if (legend.colors.empty() && legend.classes.empty())
  {
    return;
  }
  const float line = ImGui::GetTextLineHeight(), edge = line / 2;
  const float width = WidthOf(legend, coloring.attribute, line) + 2 * edge;
  const float bar =
    legend.classes.empty() ? 9 * line : static_cast<float>(legend.classes.size()) * line;
  const float height = bar + 2.5f * line + edge;
  const double margin = 12 * facts.ratio;
  const ImVec2 end{ static_cast<float>(facts.width - margin),
    static_cast<float>(facts.height - below - margin) };
  const ImVec2 corner{ end.x - width, end.y - height };
  ImDrawList& drawing = *ImGui::GetBackgroundDrawList();
  drawing.AddRectFilled(corner, end, IM_COL32(20, 22, 26, 170), edge / 2);
  drawing.AddText({ corner.x + edge, corner.y + edge }, ImGui::GetColorU32(ImGuiCol_Text),
    coloring.attribute.c_str());
  const float top = corner.y + edge + 1.75f * line;
  if (legend.classes.empty())
  {
    DrawBar(legend, drawing, { end.x - edge - line, top }, { end.x - edge, top + bar }, line);
    return;
  }
  for (std::size_t i = 0; i < legend.classes.size(); ++i)
  {
    const float y = top + static_cast<float>(i) * line;
    drawing.AddRectFilled({ corner.x + edge, y + 0.1f * line },
      { corner.x + edge + 0.8f * line, y + 0.9f * line }, Ink(legend.classes[i].color));
    drawing.AddText({ corner.x + edge + 1.25f * line, y }, ImGui::GetColorU32(ImGuiCol_Text),
      ClassText(legend.classes[i]).c_str());
  }
}

ColorChoice NextColors(const ColorChoice& colors, const ModelDescription* model)
{
  if (!model || model->scalars.empty())
  {
    return colors;
  }
  std::size_t next = 0;
  if (colors.coloring == SurfaceColoring::Attribute)
  {
    const auto here = std::find_if(model->scalars.begin(), model->scalars.end(),
      [&](const ScalarDescription& scalar) { return scalar.name == colors.attribute; });
    next = static_cast<std::size_t>(here - model->scalars.begin()) + 1;
  }
  return next < model->scalars.size() ? ColorChoice{ SurfaceColoring::Attribute,
    (model->scalars.begin() + next)->name, colors.map, {} }
                                      : ColorChoice{};
}

}
