// SPDX-License-Identifier: BSD-3-Clause
// One WebSocket: moves messages between a socket and a Conversation. Internal to the server.
//
// At most one message is being written, and the next one is made only when it has been sent. So a
// client that does not read costs the memory of one frame, and a cancel takes effect at the next
// frame.
#pragma once

#include "server/http/ServerState.h"
#include "server/protocol/ResourcePath.h"
#include "server/session/Conversation.h"

#include <boost/asio.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include <string>

namespace kdstream
{

namespace asio = boost::asio;
namespace beast = boost::beast;

template <class Stream>
class StreamConnection
  : public Drainable
  , public std::enable_shared_from_this<StreamConnection<Stream>>
{
public:
  StreamConnection(
    Stream&& stream, ServerState& state, std::shared_ptr<void> seat, AccessRecord record)
    : Socket(std::move(stream))
    , State(state)
    , Seat(std::move(seat))
    , Record(std::move(record))
    , Talk(state.Models)
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

  // Accepts the upgrade and serves the stream until the client leaves.
  template <class Request>
  void Run(const Request& request)
  {
    namespace websocket = beast::websocket;
    this->State.Enter(this->shared_from_this());
    beast::get_lowest_layer(this->Socket).expires_never();
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
    this->Socket.read_message_max(16 * protocol::maximumClientMessageBytes);
    this->Socket.auto_fragment(false);
    this->LimitUnsentBytes();
    this->Socket.async_accept(request,
      [self = this->shared_from_this()](beast::error_code error)
      {
        if (!error)
        {
          self->Accepted = true;
          self->Read();
          self->Write();
        }
      });
  }

  void Drain() override
  {
    asio::post(this->Socket.get_executor(),
      [self = this->shared_from_this()]
      {
        self->Talk.Drain();
        if (self->Accepted)
        {
          self->Write();
        }
      });
  }

private:
  using Clock = std::chrono::steady_clock;

  // Without this the kernel would buffer megabytes for a slow client, and a cancel would have to
  // wait until they are sent.
  void LimitUnsentBytes()
  {
#ifdef TCP_NOTSENT_LOWAT
    const int bytes = 2 * static_cast<int>(protocol::maximumFrameBytes);
    auto& socket = beast::get_lowest_layer(this->Socket).socket();
    ::setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &bytes, sizeof bytes);
#endif
  }

  void Read()
  {
    // After the conversation has ended we read on only to find the client's close frame.
    if (this->Reading || !(this->Talk.AcceptsMessages() || this->Talk.Closing()))
    {
      return;
    }
    this->Reading = true;
    this->Socket.async_read(this->Input,
      [self = this->shared_from_this()](beast::error_code error, std::size_t)
      {
        self->Reading = false;
        if (!error)
        {
          self->Take();
          self->Read();
          self->Write();
        }
      });
  }

  void Take()
  {
    if (this->Socket.got_text())
    {
      const auto data = this->Input.cdata();
      this->Talk.Receive({ static_cast<const char*>(data.data()), data.size() });
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
    const auto failedBefore = this->Talk.FailedBlobs();
    auto message = this->Talk.NextMessage();
    for (auto i = failedBefore; i < this->Talk.FailedBlobs(); ++i)
    {
      this->State.Counters.CountFailedBlob();
    }
    if (!message)
    {
      this->CloseIfEnded();
      return;
    }
    this->Output = std::move(*message);
    this->Writing = true;
    this->Socket.text(std::holds_alternative<std::string>(this->Output));
    const auto bytes = std::visit([](const auto& m) { return asio::buffer(m); }, this->Output);
    this->Socket.async_write(bytes,
      [self = this->shared_from_this()](beast::error_code error, std::size_t sent)
      {
        self->Writing = false;
        self->Record.bytes += sent;
        self->State.Counters.CountBytes(sent);
        if (!error)
        {
          self->Write();
          self->Read();
        }
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
    this->Socket.async_close(
      beast::websocket::close_reason(
        static_cast<beast::websocket::close_code>(static_cast<std::uint16_t>(*reason))),
      [self = this->shared_from_this()](beast::error_code) {});
  }

  beast::websocket::stream<Stream> Socket;
  ServerState& State;
  std::shared_ptr<void> Seat;
  AccessRecord Record;
  Conversation Talk;
  Clock::time_point Opened = Clock::now();
  beast::flat_buffer Input;
  Conversation::Message Output;
  bool Accepted = false;
  bool Reading = false;
  bool Writing = false;
  bool ClosingNow = false;
};

}
