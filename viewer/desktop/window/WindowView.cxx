// SPDX-License-Identifier: BSD-3-Clause
// A look in a window: see WindowView.h. Steps of a frame: 1. what people did  2. what has come
// 3. the session's choice and surface  4. words and buttons  5. the picture.
#include "viewer/desktop/window/WindowView.h"

#include "viewer/desktop/ViewReport.h"
#include "viewer/desktop/window/DisplayWindow.h"
#include "viewer/desktop/window/InterfaceLayer.h"
#include "viewer/desktop/window/Panels.h"
#include "viewer/desktop/window/RegionBoxes.h"
#include "viewer/desktop/window/SessionRecorder.h"
#include "viewer/desktop/window/SourceOpening.h"
#include "viewer/desktop/window/WindowInput.h"
#include "viewer/rendering/Picture.h"
#include "viewer/session/SceneLook.h"

#include <vtkRenderer.h>

#include <algorithm>
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

const char* WordOf(DetailMode detail)
{
  return detail == DetailMode::Level ? "level" : detail == DetailMode::Full ? "full" : "view";
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
  settings.coloring = options.coloring;
  settings.rings = options.rings;
  settings.triangles = options.triangles;
  settings.memory = options.memory;
  return settings;
}

// One window, one person, one session.
class WindowView
{
public:
  WindowView(std::string program, const ViewOptions& options,
    std::unique_ptr<DisplayWindow> display, SessionRecorder recorder);

  void Run();
  // Writes what the command line asked for at the end.
  Status Finish();

private:
  double Wait();
  void TakeEvents();
  void Handle(const WindowEvent& event);
  bool HandleKey(const WindowEvent& event);
  void FollowOpening();
  void Begin(OpenedSources sources);
  void TakeNews();
  void Send();
  void Do(const SessionStep& step);
  void OpenModel(std::size_t model);
  void OpenNext(int step);
  void GoBack();
  void Retry();
  void Frame();
  void Layout();
  PanelFacts Facts() const;
  void Apply(const ViewSettings& settings);
  void Fulfil(const PanelWishes& wishes);
  void TakePicture();
  Status WriteModelPicture(const std::string& file);
  void Tell(const std::string& note);
  void Complain();
  // Turning previews leave most of a slow machine to the model.
  double TurningPause() const
  {
    return std::max(turningSeconds, this->FrameSeconds / turningShare);
  }
  bool PreviewsTurn() const { return this->Shelf && this->Shelf->AnyIsShown(); }

  std::string Program;
  ViewOptions Options;
  std::unique_ptr<DisplayWindow> Display;
  SessionRecorder Recorder;

  vtkNew<vtkRenderer> Ground; // behind all
  SessionScene Scene;
  RegionBoxes Boxes;
  InterfaceLayer Interface;
  Panels Words;
  ViewSettings Settings;
  WindowInput Input;
  ViewerSession Session;
  ViewReport Report;

  std::unique_ptr<SourceOpening> Opening;
  std::string Trouble; // why it could not be opened
  std::unique_ptr<ModelSource> Source;
  std::unique_ptr<Previews> Shelf;
  ModelDescription Model; // that is open

  std::vector<Tile> Tiles;
  Viewport View;
  bool PressIsOfWords = false;
  bool Ended = false, IsDirty = true;
  int FramesLeft = 2; // after something was done, for what the words do then
  double LastFrame = Now(), LastTurn = Now(), FrameSeconds = 0;
  std::string Note, LastComplaint;
  double NoteUntil = 0;
};

WindowView::WindowView(std::string program, const ViewOptions& options,
  std::unique_ptr<DisplayWindow> display, SessionRecorder recorder)
  : Program(std::move(program))
  , Options(options)
  , Display(std::move(display))
  , Recorder(std::move(recorder))
  , Boxes(this->Scene.Renderer())
  , Interface(this->Display->Window(), titleLayer, this->Display->PixelRatio())
  , Settings(SettingsOf(options))
  , Session(SessionOptionsOf(options))
{
  vtkRenderWindow& window = this->Display->Window();
  window.SetNumberOfLayers(titleLayer + 1);
  this->Ground->SetBackground(backgroundTop.data());
  this->Ground->InteractiveOff();
  window.AddRenderer(this->Ground);
  this->Scene.Renderer().SetLayer(modelLayer);
  this->Scene.Renderer().PreserveColorBufferOff();
  this->Scene.SetStyle({ this->Settings.coloring });
  window.AddRenderer(&this->Scene.Renderer());
  this->Session.SetCoasting(!this->Recorder.IsOn()); // which no file tells of
  this->Session.SetAhead(aheadBytes);
  this->Retry();
}

