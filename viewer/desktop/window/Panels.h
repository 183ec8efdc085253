// SPDX-License-Identifier: BSD-3-Clause
// The panels of the window, in Dear ImGui. They only report what their buttons ask for; the window
// does it.
#pragma once

#include "filters/model/ModelDescription.h"
#include "viewer/desktop/Distances.h"
#include "viewer/desktop/SettingSteps.h"
#include "viewer/desktop/window/NotesPanel.h"
#include "viewer/desktop/window/Previews.h"
#include "viewer/session/SessionFile.h"
#include "viewer/session/SessionTypes.h"
#include "viewer/session/ViewerSession.h"

#include <array>
#include <deque>
#include <optional>
#include <string>
#include <vector>

namespace kdstream
{

// Where the previews of a server with several models are shown (paper, section 5.1).
enum class PreviewPlace
{
  Strip, // at the bottom, while no model fills the window
  PopUp  // over the model, on request
};

struct ViewSettings
{
  DetailMode detail = DetailMode::View;
  Turning turning = Turning::Upright;
  SceneSettings scene;
  unsigned rings = 1;
  std::uint64_t triangles = 0, memory = 0; // budgets
  bool prefetch = true;
  PreviewPlace previews = PreviewPlace::Strip;
  bool operator==(const ViewSettings&) const = default;
};

// The values that panels show.
struct PanelFacts
{
  int width = 0, height = 0; // of the window, pixels
  double ratio = 1;          // pixels per point
  bool fullScreen = false;   // whether the window fills the screen
  bool recording = false;

  const std::vector<ModelSummary>* models = nullptr; // null: the list is not known yet
  std::string opening;                               // progress, until the list is known
  std::string trouble;                               // why the list cannot be loaded
  std::string warnings;                              // warnings about the source

  ViewerStatus status;
  const ModelDescription* model = nullptr; // the open model
  const std::deque<BlobStatistics>* blobs = nullptr;
  SessionTraffic traffic;
  double frameSeconds = 0; // of the last frame
  std::uint64_t residentBytes = 0;
  std::string note; // shown for a moment
  Tool tool = Tool::None;
  std::vector<SeenMeasurement> measurements;
  Vec3 up{ 0, 1, 0 };                 // of the model
  std::optional<double> sectionDepth; // nothing if there is no section
  std::optional<RakingLight> light;   // nothing: the standard light
  const NotesBook* notes = nullptr;
};

// What the user asked for in one frame.
struct PanelWishes
{
  std::vector<SessionStep> steps;
  std::optional<std::size_t> open; // a model
  std::optional<std::size_t> removeMeasurement;
  std::optional<std::pair<std::size_t, std::string>> nameMeasurement;
  std::optional<bool> spin;
  bool fullScreen = false, screenshot = false, retry = false, quit = false;
  NotesWishes notes;
  bool copyLink = false, copyMeasurements = false, saveOutline = false;
};

class Panels
{
public:
  bool settingsOpen = false, detailsOpen = false, helpOpen = false, toolsOpen = false;
  NotesPanel notes;
  bool popUp = false;    // the previews
  bool bare = false;     // only the model
  std::string dismissed; // an error that the user has closed
  std::string warned;    // warnings that the user has closed

  // The tiles of the previews in this frame. Those of the strip take room from the model.
  std::vector<Tile> TilesOf(const PanelFacts& facts, const ViewSettings& settings);
  // Height of the strip, pixels; 0 if there is none.
  double StripHeight(const PanelFacts& facts, const ViewSettings& settings) const;

  // Call this between Begin and End of an InterfaceLayer. previews: null before the models are
  // known.
  PanelWishes Draw(const PanelFacts& facts, const std::vector<Tile>& tiles,
    const Previews* previews, ViewSettings& settings);

private:
  void CloseCovered(const PanelFacts& facts);
  void DrawTools(const PanelFacts& facts, PanelWishes& wishes);
  void DrawTitle(const PanelFacts& facts);
  void DrawNotesButton(const PanelFacts& facts);
  void DrawTiles(const PanelFacts& facts, const std::vector<Tile>& tiles, const Previews* previews,
    PanelWishes& wishes);
  void DrawSettings(const PanelFacts& facts, ViewSettings& settings);
  void DrawDetails(const PanelFacts& facts);
  void DrawOpening(const PanelFacts& facts, PanelWishes& wishes) const;
  void DrawError(const PanelFacts& facts, PanelWishes& wishes);
  void DrawWarnings(const PanelFacts& facts);

  std::size_t FirstTile = 0;     // number of the model in the first tile
  float DetailsWidth = 0;        // the largest width of its columns so far, pixels
  float BelowTitle = 0;          // pixels
  std::array<bool, 4> WasOpen{}; // in the last frame: tools, details, settings, notes
};

// Draws figures about what is shown, and a table with a row for each blob (paper, Tables 4-6),
// within a window. Returns the window's width in pixels at which nothing is cut off; it is known
// from the second frame on.
float DrawFacts(const PanelFacts& facts);
// Draws the table of blobs, the newest first. ratio: pixels per point.
float DrawBlobTable(const std::deque<BlobStatistics>& blobs, double ratio);

// Draws a list of what mouse, fingers and keys do, in a window with a button that closes it.
void DrawHelp(const PanelFacts& facts, bool& isOpen);

}
