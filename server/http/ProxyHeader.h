// SPDX-License-Identifier: BSD-3-Clause
// Reads the PROXY protocol's header (versions 1 and 2; haproxy.org, proxy-protocol.txt), in which a
// proxy names its client before the client's own bytes. Internal to the server.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace kdstream
{

// Takes only the header's bytes from a connection, never a byte after it. The bytes may come from
// anybody: at most mostBytes of them are read.
class ProxyHeader
{
public:
  static constexpr std::size_t mostBytes = 4096;

  // Where to put the next bytes: as many as the header certainly has. Empty when the header is
  // complete, or when the bytes can no longer become a header.
  std::span<char> Space();
  // Call this after filling Space().
  void Take();

  bool IsMalformed() const { return this->Malformed; }
  // The client's address; empty if the proxy speaks for itself, or gives no address. Call it when
  // the header is complete.
  const std::string& Client() const { return this->Address; }

private:
  std::size_t Wanted() const;
  void ReadText();
  void ReadBinary();

  std::string Bytes;
  std::size_t Filled = 0; // bytes of Bytes that are filled
  bool Malformed = false;
  std::string Address;
};

}
