// SPDX-License-Identifier: BSD-3-Clause
// The statements of a Wavefront OBJ file: see ObjStatements.h.
#include "filters/meshio/ObjStatements.h"

#include "filters/meshio/NumberText.h"
#include "filters/meshio/QuotedText.h"

#include <algorithm>
#include <cmath>

namespace kdstream
{

namespace
{

constexpr std::size_t longestStatement = ByteSource::blockSize;

Error Bad(const std::string& what)
{
  return Error{ ErrorCode::InvalidInput, what };
}

template <class T>
Status ParseReal(std::string_view word, T& value)
{
  const NumberTextError error = ParseNumber(word, value);
  return error == NumberTextError::None
           ? Status()
           : Bad(QuotedText(word) + (error == NumberTextError::NotANumber
                                        ? " is not a number"
                                        : " is too large a number"));
}

// A number from 1 on, without a sign: nearly all corners are no more.
bool ParseSmall(std::string_view word, std::int64_t& number)
{
  constexpr std::size_t most = 10; // digits
  if (word.size() > most)
  {
    return false;
  }
  std::int64_t value = 0;
  for (const char c : word)
  {
    if (c < '0' || c > '9')
    {
      return false;
    }
    value = 10 * value + (c - '0');
  }
  number = value;
  return value > 0;
}

// Whether a name follows, in which # is a character like any other.
bool TakesName(std::string_view keyword)
{
  static constexpr std::array<std::string_view, 10> keywords{ "usemtl", "mtllib", "newmtl", "g",
    "o", "bump", "norm", "disp", "decal", "refl" };
  return keyword.starts_with("map_") ||
         std::find(keywords.begin(), keywords.end(), keyword) != keywords.end();
}

// The first # that is not part of a number such as 1.#QNAN.
std::size_t FindComment(std::string_view text)
{
  std::size_t at = text.find('#');
  while (at != std::string_view::npos && text.substr(0, at).ends_with("1."))
  {
    at = text.find('#', at + 1);
  }
  return at;
}

void TrimFront(std::string_view& text)
{
  std::size_t blanks = 0;
  while (blanks < text.size() && IsBlank(text[blanks]))
  {
    ++blanks;
  }
  text.remove_prefix(blanks);
}

}

Result<bool> ObjStatements::Next()
{
  for (;;)
  {
    Result<bool> more = this->Lines.Next();
    if (!more || !*more)
    {
      return more;
    }
    this->Text = this->Lines.Line();
    TrimFront(this->Text);
    if (this->Text.empty() || this->Text[0] == '#')
    {
      continue;
    }
    if (this->Text.back() == '\\')
    {
      KDSTREAM_TRY(this->Join());
    }
    this->Understand();
    return true;
  }
}

// Appends the next lines as long as the last one ends with a backslash.
Status ObjStatements::Join()
{
  this->Joined = this->Text;
  while (!this->Joined.empty() && this->Joined.back() == '\\')
  {
    this->Joined.back() = ' ';
    const Result<bool> more = this->Lines.Next();
    KDSTREAM_TRY(more);
    if (!*more)
    {
      break;
    }
    this->Joined += this->Lines.Line();
    if (this->Joined.size() > longestStatement)
    {
      return this->Lines.Wrong("is longer than 1 MiB, with those that it goes on from");
    }
  }
  this->Text = this->Joined;
  return {};
}

void ObjStatements::Understand()
{
  if (const std::size_t comment = FindComment(this->Text); comment != std::string_view::npos)
  {
    std::string_view rest = this->Text;
    this->Text = TakesName(TakeWord(rest)) ? this->Text : this->Text.substr(0, comment);
  }
  const std::string_view word = TakeWord(this->Text);
  this->Written = word;
  const auto isOneOf = [word](std::initializer_list<std::string_view> words)
  { return std::find(words.begin(), words.end(), word) != words.end(); };
  if (word == "v")
  {
    this->Word = ObjKeyword::Place;
  }
  else if (word == "f")
  {
    this->Word = ObjKeyword::Face;
  }
  else if (word == "vt")
  {
    this->Word = ObjKeyword::TextureCoordinate;
  }
  else if (word == "vn")
  {
    this->Word = ObjKeyword::Normal;
  }
  else
  {
    this->Word = isOneOf({ "usemtl", "mtllib" })             ? ObjKeyword::Material
                 : isOneOf({ "curv", "curv2", "surf", "l" }) ? ObjKeyword::Curve
                                                             : ObjKeyword::Other;
  }
}

Status ParseObjPlace(std::string_view text, bool asFloats, ObjPlace& place)
{
  constexpr std::size_t most = 8;
  std::size_t numbers = 0;
  place.colored = false;
  for (std::string_view word = TakeWord(text); !word.empty(); word = TakeWord(text))
  {
    Status parsed;
    float single = 0;
    if (numbers < 3 && !asFloats)
    {
      parsed = ParseReal(word, place.point[numbers]);
    }
    else
    {
      parsed = ParseReal(word, single);
      if (numbers < 3)
      {
        place.point[numbers] = double(single);
      }
      else if (numbers < 6)
      {
        place.color[numbers - 3] = single;
      }
    }
    KDSTREAM_TRY(parsed);
    ++numbers;
  }
  if (numbers < 3 || numbers > most)
  {
    return Bad("a vertex of " + std::to_string(numbers) + " numbers");
  }
  place.colored = numbers >= 6;
  return {};
}

template <std::size_t Wanted>
Status ParseObjNumbers(std::string_view text, std::size_t least, std::array<float, Wanted>& values)
{
  constexpr std::size_t most = 4;
  std::size_t numbers = 0;
  values.fill(0);
  for (std::string_view word = TakeWord(text); !word.empty(); word = TakeWord(text))
  {
    float value = 0;
    KDSTREAM_TRY(ParseReal(word, value));
    if (numbers < Wanted)
    {
      values[numbers] = value;
    }
    ++numbers;
  }
  return numbers >= least && numbers <= most ? Status()
                                             : Bad("has " + std::to_string(numbers) + " numbers");
}

template Status ParseObjNumbers(std::string_view, std::size_t, std::array<float, 2>&);
template Status ParseObjNumbers(std::string_view, std::size_t, std::array<float, 3>&);

Status ParseObjCorner(std::string_view word, ObjCorner& corner)
{
  corner = { 0, noCorner, noCorner };
  if (ParseSmall(word, corner[0]))
  {
    return {};
  }
  for (std::size_t part = 0; part < 3; ++part)
  {
    const std::size_t slash = std::min(word.find('/'), word.size());
    const std::string_view number = word.substr(0, slash);
    corner[part] = noCorner;
    if (part == 0 || !number.empty())
    {
      const NumberTextError error = ParseNumber(number, corner[part]);
      const bool none = error == NumberTextError::OutOfRange || corner[part] == noCorner;
      if (error == NumberTextError::NotANumber || (part == 0 && (none || corner[part] == 0)))
      {
        return Bad(QuotedText(number) + " is no number of a " + objPartNames[part]);
      }
      corner[part] = none ? 0 : corner[part]; // there are not as many
    }
    if (slash == word.size())
    {
      return {};
    }
    word.remove_prefix(slash + 1);
  }
  return Bad("a corner of more than three numbers");
}

ObjPart ResolveObjPart(std::int64_t number, std::uint64_t before, std::uint64_t all)
{
  if (number == noCorner)
  {
    return { 0, true };
  }
  const auto last = static_cast<std::int64_t>(before), count = static_cast<std::int64_t>(all);
  const bool exists = number != 0 && number <= count && number >= -last;
  return { exists ? static_cast<std::uint32_t>(number > 0 ? number : last + number + 1) : 0,
    exists };
}

}
