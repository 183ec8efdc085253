// SPDX-License-Identifier: BSD-3-Clause
// At most one message is being written; the next one is made only when it has been sent. So a
// client that does not read costs only the memory of one frame, and a cancel takes effect at the
// next frame. The pool of readers reads blobs for the conversation, one at a time.
//
// A stream goes through these phases. No client can postpone the end of a phase:
//
//   Opening   the answer to the upgrade is being written     until sending takes too long
//   Open      messages go both ways                          until the client is silent for
//                                                            --stream-timeout, or does not take a
//                                                            message in --answer-timeout
//   Closing   a Close frame is sent or waits to be sent,     \ closePatience after our Close frame,
//             and the client's is awaited; messages are       | whatever the client does: from then
//             skipped                                         | on Deadline() does not change
//   Ending    nothing more is sent; incoming bytes are       /
//             dropped, so that the last answer arrives
//
// Then the socket is closed. This ends the read and the write in flight, and only these keep the
// stream alive. Neither waits for the other, and a reader (of disks) that works for the stream does
// not keep it alive.
#include "server/http/HttpConnection.h"

#include "filters/protocol/ResourcePath.h"
#include "server/http/RoundTrip.h"
#include "server/http/WebSocketFrames.h"
#include "server/session/Conversation.h"

#include <boost/asio/basic_waitable_timer.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/write.hpp>

