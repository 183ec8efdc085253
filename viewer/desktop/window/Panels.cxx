// SPDX-License-Identifier: BSD-3-Clause
// The panels of the window: see Panels.h. The list of blobs is in BlobTable.cxx.
#include "viewer/desktop/window/Panels.h"

#include "filters/program/ProgressReporter.h"
#include "viewer/desktop/window/ColorPanel.h"
#include "viewer/desktop/window/ToolsPanel.h"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>

namespace kdstream
{
namespace
{

// Sizes in points.
constexpr double tileWidth = 128;
constexpr double tileHeight = 104;
constexpr double tileText = 22;
constexpr double gap = 10;
constexpr double narrowWidth = 920; // narrower windows have no room for two panels

constexpr ImGuiWindowFlags plain = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNav |
                                   ImGuiWindowFlags_NoFocusOnAppearing;
constexpr ImGuiWindowFlags panel =
  ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoCollapse;

float Scaled(const PanelFacts& facts, double points)
{
  return static_cast<float>(points * facts.ratio);
}

ImVec2 Place(double x, double y)
{
  return { static_cast<float>(x), static_cast<float>(y) };
}

void Text(const std::string& text)
{
  ImGui::TextUnformatted(text.data(), text.data() + text.size());
}

const std::string& NameOf(const ModelSummary& model)
{
  return model.title.empty() ? model.id : model.title;
}

std::string SizeOf(const ModelSummary& model)
{
  return model.triangles > 0 ? CountText(static_cast<double>(model.triangles)) + " triangles"
                             : CountText(static_cast<double>(model.vertices)) + " points";
}

const ModelSummary* SelectedModel(const PanelFacts& facts)
{
  if (!facts.models)
  {
    return nullptr;
  }
  const auto found = std::find_if(facts.models->begin(), facts.models->end(),
    [&](const ModelSummary& model) { return model.id == facts.status.model; });
  return found == facts.models->end() ? nullptr : &*found;
}

bool HasSeveral(const PanelFacts& facts)
{
  return facts.models && facts.models->size() > 1;
}

SessionStep GoStep(const char* where)
{
  return { SessionStep::Kind::Go, {}, where };
}

// Returns "Level 14 of 16 · 33 k triangles"; or "Up to the original · 871 k triangles" if the
// budget leaves much of the surface coarser.
std::string DescribeSurface(const PanelFacts& facts)
{
  const ViewerStatus& status = facts.status;
  if (!status.shownLevel)
  {
    return "";
  }
  const bool original = status.original || (status.region && status.region->shown > 0);
  const bool isCut = status.remainingError > 2;
  const std::string level = std::to_string(*status.shownLevel);
  std::string text =
    isCut && original ? "Up to the original" : (isCut ? "Up to level " : "Level ") + level;
  if (facts.model && !original)
  {
    text += " of " + std::to_string(facts.model->depths.finest);
  }
  text += original && !isCut ? " and original" : "";
  return text + " · " +
         (status.triangles > 0 ? CountText(static_cast<double>(status.triangles)) + " triangles"
                               : CountText(static_cast<double>(status.vertices)) + " points");
}

bool Button(const char* label, bool isOn, const char* tip)
{
  if (isOn)
  {
    ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(ImGuiCol_ButtonActive));
  }
  const bool pressed = ImGui::Button(label);
  if (isOn)
  {
    ImGui::PopStyleColor();
  }
  if (ImGui::IsItemHovered())
  {
    ImGui::SetTooltip("%s", tip);
  }
  return pressed;
}

template <class Value>
void Choice(const char* label, Value& value, Value mine)
{
  if (ImGui::RadioButton(label, value == mine))
  {
    value = mine;
  }
}

}

double Panels::StripHeight(const PanelFacts& facts, const ViewSettings& settings) const
{
  const bool isShown = HasSeveral(facts) && settings.previews == PreviewPlace::Strip &&
                       facts.status.mode != ViewerMode::FullScreen && !this->bare;
  return isShown ? std::round((tileHeight + tileText + 2 * gap) * facts.ratio) : 0;
}

