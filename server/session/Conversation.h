// SPDX-License-Identifier: BSD-3-Clause
// One client's conversation: control messages in, control messages and frames out. Step "serve" of
// the pipeline picture. No sockets, no threads.
//
// Answers are pulled one at a time. So nothing is read from a store before the client has taken the
// previous answer, and a cancel takes effect at the next pull. Long work (reading from a disk,
// finding a large region) is a task, which may run elsewhere while the conversation takes messages.
// Requests are answered in the order of their arrival. The messages: doc/protocol.md.
#pragma once

#include "filters/protocol/BinaryFrame.h"
#include "filters/protocol/ControlMessage.h"
#include "server/session/BlobList.h"
#include "server/session/Catalog.h"
#include "server/session/Permission.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace kdstream
{

// Why a conversation ends; the values are the status codes of a WebSocket's Close frame.
enum class CloseReason : std::uint16_t
{
  GoingAway = 1001,
  NotText = 1003,
  NotJson = 1007,
  NotPermitted = 1008, // its token has expired or was revoked
  TooLarge = 1009
};

// The work that a conversation's next message waits for: to find a model, a region or a blob. A
// task holds everything that it needs except the catalog, so it may outlive its conversation.
class Task
{
public:
  Task(const Catalog& catalog, std::size_t mostPartitions, Permission permission = {})
    : Models(catalog)
    , MostPartitions(mostPartitions)
    , May(std::move(permission))
  {
  }

  // Whether the task counts against a quota.
  bool Takes() const;
  // The address of the model that the task reads, and the name of what it reads if other tasks may
  // read the same; else null and "". Call these before the task runs.
  const void* Source() const;
  std::string Part() const;
  // Does the work, once, on any thread. An error is kept for the conversation.
  void Run() noexcept;

private:
  friend class Conversation;
  void Do();
  void ReadBlob();
  void FindList();

  const Catalog& Models;
  std::size_t MostPartitions;
  Permission May;
  std::shared_ptr<const ServedModel> Model;       // null: to be found and opened first
  std::optional<protocol::ClientMessage> Request; // what to open or to list
  protocol::BlobId Blob;                          // what to read otherwise
  BlobList List;
  BlobBytes Bytes;
  std::optional<Error> Failure;
  std::optional<Refusal> Refused; // by a quota
  bool Taken = false;
};

// What one client may ask for at once.
struct ConversationLimits
{
  std::size_t partitions = 65536; // in a region
  std::size_t requests = 16;      // unfinished requests
  protocol::MessageLimits message;
};

class Conversation
{
public:
  // A control message (text), or a frame (binary).
  using Message = std::variant<std::string, std::vector<std::uint8_t>>;

  static constexpr std::size_t maximumPendingAnswers =
    64; // answers to messages that are not accepted requests

  // Refuses requests beyond the limits (400, 413, 429), and those that `permission` does not allow
  // (403). REQUIRES: the catalog outlives the conversation.
  explicit Conversation(
    const Catalog& catalog, const ConversationLimits& limits = {}, Permission permission = {});
  ~Conversation();

  // Takes a text message of any content and length. wait: not 0 if the client has asked too often:
  // requests, except cancels, are refused (429), and the client may ask again after this time.
  void Receive(std::string_view text, std::chrono::seconds wait = std::chrono::seconds(0));
  // Takes a binary message, which a client must not send.
  void ReceiveBinary();
  // The server is stopping: the current request is finished, waiting and later requests are refused
  // (503), and then the conversation closes.
  void Drain();

  // Whether the client's token is still valid. If not, the next message says so (401), and the
  // conversation closes; nothing else is sent.
  bool IsPermitted() const { return !this->May.RefuseAll(); }

  // Whether the next message may be received now. False after the end, and while too many answers
  // wait for a client that does not read.
  bool AcceptsMessages() const;

  // The next message to send. Nothing if more must be received first, or a task must be done first.
  // Never waits.
  std::optional<Message> NextMessage();
  // The task that the next message waits for. Null if there is none, or if it was taken before.
  std::shared_ptr<Task> TakeTask();
  // Takes back a task that has run. Has no effect if its request has been cancelled meanwhile.
  void Finish(const std::shared_ptr<Task>& task);
  // Continues without the task's result, as if its disk could not be read. The task may still be
  // running.
  void GiveUp(const std::shared_ptr<Task>& task);

  // About the message that was pulled last: whether it ends the first or the last blob of its
  // request, and when that request was received.
  struct Milestone
  {
    bool first = false, last = false;
    std::chrono::steady_clock::time_point received;
  };
  const Milestone& Reached() const { return this->Latest; }

  // Counts about this conversation's requests so far.
  struct Tally
  {
    std::uint64_t failedBlobs = 0; // blobs that could not be read
    // Requests refused because of the token, or ended when it expired.
    std::uint64_t forbidden = 0;
    std::uint64_t tooMany = 0; // requests beyond ConversationLimits::requests
  };
  const Tally& Counted() const { return this->Counts; }

  // Whether the client has nothing to wait for.
  bool IsIdle() const { return !this->Current && this->Waiting.empty() && this->Answers.empty(); }

  // Set when the conversation has to end: send what NextMessage still returns, then close.
  std::optional<CloseReason> Closing() const { return this->Close; }

private:
  // A request that has to wait for earlier requests.
  struct Received
  {
    protocol::ClientMessage message;
    std::chrono::steady_clock::time_point at;
  };
  // A request that is being answered.
  struct Job;

  void Answer(protocol::ServerMessage message);
  void AnswerError(std::uint32_t request, unsigned code, std::string message);
  bool IsUnfinished(std::uint32_t request) const;
  void Cancel(std::uint32_t request);
  void EndUnlessPermitted();
  Permission::Refused RefusalOf(const protocol::ClientMessage& message) const;
  void Start(Received received);
  void FinishOpening(Task& task);
  void FinishList(Task& task);
  void FinishBlob(Task& task);
  void Refuse(const Error& error);
  std::optional<Message> Continue();
  bool HasBlob();
  std::vector<std::uint8_t> NextFrame();

  const Catalog& Models;
  ConversationLimits Limits;
  Permission May;
  std::shared_ptr<const ServedModel> Model; // the open model
  std::deque<Received> Waiting;
  std::unique_ptr<Job> Current;
  std::shared_ptr<Task> Pending;               // for the current request
  std::deque<protocol::ServerMessage> Answers; // sent before anything else
  Milestone Latest;
  Tally Counts;
  bool Draining = false;
  std::optional<CloseReason> Close;
};

}
