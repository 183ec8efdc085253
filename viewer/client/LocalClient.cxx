// SPDX-License-Identifier: BSD-3-Clause
// Stores of this machine as a session's source. Step "receive" of the README's picture.
#include "viewer/client/LocalClient.h"

#include "server/session/StoreCatalog.h"
#include "server/session/StoreModel.h"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>

namespace kdstream
{
// Requests in, events out, in order.
class LocalClient::Reader
{
public:
  explicit Reader(std::vector<std::shared_ptr<const ServedModel>> models)
    : Models(std::move(models))
    , Thread([this] { this->Run(); })
  {
  }

  ~Reader()
  {
    {
      const std::lock_guard lock(this->Mutex);
      this->Ended = true;
    }
    this->Wanted.notify_one();
    this->Thread.join();
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
      this->Jobs.push_back({ request.id, request.model, {} });
    }
    for (const protocol::BlobId& blob : request.blobs)
    {
      this->Jobs.push_back({ request.id, {}, blob });
    }
    this->Wanted.notify_one();
  }

  std::vector<ClientEvent> Take()
  {
    const std::lock_guard lock(this->Mutex);
    return std::exchange(this->Events, {});
  }

  bool Wait(std::chrono::milliseconds atMost)
  {
    std::unique_lock lock(this->Mutex);
    return this->Arrived.wait_for(lock, atMost, [this] { return !this->Events.empty(); });
  }

private:
  using Clock = std::chrono::steady_clock;

  // To open a model, or to read a blob of the one that was opened last.
  struct Job
  {
    std::uint32_t request = 0;
    std::string model;
    protocol::BlobId blob;
  };

  void Run()
  {
    std::unique_lock lock(this->Mutex);
    for (;;)
    {
      this->Wanted.wait(lock, [this] { return this->Ended || !this->Jobs.empty(); });
      if (this->Ended)
      {
        return;
      }
      const Job job = std::move(this->Jobs.front());
      this->Jobs.pop_front();
      lock.unlock();
      ClientEvent event = job.model.empty() ? this->Read(job) : this->Open(job);
      lock.lock();
      this->Events.push_back(std::move(event));
      this->Arrived.notify_all();
    }
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
  std::shared_ptr<const ServedModel> Opened; // the thread's own

  std::mutex Mutex; // of all below
  std::condition_variable Wanted, Arrived;
  std::deque<Job> Jobs;
  std::vector<ClientEvent> Events;
  bool Ended = false;
  std::thread Thread;
};

LocalClient::LocalClient(std::vector<std::shared_ptr<const ServedModel>> models)
{
  for (const auto& model : models)
  {
    this->ModelList.push_back(Summarize(model->Description()));
  }
  this->Kept = std::make_unique<Reader>(std::move(models));
}

LocalClient::~LocalClient() = default;

Result<std::unique_ptr<LocalClient>> LocalClient::Open(const std::filesystem::path& storeOrFolder)
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
        wrong.empty() ? "no stores (.kds) are in this folder" : wrong };
    }
  }
  else
  {
    // What is read again lies in the operating system's memory anyway.
    const auto model = OpenStoreModel(storeOrFolder, ModelIdLike(storeOrFolder.stem().string()),
      std::make_shared<BlobCache>(0), [](const std::string&) {});
    KDSTREAM_TRY(model);
    models.push_back(*model);
  }
  return std::make_unique<LocalClient>(std::move(models));
}

void LocalClient::Send(const SessionRequest& request)
{
  this->Kept->Send(request);
}

std::vector<ClientEvent> LocalClient::Take()
{
  return this->Kept->Take();
}

bool LocalClient::Wait(std::chrono::milliseconds atMost)
{
  return this->Kept->Wait(atMost);
}

}