std::vector<Tile> Panels::TilesOf(const PanelFacts& facts, const ViewSettings& settings)
{
  std::vector<Tile> tiles;
  const double strip = this->StripHeight(facts, settings);
  if (!facts.models || (strip == 0 && !this->popUp))
  {
    return tiles;
  }
  const double width = tileWidth * facts.ratio;
  const double height = tileHeight * facts.ratio;
  const double space = gap * facts.ratio;
  const double stepX = width + space;
  const double stepY = height + tileText * facts.ratio + space;
  const double roomX = this->popUp ? 0.86 * facts.width : facts.width - 2 * stepX / 3;
  const double roomY = this->popUp ? 0.8 * facts.height : stepY;
  const auto columns = static_cast<std::size_t>(std::max(1.0, std::floor(roomX / stepX)));
  const auto rows = static_cast<std::size_t>(std::max(1.0, std::floor(roomY / stepY)));
  const std::size_t all = facts.models->size();
  const std::size_t shown = std::min(all, columns * rows);
  this->FirstTile = std::min(this->FirstTile, all - shown);
  const std::size_t across = std::min(shown, columns);
  const std::size_t down = (shown + columns - 1) / columns;
  const double left = std::round((facts.width - static_cast<double>(across) * stepX + space) / 2);
  const double top = this->popUp
                       ? std::round((facts.height - static_cast<double>(down) * stepY) / 2)
                       : facts.height - strip + space;
  for (std::size_t i = 0; i < shown; ++i)
  {
    const std::size_t column = i % columns;
    const std::size_t row = i / columns;
    tiles.push_back({ this->FirstTile + i, left + static_cast<double>(column) * stepX,
      top + static_cast<double>(row) * stepY, width, height });
  }
  return tiles;
}

PanelWishes Panels::Draw(const PanelFacts& facts, const std::vector<Tile>& tiles,
  const Previews* previews, ViewSettings& settings)
{
  PanelWishes wishes;
  if (!facts.models)
  {
    this->DrawOpening(facts, wishes);
    return wishes;
  }
  DrawDistances(facts);
  DrawColorLegend(facts, settings.scene.colors, this->StripHeight(facts, settings));
  this->DrawError(facts, wishes);
  this->DrawWarnings(facts);
  if (this->helpOpen)
  {
    DrawHelp(facts, this->helpOpen);
  }
  if (this->bare)
  {
    return wishes;
  }
  this->DrawTiles(facts, tiles, previews, wishes);
  this->DrawTitle(facts);
  this->DrawTools(facts, wishes);
  this->CloseCovered(facts);
  if (this->settingsOpen)
  {
    this->DrawSettings(facts, settings);
  }
  if (this->detailsOpen)
  {
    this->DrawDetails(facts);
  }
  if (this->toolsOpen)
  {
    DrawToolsPanel(facts, wishes, this->toolsOpen, this->BelowTitle);
  }
  if (this->notes.isOpen && facts.model)
  {
    wishes.notes = this->notes.Draw(*facts.notes, facts.width, facts.ratio);
  }
  return wishes;
}

// Tools and details appear in one place, settings and notes in another; in a narrow window, all
// appear in the same place. A panel that is opened closes the panel that was in its place.
void Panels::CloseCovered(const PanelFacts& facts)
{
  const std::array<bool*, 4> open{ &this->toolsOpen, &this->detailsOpen, &this->settingsOpen,
    &this->notes.isOpen };
  const bool isNarrow = facts.width < narrowWidth * facts.ratio;
  for (std::size_t i = 0; i < open.size(); ++i)
  {
    const bool appears = *open[i] && !this->WasOpen[i];
    for (std::size_t other = 0; appears && other < open.size(); ++other)
    {
      const bool isCovered = isNarrow || other / 2 == i / 2;
      *open[other] = *open[other] && (other == i || !isCovered);
    }
  }
  for (std::size_t i = 0; i < open.size(); ++i)
  {
    this->WasOpen[i] = *open[i];
  }
}

