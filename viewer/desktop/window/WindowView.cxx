// SPDX-License-Identifier: BSD-3-Clause
// A look in a window: see WindowView.h. Steps of a frame: 1. what people did  2. what has come
// 3. the session's choice and surface  4. words and buttons  5. the picture.
#include "viewer/desktop/window/WindowView.h"

#include "viewer/desktop/OpenSource.h"
#include "viewer/desktop/RegionBoxes.h"
#include "viewer/desktop/SettingSteps.h"
#include "viewer/desktop/ViewReport.h"
#include "viewer/desktop/window/DisplayWindow.h"
#include "viewer/desktop/window/InterfaceLayer.h"
#include "viewer/desktop/window/Panels.h"
#include "viewer/desktop/window/ScreenClipboard.h"
#include "viewer/desktop/window/ToolsPanel.h"
#include "viewer/desktop/window/WindowInput.h"
#include "viewer/desktop/window/WindowSession.h"
#include "viewer/rendering/Picture.h"
#include "viewer/session/look/OcclusionClock.h"
#include "viewer/session/look/SceneLook.h"

#include <vtkRenderer.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <numbers>

#include <unistd.h>

namespace kdstream
{
namespace
{

using namespace std::chrono_literals;

constexpr double turningSeconds = 0.05; // between frames of the previews, at least
constexpr double turningShare = 0.25;   // of the time that their frames take
constexpr double turningSpeed = 2 * std::numbers::pi / 16; // radians a second
constexpr double noteSeconds = 4;
constexpr std::size_t aheadBytes = std::size_t{ 1 } << 20;
constexpr int titleLayer = 3, previewLayer = 2, modelLayer = 1;

double Now()
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// "dragon.png", or "dragon-2.png" where that is there.
std::string NewPictureName(const std::string& model)
{
  std::error_code failure;
  std::string name = model + ".png";
  for (int i = 2; std::filesystem::exists(name, failure); ++i)
  {
    name = model + "-" + std::to_string(i) + ".png";
  }
  return name;
}

ViewSettings SettingsOf(const ViewOptions& options)
{
  ViewSettings settings;
  settings.detail = options.detail;
  settings.scene.coloring = options.coloring;
  settings.scene.occlusion = options.occlusion;
  settings.rings = options.rings;
  settings.triangles = options.triangles;
  settings.memory = options.memory;
  return settings;
}

// What the model is seen as.
struct SceneSight
{
  std::uint64_t surfaceVersion = 0;
  Vec3 eye, focal, up;
  bool operator==(const SceneSight&) const = default;
};

// One window, one person, one session.
class WindowView
{
public:
  WindowView(std::string program, const ViewOptions& options,
    std::unique_ptr<DisplayWindow> display, SessionRecorder recorder);

  void Run();
  bool IsOpen() const { return this->Session.IsOpen(); }
  // Writes what the command line asked for at the end.
  Status Finish();

private:
  double Wait();
  void TakeEvents();
  void Handle(const WindowEvent& event);
  bool HandleKey(const WindowEvent& event);
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
  void Apply(const ViewSettings& settings);
  void Apply(const SceneSettings& before);
  void Fulfil(const PanelWishes& wishes);
  void AskForPicture();
  void TakePicture();
  Status WriteModelPicture(const std::string& file);
  void Tell(const std::string& note);
  std::string Link() const { return LinkTo(this->Session.Viewer(), this->Settings.scene); }
  void WakeIf(bool changed) { this->FramesLeft = changed ? 2 : this->FramesLeft; }
  // Turning previews leave most of a slow machine to the model.
  double TurningPause() const
  {
    return std::max(turningSeconds, this->FrameSeconds / turningShare);
  }
  bool OwesOcclusion(double now) { return this->LacksOcclusion && this->Occlusion.Has(false, now); }
  bool PreviewsTurn() const { return this->Shelf && this->Shelf->AnyIsShown(); }

  ViewOptions Options;
  std::unique_ptr<DisplayWindow> Display;

