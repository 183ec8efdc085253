// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/ConditionalRequest.h"

#include "filters/core/Texts.h"

#include <algorithm>
#include <cstdint>
#include <limits>

namespace kdstream
{

namespace
{

// Parses a number of digits only. A number that is too large for 64 bits becomes the largest one.
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

bool SameWord(std::string_view text, std::string_view lowerCase)
{
  return std::equal(text.begin(), text.end(), lowerCase.begin(), lowerCase.end(),
    [](char a, char b) { return (a >= 'A' && a <= 'Z' ? a - 'A' + 'a' : a) == b; });
}

// Parses a quality ("0", "1", "0.5", "1.000"), in thousandths; nothing if the text is not a
// quality.
std::optional<unsigned> ParseQuality(std::string_view text)
{
  if (text.empty() || (text[0] != '0' && text[0] != '1') || text.size() > 5 ||
      (text.size() > 1 && text[1] != '.'))
  {
    return std::nullopt;
  }
  unsigned quality = 0;
  for (std::size_t i = 0; i < 5; ++i)
  {
    if (i == 1)
    {
      continue;
    }
    const char digit = i < text.size() ? text[i] : '0';
    if (digit < '0' || digit > '9')
    {
      return std::nullopt;
    }
    quality = quality * 10 + static_cast<unsigned>(digit - '0');
  }
  return quality <= 1000 ? std::optional(quality) : std::nullopt;
}

struct WeightedCoding
{
  std::string_view name;
  unsigned quality = 1000; // in thousandths
};

// Parses an element such as "gzip;q=0.5".
std::optional<WeightedCoding> ParseCoding(std::string_view element)
{
  const auto semicolon = element.find(';');
  WeightedCoding coding{ Trimmed(element.substr(0, semicolon)) };
  if (semicolon == std::string_view::npos)
  {
    return coding;
  }
  const auto weight = Trimmed(element.substr(semicolon + 1));
  const auto quality =
    SameWord(weight.substr(0, 2), "q=") ? ParseQuality(weight.substr(2)) : std::nullopt;
  if (!quality)
  {
    return std::nullopt;
  }
  coding.quality = *quality;
  return coding;
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
    const auto close = rest.starts_with('"') ? rest.find('"', 1) : std::string_view::npos;
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
  if (first.empty()) // "-n" asks for the last n bytes
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

bool AcceptsGzip(std::string_view acceptEncoding)
{
  std::optional<unsigned> gzip, any;
  unsigned identity = 0;
  while (!acceptEncoding.empty())
  {
    const auto comma = acceptEncoding.find(',');
    const auto coding = ParseCoding(acceptEncoding.substr(0, comma));
    acceptEncoding.remove_prefix(
      comma == std::string_view::npos ? acceptEncoding.size() : comma + 1);
    if (!coding)
    {
      continue;
    }
    if (SameWord(coding->name, "gzip") || SameWord(coding->name, "x-gzip"))
    {
      gzip = coding->quality;
    }
    else if (SameWord(coding->name, "identity"))
    {
      identity = coding->quality;
    }
    else if (coding->name == "*")
    {
      any = coding->quality;
    }
  }
  const unsigned quality = gzip ? *gzip : any.value_or(0);
  return quality > 0 && quality >= identity;
}

}
