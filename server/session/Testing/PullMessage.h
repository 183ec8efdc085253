// SPDX-License-Identifier: BSD-3-Clause
// For tests: a conversation without a socket, whose tasks run when its messages are pulled.
#pragma once

#include "server/session/Conversation.h"

#include <optional>

namespace kdstream
{

// The next message, or nothing until the conversation receives more. Reads at most one blob.
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