  vtkNew<vtkRenderer> Ground; // behind all
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
  bool LacksOcclusion = false;    // the picture, which is to have it
  std::optional<SceneSight> Seen; // in the last picture
  bool PressIsOfWords = false;
  bool Ended = false;
  bool OwesPicture = false;
  // After each change: panels take their size in the second.
  int FramesLeft = 2;
  double LastFrame = Now(), LastTurn = Now(), FrameSeconds = 0;
  std::string Note;
  double NoteUntil = 0;
};

WindowView::WindowView(std::string program, const ViewOptions& options,
  std::unique_ptr<DisplayWindow> display, SessionRecorder recorder)
  : Options(options)
  , Display(std::move(display))
  , Boxes(this->Scene.Renderer())
  , Interface(this->Display->Window(), titleLayer, this->Display->PixelRatio())
  , Settings(SettingsOf(options))
  , Session(std::move(program), options, std::move(recorder))
{
  vtkRenderWindow& window = this->Display->Window();
  window.SetNumberOfLayers(titleLayer + 1);
  this->Ground->SetBackground(backgroundTop.data());
  this->Ground->InteractiveOff();
  window.AddRenderer(this->Ground);
  this->Scene.Renderer().SetLayer(modelLayer);
  this->Scene.Renderer().PreserveColorBufferOff();
  window.AddRenderer(&this->Scene.Renderer());
  window.AddRenderer(&this->Boxes.Renderer());
  this->Session.SetAhead(aheadBytes);
}

void WindowView::Run()
{
  while (!this->Ended && !this->Display->WantsToClose() && !Interrupted())
  {
    this->Display->Wait(std::chrono::milliseconds(static_cast<int>(1000 * this->Wait())));
    this->TakeEvents();
    this->TakeNews();
    this->Clipboard.Serve();
    this->WakeIf(this->Display->TakeDamage());
    const double now = Now();
    const bool turns = this->PreviewsTurn() && now - this->LastTurn >= this->TurningPause();
    if (this->FramesLeft > 0 || turns || this->OwesOcclusion(now) ||
        this->Session.Viewer().GetStatus().coasting)
    {
      this->Frame();
    }
  }
}

// Seconds until there may be something to do that the window does not tell of.
double WindowView::Wait()
{
  if (this->FramesLeft > 0 || this->Session.Viewer().GetStatus().coasting)
  {
    return 0;
  }
  const bool waits = this->Session.IsOpening() || !this->Session.Viewer().IsIdle() ||
                     (this->Shelf && this->Shelf->IsLoading());
  const double turning = this->PreviewsTurn() ? this->LastTurn + this->TurningPause() - Now() : 1;
  const bool soon = waits || this->LacksOcclusion;
  return std::clamp(soon ? 0.01 : turning, 0.0, 0.2);
}

// ---- what people do

void WindowView::TakeEvents()
{
  for (const WindowEvent& event : this->Display->TakeEvents())
  {
    this->Handle(event);
    this->FramesLeft = 2;
  }
}

void WindowView::Handle(const WindowEvent& event)
{
  using Kind = WindowEvent::Kind;
  const bool begins = event.kind == Kind::Press || event.kind == Kind::TouchBegin;
  const bool isOverWords = this->Interface.IsOver(event.x, event.y);
  if (event.kind == Kind::Key)
  {
    if (this->HandleKey(event))
    {
      return;
    }
  }
  if (begins && !this->Input.Touching())
  {
    this->PressIsOfWords = isOverWords;
  }
  // To the words fingers are a mouse, where they began there.
  const bool isFinger =
    event.kind == Kind::TouchBegin || event.kind == Kind::TouchMove || event.kind == Kind::TouchEnd;
  if (event.kind != Kind::Key && (!isFinger || this->PressIsOfWords))
  {
    this->Interface.Handle(event);
  }
  const bool isZoom = event.kind == Kind::Wheel || event.kind == Kind::Pinch;
  const bool isOfWords = isZoom ? isOverWords : this->PressIsOfWords;
  if (!this->Session.IsOpen() || (isOfWords && event.kind != Kind::Key))
  {
    return;
  }
  for (const SessionStep& step : this->Input.Handle(event))
  {
    this->Session.Do(step);
  }
}

// Keys that do something to the window; false for the model's.
bool WindowView::HandleKey(const WindowEvent& event)
{
  const std::string& key = event.key;
  if (event.control)
  {
    this->Ended |= key == "q";
    return true;
  }
  if (key == "b")
  {
    ViewSettings settings = this->Settings;
    settings.scene.boxes = !settings.scene.boxes;
    this->Apply(settings);
    return true;
  }
  bool* const toggled = key == "o"                         ? &this->Words.settingsOpen
                        : key == "d"                       ? &this->Words.detailsOpen
                        : key == "F1" || key == "question" ? &this->Words.helpOpen
                        : key == "t"                       ? &this->Words.toolsOpen
                        : key == "m"                       ? &this->Words.popUp
                        : key == "Tab"                     ? &this->Words.bare
                                                           : nullptr;
  if (toggled)
  {
    *toggled = !*toggled;
  }
  else if (key == "Escape")
  {
    this->GoBack();
  }
  else if (key == "f" || key == "F11")
  {
    this->Display->SetFullScreen(!this->Display->IsFullScreen());
  }
  else if (key == "s" || key == "F12")
  {
    this->AskForPicture();
  }
  else if (key == "l")
  {
    this->CopyLink();
  }
  else if (key == "r" && this->Session.IsOpen())
  {
    const bool measures = this->Session.Viewer().GetTool() == Tool::Measure;
    this->Session.Do({ SessionStep::Kind::Tool, {}, measures ? "none" : "measure" });
    this->Tell(
      measures ? "Clicks measure no more." : "Click one point of the surface, then another.");
  }
  else if (key.size() == 1 && key[0] >= '1' && key[0] <= '6' && this->Session.IsOpen())
  {
    static constexpr std::array<const char*, 6> sides{ "front", "back", "left", "right", "top",
      "bottom" };
    this->Session.Do(
      { SessionStep::Kind::Side, {}, sides[static_cast<std::size_t>(key[0] - '1')] });
  }
  else if (key == "q")
  {
    this->Ended = true;
  }
  else if (key == "Next" || key == "Prior")
  {
    this->Session.OpenNext(key == "Next" ? 1 : -1);
  }
  else
  {
    return false;
  }
  return true;
}

// One thing after the other.
void WindowView::GoBack()
{
  for (bool* const open : { &this->Words.helpOpen, &this->Words.popUp, &this->Words.settingsOpen,
         &this->Words.detailsOpen, &this->Words.toolsOpen, &this->Words.bare })
  {
    if (*open)
    {
      *open = false;
      return;
    }
  }
  if (this->Display->IsFullScreen())
  {
    this->Display->SetFullScreen(false);
  }
  else if (this->Session.IsOpen() && this->Session.Models()->size() > 1)
  {
    this->Session.Do({ SessionStep::Kind::Go, {}, "back" });
  }
}

// ---- what has come

void WindowView::TakeNews()
{
  this->WakeIf(this->Session.Follow());
  this->Interface.KnowText(this->Session.TakeTexts());
  if (const std::string note = this->Session.TakeNote(); !note.empty())
  {
    this->Tell(note);
  }
  if (!this->Note.empty() && Now() >= this->NoteUntil)
  {
    this->Note.clear();
    this->FramesLeft = 2;
  }
  if (!this->Session.IsOpen())
  {
    return;
  }
  if (!this->Shelf)
  {
    this->Shelf = std::make_unique<Previews>(
      this->Display->Window(), previewLayer, this->Session.TakePreviewSource());
  }
  this->WakeIf(this->Shelf->Load());
  const ViewerStatus status = this->Session.Viewer().GetStatus();
  const std::string& name = status.title.empty() ? status.model : status.title;
  if (name != this->Titled)
  {
    this->Titled = name;
    this->Display->SetTitle(name);
  }
}

// ---- a frame

void WindowView::Frame()
{
  const double begin = Now();
  this->FramesLeft = std::max(this->FramesLeft - 1, 0);
  if (this->Shelf)
  {
    for (const SessionStep& step : this->Input.Flush())
    {
      this->Session.Do(step);
    }
    this->Layout();
    this->Session.BeginFrame(begin);
    if (const Status followed = this->Scene.Follow(this->Session.Viewer().Scene()); !followed)
    {
      this->Tell(followed.GetError().message);
    }
    this->Boxes.Show(
      this->Settings.scene.boxes ? this->Session.Viewer().RegionBoxes() : std::vector<Box>(),
      this->Scene.Center(), boxLineWidth * this->Display->PixelRatio());
    this->Shelf->Turn(turningSpeed * std::min(begin - this->LastTurn, 0.5));
    this->LastTurn = begin;
  }
  ViewSettings settings = this->Settings;
  const std::vector<PanelWishes> wishes = this->DescribePanels(begin - this->LastFrame, settings);
  this->DrawPicture();
  this->LastFrame = begin;
  this->FrameSeconds = Now() - begin;
  this->Session.EndFrame(this->FrameSeconds, this->Input.Touching());
  this->Report.AddFrame(this->Session.Viewer().GetStatus());
  if (this->OwesPicture && (!this->Session.IsRecording() || this->Session.Viewer().IsIdle()))
  {
    this->TakePicture();
  }
  this->Apply(settings);
  for (const PanelWishes& each : wishes)
  {
    this->Fulfil(each);
  }
}

// Until all of them stand where they will: a new panel is measured first, unseen, and pictures are
// slow.
std::vector<PanelWishes> WindowView::DescribePanels(double seconds, ViewSettings& settings)
{
  constexpr std::size_t mostRounds = 4;
  std::vector<PanelWishes> wishes;
  bool again = true;
  while (again && wishes.size() < mostRounds)
  {
    this->Interface.Begin(
      this->Display->Width(), this->Display->Height(), wishes.empty() ? seconds : 0);
    wishes.push_back(this->Words.Draw(this->Facts(), this->Tiles, this->Shelf.get(), settings));
    again = this->Interface.End();
  }
  if (again)
  {
    this->FramesLeft = std::max(this->FramesLeft, 1);
  }
  return wishes;
}

// With occlusion, where that is wanted and quick enough for a view that moves.
void WindowView::DrawPicture()
{
  const double begin = Now();
  const ViewerScene scene = this->Session.Viewer().Scene();
  const SceneSight sight{ scene.surfaceVersion, scene.eye, scene.focal, scene.up };
  const bool moves = this->Seen != sight;
  const bool fresh = !this->Seen || this->Seen->surfaceVersion != sight.surfaceVersion;
  const bool may = this->Occlusion.Has(moves, begin);
  this->Seen = sight;
  const SceneSettings& settings = this->Settings.scene;
  this->LacksOcclusion = settings.occlusion && !may;
  this->Scene.SetStyle({ settings.coloring, false, settings.occlusion && may });
  this->Display->Window().Render();
  const double end = Now();
  if (!fresh)
  {
    this->Occlusion.Drawn(settings.occlusion && may, end - begin, end);
  }
}

// Which part of the window the model has.
void WindowView::Layout()
{
  const int width = this->Display->Width();
  const int height = this->Display->Height();
  const PanelFacts facts = this->Facts();
  const int strip = static_cast<int>(this->Words.StripHeight(facts, this->Settings));
  const Viewport view{ width, std::max(height - strip, 1), this->Display->PixelRatio() };
  if (view != this->View)
  {
    this->View = view;
    SessionStep step{ SessionStep::Kind::Window, {} };
    step.window = view;
    this->Session.Do(step);
    this->Input.SetView(0, 0, view);
    this->Scene.Renderer().SetViewport(0, 1 - view.height / static_cast<double>(height), 1, 1);
  }
  this->Tiles = this->Words.TilesOf(facts, this->Settings);
  this->Shelf->Place(this->Tiles, width, height);
}

PanelFacts WindowView::Facts() const
{
  PanelFacts facts;
  facts.width = this->Display->Width();
  facts.height = this->Display->Height();
  facts.ratio = this->Display->PixelRatio();
  facts.fullScreen = this->Display->IsFullScreen();
  facts.recording = this->Session.IsRecording();
  facts.models = this->Shelf ? this->Session.Models() : nullptr;
  facts.opening = this->Session.Progress();
  facts.trouble = this->Session.Trouble();
  facts.warnings = this->Session.Warnings();
  facts.status = this->Session.Viewer().GetStatus();
  facts.model = this->Session.Model();
  facts.blobs = &this->Session.Viewer().Statistics();
  facts.traffic = this->Session.Viewer().GetTraffic();
  facts.frameSeconds = this->FrameSeconds;
  facts.residentBytes = ResidentMemory();
  facts.note = this->Note;
  this->AddTools(facts);
  return facts;
}

void WindowView::AddTools(PanelFacts& facts) const
{
  const ViewerSession& session = this->Session.Viewer();
  const auto pixel = [&](const MeasuredPoint& end)
  { return session.GetCamera().PixelOf(end.point); };
  for (const Measurement& each : session.Measurements())
  {
    facts.measurements.push_back(
      { each, pixel(each.from), each.to ? pixel(*each.to) : std::nullopt });
  }
  facts.tool = session.GetTool();
  facts.up = facts.model ? facts.model->pose.value_or(ModelPose{}).up : Vec3{ 0, 1, 0 };
}

void WindowView::Copy(const std::string& text, const std::string& what)
{
  this->Tell(this->Clipboard.Put(text) ? what + " copied." : "There is no clipboard.");
}

// For a browser, or for kdstream-view.
void WindowView::CopyLink()
{
  if (this->Session.Model())
  {
    const std::string& source = this->Options.source;
    const bool isServer = NamesServer(source);
    this->Copy(source + (isServer && source.back() != '/' ? "/#" : "#") + this->Link(),
      "The link to this view is");
  }
}

void WindowView::CopyMeasurements()
{
  std::string text;
  const PanelFacts facts = this->Facts();
  for (const SeenMeasurement& each : facts.measurements)
  {
    text += each.measurement.name + ": " +
            DescribeMeasurement(each.measurement, facts.up, facts.model ? facts.model->unit : "") +
            "\n";
  }
  this->Copy(text, "The distances are");
}

void WindowView::Apply(const ViewSettings& settings)
{
  const ViewSettings before = std::exchange(this->Settings, settings);
  if (before == settings)
  {
    return;
  }
  if (before.detail != settings.detail)
  {
    this->Session.Do(DetailStep(settings.detail));
  }
  if (before.turning != settings.turning)
  {
    this->Session.Do(
      { SessionStep::Kind::Turning, {}, settings.turning == Turning::Free ? "free" : "upright" });
  }
  if (before.rings != settings.rings)
  {
    this->Session.Do(RingsStep(settings.rings));
  }
  if (before.triangles != settings.triangles || before.memory != settings.memory)
  {
    this->Session.Do(BudgetsStep(settings.triangles, settings.memory));
  }
  this->Apply(before.scene);
  this->Session.SetAhead(settings.fetchAhead ? aheadBytes : 0);
  this->FramesLeft = 2;
}

// Frames are drawn by the settings as they are; here they are recorded where they were others.
void WindowView::Apply(const SceneSettings& before)
{
  const SceneSettings& now = this->Settings.scene;
  if (before.coloring != now.coloring)
  {
    this->Session.Do(ColoringStep(now.coloring));
  }
  if (before.occlusion != now.occlusion)
  {
    this->Session.Do(LightStep(now.occlusion));
  }
  if (before.boxes != now.boxes)
  {
    this->Session.Do(BoxesStep(now.boxes));
  }
}

void WindowView::Fulfil(const PanelWishes& wishes)
{
  for (const SessionStep& step : wishes.steps)
  {
    this->Session.Do(step);
  }
  if (wishes.open)
  {
    this->Session.Open(*wishes.open);
  }
  if (wishes.fullScreen)
  {
    this->Display->SetFullScreen(!this->Display->IsFullScreen());
  }
  if (wishes.screenshot)
  {
    this->AskForPicture();
  }
  if (wishes.spin)
  {
    this->Session.SetSpinning(*wishes.spin);
  }
  if (wishes.removeMeasurement)
  {
    this->Session.RemoveMeasurement(*wishes.removeMeasurement);
    this->FramesLeft = 2;
  }
  if (wishes.copyLink)
  {
    this->CopyLink();
  }
  if (wishes.copyMeasurements)
  {
    this->CopyMeasurements();
  }
  if (wishes.retry)
  {
    this->Session.Retry();
  }
  this->Ended |= wishes.quit;
}

// ---- what is written

// A picture is taken when what was done before it is on the screen; of a recording when all has
// come, as it is when that plays again.
void WindowView::AskForPicture()
{
  this->OwesPicture = true;
  this->FramesLeft = 2;
  if (this->Session.IsRecording() && !this->Session.Viewer().IsIdle())
  {
    this->Tell("The picture is taken when all of it has come.");
  }
}

void WindowView::TakePicture()
{
  this->OwesPicture = false;
  const std::string model = this->Session.Viewer().GetStatus().model;
  if (model.empty() || this->Session.Viewer().GetStatus().vertices == 0)
  {
    this->Tell("There is nothing to write a picture of yet.");
    return;
  }
  const std::string file = NewPictureName(model);
  const Status written = this->WriteModelPicture(file);
  this->Session.Do({ SessionStep::Kind::Screenshot, {}, file });
  this->Tell(written ? "Wrote " + file : written.GetError().message);
}

// The model alone. It is drawn, but not shown: the window keeps its words and buttons.
Status WindowView::WriteModelPicture(const std::string& file)
{
  vtkRenderWindow& window = this->Display->Window();
  this->Interface.SetVisible(false);
  this->Scene.SetStyle({ this->Settings.scene.coloring, false, this->Settings.scene.occlusion });
  window.SwapBuffersOff();
  const auto picture = Pixels(window);
  window.SwapBuffersOn();
  this->Interface.SetVisible(true);
  KDSTREAM_TRY(picture);
  return WritePng(PartOf(*picture, 0, 0, this->View.width, this->View.height), file);
}

void WindowView::Tell(const std::string& note)
{
  this->Note = note;
  this->Interface.KnowText(note);
  this->NoteUntil = Now() + noteSeconds;
  this->FramesLeft = 2;
}

Status WindowView::Finish()
{
  if (!this->Options.screenshot.empty() && this->Session.Viewer().GetStatus().vertices > 0)
  {
    KDSTREAM_TRY(At(this->Options.screenshot, this->WriteModelPicture(this->Options.screenshot)));
  }
  KDSTREAM_TRY(At(this->Options.record, this->Session.Recorder().Finish()));
  KDSTREAM_TRY(At(this->Options.statistics,
    WriteOutput(this->Options.statistics, StatisticsJson(this->Session.Viewer().Statistics()))));
  return At(
    this->Options.report, WriteOutput(this->Options.report,
                            this->Report.Json(this->Session.Viewer().GetTraffic(), this->Link())));
}

}

Result<int> ViewInWindow(const std::string& program, const ViewOptions& options)
{
  auto recorder = At(options.record, SessionRecorder::Make(options.record));
  KDSTREAM_TRY(recorder);
  auto display = DisplayWindow::Make(options.width, options.height, "KdStream");
  if (!display)
  {
    return NoWindow(display.GetError());
  }
  WindowView view(program, options, std::move(*display), std::move(*recorder));
  view.Run();
  KDSTREAM_TRY(view.Finish());
  if (Interrupted() && !view.IsOpen())
  {
    return Error{ ErrorCode::Cancelled, "interrupted" }; // before anything was seen
  }
  return exitDone;
}

}
