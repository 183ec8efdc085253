// SPDX-License-Identifier: BSD-3-Clause
// One window, one user, one session: what ViewInWindow shows. Its source is in four files:
// WindowView.cxx draws frames, WindowCommands.cxx performs the user's commands, WindowNotes.cxx
// performs the commands about notes, WindowOutputs.cxx writes and copies.
#pragma once

#include "filters/core/Result.h"
#include "viewer/desktop/RegionBoxes.h"
#include "viewer/desktop/SessionScene.h"
#include "viewer/desktop/ViewOptions.h"
#include "viewer/desktop/ViewReport.h"
#include "viewer/desktop/window/DisplayWindow.h"
#include "viewer/desktop/window/InterfaceLayer.h"
#include "viewer/desktop/window/Panels.h"
#include "viewer/desktop/window/ScreenClipboard.h"
#include "viewer/desktop/window/WindowInput.h"
#include "viewer/desktop/window/WindowSession.h"
#include "viewer/rendering/Picture.h"
#include "viewer/session/appearance/OcclusionClock.h"

#include <vtkNew.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

class vtkRenderer;

namespace kdstream
{

// The time of a steady clock, in seconds.
inline double SteadySeconds()
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

inline constexpr std::size_t windowPrefetchBytes = std::size_t{ 1 } << 20;

// What a picture depends on: two pictures with equal values look the same.
struct SceneSight
{
  std::uint64_t surfaceVersion = 0;
  Vec3 eye, focal, up;
  std::optional<SectionPlane> section{};
  SceneLighting lighting{};
  bool operator==(const SceneSight&) const = default;
};

class WindowController
{
public:
  WindowController(std::string program, const ViewOptions& options,
    std::unique_ptr<DisplayWindow> display, SessionRecorder recorder);

  void Run();
  bool IsOpen() const { return this->Session.IsOpen(); }
  int ExitCode() const { return this->Session.ExitCode(); }
  // Writes the outputs that the command line asks for at the end.
  Status Finish();

private:
  double Wait();
  void TakeEvents();
  bool Handle(const WindowEvent& event);
  bool HandleKey(const WindowEvent& event);
  bool HandleToolKey(const std::string& key);
  void TakeTool(Tool tool);
  void TakeNews();
  void GoBack();
  void Frame();
  std::vector<PanelWishes> DescribePanels(double seconds, ViewSettings& settings);
  void DrawPicture();
  void Layout();
  PanelFacts Facts() const;
  void AddTools(PanelFacts& facts) const;
  void Copy(const std::string& text, const std::string& what);
  void CopyLink();
  void CopyMeasurements();
  void SaveOutline();
  void Apply(const ViewSettings& settings);
  void Apply(const SceneSettings& before);
  void Fulfil(const PanelWishes& wishes);
  void Fulfil(const NotesWishes& wishes);
  void ShowNote(std::size_t index);
  void SaveNotes();
  void End();
  void AskForPicture();
  void TakePicture();
  Status WriteModelPicture(const std::string& file);
  Status WriteSpecifiedPicture(const std::string& file);
  Result<WindowPicture> PictureWith(InterfaceLayer::Part part);
  void Tell(const std::string& note);
  std::string Link() const { return LinkTo(this->Session.Viewer(), this->Settings.scene); }
  void WakeIf(bool changed) { this->FramesLeft = changed ? 2 : this->FramesLeft; }
  // Drawing the turning previews takes at most a quarter of the time, so that a slow machine can
  // draw the model.
  double TurningPause() const
  {
    constexpr double least = 0.05; // s, between frames of the previews
    constexpr double share = 0.25; // of the time that drawing them may take
    return std::max(least, this->FrameSeconds / share);
  }
  bool OcclusionPending(double now)
  {
    return this->LacksOcclusion && this->Occlusion.Has(false, now);
  }
  bool PreviewsTurn() const { return this->Shelf && this->Shelf->AnyIsShown(); }

  ViewOptions Options;
  std::unique_ptr<DisplayWindow> Display;

  vtkNew<vtkRenderer> Ground; // drawn first, behind everything
  SessionScene Scene;
  RegionBoxes Boxes;
  InterfaceLayer Interface;
  Panels Words;
  ViewSettings Settings;
  WindowInput Input;
  ScreenClipboard Clipboard;
  WindowSession Session;
  ViewReport Report;

  std::unique_ptr<Previews> Shelf; // once the models are known
  std::string Titled;              // the model that the window's title names

  std::vector<Tile> Tiles;
  Viewport View;
  OcclusionClock Occlusion;
  bool LacksOcclusion = false;    // the current picture lacks the occlusion that it should have
  std::optional<SceneSight> Seen; // what the last picture showed
  bool PressIsOfPanels = false;
  bool Ended = false;
  bool AskedToSave = false; // whether the user was asked to save notes before the end
  bool PicturePending = false;
  int CaptionHeight = 0;          // of the picture that was asked for, pixels
  std::deque<WindowEvent> Events; // that have not been handled yet
  // The frames still to draw. Each change asks for two, because panels get their size in the
  // second.
  int FramesLeft = 2;
  double LastFrame = SteadySeconds(), LastTurn = SteadySeconds(), FrameSeconds = 0;
  std::string Note;
  double NoteUntil = 0;
};

}