void Panels::DrawTools(const PanelFacts& facts, PanelWishes& wishes)
{
  ImGui::SetNextWindowPos(
    Place(facts.width - gap * facts.ratio, gap * facts.ratio), ImGuiCond_Always, { 1, 0 });
  ImGui::Begin("##tools", nullptr, plain | ImGuiWindowFlags_AlwaysAutoResize);
  const bool canGoBack = HasSeveral(facts) && facts.status.mode == ViewerMode::FullScreen;
  if (canGoBack && Button("Back", false, "Back to all models (Esc)"))
  {
    wishes.steps.push_back(GoStep("back"));
  }
  if (canGoBack)
  {
    ImGui::SameLine();
  }
  if (HasSeveral(facts))
  {
    if (Button("Models", this->popUp, "Previews of all models (M)"))
    {
      this->popUp = !this->popUp;
    }
    ImGui::SameLine();
  }
  if (Button("Home", false, "Back to the initial view (H)"))
  {
    wishes.steps.push_back(GoStep("home"));
  }
  ImGui::SameLine();
  ImGui::BeginDisabled(!facts.status.canUndo);
  if (Button("Undo", false, "Undo the last jump (U)"))
  {
    wishes.steps.push_back(GoStep("undo"));
  }
  ImGui::EndDisabled();
  ImGui::SameLine();
  if (Button("Picture", false, "Save a picture (S)"))
  {
    wishes.screenshot = true;
  }
  ImGui::SameLine();
  if (Button("Tools", this->toolsOpen, "Views, distances, links (T)"))
  {
    this->toolsOpen = !this->toolsOpen;
  }
  ImGui::SameLine();
  if (Button("Details", this->detailsOpen, "Statistics of the view and the stream (D)"))
  {
    this->detailsOpen = !this->detailsOpen;
  }
  ImGui::SameLine();
  if (Button("Settings", this->settingsOpen, "Detail, turning, colours (O)"))
  {
    this->settingsOpen = !this->settingsOpen;
  }
  ImGui::SameLine();
  if (Button(facts.fullScreen ? "Window" : "Full screen", false, "Full screen on or off (F)"))
  {
    wishes.fullScreen = true;
  }
  ImGui::SameLine();
  if (Button("?", this->helpOpen, "Mouse and keys (F1)"))
  {
    this->helpOpen = !this->helpOpen;
  }
  ImGui::End();
}

void Panels::DrawTitle(const PanelFacts& facts)
{
  const ModelSummary* model = SelectedModel(facts);
  if (!model)
  {
    this->BelowTitle = Scaled(facts, 64); // the settings then start just below the tools
    return;
  }
  // The title goes below the tools if there is no room beside them.
  const bool isNarrow = facts.width < narrowWidth * facts.ratio;
  ImGui::SetNextWindowPos(Place(gap * facts.ratio, (isNarrow ? 62 : gap) * facts.ratio));
  ImGui::Begin("##title", nullptr, plain | ImGuiWindowFlags_AlwaysAutoResize);
  Text(NameOf(*model));
  if (facts.model)
  {
    const auto& [credit, license] = std::tie(facts.model->credit, facts.model->license);
    const std::string origin = credit + (credit.empty() || license.empty() ? "" : " · ") + license;
    if (!origin.empty())
    {
      ImGui::TextDisabled("%s", origin.c_str());
    }
  }
  this->DrawNotesButton(facts);
  const std::string surface = DescribeSurface(facts);
  ImGui::TextDisabled("%s", surface.empty() ? "Loading" : surface.c_str());
  if (facts.status.blobsWanted > 0)
  {
    const auto loaded = static_cast<double>(facts.status.blobsLoaded);
    const std::string text = std::to_string(facts.status.blobsLoaded) + " of " +
                             std::to_string(facts.status.blobsWanted) + ", " +
                             BytesText(static_cast<double>(facts.status.bytesLoaded));
    ImGui::ProgressBar(static_cast<float>(loaded / static_cast<double>(facts.status.blobsWanted)),
      { Scaled(facts, 200), 0 }, text.c_str());
  }
  if (facts.recording)
  {
    Text("Recording");
  }
  if (!facts.note.empty())
  {
    Text(facts.note);
  }
  this->BelowTitle = ImGui::GetWindowPos().y + ImGui::GetWindowHeight() + Scaled(facts, gap);
  ImGui::End();
}

void Panels::DrawNotesButton(const PanelFacts& facts)
{
  const std::size_t count = facts.model ? facts.notes->Notes().size() : 0;
  if (count == 0)
  {
    return;
  }
  const std::string label = std::to_string(count) + (count == 1 ? " note" : " notes");
  if (ImGui::SmallButton((label + "###notes").c_str()))
  {
    this->notes.isOpen = !this->notes.isOpen;
  }
}

