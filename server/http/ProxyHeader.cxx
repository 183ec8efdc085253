// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/ProxyHeader.h"

#include <boost/asio/ip/address.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace kdstream
{

namespace
{

using namespace std::string_view_literals;

constexpr auto binarySignature = "\r\n\r\n\0\r\nQUIT\n"sv;
constexpr auto textSignature = "PROXY "sv;
constexpr std::size_t mostText = 107;   // including the end of the line
constexpr std::size_t binaryHead = 16;  // signature, command, family, length
constexpr std::size_t bytesOfBoth = 12; // enough bytes to distinguish the versions

std::uint8_t ByteAt(std::string_view bytes, std::size_t place)
{
  return static_cast<std::uint8_t>(bytes[place]);
}

std::size_t LengthOf(std::string_view head)
{
  return std::size_t{ ByteAt(head, 14) } << 8 | ByteAt(head, 15);
}

template <class Address>
std::string AddressAt(std::string_view bytes, std::size_t place)
{
  typename Address::bytes_type raw;
  std::memcpy(raw.data(), bytes.data() + place, raw.size());
  return Address(raw).to_string();
}

bool IsPort(std::string_view text)
{
  std::uint16_t port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  return error == std::errc() && end == text.data() + text.size();
}

// Whether the text is an address of this family, "TCP4" or "TCP6".
bool IsAddress(std::string_view text, std::string_view family)
{
  boost::system::error_code error;
  const auto address = boost::asio::ip::make_address(std::string(text), error);
  return !error && (family == "TCP4" ? address.is_v4() : address.is_v6());
}

}

std::size_t ProxyHeader::Wanted() const
{
  const std::string_view bytes(this->Bytes.data(), this->Filled);
  if (bytes.size() < bytesOfBoth)
  {
    return bytesOfBoth - bytes.size();
  }
  if (bytes.starts_with(binarySignature))
  {
    const auto whole = bytes.size() < binaryHead ? binaryHead : binaryHead + LengthOf(bytes);
    return whole - bytes.size();
  }
  return bytes.ends_with("\r\n") ? 0 : 1; // only the end of the text shows its length
}

std::span<char> ProxyHeader::Space()
{
  const auto wanted = this->Malformed ? 0 : this->Wanted();
  this->Bytes.resize(this->Filled + wanted);
  return { this->Bytes.data() + this->Filled, wanted };
}

void ProxyHeader::Take()
{
  this->Filled = this->Bytes.size();
  const std::string_view bytes = this->Bytes;
  if (bytes.starts_with(binarySignature))
  {
    this->Malformed = bytes.size() >= binaryHead &&
                      (ByteAt(bytes, 12) >> 4 != 2 || binaryHead + LengthOf(bytes) > mostBytes);
    if (!this->Malformed && this->Wanted() == 0)
    {
      this->ReadBinary();
    }
  }
  else if (!bytes.starts_with(textSignature))
  {
    this->Malformed = true;
  }
  else if (bytes.ends_with("\r\n"))
  {
    this->ReadText();
  }
  else
  {
    this->Malformed = bytes.size() >= mostText;
  }
}

// Reads "PROXY TCP4 192.0.2.1 192.0.2.2 50000 443", or "PROXY UNKNOWN" and any text.
void ProxyHeader::ReadText()
{
  std::string_view rest = this->Bytes;
  rest.remove_prefix(textSignature.size());
  rest.remove_suffix(2);
  // The family, two addresses, one port, and the rest, which is the other port.
  std::array<std::string_view, 5> words;
  for (std::size_t i = 0; i + 1 < words.size(); ++i)
  {
    words[i] = rest.substr(0, rest.find(' '));
    rest.remove_prefix(std::min(rest.size(), words[i].size() + 1));
  }
  words.back() = rest;
  if (words[0] == "UNKNOWN")
  {
    return;
  }
  this->Malformed = (words[0] != "TCP4" && words[0] != "TCP6") || !IsAddress(words[1], words[0]) ||
                    !IsAddress(words[2], words[0]) || !IsPort(words[3]) || !IsPort(words[4]);
  this->Address = this->Malformed ? "" : std::string(words[1]);
}

void ProxyHeader::ReadBinary()
{
  namespace ip = boost::asio::ip;
  const std::string_view bytes = this->Bytes;
  const unsigned command = ByteAt(bytes, 12) & 0xfu, family = ByteAt(bytes, 13) >> 4;
  const auto length = LengthOf(bytes);
  constexpr std::size_t of4 = 12, of6 = 36; // two addresses and two ports
  constexpr unsigned local = 0, proxy = 1, ipv4 = 1, ipv6 = 2;
  this->Malformed =
    command > proxy || (family == ipv4 && length < of4) || (family == ipv6 && length < of6);
  if (this->Malformed || command == local)
  {
    return;
  }
  if (family == ipv4)
  {
    this->Address = AddressAt<ip::address_v4>(bytes, binaryHead);
  }
  else if (family == ipv6)
  {
    this->Address = AddressAt<ip::address_v6>(bytes, binaryHead);
  }
}

}
