// SPDX-License-Identifier: BSD-3-Clause
// Stores on this machine as a session's source. Step "receive" of the pipeline picture.
#include "viewer/client/LocalClient.h"

#include "filters/core/CaughtError.h"
#include "filters/store/StoreNotes.h"
#include "server/session/StoreCatalog.h"
#include "server/session/StoreModel.h"
#include "viewer/client/ClientThread.h"

#include <algorithm>
#include <chrono>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

namespace kdstream
{
// Takes requests, and gives events, in order.
class LocalClient::Reader
{
public:
  Reader(std::vector<std::shared_ptr<const ServedModel>> models,
    std::map<std::string, std::filesystem::path> notes)
    : Models(std::move(models))
    , Notes(std::move(notes))
    , Thread([this] { this->Fail(); })
  {
  }

  void Send(const SessionRequest& request)
  {
    const std::lock_guard lock(this->Mutex);
    if (request.kind == SessionRequest::Kind::Cancel)
    {
      std::erase_if(this->Jobs, [&](const Job& job) { return job.request == request.id; });
      return;
    }
    if (request.kind == SessionRequest::Kind::Open)
    {
      this->Add({ Job::Kind::Open, request.id, request.model, {} });
    }
    for (const protocol::BlobId& blob : request.blobs)
    {
      this->Add({ Job::Kind::Read, request.id, {}, blob });
    }
  }

  void AskForNotes(const std::string& model)
  {
    const std::lock_guard lock(this->Mutex);
    this->Add({ Job::Kind::Notes, 0, model, {} });
  }

  ClientThread& Events() { return this->Thread; }

private:
  using Clock = std::chrono::steady_clock;

  // A job opens a model, reads a blob of the model opened last, or reads the notes on a model.
  struct Job
  {
    enum class Kind
    {
      Open,
      Read,
      Notes
    };
    Kind kind = Kind::Open;
    std::uint32_t request = 0;
    std::string model;
    protocol::BlobId blob;
  };

  // REQUIRES: Mutex is locked.
  void Add(Job job)
  {
    this->Thread.Post([this] { this->DoNext(); });
    this->Jobs.push_back(std::move(job));
  }

  void DoNext()
  {
    {
      const std::lock_guard lock(this->Mutex);
      if (this->Jobs.empty()) // its job was cancelled
      {
        return;
      }
      this->Current = std::move(this->Jobs.front());
      this->Jobs.pop_front();
    }
    this->Publish(this->Do(this->Current));
  }

  void Fail()
  {
    if (this->Current.kind == Job::Kind::Notes)
    {
      return; // the model is shown without notes
    }
    ClientEvent event;
    event.kind = this->Current.kind == Job::Kind::Read ? ClientEvent::Kind::BlobFailed
                                                       : ClientEvent::Kind::RequestFailed;
    event.request = this->Current.request;
    event.blob = this->Current.blob;
    event.message = CaughtError().message;
    this->Publish(std::move(event));
  }

  void Publish(std::optional<ClientEvent> event)
  {
    std::vector<ClientEvent> events;
    if (event)
    {
      events.push_back(std::move(*event));
    }
    this->Thread.Publish(events);
  }

  std::optional<ClientEvent> Do(const Job& job)
  {
    switch (job.kind)
    {
      case Job::Kind::Open:
        return this->Open(job);
      case Job::Kind::Read:
        return this->Read(job);
      case Job::Kind::Notes:
        return this->ReadNotesOn(job.model);
    }
    return std::nullopt;
  }

  std::optional<ClientEvent> ReadNotesOn(const std::string& model) const
  {
    const auto file = this->Notes.find(model);
    auto notes = file == this->Notes.end() ? Result<NotesText>(Error{ ErrorCode::NotFound, "" })
                                           : ReadNotes(file->second);
    if (!notes)
    {
      return std::nullopt;
    }
    ClientEvent event;
    event.kind = ClientEvent::Kind::Notes;
    event.model.id = model;
    event.bytes = std::move(notes->bytes);
    return event;
  }

