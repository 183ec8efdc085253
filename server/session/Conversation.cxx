// SPDX-License-Identifier: BSD-3-Clause
#include "server/session/Conversation.h"

#include "filters/core/CaughtError.h"
#include "server/session/Refusal.h"

#include <algorithm>
#include <utility>

namespace kdstream
{

namespace
{

using protocol::ServerMessage;

constexpr std::uint64_t bytesBetweenProgress = std::uint64_t{ 1 } << 20;
constexpr const char* stopping = "the server is stopping";

bool IsSendable(const std::vector<std::uint8_t>& blob)
{
  return !blob.empty() && blob.size() <= protocol::maximumBlobBytes;
}

}

bool Task::Takes() const
{
  return this->Request ? std::holds_alternative<protocol::RegionRequest>(this->Request->body)
                       : this->May.IsCounted(this->Blob);
}

const void* Task::Source() const
{
  const auto* const open =
    this->Request ? std::get_if<protocol::OpenRequest>(&this->Request->body) : nullptr;
  return open ? this->Models.Find(open->model).get() : this->Model.get();
}

std::string Task::Part() const
{
  return this->Request ? "" : protocol::BlobName(this->Blob);
}

// An exception, mostly lack of memory, becomes an error.
void Task::Run() noexcept
{
  try
  {
    this->Do();
  }
  catch (...)
  {
    try
    {
      this->Failure = CaughtError();
    }
    catch (...) // no memory for a message either
    {
      this->Failure = Error{ ErrorCode::LimitExceeded, "" };
    }
  }
}

void Task::Do()
{
  if (!this->Request)
  {
    this->ReadBlob();
  }
  else if (const auto* open = std::get_if<protocol::OpenRequest>(&this->Request->body))
  {
    this->Model = this->Models.Find(open->model);
    if (const auto status = this->Model ? this->Model->CheckUnchanged() : Status{}; !status)
    {
      this->Failure = status.GetError();
    }
  }
  else
  {
    this->FindList();
  }
}

void Task::ReadBlob()
{
  const auto bytes = this->Model->ReadBlob(this->Blob);
  if (!bytes)
  {
    this->Failure = bytes.GetError();
  }
  else if (!IsSendable(**bytes))
  {
    this->Failure = Error{ ErrorCode::Damaged, "the store has no size for this blob" };
  }
  else
  {
    this->Bytes = *bytes;
    if (this->May.IsCounted(this->Blob))
    {
      this->Refused =
        this->May.TakePartition(this->Model->Description(), this->Blob.number, this->Bytes->size());
    }
  }
}

void Task::FindList()
{
  if (std::holds_alternative<protocol::RegionRequest>(this->Request->body))
  {
    this->Refused = this->May.TakeRegion(this->Model->Description());
    if (this->Refused)
    {
      return;
    }
  }
  auto list = ListBlobs(*this->Model, *this->Request, this->MostPartitions);
  if (list)
  {
    this->List = std::move(*list);
  }
  else
  {
    this->Failure = list.GetError();
  }
}

struct Conversation::Job
{
  std::uint32_t request = 0;
  std::chrono::steady_clock::time_point received;
  std::shared_ptr<const ServedModel> model; // the model that was open when the request started
  BlobList list;
  bool begun = false;
  std::size_t next = 0;     // index in the list of the blob after `bytes`
  BlobBytes bytes;          // the blob that is being sent, or null
  std::uint32_t offset = 0; // of the next frame in `bytes`
  std::uint64_t sentBlobs = 0, sentBytes = 0, failedBlobs = 0, reportedBytes = 0;

