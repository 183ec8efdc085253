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
      this->Kinds.emplace(text, Told{ now });
    }
    catch (...) // no memory to remember it
    {
    }
    return text;
  }
  auto& told = found->second;
  if (now - told.at < pause)
  {
    ++told.untold;
    return std::nullopt;
  }
  if (told.untold != 0)
  {
    text += " (and " + std::to_string(told.untold) + " more times since the last message)";
  }
  told = { now };
  return text;
}

}
