// SPDX-License-Identifier: BSD-3-Clause
// Blocking clients for the tests of the server: for plain bytes, HTTP, and the stream. This header
// hides Boost.
#pragma once

#include "filters/protocol/BinaryFrame.h"
#include "filters/protocol/ControlMessage.h"
#include "filters/protocol/ResourcePath.h"

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace kdstream
{

// One connection to the server, at 127.0.0.1.
class HttpTestClient
{
public:
  struct Response
  {
    unsigned status = 0;
    std::map<std::string, std::string> fields;
    std::string body;
    std::string Field(const std::string& name) const;
  };

  explicit HttpTestClient(std::uint16_t port);
  ~HttpTestClient();
  static bool Connects(std::uint16_t port);

  void Send(const std::string& bytes);
  // Ends the client's side of the connection: nothing more is sent.
  void EndOutput();
  // The next answer, or nothing if the connection ends without one.
  std::optional<Response> Receive(bool head = false);
  std::optional<Response> Get(
    const std::string& target, const std::string& fields = "", const std::string& method = "GET");
  // Whether the server ends the connection without sending another byte.
  bool Ends();

private:
  struct Connection;
  std::unique_ptr<Connection> Peer;
};

// One WebSocket to the server, at 127.0.0.1.
class StreamTestClient
{
public:
  using Message = std::variant<protocol::ServerMessage, std::vector<std::uint8_t>>;

  explicit StreamTestClient(std::uint16_t port);
  ~StreamTestClient();

  // Opens the stream. Offers these subprotocols, and sends `authorization` as that field unless it
  // is empty.
  bool Open(const std::string& subprotocols = std::string(protocol::streamSubprotocol),
    const std::string& authorization = {});
  std::string Subprotocol() const; // the one that the server has chosen

  void Ask(const protocol::ClientMessage& message);
  void SendText(const std::string& text);
  void SendBinary(const std::string& bytes);

  // The next message, or nothing if the stream ends.
  std::optional<Message> Receive();

  struct Answer
  {
    std::vector<protocol::FrameAssembler::Blob> blobs;
    std::vector<protocol::ErrorAnswer> blobErrors;
    std::optional<protocol::BeginAnswer> begin;
    std::optional<protocol::EndAnswer> end;
    std::optional<protocol::ErrorAnswer> error;
    std::optional<protocol::OpenedAnswer> opened;
    std::size_t frames = 0;
  };

  // Receives messages until the answer to `request` has ended. onFrame: called after each frame.
  Answer Await(std::uint32_t request, const std::function<void(std::size_t frames)>& onFrame = {});

  void Close();
  std::uint16_t CloseCode() const;

private:
  struct Connection;
  std::unique_ptr<Connection> Peer;
  protocol::FrameAssembler Assembler;
};

}
