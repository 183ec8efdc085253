// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/WebSocketFrames.h"

#include <openssl/evp.h>

#include <algorithm>
#include <new>

namespace kdstream
{

namespace
{

constexpr std::size_t mostKeptBytes = 8192; // most bytes of the message buffer that stay allocated

// Section 7.4, and IANA's registry: 1004 to 1006, and 1015, must not be sent.
bool MayBeSent(std::uint16_t status)
{
  return (status >= 1000 && status <= 1003) || (status >= 1007 && status <= 1014) ||
         (status >= 3000 && status <= 4999);
}

std::uint64_t BigEndian(const std::uint8_t* bytes, std::size_t count)
{
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < count; ++i)
  {
    value = value << 8 | bytes[i];
  }
  return value;
}

}

bool Utf8Check::Take(std::string_view text)
{
  for (const char each : text)
  {
    const auto byte = static_cast<std::uint8_t>(each);
    if (this->Missing > 0)
    {
      if (byte < this->Least || byte > this->Greatest)
      {
        return false;
      }
      this->Least = 0x80;
      this->Greatest = 0xbf;
      --this->Missing;
    }
    else if (byte >= 0x80)
    {
      if (byte < 0xc2 || byte > 0xf4)
      {
        return false;
      }
      this->Missing = byte < 0xe0 ? 1 : byte < 0xf0 ? 2 : 3;
      // The first byte determines which second bytes are allowed: no overlong forms, no surrogates,
      // nothing above U+10FFFF.
      this->Least = byte == 0xe0 ? 0xa0 : byte == 0xf0 ? 0x90 : 0x80;
      this->Greatest = byte == 0xed ? 0x9f : byte == 0xf4 ? 0x8f : 0xbf;
    }
  }
  return true;
}

WebSocketReader::Event WebSocketReader::Take(std::string_view& bytes)
{
  while (!this->Ended)
  {
    if (!this->InPayload && !this->TakeHead(bytes))
    {
      return this->Failed ? Event::Error : Event::None;
    }
    if (!this->InPayload) // the head has just been completed
    {
      this->InPayload = true;
      if (this->Opcode == WebSocketOpcode::Binary && !this->Skips)
      {
        return Event::Binary;
      }
    }
    if (!this->TakePayload(bytes))
    {
      return this->Failed ? Event::Error : Event::None;
    }
    if (const auto event = this->EndFrame(); event != Event::None)
    {
      return event;
    }
  }
  bytes = {};
  return Event::None;
}

void WebSocketReader::SkipMessages()
{
  this->Skips = true;
  this->Text = {};
}

bool WebSocketReader::Fail(WebSocketError error)
{
  this->Code = static_cast<std::uint16_t>(error);
  this->Failed = this->Ended = true;
  return false;
}

// Takes bytes of the frame's head. Returns whether the head is complete.
bool WebSocketReader::TakeHead(std::string_view& bytes)
{
  while (this->HeadFilled < this->HeadSize)
  {
    if (bytes.empty())
    {
      return false;
    }
    this->Head[this->HeadFilled++] = static_cast<std::uint8_t>(bytes.front());
    bytes.remove_prefix(1);
    if (this->HeadFilled <= 2 && !this->CheckStart())
    {
      return false;
    }
  }
  if (!this->CheckLength())
  {
    return false;
  }
  if (this->IsControl())
  {
    this->ControlSize = this->ControlBegin = 0;
  }
  else
  {
    if (this->Opcode != WebSocketOpcode::Continuation)
    {
      this->IsText = this->Opcode == WebSocketOpcode::Text;
      this->Utf8 = {};
    }
    this->InMessage = !this->IsLast;
  }
  this->MaskAt = 0;
  return true;
}

// Checks the first two bytes, each as soon as it has arrived.
bool WebSocketReader::CheckStart()
{
  constexpr unsigned last = 0x80, reserved = 0x70, opcode = 0x0f, masked = 0x80, length = 0x7f;
  if (this->HeadFilled == 1)
  {
    const unsigned first = this->Head[0];
    this->IsLast = (first & last) != 0;
    this->Opcode = static_cast<WebSocketOpcode>(first & opcode);
    bool isRight = false; // whether the opcode exists
    switch (this->Opcode)
    {
      case WebSocketOpcode::Text:
      case WebSocketOpcode::Binary:
        // Within a message only its continuations may come.
        isRight = !this->InMessage;
        break;
      case WebSocketOpcode::Continuation:
        isRight = this->InMessage;
        break;
      case WebSocketOpcode::Close:
      case WebSocketOpcode::Ping:
      case WebSocketOpcode::Pong:
        isRight = this->IsLast;
        break;
    }
    return (isRight && (first & reserved) == 0) || this->Fail(WebSocketError::Protocol);
  }
  const unsigned second = this->Head[1], bytes = second & length;
  if ((second & masked) == 0 || (this->IsControl() && bytes > mostControlBytes))
  {
    return this->Fail(WebSocketError::Protocol);
  }
  this->HeadSize = 2 + (bytes == 126 ? 2u : bytes == 127 ? 8u : 0u) + 4; // including the mask
  return true;
}

