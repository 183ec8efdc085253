// SPDX-License-Identifier: BSD-3-Clause
// A session's requests as messages of the stream, and the server's answers as events.
#include "viewer/client/StreamConversation.h"

#include "viewer/client/HttpFetch.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

namespace kdstream
{
namespace
{

using protocol::BlobId;

// The most names in one message. This number of the longest names, "partitions/1073741823" with
// quotes and comma, stays well below maximumClientMessageBytes.
constexpr std::ptrdiff_t longestList = 150;

}

std::vector<BlobId> StreamConversation::PendingRequest::OutstandingInOrder() const
{
  std::vector<BlobId> blobs;
  std::copy_if(this->wanted.begin(), this->wanted.end(), std::back_inserter(blobs),
    [this](const BlobId& blob) { return this->outstanding.count(blob) != 0; });
  return blobs;
}

void StreamConversation::Send(const SessionRequest& request, double now)
{
  using Kind = SessionRequest::Kind;
  if (request.kind == Kind::Cancel)
  {
    this->Cancel(request.id);
    this->Flush(now);
    this->FollowOldest(now);
    return;
  }
  if (request.kind != Kind::Open && !this->Refusal.empty())
  {
    this->Fail(request.id, this->Refusal);
    return;
  }
  PendingRequest& pending = this->Outstanding[request.id];
  pending.open = request.kind == Kind::Open;
  pending.model = request.model;
  pending.wanted = request.blobs;
  pending.outstanding.insert(request.blobs.begin(), request.blobs.end());
  if (request.kind == Kind::Open)
  {
    this->Model = request.model;
    this->Digest.clear();
    this->Refusal.clear();
    this->Queue(request.id, protocol::OpenRequest{ request.model });
  }
  else
  {
    this->QueueList(request.id, request.blobs);
  }
  this->Flush(now);
  this->FollowOldest(now);
}

void StreamConversation::Queue(std::uint32_t request, decltype(protocol::ClientMessage::body) body)
{
  if (request != 0)
  {
    ++this->Outstanding[request].messages;
  }
  this->Waiting.push_back({ request, { 0, std::move(body) }, 0, {} });
}

// Queues a list, as several messages if it is too long for one.
void StreamConversation::QueueList(std::uint32_t request, const std::vector<BlobId>& blobs)
{
  for (auto next = blobs.begin(); next != blobs.end();)
  {
    const auto begin = std::exchange(next, next + std::min(longestList, blobs.end() - next));
    this->Queue(request, protocol::BlobsRequest{ { begin, next } });
  }
}

void StreamConversation::Cancel(std::uint32_t request)
{
  const auto pending = this->Outstanding.find(request);
  if (pending == this->Outstanding.end())
  {
    return;
  }
  const std::set<BlobId> outstanding = std::move(pending->second.outstanding);
  this->Outstanding.erase(pending);
  std::erase_if(
    this->Waiting, [request](const Message& message) { return message.request == request; });
  for (auto& [wire, message] : this->Unfinished)
  {
    // An open cannot be cancelled; its answer is ignored.
    const bool open = std::holds_alternative<protocol::OpenRequest>(message.content.body);
    if (message.request == request && !open)
    {
      this->Messages.push_back(protocol::WriteClientMessage({ wire, protocol::CancelRequest{} }));
      message.cancelled = outstanding;
    }
  }
}

void StreamConversation::Flush(double now)
{
  while (!this->Waiting.empty() && this->Unfinished.size() < mostUnfinished)
  {
    Message message = std::move(this->Waiting.front());
    this->Waiting.pop_front();
    message.content.request = ++this->LastWire;
    message.sent = now;
    this->Messages.push_back(protocol::WriteClientMessage(message.content));
    this->Unfinished[this->LastWire] = std::move(message);
  }
}

// Reserves memory for one event before a message is taken: a finished request must be reported, so
// without memory for that nothing is taken.
void StreamConversation::MakeRoomForEvent()
{
  if (this->Events.size() == this->Events.capacity())
  {
    this->Events.reserve(2 * this->Events.size() + 4);
  }
}

Status StreamConversation::ReceiveText(std::string_view text, double now)
{
  this->MakeRoomForEvent();
  auto message = protocol::ParseServerMessage(text);
  KDSTREAM_TRY(message);
  const std::uint32_t wire = message->request;
  this->NoteMessage(wire, false, now);
  const auto found = this->Unfinished.find(wire);
  if (const auto* error = std::get_if<protocol::ErrorAnswer>(&message->body))
  {
    // If the server is too busy to open the model again, this is an error, so that the line
    // connects again later.
    const bool reopening = found != this->Unfinished.end() && found->second.request == 0;
    if (wire == 0 || (reopening && IsBusy(error->code)))
    {
      return Error{ ErrorCode::InvalidInput, "the server refused: " + error->message };
    }
    this->Failed(wire, *error, now);
  }
  else if (const auto* opened = std::get_if<protocol::OpenedAnswer>(&message->body))
  {
    if (found != this->Unfinished.end())
    {
      const std::uint32_t request = found->second.request;
      this->Unfinished.erase(found);
      this->Opened(request, opened->model);
      this->Flush(now);
    }
  }
  else if (std::holds_alternative<protocol::EndAnswer>(message->body))
  {
    this->Frames.Forget(wire);
    this->FinishMessage(wire, now);
  }
  this->FollowOldest(now);
  return {};
}

void StreamConversation::Opened(std::uint32_t request, const ModelDescription& model)
{
  const auto pending = this->Outstanding.find(request);
  if (request == 0 && model.digest != this->Digest)
  {
    this->RefuseModel("the model has been replaced on the server; select it again");
  }
  else if (pending != this->Outstanding.end() && pending->second.open)
  {
    this->Digest = model.digest;
    ClientEvent event;
    event.kind = ClientEvent::Kind::Opened;
    event.request = request;
    event.model = model;
    this->Events.push_back(std::move(event));
    // This comes last: if there is no memory for the event, the request stays outstanding.
    this->Outstanding.erase(pending);
  }
}

// The server reports an error: for one blob, or for a whole message, which then ends.
void StreamConversation::Failed(std::uint32_t wire, const protocol::ErrorAnswer& answer, double now)
{
  const auto message = this->Unfinished.find(wire);
  if (message == this->Unfinished.end())
  {
    return;
  }
  const std::uint32_t request = message->second.request;
  const auto pending = this->Outstanding.find(request);
  if (IsBusy(answer.code) && request != 0)
  {
    if (pending != this->Outstanding.end())
    {
      pending->second.busy = answer.message.empty() ? "the server is busy" : answer.message;
    }
    if (!answer.blob)
    {
      this->Frames.Forget(wire);
      this->FinishMessage(wire, now);
    }
    return;
  }
  ClientEvent event;
  event.request = request;
  event.message = answer.message;
  if (answer.blob)
  {
    if (pending != this->Outstanding.end() && pending->second.outstanding.erase(*answer.blob) != 0)
    {
      event.kind = ClientEvent::Kind::BlobFailed;
      event.blob = *answer.blob;
      this->Events.push_back(std::move(event));
      this->NoteMessage(wire, true, now);
    }
    return;
  }
  this->Frames.Forget(wire);
  this->Unfinished.erase(message);
  if (request == 0)
  {
    this->RefuseModel(answer.message);
  }
  else if (pending != this->Outstanding.end())
  {
    this->Events.push_back(std::move(event));
    this->Cancel(request); // also the request's other messages
  }
  this->Flush(now);
}

void StreamConversation::FinishMessage(std::uint32_t wire, double now)
{
  const auto message = this->Unfinished.find(wire);
  if (message == this->Unfinished.end())
  {
    return;
  }
  const auto pending = this->Outstanding.find(message->second.request);
  this->Unfinished.erase(message);
  const bool ended = pending != this->Outstanding.end() && --pending->second.messages == 0;
  if (ended && !pending->second.IsInBackoff())
  {
    if (!pending->second.outstanding.empty())
    {
      ClientEvent event;
      event.kind = ClientEvent::Kind::RequestEnded;
      event.request = pending->first;
      this->Events.push_back(std::move(event));
    }
    this->Outstanding.erase(pending);
  }
  this->Flush(now);
}

Status StreamConversation::ReceiveFrame(std::span<const std::uint8_t> message, double now)
{
  this->MakeRoomForEvent();
  const auto frame = protocol::ParseFrame(message);
  KDSTREAM_TRY(frame);
  const auto found = this->Unfinished.find(frame->header.request);
  if (found == this->Unfinished.end())
  {
    this->NoteMessage(frame->header.request, false, now);
    return {}; // its request has ended
  }
  auto blob = this->Frames.Accept(*frame);
  KDSTREAM_TRY(blob);
  const auto pending = this->Outstanding.find(found->second.request);
  const bool isOutstanding = pending != this->Outstanding.end() &&
                             pending->second.outstanding.count(frame->header.blob) != 0;
  // A cancelled blob may have been in flight already.
  std::set<BlobId>& cancelled = found->second.cancelled;
  const bool isMeant = isOutstanding || cancelled.count(frame->header.blob) != 0;
  this->NoteMessage(frame->header.request, isMeant, now);
  if (!*blob)
  {
    return {};
  }
  cancelled.erase((*blob)->id); // it may arrive only once
  if (pending != this->Outstanding.end() && pending->second.outstanding.erase((*blob)->id) != 0)
  {
    ClientEvent event;
    event.kind = ClientEvent::Kind::Blob;
    event.request = pending->first;
    event.blob = (*blob)->id;
    event.bytes = std::move((*blob)->bytes);
    event.transmissionSeconds = now - std::max(found->second.sent, this->LastBlob);
    this->Events.push_back(std::move(event));
  }
  this->LastBlob = now;
  this->FollowOldest(now);
  return {};
}

StreamConversation::Oldest StreamConversation::FindOldest() const
{
  const auto isOutstanding = [this](std::uint32_t request)
  {
    const auto pending = this->Outstanding.find(request);
    return pending != this->Outstanding.end() && pending->second.IsOutstanding();
  };
  for (const auto& [wire, message] : this->Unfinished)
  {
    if (isOutstanding(message.request))
    {
      return { message.request, wire };
    }
  }
  for (const Message& message : this->Waiting)
  {
    if (isOutstanding(message.request))
    {
      return { message.request, 0 };
    }
  }
  return {};
}

void StreamConversation::FollowOldest(double now)
{
  const Oldest oldest = this->FindOldest();
  if (oldest != this->Longest)
  {
    this->Longest = oldest;
    this->LastProgress = now;
    this->AskedByThen = 0;
    this->Strays = 0;
    this->OthersArrived = false;
  }
}

void StreamConversation::NoteMessage(std::uint32_t wire, bool isMeant, double now)
{
  const bool isOwn = isMeant && wire == this->Longest.wire;
  if (isOwn)
  {
    this->AskedByThen = 0;
    this->Strays = 0;
  }
  else if (this->AskedByThen == 0)
  {
    this->AskedByThen = this->LastWire;
  }
  const bool isProgress =
    isOwn || (isMeant ? wire <= this->AskedByThen : this->Strays++ < mostStrays);
  this->LastProgress = isProgress ? now : this->LastProgress;
  this->OthersArrived = !isProgress;
}

double StreamConversation::StalledSince() const
{
  return this->Longest.request != 0 && this->OthersArrived
           ? this->LastProgress
           : std::numeric_limits<double>::infinity();
}

void StreamConversation::FailStalled(const std::string& message)
{
  this->MakeRoomForEvent();
  const auto pending = this->Outstanding.find(this->Longest.request);
  if (pending->second.open)
  {
    this->Fail(pending->first, message);
    this->Outstanding.erase(pending);
    return;
  }
  ClientEvent event;
  event.kind = ClientEvent::Kind::BlobFailed;
  event.request = pending->first;
  event.blob = pending->second.OutstandingInOrder().front();
  event.message = message;
  pending->second.outstanding.erase(event.blob);
  this->Events.push_back(std::move(event));
  if (pending->second.outstanding.empty())
  {
    this->Outstanding.erase(pending);
  }
}

void StreamConversation::Restart(double now)
{
  this->Waiting.clear();
  this->Unfinished.clear();
  this->Messages.clear();
  this->Frames = {};
  if (!this->Digest.empty())
  {
    this->Queue(0, protocol::OpenRequest{ this->Model });
  }
  for (auto& [request, pending] : this->Outstanding)
  {
    pending.messages = 0;
    pending.busy.clear();
    if (pending.open)
    {
      this->Queue(request, protocol::OpenRequest{ pending.model });
    }
    else
    {
      this->QueueList(request, pending.OutstandingInOrder());
    }
  }
  this->Flush(now);
  this->Longest = {};
  this->FollowOldest(now);
}

bool StreamConversation::PendingRequest::IsInBackoff() const
{
  return !this->busy.empty() && this->messages == 0 && (this->open || !this->outstanding.empty());
}

void StreamConversation::Adopt(const std::string& model, const std::string& digest)
{
  this->Model = model;
  this->Digest = digest;
}

bool StreamConversation::IsInBackoff() const
{
  return std::any_of(this->Outstanding.begin(), this->Outstanding.end(),
    [](const auto& entry) { return entry.second.IsInBackoff(); });
}

void StreamConversation::AskAgain(std::size_t most, double now)
{
  for (auto next = this->Outstanding.begin(); next != this->Outstanding.end();)
  {
    const auto entry = next++;
    PendingRequest& pending = entry->second;
    if (!pending.IsInBackoff())
    {
      continue;
    }
    const std::string why = std::exchange(pending.busy, {});
    if (pending.tries++ == most)
    {
      this->Fail(entry->first, why);
      this->Outstanding.erase(entry);
    }
    else if (pending.open)
    {
      this->Queue(entry->first, protocol::OpenRequest{ pending.model });
    }
    else
    {
      this->QueueList(entry->first, pending.OutstandingInOrder());
    }
  }
  this->Flush(now);
  this->FollowOldest(now);
}

void StreamConversation::FailAll(const std::string& message)
{
  for (const auto& [request, pending] : this->Outstanding)
  {
    this->Fail(request, message);
  }
  this->Outstanding.clear();
  this->Waiting.clear();
  this->Longest = {};
}

// The server has replaced the open model: pieces of another build must not be mixed with those of
// the open one.
void StreamConversation::RefuseModel(const std::string& message)
{
  this->FailAll(message);
  this->Refusal = message;
  this->Digest.clear();
}

void StreamConversation::Fail(std::uint32_t request, const std::string& message)
{
  ClientEvent event;
  event.request = request;
  event.message = message;
  this->Events.push_back(std::move(event));
}

std::vector<std::string> StreamConversation::TakeMessages()
{
  return std::exchange(this->Messages, {});
}

std::vector<ClientEvent> StreamConversation::TakeEvents()
{
  return std::exchange(this->Events, {});
}

}
