// SPDX-License-Identifier: BSD-3-Clause
// The header of a PLY file: elements, their properties, and where the body begins. Part of step
// "read".
#include "filters/meshio/ply/PlyHeader.h"

#include "filters/meshio/NumberText.h"
#include "filters/meshio/PlainText.h"
#include "filters/meshio/QuotedText.h"
#include "filters/meshio/TextLines.h"
#include "filters/meshio/TextWords.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <iterator>
#include <optional>
#include <set>
#include <utility>

namespace kdstream
{

namespace
{

struct TypeName
{
  std::string_view name;
  AttributeType type;
};

// The first name of each type is the one used in messages.
constexpr std::array<TypeName, 18> typeNames{ { { "char", AttributeType::Int8 },
  { "uchar", AttributeType::UInt8 }, { "short", AttributeType::Int16 },
  { "ushort", AttributeType::UInt16 }, { "int", AttributeType::Int32 },
  { "uint", AttributeType::UInt32 }, { "int64", AttributeType::Int64 },
  { "uint64", AttributeType::UInt64 }, { "float", AttributeType::Float32 },
  { "double", AttributeType::Float64 }, { "int8", AttributeType::Int8 },
  { "uint8", AttributeType::UInt8 }, { "int16", AttributeType::Int16 },
  { "uint16", AttributeType::UInt16 }, { "int32", AttributeType::Int32 },
  { "uint32", AttributeType::UInt32 }, { "float32", AttributeType::Float32 },
  { "float64", AttributeType::Float64 } } };

std::optional<AttributeType> FindType(std::string_view name)
{
  const auto* found = std::find_if(
    typeNames.begin(), typeNames.end(), [&](const TypeName& known) { return known.name == name; });
  return found == typeNames.end() ? std::nullopt : std::optional(found->type);
}

// Whether the name is fit for messages and lists, where names appear unchanged. Names of arrays may
// be escaped (PlyArrays).
bool IsGoodName(std::string_view name)
{
  return name.size() <= 1024 && std::none_of(name.begin(), name.end(),
                                  [](char c) { return (c >= 0 && c < ' ') || c == 0x7f; });
}

std::vector<std::string_view> WordsOf(std::string_view line)
{
  std::vector<std::string_view> words;
  SplitWords(line, " \t", words);
  return words;
}

// Returns the lines of the header one by one. The first line decides how lines end.
class LineReader
{
public:
  explicit LineReader(std::string_view bytes)
    : Bytes(bytes)
    , Terminator('\n')
  {
    const std::size_t next = bytes.find_first_not_of('\r', magic);
    if (next != bytes.npos && bytes[magic] == '\r' && bytes[next] != '\n')
    {
      this->Terminator = '\r';
    }
  }

  // Empty at the end: an unterminated line does not count.
  std::optional<std::string_view> Next()
  {
    const std::size_t end = this->Bytes.find(this->Terminator, this->Consumed);
    if (end == std::string_view::npos)
    {
      return std::nullopt;
    }
    std::string_view line = this->Bytes.substr(this->Consumed, end - this->Consumed);
    while (line.ends_with('\r')) // two if a program converted \n to \r\n twice
    {
      line.remove_suffix(1);
    }
    this->Consumed = end + 1;
    ++this->Number;
    return line;
  }

  std::size_t Position() const { return this->Consumed; }
  std::size_t LineNumber() const { return this->Number; }

private:
  static constexpr std::size_t magic = 3; // bytes of "ply"

