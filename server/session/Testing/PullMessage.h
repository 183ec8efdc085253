// SPDX-License-Identifier: BSD-3-Clause
// A conversation without a socket: its tasks are done where its messages are pulled.
#pragma once

#include "server/session/Conversation.h"

#include <optional>

namespace kdstream
{

// The next message, or nothing until more is received; at most one blob is read.
inline std::optional<Conversation::Message> PullMessage(Conversation& conversation)
{
  for (;;)
  {
    if (auto message = conversation.NextMessage())
    {
      return message;
    }
    const auto task = conversation.TakeTask();
    if (!task)
    {
      return std::nullopt;
    }
    task->Run();
    conversation.Finish(task);
  }
}

}
