// SPDX-License-Identifier: BSD-3-Clause
// A window's session and its source of models: the window's state except its picture. No VTK, no X.
#pragma once

#include "viewer/desktop/ViewOptions.h"
#include "viewer/desktop/window/NotesBook.h"
#include "viewer/desktop/window/SessionRecorder.h"
#include "viewer/desktop/window/SourceOpening.h"
#include "viewer/session/ViewerSession.h"

#include <memory>
#include <string>
#include <vector>

namespace kdstream
{

class WindowSession
{
public:
  // Starts to open what the options name. Errors are also printed on stderr, as errors of
  // `program`.
  WindowSession(std::string program, const ViewOptions& options, SessionRecorder recorder);

  // Takes what has arrived; returns whether there is any news.
  bool Follow();
  bool IsOpening() const { return this->Opening != nullptr; }
  bool IsOpen() const { return this->Source != nullptr; }
  // Progress of opening, and the error if opening fails.
  std::string Progress() const { return this->Opening ? this->Opening->Progress() : ""; }
  const std::string& Trouble() const { return this->OpeningTrouble; }
  // Warnings about an open source, such as an unreachable server.
  const std::string& Warnings() const { return this->OpeningWarnings; }
  // exitDone, or the error's code if the models lack what the command line asks for.
  int ExitCode() const { return this->Code; }
  // The models of the source; null before the source is open.
  const std::vector<ModelSummary>* Models() const;
  // The description of the selected model; null before that model is open.
  const ModelDescription* Model() const;
  // The same source, opened a second time for previews; null if there is none. Can be taken only
  // once.
  std::unique_ptr<ModelSource> TakePreviewSource() { return std::move(this->PreviewSource); }

  const ViewerSession& Viewer() const { return this->Session; }
  // Notes on the model that is open.
  NotesBook& Notes() { return this->Book; }
  const NotesBook& Notes() const { return this->Book; }
  SessionRecorder& Recorder() { return this->Record; }
  bool IsRecording() const { return this->Record.IsOn(); }

  // Performs a user's step, and records it.
  void Do(const SessionStep& step);
  // Opens the model in the whole window.
  void Open(std::size_t model);
  // Opens the next model of the list (step 1), or the one before (step -1).
  void OpenNext(int step);
  // Tries to fetch again what could not be fetched.
  void Retry();
  void SetPrefetch(std::size_t bytes);
  // These do the same as in ViewerSession; none of them is recorded.
  void SetSpinning(bool spins) { this->Session.SetSpinning(spins); }
  void RemoveMeasurement(std::size_t index);
  void NameMeasurement(std::size_t index, const std::string& name)
  {
    this->Session.NameMeasurement(index, name);
  }

  // BeginFrame calls ViewerSession's Advance and BeginFrame; EndFrame calls its EndFrame.
  void BeginFrame(double time);
  void EndFrame(double seconds, bool isTouched);

  // Returns a message to show for a moment, if there is one since the last call; otherwise empty.
  std::string TakeNote() { return std::exchange(this->Note, {}); }
  // Returns new texts that may be shown from now on, so that their letters can be loaded.
  std::string TakeTexts() { return std::exchange(this->Texts, {}); }

private:
  void Begin(OpenedSources sources);
  void RecordOptions();
  void NoteIdle();
  void TakeModel(const ModelDescription& model);
  void CheckWantedColors(const ModelDescription& model);
  void TakeNotes(const ClientEvent& event);
  void FollowOpening();
  void Send();
  void Complain();
  void Tell(const std::string& note);

  std::string Program;
  ViewOptions Options;
  SessionRecorder Record;
  ViewerSession Session;
  std::unique_ptr<SourceOpening> Opening;
  std::string OpeningTrouble, OpeningWarnings;
  std::unique_ptr<ModelSource> Source, PreviewSource;
  ModelDescription Opened;
  NotesBook Book;
  std::string LastComplaint, Note, Texts;
  int Code = exitDone;
  bool WantsColors = true; // the first model's arrays have not been compared with the options yet
  bool IsTouched = false;  // a finger or button is down: do not wait until the session is idle
};

}
