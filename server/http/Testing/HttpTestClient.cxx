// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/Testing/HttpTestClient.h"

#include "filters/protocol/ResourcePath.h"

#include <boost/asio.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

namespace kdstream
{

namespace asio = boost::asio;
namespace beast = boost::beast;
using asio::ip::tcp;

namespace
{

tcp::endpoint Loopback(std::uint16_t port)
{
  return { asio::ip::address_v4::loopback(), port };
}

// Takes a message of the answer. Returns whether the message ends its request.
bool Take(const protocol::ServerMessage& message, StreamTestClient::Answer& answer)
{
  if (const auto* begin = std::get_if<protocol::BeginAnswer>(&message.body))
  {
    answer.begin = *begin;
  }
  else if (const auto* end = std::get_if<protocol::EndAnswer>(&message.body))
  {
    answer.end = *end;
  }
  else if (const auto* opened = std::get_if<protocol::OpenedAnswer>(&message.body))
  {
    answer.opened = *opened;
  }
  else if (const auto* error = std::get_if<protocol::ErrorAnswer>(&message.body))
  {
    if (error->blob)
    {
      answer.blobErrors.push_back(*error);
    }
    else
    {
      answer.error = *error;
    }
  }
  return answer.end || answer.opened || answer.error;
}

}

struct HttpTestClient::Connection
{
  asio::io_context context;
  tcp::socket socket{ context };
  beast::flat_buffer input;
};

std::string HttpTestClient::Response::Field(const std::string& name) const
{
  const auto found = this->fields.find(name);
  return found == this->fields.end() ? "" : found->second;
}

HttpTestClient::HttpTestClient(std::uint16_t port)
  : Peer(std::make_unique<Connection>())
{
  this->Peer->socket.connect(Loopback(port));
}

HttpTestClient::~HttpTestClient() = default;

bool HttpTestClient::Connects(std::uint16_t port)
{
  Connection peer;
  beast::error_code error;
  peer.socket.connect(Loopback(port), error);
  return !error;
}

void HttpTestClient::Send(const std::string& bytes)
{
  beast::error_code error; // the server may have closed the stream already
  asio::write(this->Peer->socket, asio::buffer(bytes), error);
}

void HttpTestClient::EndOutput()
{
  this->Peer->socket.shutdown(tcp::socket::shutdown_send);
}

std::optional<HttpTestClient::Response> HttpTestClient::Receive(bool head)
{
  beast::http::response_parser<beast::http::string_body> parser;
  parser.body_limit(64u << 20);
  parser.skip(head);
  beast::error_code error;
  beast::http::read(this->Peer->socket, this->Peer->input, parser, error);
  if (error)
  {
    return std::nullopt;
  }
  auto message = parser.release();
  Response response{ message.result_int(), {}, std::move(message.body()) };
  for (const auto& field : message)
  {
    response.fields[std::string(field.name_string())] = std::string(field.value());
  }
  return response;
}

std::optional<HttpTestClient::Response> HttpTestClient::Get(
  const std::string& target, const std::string& fields, const std::string& method)
{
  this->Send(method + " " + target + " HTTP/1.1\r\nHost: test\r\n" + fields + "\r\n");
  return this->Receive(method == "HEAD");
}

bool HttpTestClient::Ends()
{
  char byte = 0;
  beast::error_code error;
  return this->Peer->input.size() == 0 &&
         this->Peer->socket.read_some(asio::buffer(&byte, 1), error) == 0 && error;
}

struct StreamTestClient::Connection
{
  asio::io_context context;
  beast::websocket::stream<tcp::socket> socket{ context };
  std::string host;
  std::string subprotocol;
};

StreamTestClient::StreamTestClient(std::uint16_t port)
  : Peer(std::make_unique<Connection>())
{
  this->Peer->host = "127.0.0.1:" + std::to_string(port);
  this->Peer->socket.next_layer().connect(Loopback(port));
}

StreamTestClient::~StreamTestClient() = default;

bool StreamTestClient::Open(const std::string& subprotocols, const std::string& authorization)
{
  this->Peer->socket.set_option(beast::websocket::stream_base::decorator(
    [=](beast::websocket::request_type& request)
    {
      request.set(beast::http::field::sec_websocket_protocol, subprotocols);
      if (!authorization.empty())
      {
        request.set(beast::http::field::authorization, authorization);
      }
    }));
  beast::websocket::response_type response;
  beast::error_code error;
  this->Peer->socket.handshake(
    response, this->Peer->host, std::string(protocol::streamPath), error);
  this->Peer->subprotocol = std::string(response[beast::http::field::sec_websocket_protocol]);
  return !error;
}

std::string StreamTestClient::Subprotocol() const
{
  return this->Peer->subprotocol;
}

void StreamTestClient::Ask(const protocol::ClientMessage& message)
{
  this->SendText(protocol::WriteClientMessage(message));
}

void StreamTestClient::SendText(const std::string& text)
{
  this->Peer->socket.text(true);
  beast::error_code error;
  this->Peer->socket.write(asio::buffer(text), error);
}

void StreamTestClient::SendBinary(const std::string& bytes)
{
  this->Peer->socket.binary(true);
  beast::error_code error;
  this->Peer->socket.write(asio::buffer(bytes), error);
}

std::optional<StreamTestClient::Message> StreamTestClient::Receive()
{
  beast::flat_buffer buffer;
  beast::error_code error;
  this->Peer->socket.read(buffer, error);
  if (error)
  {
    return std::nullopt;
  }
  const auto* data = static_cast<const std::uint8_t*>(buffer.cdata().data());
  if (this->Peer->socket.got_binary())
  {
    return std::vector<std::uint8_t>(data, data + buffer.size());
  }
  auto message =
    protocol::ParseServerMessage({ reinterpret_cast<const char*>(data), buffer.size() });
  return message ? std::optional<Message>(*message) : std::nullopt;
}

StreamTestClient::Answer StreamTestClient::Await(
  std::uint32_t request, const std::function<void(std::size_t frames)>& onFrame)
{
  Answer answer;
  while (auto message = this->Receive())
  {
    if (const auto* bytes = std::get_if<std::vector<std::uint8_t>>(&*message))
    {
      const auto frame = protocol::ParseFrame(*bytes);
      auto blob = frame ? this->Assembler.Accept(*frame) : frame.GetError();
      if (!blob || frame->header.request != request)
      {
        return {};
      }
      if (*blob)
      {
        answer.blobs.push_back(std::move(**blob));
      }
      ++answer.frames;
      if (onFrame)
      {
        onFrame(answer.frames);
      }
    }
    else if (Take(std::get<protocol::ServerMessage>(*message), answer))
    {
      this->Assembler.Forget(request);
      return answer;
    }
  }
  return answer;
}

void StreamTestClient::Close()
{
  beast::error_code error;
  this->Peer->socket.close(beast::websocket::close_code::normal, error);
}

std::uint16_t StreamTestClient::CloseCode() const
{
  return this->Peer->socket.reason().code;
}

}