  ServerMessage End(bool cancelled) const
  {
    return { this->request,
      protocol::EndAnswer{ this->sentBlobs, this->sentBytes, this->failedBlobs, cancelled } };
  }
};

Conversation::Conversation(
  const Catalog& catalog, const ConversationLimits& limits, Permission permission)
  : Models(catalog)
  , Limits(limits)
  , May(std::move(permission))
{
}

Conversation::~Conversation() = default;

void Conversation::Receive(std::string_view text, std::chrono::seconds wait)
{
  if (this->Close)
  {
    return;
  }
  const auto message = protocol::ParseClientMessage(text, this->Limits.message);
  if (!message)
  {
    const Error& error = message.GetError();
    if (error.code == ErrorCode::InvalidArgument)
    {
      const auto request = protocol::FindRequestId(text, this->Limits.message);
      this->AnswerError(this->IsUnfinished(request) ? 0 : request, 400, error.message);
      return;
    }
    const bool tooLarge = error.code == ErrorCode::LimitExceeded;
    this->AnswerError(0, tooLarge ? 413 : 400, error.message);
    this->Close = tooLarge ? CloseReason::TooLarge : CloseReason::NotJson;
    return;
  }

  if (std::holds_alternative<protocol::CancelRequest>(message->body))
  {
    this->Cancel(message->request);
  }
  else if (this->IsUnfinished(message->request))
  {
    this->AnswerError(
      0, 409, "request " + std::to_string(message->request) + " is not finished yet");
  }
  else if (wait.count() > 0)
  {
    this->AnswerError(message->request, 429, TooManyRequests(wait));
  }
  else if (this->Waiting.size() + (this->Current ? 1 : 0) >= this->Limits.requests)
  {
    ++this->Counts.tooMany;
    this->AnswerError(message->request, 429,
      "the limit of " + std::to_string(this->Limits.requests) + " unfinished requests is reached");
  }
  else if (this->Draining)
  {
    this->AnswerError(message->request, 503, stopping);
  }
  else
  {
    this->Waiting.push_back({ *message, std::chrono::steady_clock::now() });
  }
}

void Conversation::ReceiveBinary()
{
  if (!this->Close)
  {
    this->AnswerError(0, 400, "clients may only send text messages");
    this->Close = CloseReason::NotText;
  }
}

void Conversation::Drain()
{
  this->Draining = true;
  for (const auto& waiting : this->Waiting)
  {
    this->AnswerError(waiting.message.request, 503, stopping);
  }
  this->Waiting.clear();
}

// Tells the client why each request ends. If there is no request, the message has the id 0.
void Conversation::EndUnlessPermitted()
{
  const auto refused = this->Close ? std::nullopt : this->May.RefuseAll();
  if (!refused)
  {
    return;
  }
  ++this->Counts.forbidden;
  this->Answers.clear();
  if (this->IsIdle())
  {
    this->AnswerError(0, refused->status, refused->message);
  }
  if (this->Current)
  {
    this->AnswerError(this->Current->request, refused->status, refused->message);
  }
  for (const auto& waiting : this->Waiting)
  {
    this->AnswerError(waiting.message.request, refused->status, refused->message);
  }
  this->Current.reset();
  this->Pending.reset();
  this->Waiting.clear();
  this->Model.reset();
  this->Close = CloseReason::NotPermitted;
}

// Why the client may not have what the message asks for; nothing if it may. REQUIRES: a model is
// open, or the message opens one.
Permission::Refused Conversation::RefusalOf(const protocol::ClientMessage& message) const
{
  const auto* open = std::get_if<protocol::OpenRequest>(&message.body);
  return open ? this->May.RefuseModel(open->model)
              : this->May.RefuseRequest(this->Model->Description(), message);
}

bool Conversation::AcceptsMessages() const
{
  return !this->Close && this->Answers.size() < maximumPendingAnswers;
}

std::optional<Conversation::Message> Conversation::NextMessage()
{
  this->Latest = {};
  this->EndUnlessPermitted();
  for (;;)
  {
    if (!this->Answers.empty())
    {
      auto text = protocol::WriteServerMessage(this->Answers.front());
      this->Answers.pop_front();
      return text;
    }
    if (this->Close || this->Pending)
    {
      return std::nullopt;
    }
    if (this->Current)
    {
      if (auto message = this->Continue())
      {
        return message;
      }
    }
    else if (!this->Waiting.empty())
    {
      auto received = std::move(this->Waiting.front());
      this->Waiting.pop_front();
      this->Start(std::move(received));
    }
    else
    {
      if (this->Draining)
      {
        this->Close = CloseReason::GoingAway;
      }
      return std::nullopt;
    }
  }
}

std::shared_ptr<Task> Conversation::TakeTask()
{
  const bool isNew = this->Pending && !std::exchange(this->Pending->Taken, true);
  return isNew ? this->Pending : nullptr;
}

void Conversation::Finish(const std::shared_ptr<Task>& task)
{
  if (task != this->Pending)
  {
    return;
  }
  this->Pending.reset();
  if (task->Refused)
  {
    this->AnswerError(this->Current->request, task->Refused->status, task->Refused->message);
    this->Current.reset();
  }
  else if (!task->Request)
  {
    this->FinishBlob(*task);
  }
  else if (std::holds_alternative<protocol::OpenRequest>(task->Request->body))
  {
    this->FinishOpening(*task);
  }
  else
  {
    this->FinishList(*task);
  }
}

void Conversation::GiveUp(const std::shared_ptr<Task>& task)
{
  if (task != this->Pending)
  {
    return;
  }
  // While a task runs, only members that do not change are read.
  auto failed = std::make_shared<Task>(this->Models, this->Limits.partitions, this->May);
  failed->Request = task->Request;
  failed->Blob = task->Blob;
  failed->Failure = Error{ ErrorCode::InputOutput, "the disk does not respond" };
  this->Pending = failed;
  this->Finish(failed);
}

void Conversation::Answer(ServerMessage message)
{
  this->Answers.push_back(std::move(message));
}

void Conversation::AnswerError(std::uint32_t request, unsigned code, std::string message)
{
  this->Answer({ request,
    protocol::ErrorAnswer{ static_cast<std::uint16_t>(code), std::move(message), std::nullopt } });
}

bool Conversation::IsUnfinished(std::uint32_t request) const
{
  return (this->Current && this->Current->request == request) ||
         std::any_of(this->Waiting.begin(), this->Waiting.end(),
           [request](const Received& waiting) { return waiting.message.request == request; });
}

void Conversation::Cancel(std::uint32_t request)
{
  if (this->Current && this->Current->request == request)
  {
    this->Answer(this->Current->End(true));
    this->Current.reset();
    this->Pending.reset();
    return;
  }
  const auto found = std::find_if(this->Waiting.begin(), this->Waiting.end(),
    [request](const Received& waiting) { return waiting.message.request == request; });
  if (found != this->Waiting.end())
  {
    this->Waiting.erase(found);
    this->Answer({ request, protocol::EndAnswer{ 0, 0, 0, true } });
  }
}

void Conversation::Start(Received received)
{
  auto& message = received.message;
  const bool opens = std::holds_alternative<protocol::OpenRequest>(message.body);
  if (!opens && !this->Model)
  {
    this->AnswerError(message.request, 409, "no model is open");
    return;
  }
  if (const auto refused = this->RefusalOf(message))
  {
    ++this->Counts.forbidden;
    this->AnswerError(message.request, refused->status, refused->message);
    return;
  }
  this->Current = std::make_unique<Job>();
  this->Current->request = message.request;
  this->Current->received = received.at;
  this->Current->model = opens ? nullptr : this->Model;
  this->Pending = std::make_shared<Task>(this->Models, this->Limits.partitions, this->May);
  this->Pending->Model = this->Current->model;
  this->Pending->Request = std::move(message);
  const bool takesLong =
    opens || std::holds_alternative<protocol::RegionRequest>(this->Pending->Request->body);
  if (!takesLong)
  {
    const auto task = this->TakeTask();
    task->Run();
    this->Finish(task);
  }
}

// Ends the current request, which cannot be answered.
void Conversation::Refuse(const Error& error)
{
  const bool missing = error.code == ErrorCode::NotFound; // the error says which blob
  const auto refusal = RefusePart(this->Current->model->Description().id, "tree", error);
  this->Counts.failedBlobs += refusal.IsFailure();
  this->AnswerError(
    this->Current->request, refusal.status, missing ? error.message : refusal.message);
  this->Current.reset();
}

void Conversation::FinishList(Task& task)
{
  if (task.Failure)
  {
    this->Refuse(*task.Failure);
    return;
  }
  this->Current->list = std::move(task.List);
}

void Conversation::FinishOpening(Task& task)
{
  const auto request = this->Current->request;
  const auto& name = std::get<protocol::OpenRequest>(task.Request->body).model;
  this->Current.reset();
  if (task.Failure)
  {
    const auto refusal = RefuseModel(name, *task.Failure);
    this->AnswerError(request, refusal.status, refusal.message);
  }
  else if (!task.Model)
  {
    this->AnswerError(request, 404, "there is no model " + name);
  }
  else
  {
    this->Model = std::move(task.Model);
    this->Answer({ request,
      protocol::OpenedAnswer{ WithDetail(this->Model->Description(), this->May.Detail()) } });
  }
}

// Finishes reading the next blob, or tells the client why it cannot be sent. If none of the other
// blobs can be read either, the request ends.
void Conversation::FinishBlob(Task& task)
{
  Job& job = *this->Current;
  if (!task.Failure)
  {
    job.bytes = std::move(task.Bytes);
    job.offset = 0;
    return;
  }
  const auto refusal =
    RefusePart(job.model->Description().id, protocol::BlobName(task.Blob), *task.Failure);
  this->Counts.failedBlobs += refusal.IsFailure();
  if (task.Failure->code == ErrorCode::Changed)
  {
    this->AnswerError(job.request, refusal.status, refusal.message);
    this->Current.reset();
    return;
  }
  ++job.failedBlobs;
  this->Answer(
    { job.request, protocol::ErrorAnswer{ refusal.status, refusal.message, task.Blob } });
}

// The next message of the current request. Nothing if the message was added to Answers instead, or
// if a task must be done first.
std::optional<Conversation::Message> Conversation::Continue()
{
  Job& job = *this->Current;
  if (!job.begun)
  {
    job.begun = true;
    this->Answer({ job.request,
      protocol::BeginAnswer{ job.list.blobs.size(), job.list.estimatedBytes, job.list.region } });
  }
  else if (job.sentBytes - job.reportedBytes >= bytesBetweenProgress)
  {
    job.reportedBytes = job.sentBytes;
    this->Answer({ job.request, protocol::ProgressAnswer{ job.sentBlobs, job.sentBytes } });
  }
  else if (job.bytes || (job.next < job.list.blobs.size() && this->HasBlob()))
  {
    return this->NextFrame();
  }
  else if (!this->Pending && job.next == job.list.blobs.size())
  {
    this->Answer(job.End(false));
    this->Current.reset();
  }
  return std::nullopt;
}

// Continues with the next blob of the current request. False if it must be read first.
bool Conversation::HasBlob()
{
  Job& job = *this->Current;
  const auto id = job.list.blobs[job.next++];
  job.offset = 0;
  // A blob that counts, or is not in memory, is read by the task.
  job.bytes = this->May.IsCounted(id) ? nullptr : job.model->FindBlob(id);
  if (job.bytes && IsSendable(*job.bytes))
  {
    return true;
  }
  job.bytes.reset();
  this->Pending = std::make_shared<Task>(this->Models, this->Limits.partitions, this->May);
  this->Pending->Model = job.model;
  this->Pending->Blob = id;
  return false;
}

std::vector<std::uint8_t> Conversation::NextFrame()
{
  Job& job = *this->Current;
  const auto rest = std::span<const std::uint8_t>(*job.bytes).subspan(job.offset);
  const auto payload = rest.first(std::min(rest.size(), protocol::maximumPayloadBytes));
  auto frame = protocol::EncodeFrame({ job.request, job.list.blobs[job.next - 1], job.offset,
                                       static_cast<std::uint32_t>(job.bytes->size()) },
    payload);
  job.offset += static_cast<std::uint32_t>(payload.size());
  job.sentBytes += payload.size();
  if (payload.size() == rest.size())
  {
    ++job.sentBlobs;
    this->Latest = { job.sentBlobs == 1, job.next == job.list.blobs.size(), job.received };
    job.bytes.reset();
  }
  return frame;
}

}
