// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/PcdHeader.h"

#include "filters/convert/BytesAfter.h"
#include "filters/convert/PointAttributes.h"
#include "filters/core/Types.h"
#include "filters/meshio/NumberText.h"
#include "filters/meshio/QuotedText.h"
#include "filters/meshio/TextLines.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <string>

namespace kdstream
{
namespace
{

constexpr std::uint64_t mostCount = 1 << 16; // numbers in one field of a point
constexpr std::uint64_t mostFields = 4096;
// LZF, which compresses PCD bodies, expands 3 bytes to at most 264.
constexpr std::uint64_t mostExpansion = 88;

// Case does not matter for keywords, types and encodings.
std::string InCase(std::string_view word, bool upper)
{
  std::string text(word);
  for (char& c : text)
  {
    const bool other = upper ? c >= 'a' && c <= 'z' : c >= 'A' && c <= 'Z';
    c = other ? static_cast<char>(c ^ ('a' ^ 'A')) : c;
  }
  return text;
}

// What a column of a text may hold. PCL cuts off decimals, and values that do not fit wrap around.
struct Column
{
  std::size_t field = 0;
  bool isWhole = false;       // a whole number
  double least = 0, most = 0; // its range
  bool takesNan = false;      // PCL reads it as 0

  bool Holds(double value) const
  {
    return !this->isWhole || (this->takesNan && std::isnan(value)) ||
           (value >= this->least && value <= this->most && value == std::floor(value));
  }
};

class HeaderReader
{
public:
  explicit HeaderReader(TextLines lines)
    : Lines(std::move(lines))
  {
  }

  // Reads the lines up to DATA, and finds where the body begins.
  Status Read()
  {
    for (;;)
    {
      const Result<bool> more = this->Lines.Next();
      KDSTREAM_TRY(more);
      if (!*more)
      {
        return this->Values.empty()
                 ? BadInput("is not a PCD file", Remedy::Rename)
                 : BadInput("ends inside its header, before DATA", Remedy::CopyAgain);
      }
      this->BodyBegin = this->Lines.End();
      std::vector<std::string_view> words;
      SplitWords(this->Lines.Line(), " \t\r", words);
      if (words.empty() || words[0][0] == '#')
      {
        continue;
      }
      KDSTREAM_TRY(this->AddLine(words));
      if (InCase(words[0], true) == "DATA")
      {
        this->NormalizeFields();
        return {};
      }
    }
  }

  Result<PcdHeader> Check(std::uint64_t fileSize) const
  {
    PcdHeader header;
    KDSTREAM_TRY(this->ComputePoints(header));
    std::uint64_t values = 0; // numbers of one point
    KDSTREAM_TRY(this->ComputePointSize(header, values));
    header.values = values;
    const std::uint64_t body = fileSize > this->BodyBegin ? fileSize - this->BodyBegin : 0;
    const std::string& data = this->Values.at("DATA")[0];
    // The minimum size of this number of points: a digit and a separator for each value.
    const std::uint64_t least = data == "ascii" ? 2 * values : header.pointBytes;
    if (data != "binary_compressed" && header.points * least > body + 1)
    {
      return BadInput("the header claims " + std::to_string(header.points) + " points, at least " +
                        std::to_string(header.points * least) + " bytes; there are " +
                        std::to_string(body),
        Remedy::CopyAgain);
    }
    header.bodyBegin = this->BodyBegin;
    header.hasViewpoint = this->HasViewpoint();
    header.data = data == "ascii"    ? PcdData::Ascii
                  : data == "binary" ? PcdData::Binary
                                     : PcdData::Compressed;
    header.textOfFloats = data == "ascii" && this->HasFloatPlaces();
    return header;
  }

