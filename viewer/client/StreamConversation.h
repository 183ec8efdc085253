// SPDX-License-Identifier: BSD-3-Clause
// Translates a session's requests to messages of the stream, and the server's answers to events. No
// sockets, no clock.
#pragma once

#include "filters/core/Result.h"
#include "filters/protocol/BinaryFrame.h"
#include "filters/protocol/ControlMessage.h"
#include "viewer/client/ClientEvent.h"

#include <deque>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

// One session's side of a WebSocket conversation, over as many connections as it takes.
//
// A session's request becomes one message, or several if its list is too long for one. At most
// `mostUnfinished` messages are unanswered at a time; the others wait. The conversation always
// knows what has not arrived yet, so a new connection can continue where the old one ended. Times
// are seconds of any steady clock.
class StreamConversation
{
public:
  static constexpr std::size_t mostUnfinished = 12; // servers refuse more than 16

  void Send(const SessionRequest& request, double now);

  // Takes what has arrived. Errors: InvalidInput if the server violates the protocol; then give up
  // the connection.
  Status ReceiveText(std::string_view text, double now);
  Status ReceiveFrame(std::span<const std::uint8_t> message, double now);

  // For a new connection: opens the model again, and requests everything that is still outstanding.
  void Restart(double now);
  // At the next Restart, continues with a model that was opened in another way (by GET). REQUIRES:
  // nothing was sent.
  void Adopt(const std::string& model, const std::string& digest);

  // Whether something must be requested again later because the server was busy (IsBusy).
  bool IsInBackoff() const;
  // Requests it again. What has been repeated `most` times already fails instead.
  void AskAgain(std::size_t most, double now);

  // The time since when the oldest outstanding request has been stalled: other answers arrive, and
  // this request makes no progress. Infinity if it is not stalled. Progress is:
  // - a byte of this request;
  // - a byte of another request, even a cancelled one, that was made before the first other answer
  //   arrived, because a server may answer these first;
  // - up to mostStrays messages that bring bytes of neither, such as those that announce blobs.
  //
  // So even on the slowest connection there is progress, but not if the server always sends
  // something else.
  double StalledSince() const;
  static constexpr std::size_t mostStrays = 64;
  // Fails the oldest outstanding request (its next blob). REQUIRES: StalledSince() is finite.
  void FailStalled(const std::string& message);

  // Fails everything that is outstanding. The next Send starts a new conversation.
  void FailAll(const std::string& message);

  // Messages to send, in order, since the last call.
  std::vector<std::string> TakeMessages();
  std::vector<ClientEvent> TakeEvents();
  bool HasEvents() const { return !this->Events.empty(); }
  // Whether anything is outstanding.
  bool IsWaiting() const { return !this->Outstanding.empty(); }

private:
  struct PendingRequest // a request to the server, for one request of the session
  {
    bool open = false;
    std::string model;                      // for an Open
    std::vector<protocol::BlobId> wanted;   // all wanted blobs, in the order of the request
    std::set<protocol::BlobId> outstanding; // the blobs that have not arrived

    std::vector<protocol::BlobId> OutstandingInOrder() const;
    bool IsOutstanding() const
    {
      return this->busy.empty() && (this->open || !this->outstanding.empty());
    }
    bool IsInBackoff() const; // all of it must be requested again later
    std::size_t messages = 0; // that have not ended yet
    std::string busy;         // the answer of a busy server; empty: it was not busy
    std::size_t tries = 0;    // number of retries
  };
  struct Message
  {
    std::uint32_t request = 0; // the session's; 0: our own, to open the model again
    protocol::ClientMessage content;
    double sent = 0;
    std::set<protocol::BlobId> cancelled; // cancelled blobs that may still arrive, once
  };

  void MakeRoomForEvent();
  void Queue(std::uint32_t request, decltype(protocol::ClientMessage::body) body);
  void QueueList(std::uint32_t request, const std::vector<protocol::BlobId>& blobs);
  void Cancel(std::uint32_t request);
  void Flush(double now);
  void FinishMessage(std::uint32_t wire, double now);
  void Opened(std::uint32_t request, const ModelDescription& model);
  void RefuseModel(const std::string& message);
  void Fail(std::uint32_t request, const std::string& message);
  void Failed(std::uint32_t wire, const protocol::ErrorAnswer& answer, double now);

  // The oldest outstanding request.
  struct Oldest
  {
    std::uint32_t request = 0; // 0: nothing is outstanding
    std::uint32_t wire = 0;    // id of its message; 0: not sent yet
    bool operator==(const Oldest&) const = default;
  };
  Oldest FindOldest() const;
  void FollowOldest(double now);
  // isMeant: the message brings something that is outstanding, or that was outstanding when it was
  // cancelled.
  void NoteMessage(std::uint32_t wire, bool isMeant, double now);

  std::map<std::uint32_t, PendingRequest> Outstanding; // by the session's request
  std::deque<Message> Waiting;
  std::map<std::uint32_t, Message> Unfinished; // by the message's own number
  std::uint32_t LastWire = 0;
  protocol::FrameAssembler Frames;
  double LastBlob = 0;
  Oldest Longest;          // the oldest request
  double LastProgress = 0; // the time of its last progress
  // The last message that had been sent when, after the last progress, the first other answer
  // arrived; 0: none has arrived.
  std::uint32_t AskedByThen = 0;
  std::size_t Strays = 0;     // messages since then that bring nothing that was requested
  bool OthersArrived = false; // since its last progress
  std::string Model, Digest;  // of the model that is open, or was when the connection was lost
  std::string Refusal;        // why the server sends nothing more; empty: it still sends
  std::vector<std::string> Messages;
  std::vector<ClientEvent> Events;
};

}
