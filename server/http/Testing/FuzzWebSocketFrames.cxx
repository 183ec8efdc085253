// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer's entry to the reader of WebSocket frames. The first byte sets the size of the parts in
// which the other bytes arrive (0: all at once).
//
// For any input the events do not depend on the parts, and nothing follows a Close or an error. A
// message is at most as large as the limit and is UTF-8, and a control frame's payload has at most
// 125 bytes.
#include "server/http/WebSocketFrames.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <string>
#include <string_view>

using namespace kdstream;

namespace
{

constexpr std::size_t mostMessageBytes = 1000;

void Require(bool holds, const char* what)
{
  if (!holds)
  {
    std::cerr << "FuzzWebSocketFrames: broken: " << what << std::endl;
    std::abort();
  }
}

// The events in words, one after the other. partBytes: the size of the parts; 0: all bytes at once.
std::string EventsOf(std::string_view bytes, std::size_t partBytes)
{
  using Event = WebSocketReader::Event;
  WebSocketReader reader(mostMessageBytes);
  std::string events;
  bool hasEnded = false;
  while (!bytes.empty())
  {
    auto part = bytes.substr(0, partBytes == 0 ? bytes.size() : partBytes);
    bytes.remove_prefix(part.size());
    for (;;)
    {
      const auto event = reader.Take(part);
      if (event == Event::None)
      {
        Require(part.empty(), "bytes are left though more are needed");
        break;
      }
      Require(!hasEnded, "an event follows a Close or an error");
      events += std::to_string(static_cast<int>(event)) + ' ';
      if (event == Event::Text)
      {
        Require(reader.Message().size() <= mostMessageBytes, "a message is larger than the limit");
        Utf8Check check;
        Require(check.Take(reader.Message()) && check.IsWhole(), "a text is not UTF-8");
        events += reader.Message();
      }
      else if (event == Event::Close || event == Event::Error)
      {
        hasEnded = true;
        events += std::to_string(reader.Status()) + ' ';
      }
      if (event == Event::Ping || event == Event::Pong || event == Event::Close)
      {
        Require(reader.Control().size() <= 125, "a control frame is larger than 125 bytes");
        events += reader.Control();
      }
      events += '\n';
    }
  }
  return events;
}

}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  if (size == 0)
  {
    return 0;
  }
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  const auto whole = EventsOf(bytes, 0);
  Require(EventsOf(bytes, 1) == whole, "byte by byte other events");
  Require(EventsOf(bytes, data[0]) == whole, "other events by the parts");
  return 0;
}