  // Checks the lines of an ascii body, because PCL reads a word that is not a number as zero,
  // cuts off what does not fit a field, and skips lines that are too short. Returns the offset
  // after the claimed points, if the bytes there are not points. Call it after Read.
  Result<std::uint64_t> CheckAsciiBody(PcdHeader& header)
  {
    this->FindColumns();
    const std::uint64_t claimed = header.points;
    header.hasOddLines = this->Lines.EndWithReturns();
    std::vector<std::string_view> words;
    for (std::uint64_t points = 0;;)
    {
      const std::uint64_t begin = this->Lines.End();
      const Result<bool> more = this->Lines.Next();
      if (!more && points < claimed)
      {
        return more.GetError();
      }
      if (more && !*more && points < claimed)
      {
        return BadInput("the header claims " + std::to_string(claimed) + " points; there are " +
                          std::to_string(points),
          Remedy::CopyAgain);
      }
      if (!more || !*more)
      {
        this->TellPrecision(header);
        return begin;
      }
      SplitWords(this->Lines.Line(), " \t\r", words);
      if (words.empty())
      {
        continue;
      }
      if (words.front().starts_with('#') && points < claimed)
      {
        header.hasOddLines = true;
        continue;
      }
      if (Status read = this->CheckPoint(header, words); !read)
      {
        this->TellPrecision(header);
        return points < claimed ? Result<std::uint64_t>(read.GetError()) : begin;
      }
      if (++points > claimed)
      {
        header.tolerance.Count(
          Lapse::NotCounted, 1, "line " + std::to_string(this->Lines.Number()));
        header.points = points;
      }
    }
  }

  // For an ascii body: where the text ends, and how many zeros follow it.
  std::uint64_t TextEnd() const { return this->Lines.Size(); }
  std::uint64_t Padding() const { return this->Lines.Padding(); }

  // The header in the form that PCL reads.
  std::string Text(const PcdHeader& header) const
  {
    std::string text = "VERSION 0.7\n";
    for (const char* const key : { "FIELDS", "SIZE", "TYPE", "COUNT" })
    {
      text += key;
      const auto found = this->Values.find(key);
      const std::size_t fields = this->Values.at("FIELDS").size();
      for (std::size_t i = 0; i < fields; ++i)
      {
        text += " " + (found == this->Values.end() ? "1" : found->second[i]);
      }
      text += "\n";
    }
    const std::string points = std::to_string(header.points);
    return text + "WIDTH " + points + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + points +
           "\nDATA " + this->Values.at("DATA")[0] + "\n";
  }

private:
  Status CheckPoint(PcdHeader& header, const std::vector<std::string_view>& words)
  {
    if (words.size() != header.values)
    {
      return this->Lines.Wrong("has " + std::to_string(words.size()) + " numbers; a point has " +
                               std::to_string(header.values));
    }
    for (const std::size_t place : this->Places)
    {
      this->Precision.Add(words[place]);
    }
    for (std::size_t i = 0; i < words.size(); ++i)
    {
      double value = 0;
      if (ParseNumber(words[i], value) != NumberTextError::None)
      {
        return this->Lines.Wrong(
          QuotedText(words[i]) + " is not a number" + DecimalCommaHint(words[i]));
      }
      if (!this->Columns[i].Holds(value))
      {
        const std::size_t field = this->Columns[i].field;
        return this->Lines.Wrong(
          QuotedText(words[i]) + " is not a whole number that fits the field " +
          QuotedText(this->Values.at("FIELDS")[field]) + " (TYPE " +
          this->Values.at("TYPE")[field] + ", SIZE " + this->Values.at("SIZE")[field] + ")");
      }
      header.hasOddLines = header.hasOddLines || !WithPlainExponent(words[i]).empty() ||
                           !SpecialNumber(words[i]).empty();
    }
    return {};
  }

  // Changes "X" to x, unless there is a field x: letter case does not matter.
  void NormalizeFields()
  {
    static constexpr std::string_view known[] = { "x", "y", "z", "normal_x", "normal_y", "normal_z",
      "rgb", "rgba", "intensity", "curvature", "label" };
    std::vector<std::string>& fields = this->Values["FIELDS"];
    for (std::string& field : fields)
    {
      const std::string name = InCase(field, false);
      if (std::find(std::begin(known), std::end(known), name) != std::end(known) &&
          std::find(fields.begin(), fields.end(), name) == fields.end())
      {
        field = name;
      }
    }
    for (const char* const key : { "TYPE", "DATA" })
    {
      const auto found = this->Values.find(key);
      for (std::size_t i = 0; found != this->Values.end() && i < found->second.size(); ++i)
      {
        found->second[i] = InCase(found->second[i], found->first == "TYPE");
      }
    }
  }

