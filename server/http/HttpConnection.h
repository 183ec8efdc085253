// SPDX-License-Identifier: BSD-3-Clause
// One HTTP connection: reads requests and sends the routes' answers one after the other, until the
// client leaves or asks for a WebSocket. Internal to the server.
#pragma once

#include "server/http/ServerState.h"
#include "server/http/StreamConnection.h"

#include <boost/asio/ssl.hpp>
#include <boost/beast/ssl.hpp>

#include <array>
#include <cstdio>
#include <ctime>
#include <optional>
#include <string>
#include <type_traits>

namespace kdstream
{

// The current time in the format of the Date field, whatever the locale.
inline std::string HttpDate()
{
  constexpr const char* days[] = { "Sun", "Mon", "Tue", "Wed", "Thu", "Fri", "Sat" };
  constexpr const char* months[] = { "Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep",
    "Oct", "Nov", "Dec" };
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[40];
  std::snprintf(text, sizeof text, "%s, %02d %s %d %02d:%02d:%02d GMT", days[utc.tm_wday],
    utc.tm_mday, months[utc.tm_mon], utc.tm_year + 1900, utc.tm_hour, utc.tm_min, utc.tm_sec);
  return text;
}

template <class Stream>
class HttpConnection
  : public Drainable
  , public std::enable_shared_from_this<HttpConnection<Stream>>
{
public:
  // Without a seat, every request is answered 503. `refusal` is kept as long as the connection, to
  // count it.
  HttpConnection(
    Stream&& stream, ServerState& state, std::shared_ptr<void> seat, std::shared_ptr<void> refusal)
    : Executor(stream.get_executor())
    , Socket(std::move(stream))
    , State(state)
    , Seat(std::move(seat))
    , Refusal(std::move(refusal))
  {
  }

  ~HttpConnection() override { this->State.Leave(this); }

  void Run()
  {
    this->State.Enter(this->shared_from_this());
    beast::error_code error;
    auto& socket = beast::get_lowest_layer(this->Socket).socket();
    socket.set_option(asio::ip::tcp::no_delay(true), error);
    const auto address = socket.remote_endpoint(error).address();
    this->Client = error ? "-" : address.to_string();
    asio::dispatch(this->Executor,
      [self = this->shared_from_this()]
      {
        if constexpr (isTls)
        {
          self->Expire(self->State.Options.requestTimeout);
          self->Socket.async_handshake(asio::ssl::stream_base::server,
            [self](beast::error_code failed)
            {
              if (!failed)
              {
                self->Read();
              }
            });
        }
        else
        {
          self->Read();
        }
      });
  }

  void Drain() override
  {
    asio::post(this->Executor,
      [self = this->shared_from_this()]
      {
        const bool idle = self->Parser && !self->Parser->got_some() && self->Input.size() == 0;
        if (idle && !self->Answering) // has not become a WebSocket either
        {
          beast::get_lowest_layer(self->Socket).close();
        }
      });
  }

private:
  using Clock = std::chrono::steady_clock;
  using Body = beast::http::span_body<const std::uint8_t>;
  static constexpr bool isTls = !std::is_same_v<Stream, beast::tcp_stream>;
  static constexpr std::uint32_t headerBytes = 8192;

  void Expire(std::chrono::milliseconds time)
  {
    beast::get_lowest_layer(this->Socket).expires_after(time);
  }

  void Read()
  {
    this->Answering = false;
    if (this->State.Draining() && this->Input.size() == 0)
    {
      this->Close();
      return;
    }
    this->Parser.emplace();
    this->Parser->header_limit(headerBytes);
    this->Parser->body_limit(0);
    this->Expire(this->State.Options.requestTimeout);
    beast::http::async_read(this->Socket, this->Input, *this->Parser,
      [self = this->shared_from_this()](beast::error_code error, std::size_t)
      { self->OnRead(error); });
  }

  void OnRead(beast::error_code error)
  {
    namespace http = beast::http;
    this->Answering = true;
    this->Began = Clock::now();
    const auto& request = this->Parser->get();
    if (error == http::error::end_of_stream || error == http::error::partial_message)
    {
      this->Close();
    }
    else if (error == http::error::header_limit || error == http::error::buffer_overflow)
    {
      this->Refuse(
        431, "the request's header is larger than " + std::to_string(headerBytes) + " bytes");
    }
    else if (error == http::error::body_limit || error == http::error::unexpected_body)
    {
      this->Refuse(413, "requests with a body are not accepted");
    }
    else if (error.category() == make_error_code(http::error::bad_method).category())
    {
      this->Refuse(400, "the request is not HTTP: " + error.message());
    }
    else if (error)
    {
      return; // the client has gone, or took too long
    }
    else if (!this->Seat)
    {
      this->State.Counters.ConnectionRefused();
      this->Refuse(503, "there are too many connections");
    }
    else if (request.version() >= 11 && request.count(http::field::host) != 1)
    {
      this->Refuse(400, "the request must name one host");
    }
    else if (beast::websocket::is_upgrade(request))
    {
      this->Upgrade();
    }
    else
    {
      this->Send(this->State.Answers.Answer(this->Plain()), request.keep_alive());
    }
  }

  HttpRequest Plain() const
  {
    namespace http = beast::http;
    const auto& request = this->Parser->get();
    const auto field = [&](http::field name)
    {
      const auto value = request[name];
      return std::string(value.data(), value.size());
    };
    std::string encodings;
    const auto range = request.equal_range(http::field::accept_encoding);
    for (auto each = range.first; each != range.second; ++each)
    {
      encodings += encodings.empty() ? "" : ",";
      encodings.append(each->value().data(), each->value().size());
    }
    const auto method = request.method_string();
    const auto target = request.target();
    return { std::string(method.data(), method.size()), std::string(target.data(), target.size()),
      field(http::field::if_none_match), field(http::field::range), field(http::field::if_range),
      encodings };
  }

  // Answers with an error and closes the connection.
  void Refuse(unsigned status, const std::string& message)
  {
    auto response = this->State.Answers.Failure(status, message);
    response.omitBody = this->Parser->get().method() == beast::http::verb::head;
    this->Send(std::move(response), false);
  }

  void Upgrade()
  {
    namespace http = beast::http;
    const auto& request = this->Parser->get();
    const auto text = [&](http::field name)
    {
      const auto value = request[name];
      return std::string(value.data(), value.size());
    };
    const auto target = this->Plain().target;
    if (target.substr(0, target.find('?')) != protocol::streamPath)
    {
      this->Refuse(404, "there is no WebSocket at this path");
      return;
    }
    if (!http::token_list(text(http::field::sec_websocket_protocol))
           .exists(std::string(protocol::streamSubprotocol)))
    {
      this->Refuse(400, "the WebSocket's subprotocol must be kdstream.v1");
      return;
    }
    if (!this->State.Answers.MayStream(text(http::field::origin), text(http::field::host)))
    {
      this->Refuse(403, "pages of this origin may not open a stream");
      return;
    }
    if (this->Input.size() != 0)
    {
      this->Refuse(400, "the client sent data before the WebSocket was open");
      return;
    }
    const auto connection =
      std::make_shared<StreamConnection<Stream>>(std::move(this->Socket), this->State,
        std::move(this->Seat), AccessRecord{ this->Client, "STREAM", target, 101, 0, 0 });
    connection->Run(request);
  }

  void Send(HttpResponse response, bool keepAlive)
  {
    namespace http = beast::http;
    this->Answer = std::move(response);
    this->Message.emplace();
    auto& message = *this->Message;
    message.version(this->Parser->get().version() == 10 ? 10 : 11);
    message.result(this->Answer.status);
    for (const auto& field : this->Answer.fields)
    {
      message.insert(field.first, field.second);
    }
    message.set(http::field::date, HttpDate());
    message.keep_alive(keepAlive && !this->State.Draining());
    if (this->Answer.status != 304 && this->Answer.status != 204)
    {
      message.content_length(this->Answer.length);
    }
    if (this->Answer.body && !this->Answer.omitBody)
    {
      message.body() = beast::span<const std::uint8_t>(
        this->Answer.body->data() + this->Answer.begin, this->Answer.length);
    }
    const auto patience = std::chrono::seconds(message.body().size() >> 14);
    this->Expire(this->State.Options.answerTimeout + patience);
    http::async_write(this->Socket, message,
      [self = this->shared_from_this()](beast::error_code error, std::size_t)
      { self->OnSent(error); });
  }

  void OnSent(beast::error_code error)
  {
    const auto& request = this->Parser->get();
    const auto sent = error ? 0 : this->Message->body().size();
    const std::chrono::duration<double> time = Clock::now() - this->Began;
    this->State.Counters.CountRequest(this->Answer.status);
    this->State.Counters.CountBytes(sent);
    const auto method = request.method_string();
    const auto target = request.target();
    this->State.Log({ this->Client, std::string(method.data(), method.size()),
      std::string(target.data(), target.size()), this->Answer.status, sent, time.count() });
    const bool goOn = !error && this->Message->keep_alive();
    this->Message.reset();
    this->Answer = {};
    if (goOn)
    {
      this->Read();
    }
    else if (!error)
    {
      this->Close();
    }
  }

  // Sends no more, and for a moment reads what the client still sends: if the socket were closed
  // with unread bytes, the kernel would discard an answer that is still on its way.
  void Close()
  {
    this->Expire(std::chrono::seconds(2));
    if constexpr (isTls)
    {
      this->Socket.async_shutdown([self = this->shared_from_this()](beast::error_code) {});
    }
    else
    {
      beast::error_code error;
      this->Socket.socket().shutdown(asio::ip::tcp::socket::shutdown_send, error);
      if (!error)
      {
        this->Input.clear();
        this->DiscardInput();
      }
    }
  }

  void DiscardInput()
  {
    this->Socket.async_read_some(asio::buffer(this->Discarded),
      [self = this->shared_from_this()](beast::error_code error, std::size_t)
      {
        if (!error)
        {
          self->DiscardInput();
        }
      });
  }

  // A copy, because Socket is moved away when it becomes a WebSocket.
  typename Stream::executor_type Executor;
  Stream Socket;
  ServerState& State;
  std::shared_ptr<void> Seat, Refusal;
  std::string Client;
  beast::flat_buffer Input{ headerBytes + 1024 };
  std::optional<beast::http::request_parser<beast::http::empty_body>> Parser;
  HttpResponse Answer;
  std::optional<beast::http::response<Body>> Message;
  std::array<char, 4096> Discarded{};
  Clock::time_point Began;
  bool Answering = false;
};

}