void WindowView::Run()
{
  while (!this->Ended && !this->Display->WantsToClose() && !Interrupted())
  {
    this->Display->Wait(std::chrono::milliseconds(static_cast<int>(1000 * this->Wait())));
    this->TakeEvents();
    this->FollowOpening();
    this->TakeNews();
    this->IsDirty |= this->Display->TakeDamage();
    const double now = Now();
    const bool turns = this->PreviewsTurn() && now - this->LastTurn >= this->TurningPause();
    if (this->IsDirty || this->FramesLeft > 0 || turns || this->Session.GetStatus().coasting)
    {
      this->Frame();
    }
  }
}

// Seconds until there may be something to do that the window does not tell of.
double WindowView::Wait()
{
  if (this->IsDirty || this->FramesLeft > 0 || this->Session.GetStatus().coasting)
  {
    return 0;
  }
  const bool waits =
    this->Opening || !this->Session.IsIdle() || (this->Shelf && this->Shelf->IsLoading());
  const double turning = this->PreviewsTurn() ? this->LastTurn + this->TurningPause() - Now() : 1;
  return std::clamp(waits ? 0.01 : turning, 0.0, 0.2);
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
  else
  {
    this->Interface.Handle(event);
  }
  if (begins && !this->Input.Touching())
  {
    this->PressIsOfWords = isOverWords;
  }
  const bool isOfWords = event.kind == Kind::Wheel ? isOverWords : this->PressIsOfWords;
  if (!this->Source || (isOfWords && event.kind != Kind::Key))
  {
    return;
  }
  for (const SessionStep& step : this->Input.Handle(event))
  {
    this->Do(step);
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
  bool* const toggled = key == "o"                         ? &this->Words.settingsOpen
                        : key == "d"                       ? &this->Words.detailsOpen
                        : key == "F1" || key == "question" ? &this->Words.helpOpen
                        : key == "m"                       ? &this->Words.popUp
                        : key == "Tab"                     ? &this->Words.bare
                        : key == "b"                       ? &this->Settings.boxes
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
    this->TakePicture();
  }
  else if (key == "q")
  {
    this->Ended = true;
  }
  else if (key == "Next" || key == "Prior")
  {
    this->OpenNext(key == "Next" ? 1 : -1);
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
         &this->Words.detailsOpen, &this->Words.bare })
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
  else if (this->Source && this->Source->Models().size() > 1)
  {
    this->Do({ SessionStep::Kind::Go, {}, "back" });
  }
}

void WindowView::Do(const SessionStep& step)
{
  this->Recorder.Add(step);
  if (const Status done = Perform(step, this->Session); !done)
  {
    this->Tell(done.GetError().message);
  }
  this->Send();
  this->FramesLeft = 2;
}

void WindowView::OpenModel(std::size_t model)
{
  const ModelSummary& chosen = this->Source->Models()[model];
  this->Words.popUp = false;
  if (this->Session.GetStatus().model != chosen.id)
  {
    this->Do({ SessionStep::Kind::Select, {}, chosen.id });
  }
  this->Do({ SessionStep::Kind::Select, {}, chosen.id }); // again: full screen
  this->Display->SetTitle(chosen.title.empty() ? chosen.id : chosen.title);
}

void WindowView::OpenNext(int step)
{
  if (!this->Source)
  {
    return;
  }
  const auto& models = this->Source->Models();
  const auto found = std::find_if(models.begin(), models.end(),
    [this](const ModelSummary& model) { return model.id == this->Session.GetStatus().model; });
  const auto count = static_cast<std::ptrdiff_t>(models.size());
  const std::ptrdiff_t now = found == models.end() ? 0 : found - models.begin();
  this->OpenModel(static_cast<std::size_t>((now + step + count) % count));
}

// ---- where models come from

// What could not be had, once more.
void WindowView::Retry()
{
  if (this->Source)
  {
    this->Do({ SessionStep::Kind::Select, {}, this->Session.GetStatus().model });
    return;
  }
  this->Trouble.clear();
  this->Opening = std::make_unique<SourceOpening>(this->Program, this->Options);
}