  std::string_view Bytes;
  char Terminator;
  std::size_t Consumed = 0;
  std::size_t Number = 0;
};

// Takes the words of each line in turn, and builds the header.
class HeaderBuilder
{
public:
  Status AddLine(const std::vector<std::string_view>& words, std::size_t lineNumber)
  {
    this->Line = lineNumber;
    if (words.size() > 2 && words[0] == "comment" && words[1] == "TextureFile")
    {
      this->Header.textures.push_back(QuotedText(words[2]));
      const char* const end = words.back().data() + words.back().size();
      this->Header.textureFiles.emplace_back(words[2].data(), end);
    }
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info")
    {
      return {};
    }
    if (words[0] == "format")
    {
      return this->AddFormat(words);
    }
    if (words[0] == "element")
    {
      return this->AddElement(words);
    }
    if (words[0] == "property")
    {
      return this->AddProperty(words);
    }
    double number = 0;
    if (this->HasFormat && this->Header.elements.empty() &&
        ParseNumber(words.back(), number) == NumberTextError::NotANumber)
    {
      this->Header.strayLine =
        this->Header.strayLine.empty()
          ? QuotedText(words[0]) + " (header line " + std::to_string(lineNumber) + ")"
          : this->Header.strayLine;
      return {};
    }
    return this->Bad("unknown word " + QuotedText(words[0]));
  }

  Result<PlyHeader> Finish()
  {
    if (!this->HasFormat)
    {
      return Error{ ErrorCode::InvalidInput, "the header has no format line" };
    }
    return std::move(this->Header);
  }

private:
  Error Bad(const std::string& what) const
  {
    return Error{ ErrorCode::InvalidInput,
      "header line " + std::to_string(this->Line) + ": " + what };
  }

  Status AddFormat(const std::vector<std::string_view>& words)
  {
    if (this->HasFormat)
    {
      return this->Bad("a second format line");
    }
    if (words.size() != 3)
    {
      return this->Bad("a format line has a name and a version");
    }
    if (words[1] == "ascii")
    {
      this->Header.encoding = PlyEncoding::Ascii;
    }
    else if (words[1] == "binary_little_endian")
    {
      this->Header.encoding = PlyEncoding::BinaryLittleEndian;
    }
    else if (words[1] == "binary_big_endian")
    {
      this->Header.encoding = PlyEncoding::BinaryBigEndian;
    }
    else
    {
      return this->Bad("unknown format " + QuotedText(words[1]));
    }
    if (words[2] != "1.0")
    {
      return this->Bad("unknown version " + QuotedText(words[2]) + " (1.0 is known)");
    }
    this->HasFormat = true;
    return {};
  }

  Status AddElement(const std::vector<std::string_view>& words)
  {
    if (words.size() != 3)
    {
      return this->Bad("an element line has a name and a count");
    }
    if (!IsGoodName(words[1]))
    {
      return this->Bad(
        "the name " + QuotedText(words[1]) + " is too long or holds control characters");
    }
    PlyElement element;
    const std::string written = LowercaseText(words[1]);
    const std::string lower = written == "vertices" ? "vertex"
                              : written == "faces"  ? "face"
                                                    : written;
    const bool known = lower == "vertex" || lower == "face" || lower == "tristrips";
    element.name = known ? lower : std::string(words[1]);
    const char* end = words[2].data() + words[2].size();
    const auto parsed = std::from_chars(words[2].data(), end, element.count);
    if (parsed.ec != std::errc() || parsed.ptr != end)
    {
      return this->Bad("the count " + QuotedText(words[2]) + " of element " + QuotedText(words[1]) +
                       " is not a number from 0 to 2^64 - 1");
    }
    if (!this->ElementNames.insert(element.name).second)
    {
      return this->Bad("a second element " + QuotedText(words[1]));
    }
    this->Header.elements.push_back(std::move(element));
    return {};
  }

