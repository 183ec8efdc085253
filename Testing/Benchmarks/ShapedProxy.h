// SPDX-License-Identifier: BSD-3-Clause
// A line to a server with any speed and delay: a TCP proxy on this machine, for programs that run
// as a whole. (SimulatedLine does this in virtual time.)
#pragma once

#include <cstdint>
#include <memory>

namespace kdstream::benchmarks
{

// Bytes from the server leave at `rate` bytes a second, for all connections together, and arrive
// half a round trip later. Bytes to the server are delayed in the same way, but their rate is not
// limited. A new connection takes a round trip, too. At most 256 KiB wait; then the proxy stops
// reading from the server, as if a router's queue were full.
class ShapedProxy
{
public:
  struct Line
  {
    double rate = 0;      // bytes a second; 0: no limit
    double roundTrip = 0; // s
  };
  // Listens on a free port of 127.0.0.1 and connects to the port `server` there, on a thread of its
  // own. Throws std::system_error if there is no free port.
  ShapedProxy(std::uint16_t server, const Line& line);
  ~ShapedProxy();
  ShapedProxy(const ShapedProxy&) = delete;
  ShapedProxy& operator=(const ShapedProxy&) = delete;

  std::uint16_t Port() const;

private:
  class Proxy;
  std::unique_ptr<Proxy> Kept;
};

}