  // Whether VIEWPOINT, a position and a quaternion with its real part first, is not the default.
  bool HasViewpoint() const
  {
    const auto found = this->Values.find("VIEWPOINT");
    for (std::size_t i = 0; found != this->Values.end() && i < found->second.size(); ++i)
    {
      double value = 0;
      if (ParseNumber(found->second[i], value) == NumberTextError::None &&
          value != (i == 3 ? 1.0 : 0.0))
      {
        return true;
      }
    }
    return false;
  }

  // Records whether floats would lose decimals.
  void TellPrecision(PcdHeader& header) const
  {
    header.textOfFloats = header.textOfFloats && !this->Precision.FloatsSuffice();
  }

  // Finds what the columns of a text hold, and which of them are x, y and z.
  void FindColumns()
  {
    const auto& fields = this->Values.at("FIELDS");
    const auto counts = this->Values.find("COUNT");
    std::size_t column = 0;
    for (std::size_t i = 0; i < fields.size(); ++i)
    {
      std::uint64_t count = 1;
      if (counts != this->Values.end())
      {
        ParseNumber(counts->second[i], count);
      }
      const bool isPlace = fields[i] == "x" || fields[i] == "y" || fields[i] == "z";
      if (isPlace)
      {
        this->Places.push_back(column);
      }
      this->Columns.insert(this->Columns.end(), count, this->ColumnOf(i, isPlace));
      column += count;
    }
    std::erase_if(this->Places, [column](std::size_t place) { return place >= column; });
  }

  Column ColumnOf(std::size_t field, bool isPlace) const
  {
    Column column;
    column.field = field;
    const std::string& type = this->Values.at("TYPE")[field];
    std::uint64_t size = 0;
    if (type != "F" && ParseNumber(this->Values.at("SIZE")[field], size) == NumberTextError::None)
    {
      const int bits = static_cast<int>(8 * size) - (type == "I" ? 1 : 0);
      column.isWhole = true;
      column.most = std::ldexp(1.0, bits) - 1;
      column.least = type == "I" ? -std::ldexp(1.0, bits) : 0;
      column.takesNan = !isPlace;
    }
    return column;
  }

  // Whether x, y and z are floats of four bytes.
  bool HasFloatPlaces() const
  {
    const auto& fields = this->Values.at("FIELDS");
    const auto &sizes = this->Values.at("SIZE"), &types = this->Values.at("TYPE");
    for (const char* const axis : { "x", "y", "z" })
    {
      const auto found = std::find(fields.begin(), fields.end(), axis);
      const auto i = static_cast<std::size_t>(found - fields.begin());
      if (found == fields.end() || types[i] != "F" || sizes[i] != "4")
      {
        return false;
      }
    }
    return true;
  }

  Status AddLine(const std::vector<std::string_view>& words)
  {
    static constexpr std::string_view known[] = { "VERSION", "FIELDS", "COLUMNS", "SIZE", "TYPE",
      "COUNT", "WIDTH", "HEIGHT", "VIEWPOINT", "POINTS", "DATA" };
    std::string key = InCase(words[0], true);
    if (std::find(std::begin(known), std::end(known), key) == std::end(known))
    {
      return this->Values.empty()
               ? BadInput("is not a PCD file", Remedy::Rename)
               : this->Lines.Wrong(QuotedText(words[0]) + " is unknown in a header");
    }
    key = key == "COLUMNS" ? "FIELDS" : key;
    // If the field occurred twice, PCL could take the other one.
    if (this->Values.count(key) > 0)
    {
      return this->Lines.Wrong("a second " + key);
    }
    if (words.size() < 2 || words.size() > mostFields)
    {
      return this->Lines.Wrong(words.size() < 2 ? key + " has no value" : "too many fields");
    }
    const std::string value = words.size() < 2 ? "" : InCase(words[1], false);
    if (key == "DATA" && value != "ascii" && value != "binary" && value != "binary_compressed")
    {
      return this->Lines.Wrong(
        "DATA is " + QuotedText(words[1]) + "; it must be ascii, binary or binary_compressed");
    }
    this->Values[key].assign(words.begin() + 1, words.end());
    return {};
  }

