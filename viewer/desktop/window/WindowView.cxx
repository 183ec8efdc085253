// SPDX-License-Identifier: BSD-3-Clause
// A view in a window: see WindowView.h. Steps of a frame:
// 1. handle what the user did
// 2. take what has arrived
// 3. update the session's choice of pieces and its surface
// 4. describe texts and buttons
// 5. draw the picture.
#include "viewer/desktop/window/WindowView.h"

#include "viewer/desktop/window/ToolsPanel.h"
#include "viewer/desktop/window/WindowController.h"
#include "viewer/session/appearance/SceneAppearance.h"

#include <vtkRenderer.h>

#include <algorithm>
#include <numbers>
#include <utility>

namespace kdstream
{
namespace
{

constexpr double turningSpeed = 2 * std::numbers::pi / 16; // radians per second
constexpr double noteSeconds = 4;
constexpr int titleLayer = 3, previewLayer = 2, modelLayer = 1;

ViewSettings SettingsOf(const ViewOptions& options)
{
  ViewSettings settings;
  settings.detail = options.detail;
  settings.scene.colors = options.colors;
  settings.scene.occlusion = options.occlusion;
  settings.rings = options.rings;
  settings.triangles = options.triangles;
  settings.memory = options.memory;
  return settings;
}

}

WindowController::WindowController(std::string program, const ViewOptions& options,
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
  this->Session.SetPrefetch(windowPrefetchBytes);
}

void WindowController::Run()
{
  while (!this->Ended && !this->Display->WantsToClose() && !Interrupted())
  {
    this->Display->Wait(std::chrono::milliseconds(static_cast<int>(1000 * this->Wait())));
    this->TakeEvents();
    this->TakeNews();
    this->Clipboard.Serve();
    this->WakeIf(this->Display->TakeDamage());
    const double now = SteadySeconds();
    const bool turns = this->PreviewsTurn() && now - this->LastTurn >= this->TurningPause();
    if (this->FramesLeft > 0 || turns || this->OcclusionPending(now) ||
        this->Session.Viewer().GetStatus().coasting)
    {
      this->Frame();
    }
  }
}

// Seconds to wait: until then there may be work to do that no event of the window reports.
double WindowController::Wait()
{
  if (this->FramesLeft > 0 || this->Session.Viewer().GetStatus().coasting)
  {
    return 0;
  }
  const bool waits = this->Session.IsOpening() || !this->Session.Viewer().IsIdle() ||
                     (this->Shelf && this->Shelf->IsLoading());
  const double turning =
    this->PreviewsTurn() ? this->LastTurn + this->TurningPause() - SteadySeconds() : 1;
  const bool soon = waits || this->LacksOcclusion;
  return std::clamp(soon ? 0.01 : turning, 0.0, 0.2);
}

void WindowController::TakeNews()
{
  this->WakeIf(this->Session.Follow());
  this->Interface.KnowText(this->Session.TakeTexts());
  if (const std::string note = this->Session.TakeNote(); !note.empty())
  {
    this->Tell(note);
  }
  if (!this->Note.empty() && SteadySeconds() >= this->NoteUntil)
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

void WindowController::Frame()
{
  const double begin = SteadySeconds();
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
  if (this->Shelf) // a link may have changed the settings
  {
    this->Settings.turning = this->Session.Viewer().GetCamera().GetTurning();
    this->Settings.detail = this->Session.Viewer().GetDetail();
  }
  ViewSettings settings = this->Settings;
  const std::vector<PanelWishes> wishes = this->DescribePanels(begin - this->LastFrame, settings);
  this->DrawPicture();
  this->LastFrame = begin;
  this->FrameSeconds = SteadySeconds() - begin;
  this->Session.EndFrame(this->FrameSeconds, this->Input.Touching());
  this->Report.AddFrame(this->Session.Viewer().GetStatus(), this->Session.Viewer().Scene());
  if (this->PicturePending && (!this->Session.IsRecording() || this->Session.Viewer().IsIdle()))
  {
    this->TakePicture();
  }
  this->Apply(settings);
  for (const PanelWishes& each : wishes)
  {
    this->Fulfil(each);
  }
}

// Repeats until all panels are in their final places. This avoids extra pictures, which are slow: a
// new panel is measured first, invisibly.
std::vector<PanelWishes> WindowController::DescribePanels(double seconds, ViewSettings& settings)
{
  constexpr std::size_t mostRounds = 4;
  std::vector<PanelWishes> wishes;
  bool again = true;
  while (again && wishes.size() < mostRounds)
  {
    this->Interface.Begin(
      this->Display->Width(), this->Display->Height(), wishes.empty() ? seconds : 0);
    const PanelFacts facts = this->Facts();
    wishes.push_back(this->Words.Draw(facts, this->Tiles, this->Shelf.get(), settings));
    this->CaptionHeight = this->PicturePending ? DrawCaption(facts, this->View.width) : 0;
    again = this->Interface.End();
  }
  if (again)
  {
    this->FramesLeft = std::max(this->FramesLeft, 1);
  }
  return wishes;
}

// Draws with occlusion if the settings ask for it, and if it is fast enough while the view moves.
void WindowController::DrawPicture()
{
  const double begin = SteadySeconds();
  const ViewerScene scene = this->Session.Viewer().Scene();
  const SceneSight sight{ scene.surfaceVersion, scene.eye, scene.focal, scene.up, scene.section,
    scene.lighting };
  const bool moves = this->Seen != sight;
  const bool fresh = !this->Seen || this->Seen->surfaceVersion != sight.surfaceVersion;
  const bool may = this->Occlusion.Has(moves, begin);
  this->Seen = sight;
  const SceneSettings& settings = this->Settings.scene;
  this->LacksOcclusion = settings.occlusion && !may;
  this->Scene.SetAppearance(settings.colors, settings.occlusion && may);
  this->Display->Window().Render();
  const double end = SteadySeconds();
  if (!fresh)
  {
    this->Occlusion.Drawn(settings.occlusion && may, end - begin, end);
  }
}

// Decides which part of the window shows the model.
void WindowController::Layout()
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

PanelFacts WindowController::Facts() const
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

void WindowController::AddTools(PanelFacts& facts) const
{
  const ViewerSession& session = this->Session.Viewer();
  facts.measurements = SeenMeasurementsOf(session);
  facts.tool = session.GetTool();
  facts.light = session.GetLight();
  facts.notes = &this->Session.Notes();
  if (session.GetSection().Plane())
  {
    facts.sectionDepth = session.GetSection().Depth();
  }
  facts.up = facts.model ? facts.model->homeView.value_or(HomeView{}).up : Vec3{ 0, 1, 0 };
}

void WindowController::Tell(const std::string& note)
{
  this->Note = note;
  this->Interface.KnowText(note);
  this->NoteUntil = SteadySeconds() + noteSeconds;
  this->FramesLeft = 2;
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
  WindowController view(program, options, std::move(*display), std::move(*recorder));
  view.Run();
  KDSTREAM_TRY(view.Finish());
  if (Interrupted() && !view.IsOpen())
  {
    return Error{ ErrorCode::Cancelled, "interrupted" }; // before anything was shown
  }
  return view.ExitCode();
}

}
