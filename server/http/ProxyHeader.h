// SPDX-License-Identifier: BSD-3-Clause
// Reads what a proxy says about its client before the client's own bytes: the PROXY protocol,
// versions 1 and 2 (haproxy.org, proxy-protocol.txt). Internal to the server.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace kdstream
{

// Takes only the header's bytes from a connection, never a byte after it. Trusts none of them: it
// ends after mostBytes at the latest.
class ProxyHeader
{
public:
  static constexpr std::size_t mostBytes = 4096;

  // Where to read the next bytes: as many as the header certainly has; empty when it is complete,
  // or cannot become a header any more.
  std::span<char> Space();
  // Space has been filled.
  void Take();

  bool IsMalformed() const { return this->Malformed; }
  // The client's address; empty if the proxy speaks for itself, or gives none. Call it when the
  // header is complete.
  const std::string& Client() const { return this->Address; }

private:
  std::size_t Wanted() const;
  void ReadText();
  void ReadBinary();

  std::string Bytes;
  std::size_t Filled = 0; // of Bytes
  bool Malformed = false;
  std::string Address;
};

}
