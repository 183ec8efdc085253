// SPDX-License-Identifier: BSD-3-Clause
// What a proxy says of its client before the client's own bytes: the PROXY protocol, versions 1 and
// 2 (haproxy.org, proxy-protocol.txt). Internal to the server.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace kdstream
{

// Takes just the header's bytes off a connection, never one of what follows it. Trusts none of
// them: it ends after mostBytes at the latest.
class ProxyHeader
{
public:
  static constexpr std::size_t mostBytes = 4096;

  // Where the next bytes belong: as many as are sure to come, none when all are there, or once they
  // can no longer become a header.
  std::span<char> Space();
  // Space has been filled.
  void Take();

  bool IsMalformed() const { return this->Malformed; }
  // The client's address; empty where the proxy speaks for itself, or does not tell. Of a header
  // that is whole.
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
