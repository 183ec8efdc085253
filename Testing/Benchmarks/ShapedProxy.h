// SPDX-License-Identifier: BSD-3-Clause
// A line to a server that is as slow and as long as one wants: a TCP proxy on this machine, for
// programs that are run as a whole (in virtual time: SimulatedLine).
#pragma once

#include <cstdint>
#include <memory>

namespace kdstream::benchmarks
{

// What comes from the server leaves at `rate` bytes a second, all connections together, and
// arrives half a round trip later, as what goes to the server does, which has no limit. A new
// connection takes a round trip as well. At most 256 KiB wait for their turn; then the server is
// read no more, as a router's queue that is full would have it.
class ShapedProxy
{
public:
  struct Line
  {
    double rate = 0;      // bytes a second; 0: any
    double roundTrip = 0; // s
  };
  // Listens on a free port of 127.0.0.1 and connects to `server`, a port there, on a thread of its
  // own. Throws std::system_error where no port can be had.
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
