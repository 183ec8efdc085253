#include "server/http/ConditionalRequest.h"

#include <algorithm>
#include <cstdint>
#include <limits>

namespace kdstream
{

namespace
{

constexpr std::string_view spaces = " \t";

std::string_view Trimmed(std::string_view text)
{
  const auto first = text.find_first_not_of(spaces);
  if (first == std::string_view::npos)
  {
    return {};
  }
  return text.substr(first, text.find_last_not_of(spaces) - first + 1);
}

// Digits only; what is too large for 64 bits is as good as the largest.
std::optional<std::uint64_t> ParsePosition(std::string_view text)
{
  if (text.empty())
  {
    return std::nullopt;
  }
  constexpr auto most = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t value = 0;
  for (const char c : text)
  {
    if (c < '0' || c > '9')
    {
      return std::nullopt;
    }
    const auto digit = static_cast<std::uint64_t>(c - '0');
    value = value > (most - digit) / 10 ? most : value * 10 + digit;
  }
  return value;
}

}

bool NamesTag(std::string_view ifNoneMatch, std::string_view tag)
{
  auto rest = Trimmed(ifNoneMatch);
  if (rest == "*")
  {
    return true;
  }
  while (!rest.empty())
  {
    if (rest.substr(0, 2) == "W/")
    {
      rest.remove_prefix(2);
    }
    const auto close = rest.front() == '"' ? rest.find('"', 1) : std::string_view::npos;
    if (close == std::string_view::npos)
    {
      return false;
    }
    if (rest.substr(0, close + 1) == tag)
    {
      return true;
    }
    rest = Trimmed(rest.substr(close + 1));
    if (rest.empty() || rest.front() != ',')
    {
      return false;
    }
    rest = Trimmed(rest.substr(1));
  }
  return false;
}

RangeAnswer ParseRange(std::string_view range, std::size_t size)
{
  constexpr std::string_view unit = "bytes=";
  if (range.substr(0, unit.size()) != unit)
  {
    return WholeRange{};
  }
  const auto spec = Trimmed(range.substr(unit.size()));
  const auto dash = spec.find('-');
  if (dash == std::string_view::npos)
  {
    return WholeRange{};
  }
  const auto first = spec.substr(0, dash);
  const auto last = spec.substr(dash + 1);
  if (first.empty()) // the last n bytes
  {
    const auto count = ParsePosition(last);
    if (!count)
    {
      return WholeRange{};
    }
    const auto length = std::min<std::uint64_t>(*count, size);
    return length == 0 ? RangeAnswer(UnsatisfiableRange{})
                       : RangeAnswer(PartialRange{ static_cast<std::size_t>(size - length),
                           static_cast<std::size_t>(length) });
  }
  const auto begin = ParsePosition(first);
  const auto end = last.empty() ? std::numeric_limits<std::uint64_t>::max() : ParsePosition(last);
  if (!begin || !end || *begin > *end)
  {
    return WholeRange{};
  }
  if (*begin >= size)
  {
    return UnsatisfiableRange{};
  }
  const auto stop = std::min<std::uint64_t>(*end, size - 1);
  return PartialRange{ static_cast<std::size_t>(*begin),
    static_cast<std::size_t>(stop - *begin + 1) };
}

}
