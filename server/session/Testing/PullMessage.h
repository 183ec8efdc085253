// SPDX-License-Identifier: BSD-3-Clause
// A conversation without a socket: its errands are done where its messages are pulled.
#pragma once

#include "server/session/Conversation.h"

#include <optional>

namespace kdstream
{

// The next message, or nothing until more is received; at most one blob is read.
inline std::optional<Conversation::Message> PullMessage(Conversation& talk)
{
  for (;;)
  {
    if (auto message = talk.NextMessage())
    {
      return message;
    }
    const auto errand = talk.TakeErrand();
    if (!errand)
    {
      return std::nullopt;
    }
    errand->Run();
    talk.Finish(errand);
  }
}

}
