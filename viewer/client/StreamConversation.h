// SPDX-License-Identifier: BSD-3-Clause
// Translates a session's requests into messages of the stream, and the server's answers into
// events. No sockets, no clock.
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
// `mostUnfinished` messages are unanswered at a time, the others wait. The conversation always
// knows what has not arrived yet, so a new connection can continue where the old one ended. Times
// are seconds of any steady clock.
class StreamConversation
{
public:
  static constexpr std::size_t mostUnfinished = 12; // servers refuse more than 16

  void Send(const SessionRequest& request, double now);

  // What came. Errors: InvalidInput if the server violates the protocol: give up the connection.
  Status ReceiveText(std::string_view text, double now);
  Status ReceiveFrame(std::span<const std::uint8_t> message, double now);

  // A new connection: opens the model again and asks for everything that is still outstanding.
  void Restart(double now);
  // Continues, at the next Restart, with a model that was opened in another way. REQUIRES: nothing
  // was sent.
  void Adopt(const std::string& model, const std::string& digest);

  // Whether something is to be asked for again later: the server was busy (IsBusy).
  bool IsInBackoff() const;
  // Asks for it, if it was not asked for `most` times already; else it has failed.
  void AskAgain(std::size_t most, double now);

  // Since when the longest outstanding request is stalled: since other answers have arrived without
  // progress of this one. Infinite if it is not stalled. Progress is:
  // - a byte of this request;
  // - a byte of a request that was made before the first other answer arrived, also of a cancelled
  //   one, because a server may send these first;
  // - up to mostStrays messages in between without bytes of either, such as those that announce
  //   blobs.
  //
  // So even the slowest connection makes progress, but a server that always sends something else
  // does not.
  double StalledSince() const;
  static constexpr std::size_t mostStrays = 64;
  // Fails the longest outstanding request (its next blob). REQUIRES: StalledSince() is finite.
  void FailStalled(const std::string& message);

  // Everything that is outstanding has failed; the next Send starts a new conversation.
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
    std::string model;                      // of an open
    std::vector<protocol::BlobId> wanted;   // all wanted blobs, in the order of the request
    std::set<protocol::BlobId> outstanding; // the blobs that have not arrived

    std::vector<protocol::BlobId> OutstandingInOrder() const;
    bool IsOutstanding() const
    {
      return this->busy.empty() && (this->open || !this->outstanding.empty());
    }
    bool IsInBackoff() const; // all that is outstanding is to be asked for again
    std::size_t messages = 0; // not yet ended
    std::string busy;         // what a busy server answered; empty: it was not busy
    std::size_t tries = 0;    // number of retries
  };
  struct Message
  {
    std::uint32_t request = 0; // the session's; 0 = ours, to open the model again
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

  // The request that has been stalled longest.
  struct Oldest
  {
    std::uint32_t request = 0; // 0: nothing
    std::uint32_t wire = 0;    // id of its message; 0: not sent yet
    bool operator==(const Oldest&) const = default;
  };
  Oldest FindOldest() const;
  void FollowOldest(double now);
  // isMeant: it brings what is outstanding, or was and has been cancelled.
  void NoteMessage(std::uint32_t wire, bool isMeant, double now);

  std::map<std::uint32_t, PendingRequest> Outstanding; // by the session's request
  std::deque<Message> Waiting;
  std::map<std::uint32_t, Message> Unfinished; // by the message's own number
  std::uint32_t LastWire = 0;
  protocol::FrameAssembler Frames;
  double LastBlob = 0;
  Oldest Longest;          // outstanding,
  double LastProgress = 0; // time of the last progress;
  // Messages that had been sent when the first other answer arrived since then; 0: none has
  // arrived.
  std::uint32_t AskedByThen = 0;
  std::size_t Strays = 0;     // messages that bring nothing of what was asked for, since then
  bool OthersArrived = false; // since the last progress
  std::string Model, Digest;  // that is open, or was when the connection was lost
  std::string Refusal;        // why the server sends nothing more; empty: it still sends
  std::vector<std::string> Messages;
  std::vector<ClientEvent> Events;
};

}
