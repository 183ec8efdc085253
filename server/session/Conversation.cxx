// SPDX-License-Identifier: BSD-3-Clause
#include "server/session/Conversation.h"

#include "filters/core/CaughtError.h"
#include "server/session/BlobList.h"
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

// A region may take more memory than there is.
Result<BlobList> CaughtList(const ServedModel& model, const protocol::ClientMessage& message)
{
  try
  {
    return ListBlobs(model, message);
  }
  catch (...)
  {
    return CaughtError();
  }
}

}

struct Conversation::Job
{
  std::uint32_t request = 0;
  std::shared_ptr<const ServedModel> model; // as it was open when the request was started
  BlobList list;
  bool begun = false;
  std::uint64_t next = 0;   // index in the list of the blob after `bytes`
  BlobBytes bytes;          // the blob that is being sent, or null
  std::uint32_t offset = 0; // of its next frame
  std::uint64_t sentBlobs = 0, sentBytes = 0, failedBlobs = 0, reportedBytes = 0;

  ServerMessage End(bool cancelled) const
  {
    return { this->request,
      protocol::EndAnswer{ this->sentBlobs, this->sentBytes, this->failedBlobs, cancelled } };
  }
};

Conversation::Conversation(const Catalog& catalog)
  : Models(catalog)
{
}

Conversation::~Conversation() = default;

void Conversation::Receive(std::string_view text)
{
  if (this->Close)
  {
    return;
  }
  const auto message = protocol::ParseClientMessage(text);
  if (!message)
  {
    const Error& error = message.GetError();
    if (error.code == ErrorCode::InvalidArgument)
    {
      const auto request = protocol::FindRequestId(text);
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
  else if (this->Waiting.size() + (this->Current ? 1 : 0) >= maximumRequests)
  {
    this->AnswerError(message->request, 429,
      "there are already " + std::to_string(maximumRequests) + " unfinished requests");
  }
  else if (this->Draining)
  {
    this->AnswerError(message->request, 503, stopping);
  }
  else
  {
    this->Waiting.push_back(*message);
  }
}

void Conversation::ReceiveBinary()
{
  if (!this->Close)
  {
    this->AnswerError(0, 400, "a client sends text messages only");
    this->Close = CloseReason::NotText;
  }
}

void Conversation::Drain()
{
  this->Draining = true;
  for (const auto& waiting : this->Waiting)
  {
    this->AnswerError(waiting.request, 503, stopping);
  }
  this->Waiting.clear();
}

bool Conversation::AcceptsMessages() const
{
  return !this->Close && this->Answers.size() < maximumPendingAnswers;
}

std::optional<Conversation::Message> Conversation::NextMessage()
{
  for (;;)
  {
    if (!this->Answers.empty())
    {
      auto text = protocol::WriteServerMessage(this->Answers.front());
      this->Answers.pop_front();
      return text;
    }
    if (this->Close)
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
      const auto message = std::move(this->Waiting.front());
      this->Waiting.pop_front();
      this->Start(message);
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
           [request](const protocol::ClientMessage& waiting)
           { return waiting.request == request; });
}

void Conversation::Cancel(std::uint32_t request)
{
  if (this->Current && this->Current->request == request)
  {
    this->Answer(this->Current->End(true));
    this->Current.reset();
    return;
  }
  const auto found = std::find_if(this->Waiting.begin(), this->Waiting.end(),
    [request](const protocol::ClientMessage& waiting) { return waiting.request == request; });
  if (found != this->Waiting.end())
  {
    this->Waiting.erase(found);
    this->Answer({ request, protocol::EndAnswer{ 0, 0, 0, true } });
  }
}

void Conversation::Start(const protocol::ClientMessage& message)
{
  if (const auto* open = std::get_if<protocol::OpenRequest>(&message.body))
  {
    this->Open(message.request, *open);
    return;
  }
  if (!this->Model)
  {
    this->AnswerError(message.request, 409, "no model is open");
    return;
  }
  auto list = CaughtList(*this->Model, message);
  if (!list)
  {
    const Error& error = list.GetError();
    const bool missing = error.code == ErrorCode::NotFound; // the error says which blob
    const auto refusal = RefusePart(this->Model->Description().id, "tree", error);
    this->AnswerError(message.request, refusal.status, missing ? error.message : refusal.message);
    return;
  }
  this->Current = std::make_unique<Job>();
  this->Current->request = message.request;
  this->Current->model = this->Model;
  this->Current->list = std::move(*list);
}

void Conversation::Open(std::uint32_t request, const protocol::OpenRequest& body)
{
  auto model = this->Models.Find(body.model);
  if (!model)
  {
    this->AnswerError(request, 404, "there is no model " + body.model);
    return;
  }
  if (!model->CheckUnchanged())
  {
    const auto refusal = RefuseModel(body.model);
    this->AnswerError(request, refusal.status, refusal.message);
    return;
  }
  this->Model = std::move(model);
  this->Answer({ request, protocol::OpenedAnswer{ this->Model->Description() } });
}

// The next message of the current request; nothing if that has been added to Answers instead.
std::optional<Conversation::Message> Conversation::Continue()
{
  Job& job = *this->Current;
  if (!job.begun)
  {
    job.begun = true;
    this->Answer({ job.request,
      protocol::BeginAnswer{ job.list.count, job.list.estimatedBytes, job.list.region } });
  }
  else if (job.sentBytes - job.reportedBytes >= bytesBetweenProgress)
  {
    job.reportedBytes = job.sentBytes;
    this->Answer({ job.request, protocol::ProgressAnswer{ job.sentBlobs, job.sentBytes } });
  }
  else if (job.bytes || (job.next < job.list.count && this->NextBlob()))
  {
    return this->NextFrame();
  }
  else if (this->Current && job.next == job.list.count)
  {
    this->Answer(job.End(false));
    this->Current.reset();
  }
  return std::nullopt;
}

// Reads the next blob of the current request. False if it cannot be read: then the client has been
// told, and where none of the others can be read either, the request has ended.
bool Conversation::NextBlob()
{
  Job& job = *this->Current;
  const auto id = job.list.At(job.next++);
  auto blob = job.model->ReadBlob(id);
  if (blob && ((*blob)->empty() || (*blob)->size() > protocol::maximumBlobBytes))
  {
    blob = Error{ ErrorCode::Damaged, "no size of a blob" };
  }
  if (blob)
  {
    job.bytes = *blob;
    job.offset = 0;
    return true;
  }
  const auto refusal =
    RefusePart(job.model->Description().id, protocol::BlobName(id), blob.GetError());
  this->Failed += refusal.IsFailure();
  if (blob.GetError().code == ErrorCode::Changed)
  {
    this->AnswerError(job.request, refusal.status, refusal.message);
    this->Current.reset();
    return false;
  }
  ++job.failedBlobs;
  this->Answer({ job.request, protocol::ErrorAnswer{ refusal.status, refusal.message, id } });
  return false;
}

std::vector<std::uint8_t> Conversation::NextFrame()
{
  Job& job = *this->Current;
  const auto rest = std::span<const std::uint8_t>(*job.bytes).subspan(job.offset);
  const auto payload = rest.first(std::min(rest.size(), protocol::maximumPayloadBytes));
  auto frame = protocol::EncodeFrame({ job.request, job.list.At(job.next - 1), job.offset,
                                       static_cast<std::uint32_t>(job.bytes->size()) },
    payload);
  job.offset += static_cast<std::uint32_t>(payload.size());
  job.sentBytes += payload.size();
  if (payload.size() == rest.size())
  {
    ++job.sentBlobs;
    job.bytes.reset();
  }
  return frame;
}

}
