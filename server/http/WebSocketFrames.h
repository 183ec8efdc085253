// SPDX-License-Identifier: BSD-3-Clause
// Reads and writes the frames of a WebSocket (RFC 6455, sections 4 to 8) for a server. No sockets,
// no timers, no extensions. Internal to the server.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace kdstream
{

enum class WebSocketOpcode : std::uint8_t
{
  Continuation = 0,
  Text = 1,
  Binary = 2,
  Close = 8,
  Ping = 9,
  Pong = 10
};

// The status of a Close frame (section 7.4) after an error of the client.
enum class WebSocketError : std::uint16_t
{
  Protocol = 1002,
  BadText = 1007, // not UTF-8
  TooLarge = 1009
};

// Checks whether the bytes received so far may begin a UTF-8 text (RFC 3629): without surrogates
// and overlong forms, up to U+10FFFF.
class Utf8Check
{
public:
  // Takes the next bytes. Returns whether the text is correct so far. After the first false, do not
  // use this object any more.
  bool Take(std::string_view text);
  // Whether the text may end here: not in the middle of a character.
  bool IsWhole() const { return this->Missing == 0; }

private:
  int Missing = 0;                            // bytes that the character still lacks
  std::uint8_t Least = 0x80, Greatest = 0xbf; // range of the next continuation byte
};

// Reads what a client sends, in pieces of any size. Keeps at most one message and one control
// frame. An error is reported at the first wrong byte, not at the end of the frame.
class WebSocketReader
{
public:
  // mostBytes: the largest message.
  explicit WebSocketReader(std::size_t mostBytes)
    : MostBytes(mostBytes)
  {
  }

  enum class Event
  {
    None,   // more bytes are needed
    Text,   // Message() is whole
    Binary, // a binary message has begun; its bytes are dropped
    Ping,   // its payload is Control()
    Pong,
    Close, // Status(), and the reason in Control()
    Error  // Status() says what is wrong. No event follows a Close or an error.
  };
  // Takes bytes up to the next event, and returns the event.
  Event Take(std::string_view& bytes);

  // From now on messages are neither kept nor checked, and only control frames are events.
  void SkipMessages();

  const std::string& Message() const { return this->Text; }
  std::string_view Control() const
  {
    return std::string_view(this->ControlBytes.data(), this->ControlSize)
      .substr(this->ControlBegin);
  }
  // The status of a Close frame, 0 if it has none; or the status for the error.
  std::uint16_t Status() const { return this->Code; }

private:
  static constexpr std::size_t mostControlBytes = 125;

  bool TakeHead(std::string_view& bytes);
  bool CheckStart();
  bool CheckLength();
  bool TakePayload(std::string_view& bytes);
  bool KeepMessage(std::string_view part);
  Event EndFrame();
  Event EndMessage();
  Event EndClose();
  bool Fail(WebSocketError error);
  bool IsControl() const { return (static_cast<unsigned>(this->Opcode) & 8u) != 0; }

  const std::size_t MostBytes;
  // The current frame. Head: the part of its head that has come so far.
  std::array<std::uint8_t, 14> Head{};
  std::size_t HeadFilled = 0, HeadSize = 2;
  bool InPayload = false;
  WebSocketOpcode Opcode = WebSocketOpcode::Continuation;
  bool IsLast = false; // the frame is the last one of its message
  std::uint64_t Left = 0;
  std::size_t MaskAt = 0; // where in the mask the next byte's is
  // The current message.
  bool InMessage = false;
  bool IsText = false;
  bool Skips = false;
  bool IsDone = false; // the text was reported: the next message starts empty
  std::string Text;
  Utf8Check Utf8;
  // The current control frame.
  std::array<char, mostControlBytes> ControlBytes{};
  std::size_t ControlSize = 0, ControlBegin = 0;
  std::uint16_t Code = 0;
  bool Failed = false;
  bool Ended = false;
};

// The head of a frame that a server sends: unmasked, with a whole message in the frame.
class WebSocketHead
{
public:
  WebSocketHead() = default;
  WebSocketHead(WebSocketOpcode opcode, std::size_t bytes);
  std::string_view Bytes() const { return { this->Filled.data(), this->Size }; }

private:
  std::array<char, 10> Filled{};
  std::size_t Size = 0;
};

// Writes the payload of a Close frame with this status.
std::string WriteCloseStatus(std::uint16_t status);

// Whether the text is the base64 of 16 bytes, as a Sec-WebSocket-Key must be.
bool IsWebSocketKey(std::string_view text);
// The value of Sec-WebSocket-Accept for this key.
std::string WebSocketAccept(std::string_view key);

}
