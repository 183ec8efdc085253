// SPDX-License-Identifier: BSD-3-Clause
// The statements of a Wavefront OBJ file: see ObjStatements.h.
#include "filters/meshio/ObjStatements.h"

#include "filters/core/Texts.h"
#include "filters/meshio/NumberText.h"
#include "filters/meshio/QuotedText.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace kdstream
{

namespace
{

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
                                        ? " is not a number" + DecimalCommaHint(word)
                                        : std::string(" is too large a number")));
}

// Reads a number from 1 on, without a sign: nearly all corners are just this.
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

void MakeLower(std::string_view text, std::string& lower)
{
  lower.assign(text);
  for (char& c : lower)
  {
    c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
}

// Whether a name follows the keyword; in a name, # is an ordinary character. keyword: in lower
// case.
bool TakesName(std::string_view keyword)
{
  static constexpr std::array<std::string_view, 10> keywords{ "usemtl", "mtllib", "newmtl", "g",
    "o", "bump", "norm", "disp", "decal", "refl" };
  return keyword.starts_with("map_") ||
         std::find(keywords.begin(), keywords.end(), keyword) != keywords.end();
}

bool EndsInBackslash(std::string_view text)
{
  while (!text.empty() && IsBlank(text.back()))
  {
    text.remove_suffix(1);
  }
  return text.ends_with('\\');
}

// Whether a statement that ends in a backslash continues on the next line. isName: the statement
// takes a name. begin: where its last line begins.
bool GoesOn(std::string_view text, bool isName, std::size_t begin)
{
  const std::size_t backslash = text.rfind('\\');
  return isName ? backslash > 0 && IsBlank(text[backslash - 1])
                : FindComment(text.substr(begin)) == std::string_view::npos;
}

ObjKeyword KeywordOf(std::string_view word)
{
  static constexpr std::array<std::pair<std::string_view, ObjKeyword>, 18> mesh{ {
    { "v", ObjKeyword::Place },
    { "f", ObjKeyword::Face },
    { "vn", ObjKeyword::Normal },
    { "vt", ObjKeyword::TextureCoordinate },
    { "fo", ObjKeyword::Face },
    { "usemtl", ObjKeyword::Material },
    { "mtllib", ObjKeyword::Material },
    { "l", ObjKeyword::Curve },
    { "curv", ObjKeyword::Curve },
    { "curv2", ObjKeyword::Curve },
    { "surf", ObjKeyword::Curve },
    { "bsp", ObjKeyword::Curve },
    { "bzp", ObjKeyword::Curve },
    { "cdc", ObjKeyword::Curve },
    { "cdp", ObjKeyword::Curve },
    { "usemap", ObjKeyword::Picture },
    { "call", ObjKeyword::Call },
    { "csh", ObjKeyword::Call },
  } };
  // The other keywords of the format, old ones too.
  static constexpr std::array<std::string_view, 33> others{ "g", "o", "s", "p", "mg", "vp", "deg",
    "bmat", "step", "cstype", "parm", "trim", "hole", "scrv", "sp", "end", "con", "bevel",
    "c_interp", "d_interp", "lod", "shadow_obj", "trace_obj", "ctech", "stech", "maplib", "res",
    "rev", "group", "object", "color", "matlib", "version" };
  const auto* const found = std::find_if(
    mesh.begin(), mesh.end(), [word](const auto& known) { return known.first == word; });
  return found != mesh.end()                                             ? found->second
         : std::find(others.begin(), others.end(), word) != others.end() ? ObjKeyword::Other
                                                                         : ObjKeyword::Unknown;
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
    if (this->Text.starts_with("#MRGB "))
    {
      this->AsWritten = this->Folded = TakeWord(this->Text);
      this->Word = ObjKeyword::VertexColors;
      return true;
    }
    if (this->Text.empty() || this->Text[0] == '#')
    {
      continue;
    }
    if (EndsInBackslash(this->Text))
    {
      KDSTREAM_TRY(this->Join());
    }
    this->Understand();
    return true;
  }
}

// Appends the following lines as long as the last line ends with a backslash.
Status ObjStatements::Join()
{
  this->Joined = this->Text;
  bool isName = false;
  for (std::size_t begin = 0; EndsInBackslash(this->Joined);)
  {
    if (begin == 0)
    {
      std::string_view text = this->Joined;
      MakeLower(TakeWord(text), this->Lower);
      isName = TakesName(this->Lower);
    }
    if (!GoesOn(this->Joined, isName, begin))
    {
      break;
    }
    this->Joined.resize(this->Joined.rfind('\\'));
    const Result<bool> more = this->Lines.Next();
    KDSTREAM_TRY(more);
    if (!*more)
    {
      break;
    }
    std::string_view line = this->Lines.Line();
    if (this->Joined.empty())
    {
      TrimFront(line);
    }
    else
    {
      this->Joined += ' ';
    }
    begin = this->Joined.size();
    if (line.size() > longestStatement - std::min(begin, longestStatement))
    {
      return this->Lines.Wrong("is longer than " + std::to_string(longestStatement >> 20U) +
                               " MiB, together with the lines that it continues");
    }
    this->Joined += line;
  }
  this->Text = this->Joined;
  return {};
}

