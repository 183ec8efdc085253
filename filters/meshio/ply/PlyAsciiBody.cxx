// SPDX-License-Identifier: BSD-3-Clause
// Reads the records of ASCII PLY: words between blanks, with one record on a line, or all values of
// elements on one line. Also reads those of OFF, which may have comments. Part of step "read".
#include "filters/core/WithType.h"
#include "filters/meshio/NumberText.h"
#include "filters/meshio/QuotedText.h"
#include "filters/meshio/ply/PlyBody.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

namespace kdstream
{

namespace
{

// Longer words are not numbers.
constexpr std::size_t maximumWord = 4096;

bool IsSeparator(char c)
{
  return c == ' ' || c == '\n' || c == '\r' || c == '\t' || c == '\v' || c == '\f';
}

class AsciiBody : public PlyBody
{
public:
  AsciiBody(const PlyHeader& header, ByteSource& source)
    : Header(header)
    , Source(source)
    , Begin(source.Position())
  {
  }

  Status SkipRecords(const PlyElement& element, std::uint64_t first, std::uint64_t count) override;
  Result<bool> ReadPoints(const PlyElement& element, const std::array<std::size_t, 3>& coordinates,
    std::uint64_t first, std::uint64_t count, std::vector<Vec3>& points,
    PlyArraySink& arrays) override;
  Status ReadFaces(const PlyElement& element, std::size_t list, std::uint64_t first,
    std::uint64_t count, PlyFaceSink& sink, PlyArraySink& arrays) override;

private:
  Status NextWord(const PlyPlace& place, std::string_view& word);
  // Whether a word that begins with this character is a comment.
  bool IsComment(char c) const { return c == '#' && this->Header.hasComments; }
  Status SkipComment();
  template <class T>
  Status ReadNumber(const PlyPlace& place, const PlyProperty& property, T& value);
  Status ReadReal(const PlyPlace& place, const PlyProperty& property, double& value);
  Status ReadInteger(const PlyPlace& place, std::string_view what, std::int64_t& value);
  Status ReadListCount(const PlyPlace& place, const PlyProperty& property, std::int64_t& count);
  Status ReadCorners(const PlyPlace& place, const PlyProperty& property, PlyFaceSink& sink);
  Status SkipProperty(const PlyPlace& place, const PlyProperty& property);
  Status KeepOrSkip(const PlyPlace& place, std::size_t property, PlyArraySink& arrays);
  Status EndRecord(const PlyPlace& place, bool isSkipped);
  Status LookAtLines(const PlyPlace& place);
  // Looks for a line break in the blanks before a word.
  void PassBlanks(std::string_view blanks)
  {
    const bool breaks =
      this->Words > 0 && this->WordsOfFirstLine == 0 &&
      std::any_of(blanks.begin(), blanks.end(), [](char c) { return c == '\n' || c == '\r'; });
    this->WordsOfFirstLine = breaks ? this->Words : this->WordsOfFirstLine;
  }
  Error TooShort(const PlyPlace& place, std::uint64_t there, std::uint64_t all) const;
  PlyPlace At(const PlyPlace& place) const { return this->At(place, this->Source.Position()); }
  PlyPlace At(const PlyPlace& place, std::uint64_t byte) const;

  // What a line of the body is. Found out when a record and its line do not end together.
  enum class Lines
  {
    Unknown,
    Records, // one record each; further words are not read
    Free     // the values of whole elements
  };

