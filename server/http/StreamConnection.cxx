// SPDX-License-Identifier: BSD-3-Clause
// At most one message is being written, and the next one is made only when it has been sent. So a
// client that does not read costs the memory of one frame, and a cancel takes effect at the next
// frame. What the conversation has to read is read by the pool of readers, one blob at a time.
#include "server/http/StreamConnection.h"

#include "server/http/RoundTrip.h"
#include "server/protocol/ResourcePath.h"
#include "server/session/Conversation.h"

#include <boost/asio/basic_waitable_timer.hpp>
#include <boost/asio/post.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket/stream.hpp>

#include <chrono>
#include <string>
#include <utility>
#include <variant>

namespace kdstream
{

namespace
{

class StreamConnection
  : public Drainable
  , public std::enable_shared_from_this<StreamConnection>
{
public:
  StreamConnection(
    ClientSocket socket, ServerState& state, Seat seat, Permission permission, AccessRecord record)
    : Socket(std::move(socket))
    , State(state)
    , Place(std::move(seat))
    , Record(std::move(record))
    , Talk(state.Models, state.Options.stream, std::move(permission))
    , Patience(this->Socket.get_executor())
    , Looks(this->Socket.get_executor())
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

  void Run(const beast::http::request<beast::http::empty_body>& request)
  {
    namespace websocket = beast::websocket;
    this->State.Enter(this->shared_from_this());
    this->Socket.next_layer().ExpireNever();
    this->Socket.set_option(websocket::stream_base::timeout{
      this->State.Options.requestTimeout, this->State.Options.streamTimeout, true });
    this->Socket.set_option(websocket::stream_base::decorator(
      [](websocket::response_type& response)
      {
        response.set(
          beast::http::field::sec_websocket_protocol, std::string(protocol::streamSubprotocol));
      }));
    // More than a conversation accepts, so that the conversation can refuse it in words; but not
    // unlimited.
    this->Socket.read_message_max(16 * this->State.Options.stream.message.bytes);
    this->Socket.auto_fragment(false);
    this->LimitUnsentBytes();
    this->Socket.async_accept(request,
      [self = this->shared_from_this()](beast::error_code error)
      {
        if (!error)
        {
          self->Accepted = true;
          self->GoOn();
          self->WatchToken();
        }
      });
  }

  void Drain() override
  {
    asio::post(this->Socket.get_executor(),
      [self = this->shared_from_this()]
      {
        self->Guard(
          [&]
          {
            self->Talk.Drain();
            if (self->Accepted)
            {
              self->Write();
            }
          });
      });
  }

  void GiveUp() override
  {
    asio::post(this->Socket.get_executor(),
      [self = this->shared_from_this()]
      {
        if (self->Talk.IsIdle())
        {
          self->Guard(
            [&]
            {
              self->Talk.Drain();
              self->Write();
            });
        }
      });
  }

private:
  static constexpr std::chrono::milliseconds closePatience{ 2000 };

  using Timer = asio::basic_waitable_timer<Clock, asio::wait_traits<Clock>, EventLoop>;

  // What each handler does.
  template <class Work>
  void Guard(const Work& work) noexcept
  {
    this->State.Guard(work, [this] { this->Socket.next_layer().Close(); });
  }

  // Reads and writes what can be read and written now.
  void GoOn() noexcept
  {
    this->Guard(
      [this]
      {
        this->Write();
        this->Read();
      });
  }

  // Without this the kernel would buffer megabytes for a slow client, and a cancel would have to
  // wait until they are sent.
  void LimitUnsentBytes()
  {
#ifdef TCP_NOTSENT_LOWAT
    const int bytes = 2 * static_cast<int>(protocol::maximumFrameBytes);
    auto& socket = this->Socket.next_layer().Tcp();
    ::setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &bytes, sizeof bytes);
#endif
  }

  void Read()
  {
    // After the conversation has ended we read on only to find the client's close frame.
    if (this->Reading || this->Unreadable ||
        !(this->Talk.AcceptsMessages() || this->Talk.Closing()))
    {
      return;
    }
    this->Reading = true;
    this->Socket.async_read(this->Input,
      [self = this->shared_from_this()](beast::error_code error, std::size_t)
      {
        self->Reading = false;
        self->Unreadable = error.failed();
        if (!error)
        {
          self->Guard([&] { self->Take(); });
          self->GoOn();
        }
      });
  }

  void Take()
  {
    if (this->Socket.got_text())
    {
      const auto data = this->Input.cdata();
      const auto wait = this->State.Clients.TakeRequest(this->Record.client);
      if (wait.count() > 0)
      {
        this->State.Counters.CountRefusal(Metrics::Reason::Requests);
      }
      this->Talk.Receive({ static_cast<const char*>(data.data()), data.size() }, wait);
      this->SetBusy();
    }
    else
    {
      this->Talk.ReceiveBinary();
    }
    this->Input.consume(this->Input.size());
  }