  Status AddProperty(const std::vector<std::string_view>& words)
  {
    if (this->Header.elements.empty())
    {
      return this->Bad("a property before the first element");
    }
    PlyElement& element = this->Header.elements.back();
    PlyProperty property;
    property.isList = words.size() > 1 && words[1] == "list";
    const std::size_t nameBegin = property.isList ? 4 : 2;
    // A name may contain blanks: "scalar_Scalar field".
    const std::string_view name =
      words.size() > nameBegin
        ? std::string_view(words[nameBegin].data(),
            static_cast<std::size_t>(
              words.back().data() + words.back().size() - words[nameBegin].data()))
        : words.back();
    if (!IsGoodName(name))
    {
      return this->Bad("the name " + QuotedText(name) + " is too long or holds control characters");
    }
    if (words.size() <= nameBegin)
    {
      return this->Bad(property.isList ? "a list property needs two types and a name"
                                       : "a property needs a type and a name");
    }
    if (property.isList)
    {
      const std::optional<AttributeType> countType = FindType(words[2]);
      if (!countType)
      {
        return this->Bad("unknown type " + QuotedText(words[2]));
      }
      property.countType = *countType;
    }
    const std::string_view typeName = words[nameBegin - 1];
    const std::optional<AttributeType> type = FindType(typeName);
    if (!type)
    {
      return this->Bad("unknown type " + QuotedText(typeName));
    }
    property.type = *type;
    property.name = name;
    element.properties.push_back(std::move(property));
    return {};
  }

  PlyHeader Header;
  bool HasFormat = false;
  std::size_t Line = 0;
  std::set<std::string> ElementNames;
};

}

std::string_view PlyTypeName(AttributeType type)
{
  return typeNames[static_cast<std::size_t>(type)].name;
}

std::size_t PlyElement::Find(std::string_view property) const
{
  const auto found = std::find_if(this->properties.begin(), this->properties.end(),
    [&](const PlyProperty& known) { return known.name == property; });
  return static_cast<std::size_t>(std::distance(this->properties.begin(), found));
}

bool IsNameOfCorners(std::string_view property)
{
  const std::string name = LowercaseText(property);
  return name == "vertex_indices" || name == "vertex_index" || name == "vertex_indexes";
}

std::size_t PlyElement::FindCorners() const
{
  const auto isCorners = [](const PlyProperty& property) { return IsNameOfCorners(property.name); };
  const auto isIndices = [](const PlyProperty& property)
  { return property.isList && IsInteger(property.type); };
  const auto& all = this->properties;
  auto found = std::find_if(all.begin(), all.end(), isCorners);
  if (found == all.end() && std::count_if(all.begin(), all.end(), isIndices) == 1)
  {
    found = std::find_if(all.begin(), all.end(), isIndices);
  }
  return static_cast<std::size_t>(std::distance(all.begin(), found));
}

Result<PlyHeader> ReadPlyHeader(ByteSource& source)
{
  Result<std::string_view> bytes = source.Peek(ByteSource::blockSize);
  KDSTREAM_TRY(bytes);
  if (bytes->empty())
  {
    return BadInput("the file is empty", Remedy::CopyAgain);
  }
  if (IsWideText(*bytes))
  {
    return WideTextError();
  }
  if (bytes->starts_with(utf8Mark))
  {
    source.Consume(utf8Mark.size());
    bytes = bytes->substr(utf8Mark.size());
  }
  LineReader lines(*bytes);
  const std::optional<std::string_view> first = lines.Next();
  if (!first || WordsOf(*first) != std::vector<std::string_view>{ "ply" })
  {
    return BadInput("not a PLY file: its first line is not 'ply'", Remedy::Rename);
  }
  HeaderBuilder builder;
  while (const std::optional<std::string_view> line = lines.Next())
  {
    const std::vector<std::string_view> words = WordsOf(*line);
    if (words.size() == 1 && words[0] == "end_header")
    {
      source.Consume(lines.Position());
      return builder.Finish();
    }
    KDSTREAM_TRY(builder.AddLine(words, lines.LineNumber()));
  }
  return bytes->size() < ByteSource::blockSize
           ? BadInput("truncated: the header has no end_header line", Remedy::CopyAgain)
           : Error{ ErrorCode::InvalidInput, "the header has no end_header line in the first MiB" };
}

}