  // The numbers in the line of this keyword; nothing if there is no such line.
  Result<std::vector<std::uint64_t>> Numbers(const std::string& key) const
  {
    std::vector<std::uint64_t> numbers;
    const auto found = this->Values.find(key);
    if (found != this->Values.end())
    {
      for (const std::string& word : found->second)
      {
        std::uint64_t number = 0;
        if (ParseNumber(word, number) != NumberTextError::None)
        {
          return Error{ ErrorCode::InvalidInput,
            key + " " + QuotedText(word) + " in the header is not a count" };
        }
        numbers.push_back(number);
      }
    }
    return numbers;
  }

  Status ComputePoints(PcdHeader& header) const
  {
    std::optional<std::uint64_t> claims[3];
    const char* const keys[] = { "WIDTH", "HEIGHT", "POINTS" };
    for (std::size_t i = 0; i < 3; ++i)
    {
      const auto numbers = this->Numbers(keys[i]);
      KDSTREAM_TRY(numbers);
      if (!numbers->empty())
      {
        claims[i] = numbers->front();
      }
      if (claims[i] && *claims[i] >= noVertex)
      {
        return Error{ ErrorCode::LimitExceeded,
          std::string(keys[i]) + " " + std::to_string(*claims[i]) +
            " in the header; at most 4294967294 can be read" };
      }
    }
    if (!claims[0] && !claims[2])
    {
      return Error{ ErrorCode::InvalidInput, "the header has neither WIDTH nor POINTS" };
    }
    const std::uint64_t product = claims[0] ? *claims[0] * claims[1].value_or(1) : *claims[2];
    header.points = claims[2].value_or(product);
    if (header.points != product || product >= noVertex)
    {
      return Error{ ErrorCode::InvalidInput,
        "the header says POINTS " + std::to_string(header.points) + ", but WIDTH times HEIGHT is " +
          std::to_string(product) };
    }
    return {};
  }

  Status ComputePointSize(PcdHeader& header, std::uint64_t& values) const
  {
    const auto fields = this->Values.find("FIELDS");
    const auto sizes = this->Numbers("SIZE"), counts = this->Numbers("COUNT");
    const auto types = this->Values.find("TYPE");
    if (!sizes || !counts)
    {
      return !sizes ? sizes.GetError() : counts.GetError();
    }
    if (fields == this->Values.end() || fields->second.empty() || sizes->empty() ||
        types == this->Values.end())
    {
      return Error{ ErrorCode::InvalidInput, "the header lacks FIELDS, SIZE or TYPE" };
    }
    const std::size_t number = fields->second.size();
    if (sizes->size() != number || types->second.size() != number ||
        (!counts->empty() && counts->size() != number))
    {
      return Error{ ErrorCode::InvalidInput,
        "the header has " + std::to_string(number) +
          " FIELDS, but another number of values for SIZE, TYPE or COUNT" };
    }
    for (std::size_t i = 0; i < number; ++i)
    {
      const std::uint64_t size = (*sizes)[i], count = counts->empty() ? 1 : (*counts)[i];
      const std::string& type = types->second[i];
      const bool sound =
        (type == "F" && (size == 4 || size == 8)) ||
        ((type == "I" || type == "U") && (size == 1 || size == 2 || size == 4 || size == 8));
      if (!sound || count > mostCount)
      {
        return Error{ ErrorCode::InvalidInput,
          "field " + QuotedText(fields->second[i]) + ": SIZE " + std::to_string(size) + ", TYPE " +
            QuotedText(type) + ", COUNT " + std::to_string(count) + " is not a valid field" };
      }
      header.pointBytes += size * count;
      values += count;
    }
    return {};
  }

