// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/RareMessages.h"

#include <utility>

namespace kdstream
{

std::optional<std::string> RareMessages::Take(std::string_view message, Clock::time_point now)
{
  std::string text(message);
  const auto found = this->Kinds.find(message);
  if (found == this->Kinds.end())
  {
    if (this->Kinds.size() >= mostKinds)
    {
      this->Kinds.clear();
    }
    try
    {
      this->Kinds.emplace(text, Reported{ now });
    }
    catch (...) // no memory to remember the message
    {
    }
    return text;
  }
  auto& reported = found->second;
  if (now - reported.at < pause)
  {
    ++reported.unreported;
    return std::nullopt;
  }
  if (reported.unreported != 0)
  {
    text += " (and " + std::to_string(reported.unreported) + " more times since the last message)";
  }
  reported = { now };
  return text;
}

}