void Panels::DrawTiles(const PanelFacts& facts, const std::vector<Tile>& tiles,
  const Previews* previews, PanelWishes& wishes)
{
  if (tiles.empty())
  {
    return;
  }
  const double space = 0.5 * gap * facts.ratio;
  const double text = tileText * facts.ratio;
  const double left = tiles.front().left - 8 * space;
  double right = 0;
  for (const Tile& tile : tiles)
  {
    right = std::max(right, tile.left + tile.width + 8 * space);
  }
  const double top = tiles.front().top - space;
  const double bottom = tiles.back().top + tiles.back().height + text + space;
  ImGui::SetNextWindowPos(Place(left, top));
  ImGui::SetNextWindowSize(Place(right - left, bottom - top));
  // The previews are drawn below this window, so it must not cover them.
  ImGui::Begin("##models", nullptr,
    plain | ImGuiWindowFlags_NoBackground | ImGuiWindowFlags_NoScrollWithMouse);
  if (ImGui::IsWindowHovered() && ImGui::GetIO().MouseWheel != 0)
  {
    const bool back = ImGui::GetIO().MouseWheel > 0;
    this->FirstTile =
      back ? this->FirstTile - std::min<std::size_t>(this->FirstTile, 1) : this->FirstTile + 1;
  }
  // Buttons to scroll, if there are more previews than there is room for.
  const double middle = tiles.front().top + 0.4 * tiles.front().height;
  if (this->FirstTile > 0)
  {
    ImGui::SetCursorScreenPos(Place(left, middle));
    this->FirstTile -= ImGui::Button("<") ? std::min(this->FirstTile, tiles.size()) : 0;
  }
  if (tiles.back().model + 1 < facts.models->size())
  {
    ImGui::SetCursorScreenPos(Place(right - 6 * space, middle));
    this->FirstTile += ImGui::Button(">") ? tiles.size() : 0;
  }
  for (const Tile& tile : tiles)
  {
    const ModelSummary& model = (*facts.models)[tile.model];
    ImGui::PushID(static_cast<int>(tile.model));
    ImGui::SetCursorScreenPos(Place(tile.left, tile.top));
    if (ImGui::InvisibleButton("##tile", Place(tile.width, tile.height + text)))
    {
      wishes.open = tile.model;
    }
    const bool isSelected = model.id == facts.status.model;
    const bool isHovered = ImGui::IsItemHovered();
    ImDrawList& drawing = *ImGui::GetWindowDrawList();
    const ImVec2 corner = Place(tile.left, tile.top);
    const ImVec2 end = Place(tile.left + tile.width, tile.top + tile.height);
    const auto edge = ImGui::GetColorU32(ImGui::GetStyleColorVec4(ImGuiCol_CheckMark));
    drawing.AddRect(corner, end,
      isSelected || isHovered ? edge : ImGui::GetColorU32(ImGuiCol_Border), 0, 0,
      Scaled(facts, isSelected || isHovered ? 2 : 1));
    drawing.AddRectFilled(Place(tile.left, tile.top + tile.height),
      Place(tile.left + tile.width, tile.top + tile.height + text),
      ImGui::GetColorU32(ImGuiCol_WindowBg));
    drawing.PushClipRect(
      corner, Place(tile.left + tile.width, tile.top + tile.height + text), true);
    drawing.AddText(Place(tile.left, tile.top + tile.height + 3 * facts.ratio),
      ImGui::GetColorU32(ImGuiCol_Text), NameOf(model).c_str());
    drawing.PopClipRect();
    if (isHovered)
    {
      const std::string& trouble = previews->TroubleOf(tile.model);
      ImGui::SetTooltip("%s\n%s%s%s", NameOf(model).c_str(), SizeOf(model).c_str(),
        trouble.empty() ? "" : "\n", trouble.c_str());
    }
    ImGui::PopID();
  }
  ImGui::End();
}

void Panels::DrawSettings(const PanelFacts& facts, ViewSettings& settings)
{
  ImGui::SetNextWindowPos(
    Place(facts.width - gap * facts.ratio, 64 * facts.ratio), ImGuiCond_Appearing, { 1, 0 });
  ImGui::Begin("Settings", &this->settingsOpen, panel | ImGuiWindowFlags_AlwaysAutoResize);
  Text("Detail");
  Choice("Where I look", settings.detail, DetailMode::View);
  ImGui::SameLine();
  Choice("Same everywhere", settings.detail, DetailMode::Level);
  ImGui::SameLine();
  Choice("All of the original", settings.detail, DetailMode::Full);
  Text("Turning");
  Choice("Upright", settings.turning, Turning::Upright);
  ImGui::SameLine();
  Choice("Free", settings.turning, Turning::Free);
  Text("Original around a double click");
  Choice("Near", settings.rings, 1u);
  ImGui::SameLine();
  Choice("Wide", settings.rings, 2u);
  ImGui::SameLine();
  Choice("Widest", settings.rings, 3u);
  ImGui::Checkbox("Boxes of its partitions", &settings.scene.boxes);
  DrawColorChoice(facts, settings.scene.colors);
  ImGui::Checkbox("Relief (ambient occlusion)", &settings.scene.occlusion);
  Text("At most");
  auto triangles = static_cast<float>(settings.triangles) / 1e6f;
  if (ImGui::SliderFloat("million triangles", &triangles, 0.01f, 20.0f, "%.2f",
        ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp))
  {
    settings.triangles = static_cast<std::uint64_t>(triangles * 1e6f);
  }
  auto memory = static_cast<int>(settings.memory >> 20);
  if (ImGui::SliderInt("MiB of memory", &memory, 32, 16384, "%d",
        ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp))
  {
    settings.memory = static_cast<std::uint64_t>(memory) << 20;
  }
  ImGui::Checkbox("Prefetch what may be needed next", &settings.prefetch);
  if (HasSeveral(facts))
  {
    Text("Previews");
    Choice("At the bottom", settings.previews, PreviewPlace::Strip);
    ImGui::SameLine();
    Choice("On demand", settings.previews, PreviewPlace::PopUp);
  }
  ImGui::End();
}