  TextLines Lines;
  std::map<std::string, std::vector<std::string>> Values;
  std::vector<Column> Columns;     // of a text
  std::vector<std::size_t> Places; // columns of x, y and z
  DecimalPrecision Precision;      // of the decimals of x, y and z
  std::uint64_t BodyBegin = 0;
};

// Checks a compressed body, which begins with its two sizes. Returns where it ends.
Result<std::uint64_t> CheckCompressedBody(ByteSource& source, PcdHeader& header)
{
  const std::uint64_t begin = header.bodyBegin;
  const Error cut = BadInput("ends before its compressed points", Remedy::CopyAgain);
  if (source.Size() < begin + 8)
  {
    return cut;
  }
  source.Seek(begin);
  const Result<std::string_view> bytes = source.Peek(8);
  KDSTREAM_TRY(bytes);
  std::uint32_t sizes[2] = {};
  if (bytes->size() < 8)
  {
    return cut;
  }
  std::memcpy(sizes, bytes->data(), 8);
  const std::uint64_t room = source.Size() - begin - 8;
  if (sizes[0] > room)
  {
    return BadInput("claims " + std::to_string(sizes[0]) +
                      " bytes of compressed points; there are " + std::to_string(room),
      Remedy::CopyAgain);
  }
  const std::uint64_t held = header.pointBytes > 0 ? sizes[1] / header.pointBytes : 0;
  if (held > header.points && held * header.pointBytes == sizes[1])
  {
    header.tolerance.Count(
      Lapse::NotCounted, held - header.points, "point " + std::to_string(header.points));
    header.points = held;
  }
  const std::uint64_t expected = header.points * header.pointBytes;
  if (sizes[1] != expected || expected > std::uint64_t{ sizes[0] } * mostExpansion)
  {
    return Error{ ErrorCode::InvalidInput,
      "the header claims " + std::to_string(header.points) + " points, " +
        std::to_string(expected) + " bytes, but says that its " + std::to_string(sizes[0]) +
        " compressed bytes hold " + std::to_string(sizes[1]) };
  }
  return begin + 8 + sizes[0];
}

}

Result<PcdHeader> CheckPcdHeader(const std::filesystem::path& file)
{
  Result<ByteSource> source = ByteSource::Open(file);
  KDSTREAM_TRY(source);
  Result<ByteSource> lines = source->Again();
  KDSTREAM_TRY(lines);
  HeaderReader reader{ TextLines(std::move(*lines)) };
  KDSTREAM_TRY(reader.Read());
  Result<PcdHeader> header = reader.Check(source->Size());
  KDSTREAM_TRY(header);
  std::uint64_t end = header->bodyBegin + header->points * header->pointBytes;
  if (header->data != PcdData::Binary)
  {
    const Result<std::uint64_t> after = header->data == PcdData::Ascii
                                          ? reader.CheckAsciiBody(*header)
                                          : CheckCompressedBody(*source, *header);
    KDSTREAM_TRY(after);
    end = *after;
  }
  const bool isText = header->data == PcdData::Ascii;
  const std::uint64_t size = isText ? std::max(end, reader.TextEnd()) : source->Size();
  header->tolerance.Count(
    Lapse::PaddedEnd, isText ? reader.Padding() : 0, "byte " + std::to_string(reader.TextEnd()));
  // Only a binary body can have whole points that the header does not count.
  const std::uint64_t pointBytes = header->data == PcdData::Binary ? header->pointBytes : 0;
  const auto more =
    CheckBytesAfter(*source, end, size, pointBytes, header->points, header->tolerance);
  KDSTREAM_TRY(more);
  header->points += *more;
  KDSTREAM_TRY(CheckPointCount(header->points));
  header->text = reader.Text(*header);
  return header;
}

}