void WindowView::FollowOpening()
{
  if (!this->Opening)
  {
    return;
  }
  this->FramesLeft = std::max(this->FramesLeft, 1);
  if (auto ended = this->Opening->Take())
  {
    this->Opening.reset();
    if (*ended)
    {
      this->Begin(std::move(**ended));
    }
    else
    {
      this->Trouble = ended->GetError().message;
      PrintError(this->Program, "", ended->GetError());
    }
  }
}

void WindowView::Begin(OpenedSources sources)
{
  this->Source = std::move(sources.models);
  const auto& models = this->Source->Models();
  for (const ModelSummary& model : models)
  {
    this->Interface.KnowText(model.title);
  }
  this->Session.SetModels(models);
  this->Shelf =
    std::make_unique<Previews>(this->Display->Window(), previewLayer, std::move(sources.previews));
  this->Layout();
  this->Do({ SessionStep::Kind::Turning, {}, "upright" });
  if (models.empty())
  {
    this->Tell("There are no models yet.");
    return;
  }
  const auto named = std::find_if(models.begin(), models.end(),
    [this](const ModelSummary& model) { return model.id == this->Options.model; });
  if (!this->Options.model.empty() && named == models.end())
  {
    const Error error{ ErrorCode::NotFound,
      this->Options.source + ": there is no model '" + this->Options.model + "'" };
    PrintError(this->Program, "", error);
    this->Tell(error.message);
  }
  if (named != models.end() || models.size() == 1)
  {
    this->OpenModel(named == models.end() ? 0 : static_cast<std::size_t>(named - models.begin()));
  }
  else
  {
    this->Do({ SessionStep::Kind::Select, {}, models.front().id });
  }
}

void WindowView::TakeNews()
{
  if (!this->Source)
  {
    return;
  }
  for (const ClientEvent& event : this->Source->Take())
  {
    if (event.kind == ClientEvent::Kind::Opened)
    {
      this->Model = event.model;
      this->Interface.KnowText(event.model.title + event.model.credit + event.model.license);
    }
    Deliver(event, this->Session);
    this->IsDirty = true;
  }
  this->IsDirty |= this->Shelf->Load();
  this->Send();
  this->Complain();
}

void WindowView::Send()
{
  for (const SessionRequest& request : this->Session.TakeRequests())
  {
    this->Source->Send(request);
  }
}

// On stderr too, each sentence once.
void WindowView::Complain()
{
  const std::string error = this->Session.GetStatus().error;
  if (!error.empty() && error != this->LastComplaint)
  {
    this->Interface.KnowText(error);
    PrintError(this->Program, this->Options.source, { ErrorCode::NotFound, error });
  }
  this->LastComplaint = error;
}

// ---- a frame

void WindowView::Frame()
{
  const double begin = Now();
  this->IsDirty = false;
  this->FramesLeft = std::max(this->FramesLeft - 1, 0);
  if (this->Source)
  {
    for (const SessionStep& step : this->Input.Flush())
    {
      this->Do(step);
    }
    this->Session.Advance(begin);
    this->Layout();
    this->Session.BeginFrame();
    this->Send();
    if (const Status followed = this->Scene.Follow(this->Session.Scene()); !followed)
    {
      this->Tell(followed.GetError().message);
    }
    this->Boxes.Show(this->Settings.boxes ? this->Session.RegionBoxes() : std::vector<Box>(),
      this->Scene.Center(), 1.5 * this->Display->PixelRatio());
    this->Shelf->Turn(turningSpeed * std::min(begin - this->LastTurn, 0.5));
    this->LastTurn = begin;
  }
  this->Interface.Begin(this->Display->Width(), this->Display->Height(), begin - this->LastFrame);
  ViewSettings settings = this->Settings;
  static const Previews none(this->Display->Window(), previewLayer, nullptr);
  const PanelWishes wishes =
    this->Words.Draw(this->Facts(), this->Tiles, this->Shelf ? *this->Shelf : none, settings);
  if (this->Interface.End())
  {
    this->FramesLeft = std::max(this->FramesLeft, 1);
  }
  this->Display->Window().Render();
  this->LastFrame = begin;
  this->FrameSeconds = Now() - begin;
  this->Session.EndFrame(this->FrameSeconds);
  this->Report.AddFrame(this->Session.GetStatus());
  if (this->Session.IsIdle() && !this->Input.Touching())
  {
    this->Recorder.NoteIdle();
  }
  this->Apply(settings);
  this->Fulfil(wishes);
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
    this->Do(step);
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
  facts.recording = this->Recorder.IsOn();
  facts.models = this->Source ? &this->Source->Models() : nullptr;
  facts.opening = this->Opening ? this->Opening->Progress() : "";
  facts.trouble = this->Trouble;
  facts.status = this->Session.GetStatus();
  facts.model = this->Model.id == facts.status.model && this->Source ? &this->Model : nullptr;
  facts.blobs = &this->Session.Statistics();
  facts.traffic = this->Session.GetTraffic();
  facts.frameSeconds = this->FrameSeconds;
  facts.residentBytes = ResidentMemory();
  facts.note = Now() < this->NoteUntil ? this->Note : "";
  return facts;
}