void Panels::DrawDetails(const PanelFacts& facts)
{
  ImGui::SetNextWindowPos(Place(gap * facts.ratio, this->BelowTitle), ImGuiCond_Appearing);
  ImGui::SetNextWindowSize(Place(560 * facts.ratio, 420 * facts.ratio), ImGuiCond_Appearing);
  // As wide as the columns need, if the window has room.
  const double most = facts.width - 2 * gap * facts.ratio;
  ImGui::SetNextWindowSizeConstraints(
    Place(std::min<double>(this->DetailsWidth, most), 0), Place(FLT_MAX, FLT_MAX));
  if (ImGui::Begin("Details", &this->detailsOpen, panel))
  {
    if (facts.model && !facts.model->description.empty())
    {
      ImGui::PushTextWrapPos(0);
      Text(facts.model->description);
      ImGui::PopTextWrapPos();
      ImGui::Separator();
    }
    this->DetailsWidth = std::max(this->DetailsWidth, DrawFacts(facts));
    this->DetailsWidth = std::max(this->DetailsWidth, DrawBlobTable(*facts.blobs, facts.ratio));
  }
  ImGui::End();
}

void Panels::DrawOpening(const PanelFacts& facts, PanelWishes& wishes) const
{
  ImGui::SetNextWindowPos(
    Place(facts.width / 2.0, facts.height / 2.0), ImGuiCond_Always, { 0.5f, 0.5f });
  ImGui::Begin("##opening", nullptr, plain | ImGuiWindowFlags_AlwaysAutoResize);
  ImGui::PushTextWrapPos(Scaled(facts, 480));
  Text(facts.trouble.empty() ? facts.opening : facts.trouble);
  ImGui::PopTextWrapPos();
  if (!facts.trouble.empty() && ImGui::Button("Try again"))
  {
    wishes.retry = true;
  }
  if (!facts.trouble.empty())
  {
    ImGui::SameLine();
  }
  if (ImGui::Button(facts.trouble.empty() ? "Cancel" : "Quit"))
  {
    wishes.quit = true;
  }
  ImGui::End();
}

void Panels::DrawError(const PanelFacts& facts, PanelWishes& wishes)
{
  const std::string& error = facts.status.error;
  if (error.empty() || error == this->dismissed)
  {
    this->dismissed = error.empty() ? "" : this->dismissed;
    return;
  }
  ImGui::SetNextWindowPos(
    Place(facts.width / 2.0, 72 * facts.ratio), ImGuiCond_Always, { 0.5f, 0 });
  ImGui::Begin("##error", nullptr, plain | ImGuiWindowFlags_AlwaysAutoResize);
  ImGui::PushTextWrapPos(Scaled(facts, 560));
  Text(error);
  ImGui::PopTextWrapPos();
  if (ImGui::Button("Try again"))
  {
    wishes.retry = true;
  }
  ImGui::SameLine();
  if (ImGui::Button("Dismiss"))
  {
    this->dismissed = error;
  }
  ImGui::End();
}

// Warnings are not shown while an error is shown in the same place, because the error is more
// important.
void Panels::DrawWarnings(const PanelFacts& facts)
{
  const std::string& error = facts.status.error;
  const bool isErrorReported = !error.empty() && error != this->dismissed;
  if (facts.warnings.empty() || facts.warnings == this->warned || isErrorReported)
  {
    return;
  }
  ImGui::SetNextWindowPos(
    Place(facts.width / 2.0, 72 * facts.ratio), ImGuiCond_Always, { 0.5f, 0 });
  ImGui::Begin("##warnings", nullptr, plain | ImGuiWindowFlags_AlwaysAutoResize);
  ImGui::PushTextWrapPos(Scaled(facts, 560));
  Text(facts.warnings);
  ImGui::PopTextWrapPos();
  if (ImGui::Button("Dismiss"))
  {
    this->warned = facts.warnings;
  }
  ImGui::End();
}

}