#include <algorithm>
#include <chrono>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace kdstream
{

namespace
{

class StreamConnection
  : public Drainable
  , public std::enable_shared_from_this<StreamConnection>
{
public:
  StreamConnection(ClientSocket socket, ServerState& state, ConnectionSlot slot,
    Permission permission, AccessRecord record)
    : Socket(std::move(socket))
    , State(state)
    , Slot(std::move(slot))
    , Record(std::move(record))
    , Stream(state.Models, state.Options.stream, std::move(permission))
    // More than a conversation accepts, so that the conversation can refuse the message with an
    // answer; but not unlimited.
    , Frames(16 * state.Options.stream.message.bytes)
    , Arrived(bytesAtOnce)
    , Alarm(this->Socket.get_executor())
  {
    this->State.Counters.StreamOpened();
  }

  ~StreamConnection() override
  {
    this->State.Leave(this);
    this->State.Counters.StreamClosed();
    const std::chrono::duration<double> time = Clock::now() - this->Opened;
    this->Record.seconds = time.count();
    this->State.Log(this->Record);
  }

  void Run(const std::string& key)
  {
    this->State.Enter(this->shared_from_this());
    this->Socket.ExpireNever();
    this->LimitUnsentBytes();
    this->Head = "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                 "Sec-WebSocket-Accept: " +
                 WebSocketAccept(key) +
                 "\r\nSec-WebSocket-Protocol: " + std::string(protocol::streamSubprotocol) +
                 "\r\n\r\n";
    this->Send(this->Head, {}, &StreamConnection::OnOpened);
  }

  void Drain() override
  {
    asio::post(this->Socket.get_executor(),
      [self = this->shared_from_this()]
      {
        self->Guard(
          [&]
          {
            self->Stream.Drain();
            self->Write();
          });
      });
  }

  void GiveUp() override
  {
    asio::post(this->Socket.get_executor(),
      [self = this->shared_from_this()]
      {
        if (self->Stream.IsIdle())
        {
          self->Guard(
            [&]
            {
              self->Stream.Drain();
              self->Write();
            });
        }
      });
  }

  void EndIfOverdue() override
  {
    asio::post(this->Socket.get_executor(),
      [self = this->shared_from_this()] { self->Guard([&] { self->OnAlarm(); }); });
  }

private:
  static constexpr std::size_t bytesAtOnce = 4096; // for each read
  static constexpr std::chrono::milliseconds closePatience{ 2000 };

  using Timer = asio::basic_waitable_timer<Clock, asio::wait_traits<Clock>, EventLoop>;

  enum class Phase
  {
    Opening,
    Open,
    Closing,
    Ending
  };

  // Runs the work of a handler. An exception ends this stream.
  template <class Work>
  void Guard(const Work& work) noexcept
  {
    this->State.Guard(work, [this] { this->Socket.Close(); });
  }

  // Limits the bytes that the kernel buffers. Otherwise it would buffer megabytes for a slow
  // client, and a cancel would have to wait until they are sent.
  void LimitUnsentBytes()
  {
#ifdef TCP_NOTSENT_LOWAT
    const int bytes = 2 * static_cast<int>(protocol::maximumFrameBytes);
    ::setsockopt(
      this->Socket.Tcp().native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &bytes, sizeof bytes);
#endif
  }

  void OnOpened()
  {
    this->Head = {};
    this->Now = Phase::Open;
    this->GoOn();
  }

  // Reads and writes as much as is possible now.
  void GoOn()
  {
    this->Write();
    this->Read();
  }

  // ---- messages from the client

  bool Listens() const
  {
    switch (this->Now)
    {
      case Phase::Opening:
        return false;
      case Phase::Open:
        return this->Stream.AcceptsMessages();
      default:
        return true;
    }
  }

  void Read()
  {
    while (!this->Reading && this->Listens())
    {
      if (this->Unread.empty())
      {
        this->ReadMore();
        return;
      }
      this->TakeNext();
    }
  }

  void ReadMore()
  {
    this->Hear();
    this->Reading = true;
    this->Socket.async_read_some(asio::buffer(this->Arrived),
      [self = this->shared_from_this()](beast::error_code error, std::size_t bytes)
      {
        self->Reading = false;
        // The client has left without a Close frame, or continues to send after the end: do not
        // wait for it.
        if (error || Clock::now() >= self->Deadline())
        {
          self->Socket.Close();
          return;
        }
        self->Unread = { self->Arrived.data(), bytes };
        self->Guard(
          [&]
          {
            self->Hear();
            self->Read();
          });
      });
  }

  // Notes that the client is still there.
  void Hear()
  {
    this->HeardAt = Clock::now();
    this->Pinged = false;
  }

  void TakeNext()
  {
    if (this->Now == Phase::Ending)
    {
      this->Unread = {};
      return;
    }
    using Event = WebSocketReader::Event;
    switch (this->Frames.Take(this->Unread))
    {
      case Event::None:
      case Event::Pong:
        break;
      case Event::Text:
        this->TakeText();
        break;
      case Event::Binary:
        this->Stream.ReceiveBinary();
        this->Write();
        break;
      case Event::Ping: // only the latest is answered, as allowed (section 5.5.3)
        if (this->Now == Phase::Open)
        {
          this->Pong = std::string(this->Frames.Control());
          this->Write();
        }
        break;
      case Event::Close: // answered with the client's status
        this->IsOver = true;
        this->Close(this->Frames.Status() == 0 ? normalClosure : this->Frames.Status());
        break;
      case Event::Error:
        this->IsOver = true;
        this->Close(this->Frames.Status());
        break;
    }
  }

  void TakeText()
  {
    const auto wait = this->State.Clients.TakeRequest(this->Record.client);
    if (wait.count() > 0)
    {
      this->State.Counters.CountRefusal(Metrics::Reason::Requests);
    }
    this->Stream.Receive(this->Frames.Message(), wait);
    this->SetBusy();
    this->Write();
  }

  // ---- messages to the client

  // Sends head and body, then continues with `then`.
  void Send(std::string_view head, asio::const_buffer body, void (StreamConnection::*then)())
  {
    this->Writing = true;
    this->TakenBy = Clock::now() + this->State.PatienceFor(head.size() + body.size());
    this->Watch();
    asio::async_write(
      this->Socket, std::array{ asio::const_buffer(head.data(), head.size()), body },
      [](beast::error_code error, std::size_t) // decides how much to write at once
      { return error ? 0 : std::numeric_limits<std::size_t>::max(); },
      [self = this->shared_from_this(), then](beast::error_code error, std::size_t sent)
      {
        self->Writing = false;
        self->CountSent(sent);
        if (error)
        {
          self->Socket.Close();
          return;
        }
        self->Guard([&] { (self.get()->*then)(); });
      });
  }

  void SendFrame(WebSocketOpcode opcode, std::string_view payload, void (StreamConnection::*then)())
  {
    this->FrameHead = WebSocketHead(opcode, payload.size());
    this->Send(this->FrameHead.Bytes(), asio::const_buffer(payload.data(), payload.size()), then);
  }

  // Writes the next frame that waits to be sent, if none is being written.
  void Write()
  {
    if (this->Writing || this->Now == Phase::Opening || this->Now == Phase::Ending)
    {
      return;
    }
    if (this->Now == Phase::Closing)
    {
      this->WriteClose();
    }
    else if (!this->WriteControl())
    {
      this->WriteMessage();
    }
  }

  // Sends a pong or a ping, but not two in a row, so that a client that sends many pings does not
  // delay its answers.
  bool WriteControl()
  {
    const bool may = !std::exchange(this->WasControl, false);
    if (may && this->Pong)
    {
      this->Controlled = std::move(*std::exchange(this->Pong, std::nullopt));
      this->WasControl = true;
      this->SendFrame(WebSocketOpcode::Pong, this->Controlled, &StreamConnection::GoOn);
    }
    else if (may && this->PingIsDue)
    {
      this->PingIsDue = false;
      this->WasControl = true;
      this->SendFrame(WebSocketOpcode::Ping, {}, &StreamConnection::GoOn);
    }
    return this->Writing;
  }

  void WriteMessage()
  {
    auto message = this->Stream.NextMessage();
    this->CountWhatWasRefused();
    if (!message)
    {
      this->RunTask();
      if (const auto reason = this->Stream.Closing())
      {
        this->Close(static_cast<std::uint16_t>(*reason));
      }
      else if (this->Pong || this->PingIsDue)
      {
        this->WriteControl();
      }
      else if (this->Stream.IsIdle() && this->IsBusy()) // pings do not end idleness
      {
        this->SetIdle(this->State.Options.idleTimeout);
      }
      return;
    }
    this->Output = std::move(*message);
    this->Sending = this->Stream.Reached();
    this->SetBusy();
    this->SendsMessage = true;
    const bool isText = std::holds_alternative<std::string>(this->Output);
    this->SendFrame(isText ? WebSocketOpcode::Text : WebSocketOpcode::Binary, this->Payload(),
      &StreamConnection::OnMessageSent);
  }

  std::string_view Payload() const
  {
    return std::visit([](const auto& message)
      { return std::string_view(reinterpret_cast<const char*>(message.data()), message.size()); },
      this->Output);
  }

  // bytes: including the frame's head.
  void CountSent(std::size_t bytes)
  {
    if (std::exchange(this->SendsMessage, false))
    {
      const auto sent = bytes - std::min(bytes, this->FrameHead.Bytes().size());
      this->Record.bytes += sent;
      this->State.Counters.CountBytes(sent);
    }
  }

  void OnMessageSent()
  {
    this->CountBlob();
    this->GoOn();
  }

  void CountWhatWasRefused()
  {
    const auto& now = this->Stream.Counted();
    auto& counters = this->State.Counters;
    for (; this->Counted.failedBlobs < now.failedBlobs; ++this->Counted.failedBlobs)
    {
      counters.CountFailedBlob();
    }
    for (; this->Counted.forbidden < now.forbidden; ++this->Counted.forbidden)
    {
      counters.CountRefusal(Metrics::Reason::Token);
    }
    for (; this->Counted.tooMany < now.tooMany; ++this->Counted.tooMany)
    {
      counters.CountRefusal(Metrics::Reason::Requests);
    }
  }

  // Measures the time, if the blob that was sent is the first or the last one of its request.
  void CountBlob()
  {
    const auto time = Clock::now() - this->Sending.received;
    if (this->Sending.first)
    {
      this->State.Counters.CountFirstBlob(time);
    }
    if (this->Sending.last)
    {
      this->State.Counters.CountLastBlob(time);
    }
  }

  // Passes the conversation's task to the readers. They do not keep the stream alive: its slot
  // becomes free when its client has left, even if a disk hangs.
  void RunTask()
  {
    const auto task = this->Stream.TakeTask();
    if (!task)
    {
      return;
    }
    MakeRoundTrip(
      this->Socket.get_executor(),
      [&](WorkerPool::Work work, WorkerPool::Work giveUp)
      {
        this->State.Read(
          task->Takes(), { std::move(work), std::move(giveUp), task->Source(), task->Part() });
      },
      [task] { task->Run(); },
      [weak = this->weak_from_this(), task](bool isDone)
      {
        if (const auto self = weak.lock())
        {
          self->Guard(
            [&]
            {
              if (isDone)
              {
                self->Stream.Finish(task);
              }
              else
              {
                self->State.CountGivenUp();
                self->Stream.GiveUp(task);
              }
              self->GoOn();
            });
        }
      });
  }

  // ---- the end of the stream

  // Begins the closing handshake: a Close frame after the current message, and no message after it.
  // IsOver: the client's Close frame has arrived, or its input is malformed.
  void Close(std::uint16_t status)
  {
    if (this->Now == Phase::Closing) // our Close frame is in flight, or will be sent
    {
      this->Write();
      return;
    }
    this->Now = Phase::Closing;
    this->SetBusy(); // its slot will soon be free anyway
    this->Frames.SkipMessages();
    this->Status = WriteCloseStatus(status);
    this->Write();
  }

  void WriteClose()
  {
    if (!this->ClosedBy)
    {
      // All frames have been passed to the kernel. A client that does not answer has left, or
      // sleeps. Nothing waits for it, least of all the end of the server.
      this->ClosedBy = Clock::now() + std::min(closePatience, this->State.PatienceFor(0));
      this->SendFrame(WebSocketOpcode::Close, this->Status, &StreamConnection::GoOn);
    }
    else if (this->IsOver)
    {
      this->EndOutput();
    }
  }

  // For a moment reads the bytes that the client still sends: if the socket were closed with unread
  // bytes, the kernel would discard the Close frame that is in flight.
  void EndOutput()
  {
    this->Now = Phase::Ending;
    this->Socket.EndOutput(
      [self = this->shared_from_this()](beast::error_code error)
      {
        if (error)
        {
          self->Socket.Close();
        }
      });
    this->Read();
  }

  // ---- deadlines

  // The time at which the stream ends, unless something happens before.
  Clock::time_point Deadline() const
  {
    if (this->ClosedBy)
    {
      return *this->ClosedBy;
    }
    const auto idleAt = this->HeardAt + this->State.Options.streamTimeout;
    return this->Writing ? std::min(idleAt, this->TakenBy) : idleAt;
  }

  Clock::time_point PingAt() const
  {
    return this->HeardAt + this->State.Options.streamTimeout / 2;
  }

  // The conversation checks its token before each message. If the client waits for no message, the
  // token is checked at this interval.
  static constexpr std::chrono::milliseconds tokenInterval{ 250 };

  // Sets the timer. There is one timer for all deadlines: when it expires, it checks them again; it
  // is set again only if it would expire too late.
  void Watch()
  {
    auto next = this->Deadline();
    this->EndBy(next);
    if (this->Now == Phase::Open || this->Now == Phase::Opening)
    {
      next = this->Pinged ? next : std::min(next, this->PingAt());
      next = this->State.Options.guard ? std::min(next, Clock::now() + tokenInterval) : next;
    }
    if (this->Watching && this->Alarm.expiry() <= next)
    {
      return;
    }
    this->Watching = false;
    this->Alarm.expires_at(next);
    this->Alarm.async_wait(
      [weak = this->weak_from_this()](beast::error_code error)
      {
        const auto self = weak.lock();
        if (self && !error)
        {
          self->Watching = false;
          self->Guard([&] { self->OnAlarm(); });
        }
      });
    this->Watching = true;
  }

  void OnAlarm()
  {
    const auto now = Clock::now();
    if (now >= this->Deadline())
    {
      if (this->Writing && !this->ClosedBy && now >= this->TakenBy)
      {
        this->State.Counters.CountRefusal(Metrics::Reason::Slow);
      }
      this->Socket.Close();
      return;
    }
    if (this->Now == Phase::Open)
    {
      if (!this->Pinged && now >= this->PingAt())
      {
        this->Pinged = this->PingIsDue = true;
        this->Write();
      }
      if (this->State.Options.guard && !this->Stream.IsPermitted())
      {
        this->Write();
      }
    }
    this->Watch();
  }

  static constexpr std::uint16_t normalClosure = 1000;

  ClientSocket Socket;
  ServerState& State;
  ConnectionSlot Slot;
  AccessRecord Record;
  Conversation Stream;
  Conversation::Tally Counted; // counts that the metrics already have
  Clock::time_point Opened = Clock::now();
  Phase Now = Phase::Opening;
  // Input.
  WebSocketReader Frames;
  std::vector<char> Arrived;
  std::string_view Unread; // received, but not parsed yet
  bool Reading = false;
  Clock::time_point HeardAt = Clock::now();
  // Output.
  std::string Head; // of the answer to the upgrade
  WebSocketHead FrameHead;
  Conversation::Message Output;    // being sent
  Conversation::Milestone Sending; // of the request that Output answers
  std::optional<std::string> Pong; // waits to be sent
  std::string Controlled;          // the payload of the control frame that is being sent
  std::string Status;              // of our Close frame
  bool Writing = false;
  bool SendsMessage = false;
  bool WasControl = false;
  bool PingIsDue = false;
  bool Pinged = false; // we have sent a ping since we last heard from the client
  bool IsOver = false; // from now on nothing that the client sends matters
  // TakenBy: the time by which the current message must be sent. ClosedBy: the time by which
  // everything must have ended after our Close frame.
  Clock::time_point TakenBy;
  std::optional<Clock::time_point> ClosedBy;
  Timer Alarm;
  bool Watching = false;
};

}

void ServeStream(ClientSocket socket, ServerState& state, ConnectionSlot slot,
  Permission permission, AccessRecord record, const std::string& key)
{
  std::make_shared<StreamConnection>(
    std::move(socket), state, std::move(slot), std::move(permission), std::move(record))
    ->Run(key);
}

}