  void Write()
  {
    if (this->Writing)
    {
      return;
    }
    auto message = this->Talk.NextReadyMessage();
    this->CountWhatWasRefused();
    if (!message)
    {
      this->RunErrand();
      this->CloseIfEnded();
      if (this->Talk.IsIdle() && !this->Talk.Closing())
      {
        this->SetIdle(this->State.Options.idleTimeout);
      }
      return;
    }
    this->Output = std::move(*message);
    this->Sending = this->Talk.Reached();
    this->Writing = true;
    this->SetBusy();
    this->Socket.text(std::holds_alternative<std::string>(this->Output));
    const auto bytes = std::visit([](const auto& m) { return asio::buffer(m); }, this->Output);
    this->WatchWrite(bytes.size());
    this->Socket.async_write(bytes,
      [self = this->shared_from_this()](beast::error_code error, std::size_t sent)
      {
        self->Writing = false;
        self->Record.bytes += sent;
        self->State.Counters.CountBytes(sent);
        if (!error)
        {
          self->CountBlob();
          self->GoOn();
        }
      });
  }

  void CountWhatWasRefused()
  {
    const auto& now = this->Talk.Counted();
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

  // If what was sent is the first or the last that its request is owed.
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

  // Ends the stream if what is being written is not taken in time, though the client may answer
  // pings: one timer, which looks again when it goes off.
  void WatchWrite(std::size_t bytes)
  {
    this->TakenBy = Clock::now() + this->State.PatienceFor(bytes);
    if (!this->Watching)
    {
      this->Watch();
    }
  }

  void Watch()
  {
    this->Watching = true;
    this->Patience.expires_at(this->TakenBy);
    this->Patience.async_wait(
      [weak = this->weak_from_this()](beast::error_code error)
      {
        const auto self = weak.lock();
        if (self && !error)
        {
          self->Guard([&] { self->LookAtWrite(); });
        }
      });
  }

  void LookAtWrite()
  {
    this->Watching = false;
    if (!this->Writing)
    {
      return;
    }
    if (Clock::now() < this->TakenBy)
    {
      this->Watch();
      return;
    }
    this->State.Counters.CountRefusal(Metrics::Reason::Slow);
    this->Socket.next_layer().Close();
  }

  // The conversation itself looks at its token before each message; who waits for none is told
  // within this time.
  static constexpr std::chrono::milliseconds tokenInterval{ 250 };

  void WatchToken()
  {
    if (!this->State.Options.guard || this->Talk.Closing())
    {
      return;
    }
    this->Looks.expires_after(tokenInterval);
    this->Looks.async_wait(
      [weak = this->weak_from_this()](beast::error_code error)
      {
        const auto self = weak.lock();
        if (self && !error)
        {
          self->Guard(
            [&]
            {
              if (!self->Talk.IsPermitted())
              {
                self->Write();
              }
              self->WatchToken();
            });
        }
      });
  }

  // Has the readers do what the conversation waits for.
  void RunErrand()
  {
    const auto errand = this->Talk.TakeErrand();
    if (!errand)
    {
      return;
    }
    const auto self = this->shared_from_this();
    MakeRoundTrip(
      this->Socket.get_executor(),
      [&](WorkerPool::Work work, WorkerPool::Work giveUp)
      {
        this->State.Read(errand->Takes(),
          { std::move(work), std::move(giveUp), errand->Source(), errand->Part() });
      },
      [errand] { errand->Run(); },
      [self, errand](bool isDone)
      {
        self->Guard(
          [&]
          {
            if (isDone)
            {
              self->Talk.Finish(errand);
              return;
            }
            self->State.CountGivenUp();
            self->Talk.GiveUp(errand);
          });
        self->GoOn();
      });
  }

  void CloseIfEnded()
  {
    const auto reason = this->Talk.Closing();
    if (!reason || this->ClosingNow)
    {
      return;
    }
    this->ClosingNow = true;
    this->Writing = true;
    // All that is owed has been given to the kernel. Who does not answer has gone, or sleeps:
    // nobody waits for him, least of all the end of the server.
    this->TakenBy = Clock::now() + std::min(closePatience, this->State.PatienceFor(0));
    this->Watch();
    this->Socket.async_close(
      beast::websocket::close_reason(
        static_cast<beast::websocket::close_code>(static_cast<std::uint16_t>(*reason))),
      [self = this->shared_from_this()](beast::error_code) {});
  }

  beast::websocket::stream<ClientSocket, false> Socket; // false: no code for compression
  ServerState& State;
  Seat Place;
  AccessRecord Record;
  Conversation Talk;
  Conversation::Tally Counted; // what the metrics know of
  Clock::time_point Opened = Clock::now();
  beast::flat_buffer Input;
  Conversation::Message Output;    // that is being sent
  Conversation::Milestone Sending; // for its request
  Timer Patience, Looks;
  Clock::time_point TakenBy; // what is being written
  bool Watching = false;
  bool Accepted = false;
  bool Reading = false;
  bool Unreadable = false; // it has failed: amid a message it must not be read again
  bool Writing = false;
  bool ClosingNow = false;
};

}

void ServeStream(ClientSocket socket, ServerState& state, Seat seat, Permission permission,
  AccessRecord record, const beast::http::request<beast::http::empty_body>& request)
{
  std::make_shared<StreamConnection>(
    std::move(socket), state, std::move(seat), std::move(permission), std::move(record))
    ->Run(request);
}

}