  ClientEvent Open(const Job& job)
  {
    ClientEvent event;
    event.request = job.request;
    const auto found = std::find_if(this->Models.begin(), this->Models.end(),
      [&](const auto& model) { return model->Description().id == job.model; });
    this->Opened = found == this->Models.end() ? nullptr : *found;
    if (!this->Opened)
    {
      event.message = "there is no model '" + job.model + "'";
      return event;
    }
    event.kind = ClientEvent::Kind::Opened;
    event.model = this->Opened->Description();
    return event;
  }

  ClientEvent Read(const Job& job)
  {
    const auto begin = Clock::now();
    ClientEvent event;
    event.request = job.request;
    event.blob = job.blob;
    const Result<BlobBytes> bytes =
      this->Opened ? this->Opened->ReadBlob(job.blob)
                   : Result<BlobBytes>(Error{ ErrorCode::NotFound, "no model is open" });
    if (!bytes)
    {
      event.kind = ClientEvent::Kind::BlobFailed;
      event.message = bytes.GetError().message;
      return event;
    }
    event.kind = ClientEvent::Kind::Blob;
    event.bytes = **bytes;
    event.transmissionSeconds = std::chrono::duration<double>(Clock::now() - begin).count();
    return event;
  }

  const std::vector<std::shared_ptr<const ServedModel>> Models;
  const std::map<std::string, std::filesystem::path> Notes;
  std::shared_ptr<const ServedModel> Opened; // this and the next are used only by the thread
  Job Current;
  std::mutex Mutex; // guards Jobs
  std::deque<Job> Jobs;
  ClientThread Thread; // the last member, because the thread uses all members above
};

LocalClient::LocalClient(std::vector<std::shared_ptr<const ServedModel>> models,
  std::map<std::string, std::filesystem::path> notes)
{
  for (const auto& model : models)
  {
    ModelSummary& summary = this->ModelList.emplace_back(Summarize(model->Description()));
    if (const auto file = notes.find(summary.id); file != notes.end())
    {
      const auto found = ReadNotes(file->second);
      summary.notes = found ? found->notes.size() : 0;
    }
  }
  this->Kept = std::make_unique<Reader>(std::move(models), std::move(notes));
}

LocalClient::~LocalClient() = default;

Result<std::unique_ptr<LocalClient>> LocalClient::Open(
  const std::filesystem::path& storeOrFolder, std::shared_ptr<const void> held)
{
  std::error_code failure;
  std::vector<std::shared_ptr<const ServedModel>> models;
  if (std::filesystem::is_directory(storeOrFolder, failure))
  {
    std::string wrong;
    const auto report = [&wrong](const std::filesystem::path& file, const std::string& what)
    {
      if (wrong.empty())
      {
        wrong = file.filename().string() + ": " + what;
      }
    };
    StoreCatalog catalog(storeOrFolder, report);
    KDSTREAM_TRY(catalog.Reload());
    models = catalog.Models();
    if (models.empty())
    {
      return Error{ ErrorCode::NotFound,
        wrong.empty() ? "this folder has no stores (.kds)" : wrong };
    }
  }
  else
  {
    // No cache of our own: repeated reads come from the operating system's cache.
    const auto model = OpenStoreModel(storeOrFolder, ModelIdLike(storeOrFolder.stem().string()),
      std::make_shared<BlobCache>(0), [](const std::string&) {});
    KDSTREAM_TRY(model);
    models.push_back(*model);
  }
  std::map<std::string, std::filesystem::path> notes;
  for (const auto& model : models)
  {
    const std::string& id = model->Description().id;
    notes[id] = NotesFileIn(storeOrFolder, id);
  }
  auto client = std::make_unique<LocalClient>(std::move(models), std::move(notes));
  client->Held = std::move(held);
  return client;
}

void LocalClient::Send(const SessionRequest& request)
{
  this->Kept->Send(request);
}

void LocalClient::AskForNotes(const std::string& model)
{
  this->Kept->AskForNotes(model);
}

std::vector<ClientEvent> LocalClient::Take()
{
  return this->Kept->Events().Take();
}

bool LocalClient::Wait(std::chrono::milliseconds atMost)
{
  return this->Kept->Events().Wait(atMost);
}

}
