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
    { "Wheel, pinch, + and -", "zoom in and out" },
    { "Double click, double tap, Return", "show the original there" },
    { "Double click beside the model, H, Home", "back to the initial view" },
    { "U, Backspace", "undo the last jump" },
    { "Click on a preview, Page Up, Page Down", "another model" },
    { "M", "previews of all models" },
    { "Esc", "close or go back, one step at a time" },
    { "S, F12", "save a picture" },
    { "T", "tools: views, distances, section, light, links" },
    { "1 to 6", "look from front, back, left, right, top, bottom" },
    { "R", "measure with clicks: on, off" },
    { "C", "move the section with the mouse: on, off" },
    { "I", "move the light with the mouse: on, off" },
    { "L", "copy a link to this view" },
    { "N", "read and write notes on the model" },
    { "D", "statistics of the view and the stream" },
    { "O", "settings" },
    { "K", "colour by the next array" },
    { "B", "boxes of the partitions of the original region" },
    { "Tab", "hide all panels" },
    { "F, F11", "full screen" },
    { "F1, ?", "this list" },
    { "Q, Ctrl-Q", "quit" },
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