  const PlyHeader& Header;
  ByteSource& Source;
  std::uint64_t Begin; // where the body begins
  Lines LinesAre = Lines::Unknown;
  // About the current record: the number of its words so far; how many of them are on its first
  // line (0 until it continues on another line); where its first byte is.
  std::uint64_t Words = 0, WordsOfFirstLine = 0, RecordBegin = 0;
};

// Adds to a place the number of the line in which this byte is, or which it ends. Counts by reading
// the file up to there, so this is only for errors that end the reading.
PlyPlace AsciiBody::At(const PlyPlace& place, std::uint64_t byte) const
{
  Result<ByteSource> again = this->Source.Again();
  std::uint64_t line = 1;
  bool afterReturn = false;
  for (std::uint64_t left = byte; again && left > 0;)
  {
    const Result<std::string_view> block = again->Peek(ByteSource::blockSize);
    if (!block || block->empty())
    {
      return place;
    }
    const std::string_view text =
      block->substr(0, static_cast<std::size_t>(std::min<std::uint64_t>(left, block->size())));
    for (const char c : text)
    {
      line += c == '\r' || (c == '\n' && !afterReturn) ? 1 : 0;
      afterReturn = c == '\r';
    }
    again->Consume(text.size());
    left -= text.size();
  }
  return again ? PlyPlace{ place.element, place.record, line } : place;
}

// The next word, on this line or a later one; the view is valid until the next call.
Status AsciiBody::NextWord(const PlyPlace& place, std::string_view& word)
{
  for (;;)
  {
    const Result<std::string_view> ahead = this->Source.Peek(maximumWord + 2);
    KDSTREAM_TRY(ahead);
    if (ahead->empty())
    {
      return place.Truncated(this->Source.Position());
    }
    const auto* begin = std::find_if_not(ahead->begin(), ahead->end(), IsSeparator);
    const auto blanks = static_cast<std::size_t>(begin - ahead->begin());
    this->PassBlanks(ahead->substr(0, blanks));
    this->Source.Consume(blanks);
    if (begin != ahead->end() && this->IsComment(*begin))
    {
      KDSTREAM_TRY(this->SkipComment());
      continue;
    }
    if (static_cast<std::size_t>(ahead->end() - begin) <= maximumWord + 1 &&
        begin != ahead->begin())
    {
      continue; // a word may be only partly in memory
    }
    const char* limit = begin + std::min<std::ptrdiff_t>(ahead->end() - begin, maximumWord + 1);
    const char* end = std::find_if(begin, limit, IsSeparator);
    word = std::string_view(begin, static_cast<std::size_t>(end - begin));
    if (word.size() > maximumWord)
    {
      return this->At(place).Bad(
        "a word of more than " + std::to_string(maximumWord) + " characters");
    }
    this->RecordBegin = this->Words++ == 0 ? this->Source.Position() : this->RecordBegin;
    this->Source.Consume(word.size());
    return {};
  }
}

// Skips to the end of the line.
Status AsciiBody::SkipComment()
{
  for (;;)
  {
    const Result<std::string_view> ahead = this->Source.Peek(1);
    KDSTREAM_TRY(ahead);
    const std::size_t end = std::min(ahead->find_first_of("\r\n"), ahead->size());
    this->Source.Consume(end);
    if (end < ahead->size() || ahead->empty())
    {
      return {};
    }
  }
}

// Reads a number of the property's type.
template <class T>
Status AsciiBody::ReadNumber(const PlyPlace& place, const PlyProperty& property, T& value)
{
  std::string_view word;
  KDSTREAM_TRY(this->NextWord(place, word));
  const NumberTextError error = ParsePlyNumber(word, value);
  if (error != NumberTextError::None)
  {
    return this->At(place).Bad(
      property.name + " " + QuotedText(word) +
      (error == NumberTextError::NotANumber ? " is not a number of type "
                                            : " is out of range of the type ") +
      std::string(PlyTypeName(property.type)) + DecimalCommaHint(word));
  }
  return {};
}

Status AsciiBody::ReadReal(const PlyPlace& place, const PlyProperty& property, double& value)
{
  return WithType(property.type,
    [&]<class T>()
    {
      T parsed{};
      Status status = this->ReadNumber(place, property, parsed);
      value = static_cast<double>(parsed);
      return status;
    });
}

// Reads a property that is not a coordinate; if it belongs to an array, keeps the value there.
Status AsciiBody::KeepOrSkip(const PlyPlace& place, std::size_t property, PlyArraySink& arrays)
{
  const PlyProperty& kept = place.element.properties[property];
  std::uint8_t* const to = arrays.PlaceOf(property);
  if (!to)
  {
    return this->SkipProperty(place, kept);
  }
  return WithType(kept.type,
    [&]<class T>()
    {
      T value{};
      Status status = this->ReadNumber(place, kept, value);
      std::memcpy(to, &value, sizeof(T));
      return status;
    });
}

// Reads a count or an index. It may exceed the range of its type: the list limits it more strictly.
Status AsciiBody::ReadInteger(const PlyPlace& place, std::string_view what, std::int64_t& value)
{
  std::string_view word;
  KDSTREAM_TRY(this->NextWord(place, word));
  const NumberTextError error = ParsePlyNumber(word, value);
  if (error != NumberTextError::None)
  {
    return this->At(place).Bad(
      std::string(what) + " " + QuotedText(word) +
      (error == NumberTextError::NotANumber ? " is not an integer" : " out of range"));
  }
  return {};
}

Status AsciiBody::ReadListCount(
  const PlyPlace& place, const PlyProperty& property, std::int64_t& count)
{
  KDSTREAM_TRY(this->ReadInteger(place, "list count", count));
  if (count < 0)
  {
    return this->At(place).BadListCount(property, count);
  }
  // Every value needs a blank and a digit.
  if (static_cast<std::uint64_t>(count) > this->Source.Remaining() / 2)
  {
    return place.ListPastEnd(property, count, this->Source.Position());
  }
  return {};
}

Status AsciiBody::SkipProperty(const PlyPlace& place, const PlyProperty& property)
{
  std::int64_t words = 1;
  if (property.isList)
  {
    KDSTREAM_TRY(this->ReadListCount(place, property, words));
  }
  std::string_view word;
  for (; words > 0; --words)
  {
    KDSTREAM_TRY(this->NextWord(place, word));
  }
  return {};
}

// The error for a record that continues into the next record's line. there: how many of its words
// are on its own line.
Error AsciiBody::TooShort(const PlyPlace& place, std::uint64_t there, std::uint64_t all) const
{
  const bool isPoint = place.element.name == "vertex" && place.element.properties.size() == 3;
  return Error{ ErrorCode::InvalidInput,
    this->At(place, this->RecordBegin).Name() + " has " + std::to_string(there) + " of its " +
      std::to_string(all) + (isPoint ? " coordinates" : " values") };
}

// Called after the last value that the header names. If each record has lines of its own, skips
// what the line has beyond these values; a line that already holds values of the next record is an
// error. If lines have no meaning in this file (Lines::Free), does nothing.
Status AsciiBody::EndRecord(const PlyPlace& place, bool isSkipped)
{
  const std::uint64_t all = std::exchange(this->Words, 0);
  const std::uint64_t ofFirstLine = std::exchange(this->WordsOfFirstLine, 0);
  bool isLong = false;
  while (this->LinesAre != Lines::Free)
  {
    const Result<std::string_view> ahead = this->Source.Peek(1);
    KDSTREAM_TRY(ahead);
    const auto* next = std::find_if(ahead->begin(), ahead->end(),
      [isLong](char c) { return c == '\n' || c == '\r' || !(isLong || IsSeparator(c)); });
    this->Source.Consume(static_cast<std::size_t>(next - ahead->begin()));
    if (ahead->empty() || (next != ahead->end() && IsSeparator(*next)))
    {
      return {};
    }
    if (next != ahead->end() && this->IsComment(*next))
    {
      KDSTREAM_TRY(this->SkipComment());
    }
    else if (next != ahead->end())
    {
      KDSTREAM_TRY(this->LookAtLines(place));
      isLong = this->LinesAre == Lines::Records;
      if (isLong && ofFirstLine > 0)
      {
        return this->TooShort(place, ofFirstLine, all);
      }
      if (isLong && !isSkipped && this->LongLines++ == 0 && this->FirstLong.empty())
      {
        this->FirstLong = this->At(place).Name();
      }
    }
  }
  return {};
}

// Called when a line goes on after its record. Counts the lines. If there are enough lines for all
// records, the lines have more values than the header names. If there are no more lines than
// elements, a line holds a whole element, or several. Errors: InvalidInput for a number of lines
// between these; InputOutput.
Status AsciiBody::LookAtLines(const PlyPlace& place)
{
  if (this->LinesAre != Lines::Unknown)
  {
    return {};
  }
  std::uint64_t records = 0;
  for (const PlyElement& element : this->Header.elements)
  {
    const std::uint64_t count = element.properties.empty() ? 0 : element.count;
    records += std::min(count, std::numeric_limits<std::uint64_t>::max() - records);
  }
  Result<ByteSource> again = this->Source.Again();
  KDSTREAM_TRY(again);
  again->Seek(this->Begin);
  std::uint64_t lines = 0;
  for (bool inLine = false; lines < records;)
  {
    const Result<std::string_view> block = again->Peek(ByteSource::blockSize);
    KDSTREAM_TRY(block);
    if (block->empty())
    {
      break;
    }
    for (const char c : *block)
    {
      const bool isEnd = c == '\n' || c == '\r';
      lines += !inLine && !IsSeparator(c) && !this->IsComment(c) ? 1 : 0;
      inLine = !isEnd && (inLine || !IsSeparator(c));
    }
    again->Consume(block->size());
  }
  if (lines > this->Header.elements.size() && lines < records)
  {
    return this->At(place).Bad("its line holds more values than the header names, and there are " +
                               std::to_string(lines) + " lines for " + std::to_string(records) +
                               " elements: the file was cut, or has lines of another kind");
  }
  this->LinesAre = lines < records ? Lines::Free : Lines::Records;
  return {};
}

Status AsciiBody::SkipRecords(const PlyElement& element, std::uint64_t first, std::uint64_t count)
{
  if (element.properties.empty())
  {
    return {};
  }
  for (std::uint64_t i = 0; i < count; ++i)
  {
    const PlyPlace place{ element, first + i };
    for (const PlyProperty& property : element.properties)
    {
      KDSTREAM_TRY(this->SkipProperty(place, property));
    }
    KDSTREAM_TRY(this->EndRecord(place, true));
  }
  return {};
}

Result<bool> AsciiBody::ReadPoints(const PlyElement& element,
  const std::array<std::size_t, 3>& coordinates, std::uint64_t first, std::uint64_t count,
  std::vector<Vec3>& points, PlyArraySink& arrays)
{
  for (std::uint64_t i = 0; i < count; ++i)
  {
    const PlyPlace place{ element, first + i };
    Vec3 point{};
    for (std::size_t p = 0; p < element.properties.size(); ++p)
    {
      const auto* wanted = std::find(coordinates.begin(), coordinates.end(), p);
      Status read = wanted == coordinates.end()
                      ? this->KeepOrSkip(place, p, arrays)
                      : this->ReadReal(place, element.properties[p],
                          point[static_cast<std::size_t>(wanted - coordinates.begin())]);
      KDSTREAM_TRY(read);
    }
    KDSTREAM_TRY(this->EndRecord(place, false));
    points.push_back(point);
    arrays.Append(1);
  }
  return false;
}

Status AsciiBody::ReadCorners(const PlyPlace& place, const PlyProperty& property, PlyFaceSink& sink)
{
  std::int64_t count = 0;
  KDSTREAM_TRY(this->ReadListCount(place, property, count));
  sink.Begin();
  for (; count > 0; --count)
  {
    std::int64_t index = 0;
    KDSTREAM_TRY(this->ReadInteger(place, "index", index));
    if (!sink.Add(index))
    {
      return this->At(place).BadIndex(index, sink);
    }
  }
  sink.End(place.record);
  return {};
}

Status AsciiBody::ReadFaces(const PlyElement& element, std::size_t list, std::uint64_t first,
  std::uint64_t count, PlyFaceSink& sink, PlyArraySink& arrays)
{
  for (std::uint64_t i = 0; i < count; ++i)
  {
    const PlyPlace place{ element, first + i };
    const std::size_t before = sink.GetTriangles().size();
    for (std::size_t p = 0; p < element.properties.size(); ++p)
    {
      const PlyProperty& property = element.properties[p];
      Status read =
        p == list ? this->ReadCorners(place, property, sink) : this->KeepOrSkip(place, p, arrays);
      KDSTREAM_TRY(read);
    }
    KDSTREAM_TRY(this->EndRecord(place, false));
    const std::size_t triangles = sink.GetTriangles().size() - before;
    sink.EndFace(before, triangles);
    if (!arrays.Append(triangles))
    {
      return this->At(place).RepeatsTooMuch();
    }
  }
  return {};
}

}

std::unique_ptr<PlyBody> MakePlyAsciiBody(const PlyHeader& header, ByteSource& source)
{
  return std::make_unique<AsciiBody>(header, source);
}

}
