// SPDX-License-Identifier: BSD-3-Clause
// A window's session and its source of models: see WindowSession.h.
#include "viewer/desktop/window/WindowSession.h"

#include "viewer/desktop/CheckColors.h"
#include "viewer/desktop/SettingSteps.h"

#include <algorithm>
#include <utility>

namespace kdstream
{

WindowSession::WindowSession(
  std::string program, const ViewOptions& options, SessionRecorder recorder)
  : Program(std::move(program))
  , Options(options)
  , Record(std::move(recorder))
  , Session(SessionOptionsOf(options))
{
  this->Session.SetCoasting(!this->Record.IsOn()); // session files do not record coasting
  this->Retry();
}

const std::vector<ModelSummary>* WindowSession::Models() const
{
  return this->Source ? &this->Source->Models() : nullptr;
}

const ModelDescription* WindowSession::Model() const
{
  const bool isOpen = this->Source && this->Opened.id == this->Session.GetStatus().model;
  return isOpen ? &this->Opened : nullptr;
}

// ---- the source of models

void WindowSession::Retry()
{
  if (this->Source)
  {
    this->Do({ SessionStep::Kind::Select, {}, this->Session.GetStatus().model });
    return;
  }
  this->OpeningTrouble.clear();
  this->Opening = std::make_unique<SourceOpening>(this->Program, this->Options);
}

bool WindowSession::Follow()
{
  if (!this->Source)
  {
    this->FollowOpening();
    return true;
  }
  const auto events = this->Source->Take();
  for (const ClientEvent& event : events)
  {
    if (event.kind == ClientEvent::Kind::Opened)
    {
      this->TakeModel(event.model);
    }
    if (event.kind == ClientEvent::Kind::Notes)
    {
      this->TakeNotes(event);
    }
    Deliver(event, this->Session);
  }
  this->Send();
  this->Complain();
  return !events.empty();
}

void WindowSession::TakeModel(const ModelDescription& model)
{
  this->Opened = model;
  this->Texts += model.title + model.description + model.credit + model.license;
  for (const ScalarDescription& scalar : model.scalars)
  {
    this->Texts += scalar.name;
  }
  this->CheckWantedColors(model);
  this->Book.Open(model.id, {});
  const auto& models = this->Source->Models();
  const auto found = std::find_if(models.begin(), models.end(),
    [&](const ModelSummary& summary) { return summary.id == model.id; });
  if (found != models.end() && found->notes > 0)
  {
    this->Source->AskForNotes(model.id);
  }
}

// Checks only the model that the command line names, or the only one: other models need not have
// the array.
void WindowSession::CheckWantedColors(const ModelDescription& model)
{
  const bool isMeant = model.id == this->Options.model || this->Source->Models().size() == 1;
  const Status known = CheckColors(this->Options.colors, model.scalars);
  if (this->WantsColors && isMeant && !known)
  {
    this->Code = PrintError(this->Program, "", At(this->Options.source, known).GetError());
    this->Tell(known.GetError().message);
  }
  this->WantsColors = this->WantsColors && !isMeant;
}

void WindowSession::TakeNotes(const ClientEvent& event)
{
  auto notes =
    ParseNotes({ reinterpret_cast<const char*>(event.bytes.data()), event.bytes.size() });
  if (!notes)
  {
    this->Tell("The notes on " + event.model.id + " cannot be read: " + notes.GetError().message);
  }
  else if (event.model.id == this->Book.Model())
  {
    for (const auto& note : *notes)
    {
      this->Texts += note.title + note.text;
    }
    this->Book.Open(event.model.id, std::move(*notes));
  }
}

void WindowSession::FollowOpening()
{
  auto ended = this->Opening ? this->Opening->Take() : std::nullopt;
  if (!ended)
  {
    return;
  }
  this->Opening.reset();
  if (*ended)
  {
    this->Begin(std::move(**ended));
  }
  else
  {
    this->OpeningTrouble = ended->GetError().message;
    this->Texts += this->OpeningTrouble;
    PrintError(this->Program, "", ended->GetError());
  }
}

void WindowSession::Begin(OpenedSources sources)
{
  this->Source = std::move(sources.models);
  this->PreviewSource = std::move(sources.previews);
  this->OpeningWarnings = std::move(sources.warnings);
  this->Texts += this->OpeningWarnings;
  const auto& models = this->Source->Models();
  for (const ModelSummary& model : models)
  {
    this->Texts += model.title;
  }
  this->Session.SetModels(models);
  this->Do({ SessionStep::Kind::Turning, {}, "upright" });
  this->RecordOptions();
  if (models.empty())
  {
    this->Tell("There are no models yet.");
    return;
  }
  const auto named = std::find_if(models.begin(), models.end(),
    [this](const ModelSummary& model) { return model.id == this->Options.model; });
  if (named != models.end() && !this->Options.link.empty())
  {
    this->Do({ SessionStep::Kind::Link, {}, this->Options.link });
  }
  else if (named != models.end() || models.size() == 1)
  {
    this->Open(named == models.end() ? 0 : static_cast<std::size_t>(named - models.begin()));
  }
  else
  {
    this->Do({ SessionStep::Kind::Select, {}, models.front().id });
  }
  if (!this->Options.model.empty() && named == models.end())
  {
    const Error error{ ErrorCode::NotFound,
      this->Options.source + ": there is no model '" + this->Options.model + "'" };
    PrintError(this->Program, "", error);
    this->Tell(error.message);
  }
}

// Records the options, so that a replay gives the same result whatever options it is started with.
void WindowSession::RecordOptions()
{
  const ViewOptions& now = this->Options;
  const ViewOptions usual;
  if (now.detail != usual.detail)
  {
    this->Record.Add(DetailStep(now.detail));
  }
  if (now.rings != usual.rings)
  {
    this->Record.Add(RingsStep(now.rings));
  }
  if (now.triangles != usual.triangles || now.memory != usual.memory)
  {
    this->Record.Add(BudgetsStep(now.triangles, now.memory));
  }
  if (now.colors != usual.colors)
  {
    this->Record.Add(ColorsStep(now.colors));
  }
  if (now.occlusion != usual.occlusion)
  {
    this->Record.Add(LightStep(now.occlusion));
  }
}

void WindowSession::Send()
{
  for (const SessionRequest& request : this->Session.TakeRequests())
  {
    this->Source->Send(request);
  }
}

// Reports the session's error in the window and on stderr, each sentence once.
void WindowSession::Complain()
{
  const std::string error = this->Session.GetStatus().error;
  if (!error.empty() && error != this->LastComplaint)
  {
    this->Texts += error;
    PrintError(this->Program, this->Options.source, { ErrorCode::NotFound, error });
  }
  this->LastComplaint = error;
}

void WindowSession::Tell(const std::string& note)
{
  this->Note = note;
  this->Texts += note;
}

// ---- what the user does

void WindowSession::Do(const SessionStep& step)
{
  this->NoteIdle(); // what arrived last may have needed no frame
  this->Record.Add(step);
  if (step.kind == SessionStep::Kind::Touches)
  {
    this->IsTouched = !step.frame.touches.empty();
  }
  if (const Status done = Perform(step, this->Session); !done)
  {
    this->Tell(done.GetError().message);
  }
  if (this->Source)
  {
    this->Send();
  }
}

void WindowSession::Open(std::size_t model)
{
  const std::string& id = this->Source->Models()[model].id;
  if (this->Session.GetStatus().model != id)
  {
    this->Do({ SessionStep::Kind::Select, {}, id });
  }
  this->Do({ SessionStep::Kind::Select, {}, id }); // the second selection: full screen
}

void WindowSession::OpenNext(int step)
{
  if (!this->Source || this->Source->Models().empty())
  {
    return;
  }
  const auto& models = this->Source->Models();
  const auto found = std::find_if(models.begin(), models.end(),
    [this](const ModelSummary& model) { return model.id == this->Session.GetStatus().model; });
  const auto count = static_cast<std::ptrdiff_t>(models.size());
  const std::ptrdiff_t now = found == models.end() ? 0 : found - models.begin();
  this->Open(static_cast<std::size_t>((now + step + count) % count));
}

void WindowSession::SetPrefetch(std::size_t bytes)
{
  this->Session.SetPrefetch(bytes);
}

void WindowSession::RemoveMeasurement(std::size_t index)
{
  this->Session.RemoveMeasurement(index);
  this->Send();
}

// ---- frames

void WindowSession::BeginFrame(double time)
{
  this->Session.Advance(time);
  this->Session.BeginFrame();
  this->Send();
}

void WindowSession::EndFrame(double seconds, bool isTouched)
{
  this->Session.EndFrame(seconds);
  this->IsTouched = isTouched;
  this->NoteIdle();
}

void WindowSession::NoteIdle()
{
  if (this->Session.IsIdle() && !this->IsTouched)
  {
    this->Record.NoteIdle();
  }
}

}