// Checks that the payload's length has its shortest form, and that the payload fits into a message.
bool WebSocketReader::CheckLength()
{
  const auto extended = this->HeadSize - 6;
  this->Left = extended == 0 ? this->Head[1] & 0x7fu : BigEndian(this->Head.data() + 2, extended);
  if ((extended == 2 && this->Left < 126) ||
      (extended == 8 && (this->Left < 65536 || this->Left >> 63 != 0)))
  {
    return this->Fail(WebSocketError::Protocol);
  }
  if (this->IsControl() || this->Skips)
  {
    return true;
  }
  if (this->Opcode != WebSocketOpcode::Continuation || this->IsDone)
  {
    this->IsDone = false;
    this->Text.clear();
    if (this->Text.capacity() > mostKeptBytes)
    {
      this->Text = {};
    }
  }
  return this->Left <= this->MostBytes - this->Text.size() || this->Fail(WebSocketError::TooLarge);
}

// Takes bytes of the frame's payload. Returns whether the payload is complete.
bool WebSocketReader::TakePayload(std::string_view& bytes)
{
  const auto* mask = this->Head.data() + this->HeadSize - 4;
  while (this->Left > 0)
  {
    if (bytes.empty())
    {
      return false;
    }
    std::array<char, 512> plain;
    const auto count =
      static_cast<std::size_t>(std::min<std::uint64_t>({ this->Left, bytes.size(), plain.size() }));
    for (std::size_t i = 0; i < count; ++i)
    {
      plain[i] = static_cast<char>(static_cast<std::uint8_t>(bytes[i]) ^ mask[this->MaskAt++ % 4]);
    }
    bytes.remove_prefix(count);
    this->Left -= count;
    if (this->IsControl())
    {
      std::copy_n(plain.data(), count, this->ControlBytes.data() + this->ControlSize);
      this->ControlSize += count;
    }
    else if (!this->KeepMessage({ plain.data(), count }))
    {
      return false;
    }
  }
  return true;
}

bool WebSocketReader::KeepMessage(std::string_view part)
{
  if (this->Skips || !this->IsText)
  {
    return true;
  }
  if (!this->Utf8.Take(part))
  {
    return this->Fail(WebSocketError::BadText);
  }
  this->Text += part;
  return true;
}

WebSocketReader::Event WebSocketReader::EndFrame()
{
  this->InPayload = false;
  this->HeadFilled = 0;
  this->HeadSize = 2;
  switch (this->Opcode)
  {
    case WebSocketOpcode::Ping:
      return Event::Ping;
    case WebSocketOpcode::Pong:
      return Event::Pong;
    case WebSocketOpcode::Close:
      return this->EndClose();
    default:
      return this->EndMessage();
  }
}

WebSocketReader::Event WebSocketReader::EndMessage()
{
  if (!this->IsLast || this->Skips || !this->IsText)
  {
    return Event::None;
  }
  if (!this->Utf8.IsWhole())
  {
    this->Fail(WebSocketError::BadText);
    return Event::Error;
  }
  this->IsDone = true;
  return Event::Text;
}

WebSocketReader::Event WebSocketReader::EndClose()
{
  this->Ended = true;
  this->Code = 0;
  if (this->ControlSize == 0)
  {
    return Event::Close;
  }
  const std::array<std::uint8_t, 2> status{ static_cast<std::uint8_t>(this->ControlBytes[0]),
    static_cast<std::uint8_t>(this->ControlBytes[1]) };
  this->Code = static_cast<std::uint16_t>(BigEndian(status.data(), status.size()));
  if (this->ControlSize == 1 || !MayBeSent(this->Code))
  {
    this->Fail(WebSocketError::Protocol);
    return Event::Error;
  }
  this->ControlBegin = 2;
  Utf8Check reason;
  if (!reason.Take(this->Control()) || !reason.IsWhole())
  {
    this->Fail(WebSocketError::BadText);
    return Event::Error;
  }
  return Event::Close;
}

WebSocketHead::WebSocketHead(WebSocketOpcode opcode, std::size_t bytes)
{
  const auto put = [this](std::uint64_t byte)
  { this->Filled[this->Size++] = static_cast<char>(static_cast<std::uint8_t>(byte)); };
  put(0x80u | static_cast<unsigned>(opcode));
  const unsigned extended = bytes < 126 ? 0 : bytes < 65536 ? 2 : 8;
  put(extended == 0 ? bytes : extended == 2 ? 126 : 127);
  for (unsigned left = extended; left > 0; --left)
  {
    put(std::uint64_t{ bytes } >> (8 * (left - 1)));
  }
}

std::string WriteCloseStatus(std::uint16_t status)
{
  return { static_cast<char>(status >> 8), static_cast<char>(status & 0xff) };
}

bool IsWebSocketKey(std::string_view text)
{
  constexpr std::string_view digits =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  return text.size() == 24 && text.ends_with("==") &&
         text.find_first_not_of(digits) == text.size() - 2;
}

// Section 4.2.2: the hash of the key and a text that the standard specifies.
std::string WebSocketAccept(std::string_view key)
{
  const auto text = std::string(key) + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";
  std::array<unsigned char, EVP_MAX_MD_SIZE> hash{};
  unsigned bytes = 0;
  if (EVP_Digest(text.data(), text.size(), hash.data(), &bytes, EVP_sha1(), nullptr) != 1)
  {
    throw std::bad_alloc();
  }
  std::array<unsigned char, 2 * EVP_MAX_MD_SIZE> base64{};
  const int written = EVP_EncodeBlock(base64.data(), hash.data(), static_cast<int>(bytes));
  return { base64.begin(), base64.begin() + written };
}

}
