// SPDX-License-Identifier: BSD-3-Clause
// Decides about decimal commas in VRML: see VrmlCommas.h. Steps:
// 1. find the numbers, and what separates them
// 2. count them in both readings
// 3. check whether they make complete values
// 4. check which reading is regular.
#include "filters/convert/VrmlCommas.h"

#include "filters/meshio/TextWords.h"

#include <algorithm>
#include <array>
#include <vector>

namespace kdstream
{
namespace
{

enum class CommaBetween : std::uint8_t
{
  Digits, // only a comma, between two digits
  Comma,  // a comma with blanks or line breaks
  Blank
};

bool IsCommaDigit(char c)
{
  return c >= '0' && c <= '9';
}

// The numbers of a field, separated as the format says.
class CommaNumbers
{
public:
  // False if a number has a point, or if a separator cannot occur beside decimal commas.
  bool Scan(std::string_view text, bool isList)
  {
    std::size_t at = 0;
    for (std::string_view before;;)
    {
      bool comma = false, blank = false;
      const std::size_t after = at;
      for (; at < text.size() && (IsBlank(text[at]) || text[at] == ',' || text[at] == '#'); ++at)
      {
        comma = comma || text[at] == ',';
        blank = blank || text[at] != ',' || (comma && at > after);
        if (text[at] == '#')
        {
          at = std::min(text.find_first_of("\r\n", at), text.size() - 1);
        }
      }
      const std::string_view word = text.substr(at, text.find_first_of(" \t\r\n,#[]{}\"", at) - at);
      const bool isNumber =
        !word.empty() && (IsCommaDigit(word[0]) || word[0] == '-' || word[0] == '+');
      if (word.empty() || (!isList && !isNumber))
      {
        return true;
      }
      if (word.find('.') != word.npos)
      {
        return false;
      }
      if (!before.empty())
      {
        const bool digits = comma && !blank && IsCommaDigit(before.back()) && IsCommaDigit(word[0]);
        if (comma && !blank && !(digits && this->TakeDecimals(before, word)))
        {
          return false;
        }
        this->Separators.push_back(digits  ? CommaBetween::Digits
                                   : comma ? CommaBetween::Comma
                                           : CommaBetween::Blank);
        this->Commas += digits ? 1 : 0;
      }
      before = word;
      at += word.size();
      this->Size = at;
      ++this->Count;
    }
  }

  std::size_t Count = 0, Commas = 0;    // numbers; commas that may be decimal ones
  bool HasZeros = false;                // after such a comma, a 0 and another digit
  std::size_t Size = 0;                 // of the text, in bytes
  std::vector<CommaBetween> Separators; // after each number except the last

  // Whether the separators between values, and at each position within values, are the same for all
  // values.
  bool IsRegular(std::size_t width, bool decimal) const
  {
    std::array<int, 16> ofPlace{};
    std::size_t place = 0;
    for (const CommaBetween separator : this->Separators)
    {
      if (decimal && separator == CommaBetween::Digits)
      {
        continue;
      }
      const int own = 1 + static_cast<int>(separator);
      int& first = ofPlace[place++ % width];
      first = first == 0 ? own : first;
      if (own != first)
      {
        return false;
      }
    }
    return true;
  }

  // Whether commas between digits occur only between values.
  bool SeparateValues(std::size_t width) const
  {
    for (std::size_t i = 0; i < this->Separators.size(); ++i)
    {
      if (this->Separators[i] == CommaBetween::Digits && i % width != width - 1)
      {
        return false;
      }
    }
    return true;
  }

private:
  // Whether "before,word" may be one number: it has no second comma, and an exponent only at its
  // end.
  bool TakeDecimals(std::string_view before, std::string_view word)
  {
    const bool second =
      !this->Separators.empty() && this->Separators.back() == CommaBetween::Digits;
    this->HasZeros = this->HasZeros || (word.size() > 1 && word[0] == '0' && IsCommaDigit(word[1]));
    return !second && before.find_first_not_of("0123456789", 1) == before.npos;
  }
};

}

VrmlCommaReading ReadVrmlCommas(std::string_view text, const VrmlNumbers& numbers)
{
  CommaNumbers found;
  if (!found.Scan(text, numbers.isList) || found.Commas == 0)
  {
    return {};
  }
  const std::size_t width = numbers.width, decimals = found.Count - found.Commas;
  const VrmlCommaReading decimal{ VrmlCommas::Decimal, found.Size };
  const std::size_t expected = numbers.isList ? numbers.all : width;
  if (found.Count == expected || decimals == expected)
  {
    return decimals == expected ? decimal : VrmlCommaReading{};
  }
  const bool fits = found.Count % width == 0, decimalsFit = decimals % width == 0;
  if (!decimalsFit || !numbers.isList)
  {
    return {};
  }
  if (!fits || found.HasZeros)
  {
    return decimal;
  }
  if (width > 1 && found.SeparateValues(width))
  {
    return {};
  }
  const bool regular = found.IsRegular(width, false);
  if (regular != found.IsRegular(width, true))
  {
    return regular ? VrmlCommaReading{} : decimal;
  }
  if (regular && width == 1 && numbers.all == 0)
  {
    return {}; // a list such as "10,20"
  }
  return !regular && 2 * found.Commas == found.Count ? decimal
                                                     : VrmlCommaReading{ VrmlCommas::Either, 0 };
}

}
