// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/PcdHeader.h"

#include "filters/core/Types.h"
#include "filters/meshio/NumberText.h"
#include "filters/meshio/QuotedText.h"
#include "filters/meshio/TextLines.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <optional>
#include <string>

namespace kdstream
{
namespace
{

constexpr std::uint64_t mostCount = 1 << 16; // values of one field
constexpr std::uint64_t mostFields = 4096;
// LZF, which compresses a PCD's body, makes at most 264 bytes of 3.
constexpr std::uint64_t mostExpansion = 88;

enum class PcdData
{
  Ascii,
  Binary,
  Compressed
};

Error MorePoints(const PcdHeader& header, std::uint64_t points)
{
  return { ErrorCode::InvalidInput, "the header claims " + std::to_string(header.points) +
                                      " points, but the body holds " + std::to_string(points) };
}

// PCL reads what the header claims, whatever follows. Less than a point may be padding.
Status CheckNoMore(const PcdHeader& header, std::uint64_t bytes)
{
  const std::uint64_t points = header.pointBytes > 0 ? bytes / header.pointBytes : header.points;
  return points > header.points ? Status(MorePoints(header, points)) : Status();
}

class HeaderReader
{
public:
  explicit HeaderReader(TextLines lines)
    : Lines(std::move(lines))
  {
  }

  // The lines to DATA, and where the body begins.
  Status Read()
  {
    for (;;)
    {
      const Result<bool> more = this->Lines.Next();
      KDSTREAM_TRY(more);
      if (!*more)
      {
        return Error{ ErrorCode::InvalidInput,
          this->Values.empty() ? "is not a PCD file" : "ends inside its header, before DATA" };
      }
      this->BodyBegin = this->Lines.End();
      std::vector<std::string_view> words;
      SplitWords(this->Lines.Line(), " \t\r", words);
      if (words.empty() || words[0][0] == '#')
      {
        continue;
      }
      KDSTREAM_TRY(this->AddLine(words));
      if (words[0] == "DATA")
      {
        return {};
      }
    }
  }

  Result<PcdHeader> Check(std::uint64_t fileSize) const
  {
    PcdHeader header;
    KDSTREAM_TRY(this->ComputePoints(header));
    std::uint64_t values = 0; // of one point
    KDSTREAM_TRY(this->ComputePointSize(header, values));
    header.values = values;
    const std::uint64_t body = fileSize > this->BodyBegin ? fileSize - this->BodyBegin : 0;
    const std::string& data = this->Values.at("DATA")[0];
    // The least that so many points take: a digit and a separator a value.
    const std::uint64_t least = data == "ascii" ? 2 * values : header.pointBytes;
    if (data != "binary_compressed" && header.points * least > body + 1)
    {
      return Error{ ErrorCode::InvalidInput,
        "the header claims " + std::to_string(header.points) + " points, at least " +
          std::to_string(header.points * least) + " bytes; there are " + std::to_string(body) };
    }
    if (data == "binary")
    {
      KDSTREAM_TRY(CheckNoMore(header, body));
    }
    header.textOfFloats = data == "ascii" && this->HasFloatPlaces();
    return header;
  }

  // PCL takes what is no number for zero, passes over lines that are too short, and does not look
  // behind the claimed points: goes through the lines of an ascii body. To be called after Read.
  Status CheckAsciiBody(const PcdHeader& header)
  {
    std::vector<std::string_view> words;
    std::uint64_t points = 0;
    while (points < header.points)
    {
      const Result<bool> more = this->Lines.Next();
      KDSTREAM_TRY(more);
      if (!*more)
      {
        return Error{ ErrorCode::InvalidInput, "the header claims " +
                                                 std::to_string(header.points) +
                                                 " points; there are " + std::to_string(points) };
      }
      SplitWords(this->Lines.Line(), " \t\r", words);
      if (words.empty())
      {
        continue;
      }
      if (words.size() != header.values)
      {
        return this->Lines.Wrong("has " + std::to_string(words.size()) + " numbers; a point has " +
                                 std::to_string(header.values));
      }
      for (const std::string_view word : words)
      {
        double value = 0;
        if (ParseNumber(word, value) != NumberTextError::None)
        {
          return this->Lines.Wrong(QuotedText(word) + " is no number");
        }
      }
      ++points;
    }
    return this->CheckNoMoreLines(header);
  }

