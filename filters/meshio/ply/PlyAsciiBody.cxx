// SPDX-License-Identifier: BSD-3-Clause
// ASCII PLY records: words between blanks, a record ends with its line. Part of step "read".
#include "filters/meshio/NumberText.h"
#include "filters/meshio/QuotedText.h"
#include "filters/meshio/ply/PlyBody.h"

#include <algorithm>
#include <cstring>

namespace kdstream
{

namespace
{

// Longer words are no numbers.
constexpr std::size_t maximumWord = 4096;

bool IsSeparator(char c)
{
  return c == ' ' || c == '\n' || c == '\r' || c == '\t' || c == '\v' || c == '\f';
}

class AsciiBody : public PlyBody
{
public:
  explicit AsciiBody(ByteSource& source)
    : Source(source)
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
  template <class T>
  Status ReadNumber(const PlyPlace& place, const PlyProperty& property, T& value);
  Status ReadReal(const PlyPlace& place, const PlyProperty& property, double& value);
  Status ReadInteger(const PlyPlace& place, std::string_view what, std::int64_t& value);
  Status ReadListCount(const PlyPlace& place, const PlyProperty& property, std::int64_t& count);
  Status ReadCorners(const PlyPlace& place, const PlyProperty& property, PlyFaceSink& sink);
  Status SkipProperty(const PlyPlace& place, const PlyProperty& property);
  Status KeepOrSkip(const PlyPlace& place, std::size_t property, PlyArraySink& arrays);
  Status EndRecord(const PlyPlace& place);

  ByteSource& Source;
};

// The next word, wherever it stands; the view holds until the next call.
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
    this->Source.Consume(static_cast<std::size_t>(begin - ahead->begin()));
    if (static_cast<std::size_t>(ahead->end() - begin) <= maximumWord + 1 &&
        begin != ahead->begin())
    {
      continue; // what is left in memory may be the beginning of a word only
    }
    const char* limit = begin + std::min<std::ptrdiff_t>(ahead->end() - begin, maximumWord + 1);
    const char* end = std::find_if(begin, limit, IsSeparator);
    word = std::string_view(begin, static_cast<std::size_t>(end - begin));
    if (word.size() > maximumWord)
    {
      return place.Bad("a word of more than " + std::to_string(maximumWord) + " characters");
    }
    this->Source.Consume(word.size());
    return {};
  }
}

// A number of the property's type.
template <class T>
Status AsciiBody::ReadNumber(const PlyPlace& place, const PlyProperty& property, T& value)
{
  std::string_view word;
  KDSTREAM_TRY(this->NextWord(place, word));
  const NumberTextError error = ParseNumber(word, value);
  if (error != NumberTextError::None)
  {
    return place.Bad(property.name + " " + QuotedText(word) +
                     (error == NumberTextError::NotANumber ? " is not a number of type "
                                                           : " is out of range of the type ") +
                     std::string(PlyTypeName(property.type)));
  }
  return {};
}

Status AsciiBody::ReadReal(const PlyPlace& place, const PlyProperty& property, double& value)
{
  return WithPlyType(property.type,
    [&]<class T>()
    {
      T parsed{};
      Status status = this->ReadNumber(place, property, parsed);
      value = static_cast<double>(parsed);
      return status;
    });
}

// A property that is no coordinate: into its array if it has one.
Status AsciiBody::KeepOrSkip(const PlyPlace& place, std::size_t property, PlyArraySink& arrays)
{
  const PlyProperty& kept = place.element.properties[property];
  std::uint8_t* const to = arrays.PlaceOf(property);
  if (!to)
  {
    return this->SkipProperty(place, kept);
  }
  return WithPlyType(kept.type,
    [&]<class T>()
    {
      T value{};
      Status status = this->ReadNumber(place, kept, value);
      std::memcpy(to, &value, sizeof(T));
      return status;
    });
}

// Counts and indices are not held to their property's type: a list bounds them more closely than
// that.
Status AsciiBody::ReadInteger(const PlyPlace& place, std::string_view what, std::int64_t& value)
{
  std::string_view word;
  KDSTREAM_TRY(this->NextWord(place, word));
  const NumberTextError error = ParseNumber(word, value);
  if (error != NumberTextError::None)
  {
    return place.Bad(
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
    return place.BadListCount(property, count);
  }
  // Every value takes a blank and a digit.
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

// A record ends with its line: more values than the header names would shift everything after them.
Status AsciiBody::EndRecord(const PlyPlace& place)
{
  for (;;)
  {
    const Result<std::string_view> ahead = this->Source.Peek(1);
    KDSTREAM_TRY(ahead);
    const auto* next = std::find_if(ahead->begin(), ahead->end(),
      [](char c) { return c == '\n' || c == '\r' || !IsSeparator(c); });
    this->Source.Consume(static_cast<std::size_t>(next - ahead->begin()));
    if (ahead->empty() || (next != ahead->end() && IsSeparator(*next)))
    {
      return {};
    }
    if (next != ahead->end())
    {
      return place.Bad("its line holds more values than the header names");
    }
  }
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
    KDSTREAM_TRY(this->EndRecord(place));
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
    KDSTREAM_TRY(this->EndRecord(place));
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
      return place.BadIndex(index, sink);
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
    KDSTREAM_TRY(this->EndRecord(place));
    const std::size_t triangles = sink.GetTriangles().size() - before;
    sink.EndFace(before, triangles);
    if (!arrays.Append(triangles))
    {
      return place.RepeatsTooMuch();
    }
  }
  return {};
}

}

std::unique_ptr<PlyBody> MakePlyAsciiBody(ByteSource& source)
{
  return std::make_unique<AsciiBody>(source);
}

}
