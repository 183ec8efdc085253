// SPDX-License-Identifier: BSD-3-Clause
// The panel of tools: see ToolsPanel.h.
#include "viewer/desktop/window/ToolsPanel.h"

#include "viewer/desktop/window/Panels.h"

#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace kdstream
{
namespace
{

constexpr ImU32 lineColor = IM_COL32(255, 209, 102, 255), shadowColor = IM_COL32(10, 12, 15, 200);

void Say(const std::string& text)
{
  ImGui::TextUnformatted(text.data(), text.data() + text.size());
}

void DrawSides(const PanelFacts& facts, PanelWishes& wishes)
{
  Say("Look from");
  static constexpr std::array<std::pair<const char*, const char*>, 6> sides{ { { "Front", "front" },
    { "Back", "back" }, { "Left", "left" }, { "Right", "right" }, { "Top", "top" },
    { "Bottom", "bottom" } } };
  for (std::size_t i = 0; i < sides.size(); ++i)
  {
    if (i % 3 != 0)
    {
      ImGui::SameLine();
    }
    if (ImGui::Button(sides[i].first, { static_cast<float>(76 * facts.ratio), 0 }))
    {
      wishes.steps.push_back({ SessionStep::Kind::Side, {}, sides[i].second });
    }
  }
  bool spins = facts.status.spinning;
  ImGui::BeginDisabled(facts.recording); // session files do not record turning
  if (ImGui::Checkbox("Turn automatically", &spins))
  {
    wishes.spin = spins;
  }
  ImGui::EndDisabled();
}

// A text field for the name of a distance.
void DrawName(
  const PanelFacts& facts, const std::string& name, std::size_t index, PanelWishes& wishes)
{
  std::string text = name;
  ImGui::SetNextItemWidth(static_cast<float>(90 * facts.ratio));
  if (ImGui::InputText("##name", &text))
  {
    wishes.nameMeasurement = { index, text };
  }
  ImGui::SameLine();
}

void DrawList(const PanelFacts& facts, PanelWishes& wishes)
{
  const std::string unit = facts.model ? facts.model->unit : "";
  for (std::size_t i = 0; i < facts.measurements.size(); ++i)
  {
    ImGui::PushID(static_cast<int>(i));
    if (ImGui::SmallButton("Remove"))
    {
      wishes.removeMeasurement = i;
    }
    ImGui::SameLine();
    const Measurement& each = facts.measurements[i].measurement;
    DrawName(facts, each.name, i, wishes);
    std::string text = DescribeMeasurement(each, facts.up, unit);
    const std::size_t comma = text.find(", height"); // break the text into two lines there
    Say(comma == std::string::npos ? text : text.replace(comma, 2, "\n"));
    ImGui::PopID();
  }
}

}

std::string DescribeMeasurement(
  const Measurement& measurement, const Vec3& up, const std::string& unit)
{
  if (!measurement.to)
  {
    return "from here to …";
  }
  const double error = measurement.Error();
  const auto length = [&](double value) { return WithUnit(LengthText(value, error), unit); };
  const bool waits = measurement.from.waits || measurement.to->waits;
  return LengthText(measurement.Distance(), error) +
         (error > 0 ? " ± " + LengthText(error, error / 2) : "") + WithUnit("", unit) +
         (waits                    ? " (the original is loading)"
           : measurement.IsExact() ? ""
                                   : " (of a coarser level)") +
         ", height " + length(measurement.Height(up)) + ", across " +
         length(measurement.Horizontal(up));
}

namespace
{

void AskForTool(
  const PanelFacts& facts, PanelWishes& wishes, const char* text, Tool tool, const char* word)
{
  bool has = facts.tool == tool;
  if (ImGui::Checkbox(text, &has))
  {
    wishes.steps.push_back({ SessionStep::Kind::Tool, {}, has ? word : "none" });
  }
}

// A slider from 0 to 100 % of `most`. Returns whether it was moved.
bool Slider(const PanelFacts& facts, const char* text, double& value, double most)
{
  auto percent = static_cast<float>(100 * value / most);
  ImGui::SetNextItemWidth(static_cast<float>(160 * facts.ratio));
  const bool moved =
    ImGui::SliderFloat(text, &percent, 0, 100, "%.0f %%", ImGuiSliderFlags_AlwaysClamp);
  value = moved ? percent / 100 * most : value;
  return moved;
}

void DrawSection(const PanelFacts& facts, PanelWishes& wishes)
{
  Say("Section");
  static constexpr std::array<std::pair<const char*, const char*>, 6> words{
    { { "From the front", "front" }, { "From the side", "side" }, { "From above", "above" },
      { "Facing me", "view" }, { "Other side", "flip" }, { "None", "off" } }
  };
  ImGui::PushID("section");
  for (std::size_t i = 0; i < words.size(); ++i)
  {
    if (ImGui::Button(words[i].first))
    {
      wishes.steps.push_back({ SessionStep::Kind::Section, {}, words[i].second });
    }
    if (i % 3 != 2)
    {
      ImGui::SameLine();
    }
  }
  if (facts.sectionDepth)
  {
    double depth = *facts.sectionDepth;
    if (Slider(facts, "is cut away", depth, 1))
    {
      SessionStep step{ SessionStep::Kind::Depth, {} };
      step.factor = depth;
      wishes.steps.push_back(step);
    }
    AskForTool(facts, wishes, "Move by mouse, right drag turns (C)", Tool::Section, "section");
    wishes.saveOutline |= ImGui::Button("Save outline");
  }
  ImGui::PopID();
}

void DrawLight(const PanelFacts& facts, PanelWishes& wishes)
{
  Say("Light");
  AskForTool(facts, wishes, "Light from the mouse (I)", Tool::Light, "light");
  AskForTool(facts, wishes, "Second light from the mouse", Tool::SecondLight, "second light");
  if (!facts.light)
  {
    return;
  }
  RakingLight light = *facts.light;
  bool moved = Slider(facts, "bright", light.lightSource.intensity, RakingLight::mostIntensity);
  if (light.second)
  {
    moved |= Slider(facts, "the second", light.second->intensity, RakingLight::mostIntensity);
  }
  moved |= Slider(facts, "relief", light.relief, 1);
  const bool standard = ImGui::Button("Standard light");
  if (moved || standard)
  {
    wishes.steps.push_back({ SessionStep::Kind::Lights, {},
      FormatLights(standard ? std::nullopt : std::optional(light)) });
  }
}

}

void DrawToolsPanel(const PanelFacts& facts, PanelWishes& wishes, bool& isOpen, float top)
{
  const auto scaled = [&](double points) { return static_cast<float>(points * facts.ratio); };
  ImGui::SetNextWindowPos({ scaled(10), top }, ImGuiCond_Appearing);
  if (ImGui::Begin("Tools", &isOpen,
        ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoCollapse |
          ImGuiWindowFlags_AlwaysAutoResize))
  {
    DrawSides(facts, wishes);
    ImGui::Separator();
    Say("Distances");
    AskForTool(facts, wishes, "Measure: click two points (R)", Tool::Measure, "measure");
    DrawList(facts, wishes);
    if (!facts.measurements.empty() && ImGui::Button("Copy as text"))
    {
      wishes.copyMeasurements = true;
    }
    ImGui::Separator();
    DrawSection(facts, wishes);
    ImGui::Separator();
    DrawLight(facts, wishes);
    ImGui::Separator();
    Say("This view");
    if (ImGui::Button("Copy link (L)"))
    {
      wishes.copyLink = true;
    }
  }
  ImGui::End();
}

void DrawDistances(const PanelFacts& facts)
{
  ImDrawList& drawList = *ImGui::GetBackgroundDrawList();
  const auto scaled = [&](double points) { return static_cast<float>(points * facts.ratio); };
  const auto place = [](const std::array<double, 2>& pixel)
  { return ImVec2(static_cast<float>(pixel[0]), static_cast<float>(pixel[1])); };
  for (const SeenMeasurement& each : facts.measurements)
  {
    for (const auto& end : { each.from, each.to })
    {
      if (end)
      {
        drawList.AddCircleFilled(place(*end), scaled(5), shadowColor);
        drawList.AddCircleFilled(place(*end), scaled(4), lineColor);
      }
    }
    if (!each.from || !each.to)
    {
      continue;
    }
    const ImVec2 from = place(*each.from), to = place(*each.to);
    drawList.AddLine(from, to, shadowColor, scaled(4));
    drawList.AddLine(from, to, lineColor, scaled(2));
    const std::string text = DistanceText(each.measurement, facts.model ? facts.model->unit : "");
    const ImVec2 size = ImGui::CalcTextSize(text.c_str());
    const ImVec2 at((from.x + to.x - size.x) / 2, (from.y + to.y) / 2 - size.y - scaled(6));
    drawList.AddRectFilled({ at.x - scaled(4), at.y - scaled(1) },
      { at.x + size.x + scaled(4), at.y + size.y + scaled(1) }, shadowColor, scaled(3));
    drawList.AddText(at, lineColor, text.c_str());
  }
}

int DrawCaption(const PanelFacts& facts, int width)
{
  if (!facts.model)
  {
    return 0;
  }
  const ModelDescription& model = *facts.model;
  std::string text;
  for (const std::string& each :
    { model.title.empty() ? model.id : model.title, model.credit, model.license })
  {
    text += (text.empty() || each.empty() ? "" : "\n") + each;
  }
  const auto gap = static_cast<float>(8 * facts.ratio);
  const float room = static_cast<float>(width) - 2 * gap;
  const ImVec2 size = ImGui::CalcTextSize(text.c_str(), nullptr, false, room);
  const int height = static_cast<int>(std::ceil(size.y + 2 * gap));
  ImDrawList& drawList = *ImGui::GetForegroundDrawList();
  drawList.AddRectFilled(
    { 0, 0 }, { static_cast<float>(width), static_cast<float>(height) }, IM_COL32(26, 28, 32, 255));
  drawList.AddText(ImGui::GetFont(), ImGui::GetFontSize(), { gap, gap },
    IM_COL32(240, 236, 228, 255), text.c_str(), nullptr, room);
  return height;
}

}
