// SPDX-License-Identifier: BSD-3-Clause
#include "filters/protocol/TextParts.h"

namespace kdstream::protocol
{

std::vector<std::string_view> SplitPath(std::string_view path)
{
  std::vector<std::string_view> parts;
  for (;;)
  {
    const auto slash = path.find('/');
    parts.push_back(path.substr(0, slash));
    if (slash == std::string_view::npos)
    {
      return parts;
    }
    path.remove_prefix(slash + 1);
  }
}

std::optional<std::uint32_t> ParseDecimal(
  std::string_view text, std::uint32_t lowest, std::uint32_t highest)
{
  // Ten digits hold every 32-bit number and cannot overflow 64 bits.
  if (text.empty() || text.size() > 10 || (text[0] == '0' && text.size() > 1))
  {
    return std::nullopt;
  }
  std::uint64_t value = 0;
  for (const char c : text)
  {
    if (c < '0' || c > '9')
    {
      return std::nullopt;
    }
    value = value * 10 + static_cast<std::uint64_t>(c - '0');
  }
  if (value < lowest || value > highest)
  {
    return std::nullopt;
  }
  return static_cast<std::uint32_t>(value);
}

}