void WindowView::Apply(const ViewSettings& settings)
{
  const ViewSettings before = std::exchange(this->Settings, settings);
  if (before == settings || !this->Source)
  {
    return;
  }
  if (before.detail != settings.detail)
  {
    this->Do({ SessionStep::Kind::Detail, {}, WordOf(settings.detail) });
  }
  if (before.turning != settings.turning)
  {
    this->Do(
      { SessionStep::Kind::Turning, {}, settings.turning == Turning::Free ? "free" : "upright" });
  }
  if (before.rings != settings.rings)
  {
    SessionStep step{ SessionStep::Kind::Rings, {} };
    step.rings = settings.rings;
    this->Do(step);
  }
  if (before.triangles != settings.triangles || before.memory != settings.memory)
  {
    this->Session.SetBudgets(settings.triangles, settings.memory);
  }
  this->Session.SetAhead(settings.fetchAhead ? aheadBytes : 0);
  this->Scene.SetStyle({ settings.coloring });
  this->Send();
  this->FramesLeft = 2;
}

void WindowView::Fulfil(const PanelWishes& wishes)
{
  for (const SessionStep& step : wishes.steps)
  {
    this->Do(step);
  }
  if (wishes.open)
  {
    this->OpenModel(*wishes.open);
  }
  if (wishes.fullScreen)
  {
    this->Display->SetFullScreen(!this->Display->IsFullScreen());
  }
  if (wishes.screenshot)
  {
    this->TakePicture();
  }
  if (wishes.retry)
  {
    this->Retry();
  }
  this->Ended |= wishes.quit;
}

// ---- what is written

void WindowView::TakePicture()
{
  const std::string model = this->Session.GetStatus().model;
  if (model.empty() || this->Session.GetStatus().vertices == 0)
  {
    this->Tell("There is nothing to write a picture of yet.");
    return;
  }
  const std::string file = NewPictureName(model);
  const Status written = this->WriteModelPicture(file);
  this->Recorder.Add({ SessionStep::Kind::Screenshot, {}, file });
  this->Tell(written ? "Wrote " + file : written.GetError().message);
}

// The model alone.
Status WindowView::WriteModelPicture(const std::string& file)
{
  this->Interface.SetVisible(false);
  const auto picture = Pixels(this->Display->Window());
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
  if (!this->Options.screenshot.empty() && this->Session.GetStatus().vertices > 0)
  {
    KDSTREAM_TRY(At(this->Options.screenshot, this->WriteModelPicture(this->Options.screenshot)));
  }
  KDSTREAM_TRY(At(this->Options.record, this->Recorder.Finish()));
  KDSTREAM_TRY(At(this->Options.statistics,
    WriteOutput(this->Options.statistics, StatisticsJson(this->Session.Statistics()))));
  return At(this->Options.report,
    WriteOutput(this->Options.report, this->Report.Json(this->Session.GetTraffic())));
}

}

Result<int> ViewInWindow(const std::string& program, const ViewOptions& options)
{
  auto recorder = At(options.record, SessionRecorder::Make(options.record));
  KDSTREAM_TRY(recorder);
  auto display = DisplayWindow::Make(options.width, options.height, "KdStream");
  if (!display)
  {
    return Error{ display.GetError().code,
      "no window can be opened: " + display.GetError().message +
        "; --offscreen auto draws without one" };
  }
  WindowView view(program, options, std::move(*display), std::move(*recorder));
  view.Run();
  KDSTREAM_TRY(view.Finish());
  return exitDone;
}

}
