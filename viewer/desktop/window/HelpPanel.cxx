// SPDX-License-Identifier: BSD-3-Clause

#include "viewer/desktop/window/Panels.h"

#include <imgui.h>

#include <array>

namespace kdstream
{

void DrawHelp(const PanelFacts& facts, bool& isOpen)
{
  constexpr ImGuiWindowFlags panel = ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNav |
                                     ImGuiWindowFlags_NoCollapse |
                                     ImGuiWindowFlags_AlwaysAutoResize;
  const auto middle = [](int side) { return static_cast<float>(side) / 2; };
  struct Line
  {
    const char *what, *how;
  };
  static constexpr std::array<Line, 25> lines{ {
    { "Drag, one finger, arrow keys", "turn" },
    { "Right drag, Shift and drag, two fingers", "move" },
    { "Wheel, pinch, + and -", "nearer and farther" },
    { "Double click, double tap, Return", "the original there, at once" },
    { "Double click beside the model, H, Home", "the first view again" },
    { "U, Backspace", "the view before the last jump" },
    { "Click on a preview, Page Up, Page Down", "another model" },
    { "M", "previews of all models" },
    { "Esc", "back, one thing after the other" },
    { "S, F12", "write a picture" },
    { "T", "tools: sides, distances, section, light, links" },
    { "1 to 6", "from the front, back, left, right, top, bottom" },
    { "R", "clicks measure, or not" },
    { "C", "cut it open: the mouse moves the section, or not" },
    { "I", "the light comes from the mouse, or not" },
    { "L", "copy a link to this view" },
    { "N", "notes on the model: read them, write them" },
    { "D", "what is shown, and what came of it" },
    { "O", "settings" },
    { "K", "colours: by the next array of the model" },
    { "B", "boxes of the partitions around a double click" },
    { "Tab", "the model alone, without words" },
    { "F, F11", "full screen" },
    { "F1, ?", "this list" },
    { "Q, Ctrl-Q", "end" },
  } };
  ImGui::SetNextWindowPos(
    { middle(facts.width), middle(facts.height) }, ImGuiCond_Appearing, { 0.5f, 0.5f });
  ImGui::Begin("Mouse, fingers and keys", &isOpen, panel);
  if (ImGui::BeginTable("##help", 2, ImGuiTableFlags_SizingFixedFit))
  {
    for (const auto& [what, how] : lines)
    {
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(what);
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(how);
    }
    ImGui::EndTable();
  }
  ImGui::End();
}

}