void ObjStatements::Understand()
{
  const auto takeKeyword = [this](std::string_view& text)
  {
    this->AsWritten = this->Folded = TakeWord(text);
    if (std::any_of(this->AsWritten.begin(), this->AsWritten.end(),
          [](char c) { return c >= 'A' && c <= 'Z'; }))
    {
      MakeLower(this->AsWritten, this->Lower);
      this->Folded = this->Lower;
    }
  };
  std::string_view rest = this->Text;
  takeKeyword(rest);
  if (const std::size_t comment = FindComment(this->Text);
      comment != std::string_view::npos && !TakesName(this->Folded))
  {
    rest = this->Text.substr(0, comment);
    takeKeyword(rest);
  }
  this->Text = rest;
  this->Word = KeywordOf(this->Folded);
}

void ObjPassedOver::Add(const ObjStatements& statements)
{
  this->Curves += statements.Keyword() == ObjKeyword::Curve ? 1 : 0;
  this->HasVertexColors = this->HasVertexColors || statements.Keyword() == ObjKeyword::VertexColors;
  const auto written = [&statements]
  {
    return QuotedText(std::string(statements.Written()) + " " +
                      std::string(Trimmed(statements.Rest(), " \t\r"))) +
           " in line " + std::to_string(statements.GetLines().Number());
  };
  if (statements.Keyword() == ObjKeyword::Call && this->FirstCall.empty())
  {
    this->FirstCall = written();
  }
  std::string_view rest = statements.Rest();
  if (statements.Keyword() == ObjKeyword::Picture && this->FirstPicture.empty() &&
      TakeWord(rest) != "off")
  {
    this->FirstPicture = written();
  }
  if (statements.Keyword() == ObjKeyword::Unknown && this->Unknown++ == 0)
  {
    this->FirstUnknown = QuotedText(statements.Written()) + " in line " +
                         std::to_string(statements.GetLines().Number());
  }
}

void ObjPassedOver::Name(std::vector<std::string>& notCarried) const
{
  if (this->Curves > 0)
  {
    notCarried.push_back(
      this->Curves == 1 ? "1 line, free-form curve or surface"
                        : std::to_string(this->Curves) + " lines and free-form curves or surfaces");
  }
  if (this->HasVertexColors)
  {
    notCarried.emplace_back("colours that ZBrush writes into comments (#MRGB)");
  }
  if (!this->FirstPicture.empty())
  {
    notCarried.push_back("pictures without a material: " + this->FirstPicture);
  }
  if (!this->FirstCall.empty())
  {
    notCarried.push_back("calls of other files or programs: " + this->FirstCall);
  }
  if (this->Unknown > 0)
  {
    notCarried.push_back(
      std::to_string(this->Unknown) +
      (this->Unknown == 1 ? " line that is not a statement of OBJ: "
                          : " lines that are not statements of OBJ: the first is ") +
      this->FirstUnknown);
  }
}

Status ParseObjPlace(std::string_view text, bool asFloats, ObjPlace& place, std::size_t colorsAt)
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
      else if (numbers >= colorsAt && numbers < colorsAt + 3)
      {
        place.color[numbers - colorsAt] = single;
      }
    }
    KDSTREAM_TRY(parsed);
    ++numbers;
  }
  if (numbers < 3 || numbers > most)
  {
    return Bad("a vertex of " + std::to_string(numbers) + " numbers");
  }
  place.colored = numbers >= colorsAt + 3;
  return {};
}

Status ParseObjTextureCoordinate(std::string_view text, std::array<float, 2>& values)
{
  values.fill(0);
  for (std::size_t k = 0; k < values.size(); ++k)
  {
    const std::string_view word = TakeWord(text);
    if (word.empty() && k > 0)
    {
      break;
    }
    const NumberTextError error = ParseNumber(word, values[k]);
    if (error == NumberTextError::NotANumber)
    {
      return Bad(word.empty() ? "has no numbers"
                              : QuotedText(word) + " is not a number" + DecimalCommaHint(word));
    }
    values[k] =
      error == NumberTextError::None ? values[k] : std::numeric_limits<float>::quiet_NaN();
  }
  return {};
}

Status ParseObjNormal(std::string_view text, std::array<float, 3>& values)
{
  constexpr std::size_t most = 4;
  std::size_t numbers = 0;
  for (std::string_view word = TakeWord(text); !word.empty(); word = TakeWord(text))
  {
    float value = 0;
    KDSTREAM_TRY(ParseReal(word, value));
    if (numbers < values.size())
    {
      values[numbers] = value;
    }
    ++numbers;
  }
  return numbers >= values.size() && numbers <= most
           ? Status()
           : Bad("has " + std::to_string(numbers) + " numbers");
}

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
        return Bad(QuotedText(number) + " is not the number of a " + objPartNames[part]);
      }
      corner[part] = none ? 0 : corner[part]; // no element has this number
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
