// SPDX-License-Identifier: BSD-3-Clause
// WebSocket frames of a client as tests write them, correct and wrong ones, and a reader of a
// server's frames. Written from RFC 6455, not from the server's code.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace kdstream
{

struct ClientFrame
{
  unsigned opcode = 1;
  std::string payload;
  bool isLast = true;
  unsigned reserved = 0; // three bits
  bool isMasked = true;
  // How many bytes the length is written in: 0: as many as it should be; 2 or 8: this many.
  unsigned lengthBytes = 0;
  std::optional<std::uint64_t> length = {}; // in the frame, if it is not the payload's length
  std::uint32_t mask = 0x12345678;

  std::string Bytes() const
  {
    std::string bytes;
    const auto put = [&bytes](std::uint64_t byte)
    { bytes += static_cast<char>(static_cast<std::uint8_t>(byte)); };
    put((this->isLast ? 0x80u : 0u) | this->reserved << 4 | this->opcode);
    const auto reported = this->length.value_or(this->payload.size());
    const unsigned extended = this->lengthBytes != 0 ? this->lengthBytes
                              : reported < 126       ? 0
                              : reported < 65536     ? 2
                                                     : 8;
    put((this->isMasked ? 0x80u : 0u) | (extended == 0 ? reported : extended == 2 ? 126u : 127u));
    for (unsigned i = extended; i > 0; --i)
    {
      put(reported >> (8 * (i - 1)));
    }
    const auto maskAt = [this](std::size_t i) { return this->mask >> (8 * (3 - i % 4)) & 0xffu; };
    for (std::size_t i = 0; i < 4 && this->isMasked; ++i)
    {
      put(maskAt(i));
    }
    for (std::size_t i = 0; i < this->payload.size(); ++i)
    {
      put(static_cast<std::uint8_t>(this->payload[i]) ^ (this->isMasked ? maskAt(i) : 0u));
    }
    return bytes;
  }
};

inline std::string TextFrame(std::string payload)
{
  return ClientFrame{ 1, std::move(payload) }.Bytes();
}

// status: 0: the frame has none.
inline std::string CloseFrame(unsigned status, const std::string& reason = {})
{
  std::string payload;
  if (status != 0)
  {
    payload += static_cast<char>(status >> 8);
    payload += static_cast<char>(status & 0xffu);
  }
  return ClientFrame{ 8, payload + reason }.Bytes();
}

inline std::string UpgradeRequest(std::string_view host = "127.0.0.1")
{
  return "GET /api/stream HTTP/1.1\r\nHost: " + std::string(host) +
         "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
         "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
         "Sec-WebSocket-Protocol: kdstream.v2\r\n\r\n";
}

struct ServerFrame
{
  unsigned opcode = 0;
  std::string payload;
  bool isRight = false; // it is whole and unmasked, and no reserved bits are set
};

// Takes the next frame from the front of the bytes, if a whole frame is there.
inline std::optional<ServerFrame> TakeServerFrame(std::string& bytes)
{
  const auto at = [&bytes](std::size_t i)
  { return std::uint64_t{ static_cast<std::uint8_t>(bytes[i]) }; };
  if (bytes.size() < 2)
  {
    return std::nullopt;
  }
  std::uint64_t length = at(1) & 0x7f;
  const std::size_t extended = length == 126 ? 2 : length == 127 ? 8 : 0;
  if (bytes.size() < 2 + extended)
  {
    return std::nullopt;
  }
  for (std::size_t i = 0; i < extended; ++i)
  {
    length = (i == 0 ? 0 : length << 8) | at(2 + i);
  }
  if (bytes.size() - 2 - extended < length)
  {
    return std::nullopt;
  }
  ServerFrame frame{ static_cast<unsigned>(at(0) & 0xf), bytes.substr(2 + extended, length),
    (at(0) & 0xf0) == 0x80 && (at(1) & 0x80) == 0 };
  bytes.erase(0, 2 + extended + length);
  return frame;
}

}