  PcdData Data() const
  {
    const std::string& data = this->Values.at("DATA")[0];
    return data == "ascii"    ? PcdData::Ascii
           : data == "binary" ? PcdData::Binary
                              : PcdData::Compressed;
  }
  std::uint64_t Body() const { return this->BodyBegin; }

private:
  // Behind the claimed points.
  Status CheckNoMoreLines(const PcdHeader& header)
  {
    std::uint64_t points = header.points;
    for (;;)
    {
      const Result<bool> more = this->Lines.Next();
      KDSTREAM_TRY(more);
      if (!*more)
      {
        return points == header.points ? Status() : Status(MorePoints(header, points));
      }
      points += this->Lines.Line().find_first_not_of(" \t\r") != std::string_view::npos ? 1 : 0;
    }
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
    std::string key(words[0]);
    if (std::find(std::begin(known), std::end(known), key) == std::end(known))
    {
      return this->Values.empty() ? Error{ ErrorCode::InvalidInput, "is not a PCD file" }
                                  : this->Lines.Wrong(QuotedText(key) + " is unknown in a header");
    }
    key = key == "COLUMNS" ? "FIELDS" : key;
    // Were there two, PCL could take the other.
    if (this->Values.count(key) > 0)
    {
      return this->Lines.Wrong("a second " + key);
    }
    if (words.size() < 2 || words.size() > mostFields)
    {
      return this->Lines.Wrong(words.size() < 2 ? key + " has no value" : "too many fields");
    }
    if (key == "DATA" && words[1] != "ascii" && words[1] != "binary" &&
        words[1] != "binary_compressed")
    {
      return this->Lines.Wrong(
        "DATA is " + QuotedText(words[1]) + ", none of ascii, binary and binary_compressed");
    }
    this->Values[key].assign(words.begin() + 1, words.end());
    return {};
  }

  // The numbers of a line, nothing where there is no such line.
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
            key + " " + QuotedText(word) + " in the header is no count" };
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
    if (fields == this->Values.end() || sizes->empty() || types == this->Values.end())
    {
      return Error{ ErrorCode::InvalidInput, "the header lacks FIELDS, SIZE or TYPE" };
    }
    const std::size_t number = fields->second.size();
    if (sizes->size() != number || types->second.size() != number ||
        (!counts->empty() && counts->size() != number))
    {
      return Error{ ErrorCode::InvalidInput,
        "the header has " + std::to_string(number) +
          " FIELDS, but not as many values of SIZE, TYPE and COUNT" };
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
            QuotedText(type) + ", COUNT " + std::to_string(count) + " is no field" };
      }
      header.pointBytes += size * count;
      values += count;
    }
    return {};
  }

  TextLines Lines;
  std::map<std::string, std::vector<std::string>> Values;
  std::uint64_t BodyBegin = 0;
};

// The body of a compressed file begins with its two sizes.
Status CheckCompressedBody(ByteSource source, std::uint64_t begin, const PcdHeader& header)
{
  const Error cut{ ErrorCode::InvalidInput, "ends before its compressed points" };
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
    return Error{ ErrorCode::InvalidInput, "claims " + std::to_string(sizes[0]) +
                                             " bytes of compressed points; there are " +
                                             std::to_string(room) };
  }
  const std::uint64_t expected = header.points * header.pointBytes;
  KDSTREAM_TRY(CheckNoMore(header, sizes[1]));
  if (sizes[1] != expected || expected > std::uint64_t{ sizes[0] } * mostExpansion)
  {
    return Error{ ErrorCode::InvalidInput,
      "the header claims " + std::to_string(header.points) + " points, " +
        std::to_string(expected) + " bytes; " + std::to_string(sizes[0]) +
        " compressed ones that are said to hold " + std::to_string(sizes[1]) + " cannot be those" };
  }
  return {};
}

}

Result<PcdHeader> CheckPcdHeader(const std::filesystem::path& file)
{
  Result<ByteSource> source = ByteSource::Open(file);
  KDSTREAM_TRY(source);
  const std::uint64_t fileSize = source->Size();
  HeaderReader reader{ TextLines(std::move(*source)) };
  KDSTREAM_TRY(reader.Read());
  Result<PcdHeader> header = reader.Check(fileSize);
  if (header && reader.Data() == PcdData::Compressed)
  {
    Result<ByteSource> body = ByteSource::Open(file);
    const Status status = body ? CheckCompressedBody(std::move(*body), reader.Body(), *header)
                               : Status(body.GetError());
    KDSTREAM_TRY(status);
  }
  if (header && reader.Data() == PcdData::Ascii)
  {
    KDSTREAM_TRY(reader.CheckAsciiBody(*header));
  }
  return header;
}

}
