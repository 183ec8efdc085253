// SPDX-License-Identifier: BSD-3-Clause
// Reads STL files in chunks: see StlReader.h.
#include "filters/meshio/StlReader.h"

#include "filters/core/CutPolygon.h"
#include "filters/meshio/ContentFormat.h"
#include "filters/meshio/DroppedPoints.h"
#include "filters/meshio/MakeRoom.h"
#include "filters/meshio/NumberText.h"
#include "filters/meshio/PlainText.h"
#include "filters/meshio/QuotedText.h"
#include "filters/meshio/TextWords.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <span>

namespace kdstream
{

namespace
{

constexpr std::uint64_t mostStlVertices = noVertex - 1;
constexpr std::size_t headerBytes = 84;  // 80 bytes of anything, then the number of triangles
constexpr std::size_t facetBytes = 50;   // normal, three places, two bytes
constexpr std::size_t placeBytes = 12;   // also of the normal, which comes first
constexpr std::size_t facetBatch = 1024; // facets decoded together, to stay in caches
constexpr std::uint64_t facetsPerReport = 1 << 16;

Error AtFacet(std::uint64_t facet, const std::string& what)
{
  return Error{ ErrorCode::InvalidInput, "facet " + std::to_string(facet) + ": " + what };
}

// The common part of both encodings: the triangles, whose corners are consecutive numbers, and the
// first error.
class StlReader : public MeshReader
{
public:
  const MeshFileInfo& Info() const override { return this->FileInfo; }

  Result<std::size_t> ReadVertices(Mesh& mesh, std::size_t limit) override
  {
    mesh.scalarType = this->FileInfo.scalarType;
    if (this->Failure)
    {
      return *this->Failure;
    }
    const auto number = static_cast<std::size_t>(
      std::min<std::uint64_t>(limit, this->FileInfo.vertices - this->VerticesRead));
    if (Status read = this->ReadPoints(mesh.points, number); !read)
    {
      this->Failure = read.GetError();
      return *this->Failure;
    }
    // Replaces -0.0 by 0.0, because welding joins only corners with equal bits.
    for (Vec3& point : std::span(mesh.points).last(number))
    {
      point = { point[0] + 0.0, point[1] + 0.0, point[2] + 0.0 };
    }
    this->VerticesRead += number;
    return number;
  }

  Result<std::size_t> ReadTriangles(Mesh& mesh, std::size_t limit) override
  {
    mesh.scalarType = this->FileInfo.scalarType;
    if (this->Failure)
    {
      return *this->Failure;
    }
    const auto number = static_cast<std::size_t>(
      std::min<std::uint64_t>(limit, this->FileInfo.faces - this->TrianglesRead));
    MakeRoom(mesh.triangles, number); // facets were counted, or the file has room for them
    for (std::size_t i = 0; i < number; ++i)
    {
      const auto first = static_cast<VertexId>(3 * this->TrianglesRead++);
      mesh.triangles.push_back({ first, first + 1, first + 2 });
    }
    return number;
  }

  Result<std::uint64_t> SkipFaces(std::uint64_t count) override
  {
    const std::uint64_t number = std::min(count, this->FileInfo.faces - this->TrianglesRead);
    this->TrianglesRead += number;
    return number;
  }

  bool KnowsFinite() const override { return this->Finite; }
  bool CountsNotFinite() const override { return true; }
  std::uint64_t FileSize() const override { return this->Source.Size(); }
  std::uint64_t Position() const override { return this->Source.Position(); }

protected:
  explicit StlReader(ByteSource source)
    : Source(std::move(source))
  {
    this->FileInfo.soup = true;
  }

  Status SetFacets(std::uint64_t facets)
  {
    if (facets > mostStlVertices / 3)
    {
      return Error{ ErrorCode::LimitExceeded, std::to_string(facets) + " triangles; " +
                                                std::to_string(mostStlVertices / 3) +
                                                " are the most that can be read" };
    }
    this->FileInfo.vertices = 3 * facets;
    this->FileInfo.faces = facets;
    this->FileInfo.mostTriangles = facets;
    return {};
  }

  // Appends the next `number` vertices, which exist. If one vertex of a facet is not finite, all of
  // them become NaN, so that the facet is dropped whole.
  virtual Status ReadPoints(std::vector<Vec3>& points, std::size_t number) = 0;

  // Counts a vertex of a facet that is not finite.
  void CountNotFinite(std::size_t vertex, std::uint64_t facet)
  {
    this->Finite = false;
    Tolerance& tolerance = this->FileInfo.tolerance;
    constexpr Lapse kind = Lapse::PointNotFinite;
    tolerance.Count(kind, 1,
      tolerance.Of(kind) > 0
        ? std::string()
        : "vertex " + std::to_string(vertex) + " of facet " + std::to_string(facet));
  }

  ByteSource Source;
  MeshFileInfo FileInfo;
  std::uint64_t VerticesRead = 0;
  std::uint64_t TrianglesRead = 0;
  bool Finite = true; // whether all vertices read so far are
  std::optional<Error> Failure;
};

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr Vec3 notFinite{ nan, nan, nan };

std::uint32_t LoadLittle(const char* bytes)
{
  std::uint32_t value = 0;
  std::memcpy(&value, bytes, sizeof(value));
  return std::endian::native == std::endian::little ? value : __builtin_bswap32(value);
}

// Whether these can be the bytes of a triangle.
bool LooksLikeFacet(std::string_view bytes)
{
  if (bytes.size() < facetBytes)
  {
    return false;
  }
  for (std::size_t k = 3; k < 12; ++k) // the normal may be anything
  {
    constexpr double least = 1e-30, most = 1e30;
    const double value =
      std::abs(static_cast<double>(std::bit_cast<float>(LoadLittle(bytes.data() + 4 * k))));
    if (value != 0 && !(value >= least && value <= most))
    {
      return false;
    }
  }
  return true;
}

class BinaryStlReader : public StlReader
{
public:
  BinaryStlReader(ByteSource source, std::uint64_t facets)
    : StlReader(std::move(source))
    , Facets(facets)
  {
  }

  // counted: the number of facets that the header counts.
  Status Start(std::uint32_t counted)
  {
    if (counted != this->Facets)
    {
      this->FileInfo.tolerance.Count(Lapse::NotCounted, this->Facets,
        "byte " + std::to_string(headerBytes) + ", where the header counts " +
          std::to_string(counted) +
          ", because the program that wrote it did not know the number yet: all are read");
    }
    KDSTREAM_TRY(this->LookAtHeader());
    KDSTREAM_TRY(this->CheckBytesAfterEnd());
    this->Source.Seek(headerBytes);
    return this->SetFacets(this->Facets);
  }

  Result<std::uint64_t> SkipVertices(std::uint64_t count) override
  {
    const std::uint64_t number = std::min(count, this->FileInfo.vertices - this->VerticesRead);
    this->VerticesRead += number;
    this->Source.Seek(headerBytes + this->VerticesRead / 3 * facetBytes);
    return number;
  }

private:
  Status ReadPoints(std::vector<Vec3>& points, std::size_t number) override;
  Status LookAtHeader();
  Status CheckBytesAfterEnd();
  // Reports the two bytes after each facet, which some programs use for a colour.
  void LookAtAttributes(const char* bytes, std::size_t count);
  // Puts the vertices of `count` facets into Batch; false if one is not finite.
  bool Decode(const char* bytes, std::size_t count);
  // Finds facets in Batch with a vertex that is not finite, and sets all values of such a facet to
  // NaN. Counts only the vertices [first, last) of Batch. facet: the number in the file of the
  // first facet in Batch.
  void SpreadNotFinite(std::uint64_t facet, std::size_t first, std::size_t last);

  std::uint64_t Facets;
  bool HasAttributes = false; // whether attribute bytes were reported
  std::array<Vec3, 3 * facetBatch> Batch;
};

Status BinaryStlReader::ReadPoints(std::vector<Vec3>& points, std::size_t number)
{
  MakeRoom(points, number); // the file had the bytes when it was opened
  for (std::uint64_t vertex = this->VerticesRead, end = vertex + number; vertex < end;)
  {
    // The source stands at the facet that has this vertex.
    const Result<std::string_view> ahead = this->Source.Peek(facetBytes);
    KDSTREAM_TRY(ahead);
    if (ahead->size() < facetBytes)
    {
      return BadInput("truncated: facet " + std::to_string(vertex / 3) + " of " +
                        std::to_string(this->Facets) + " expected at byte " +
                        std::to_string(this->Source.Position()),
        Remedy::CopyAgain);
    }
    const auto first = static_cast<std::size_t>(vertex % 3);
    const auto last = static_cast<std::size_t>(std::min<std::uint64_t>(
      3 * std::min(ahead->size() / facetBytes, facetBatch), first + (end - vertex)));
    if (!this->Decode(ahead->data(), (last + 2) / 3))
    {
      this->SpreadNotFinite(vertex / 3, first, last);
    }
    const auto* const begin = this->Batch.begin();
    points.insert(points.end(), begin + first, begin + last);
    this->LookAtAttributes(ahead->data(), (last + 2) / 3);
    this->Source.Consume(last / 3 * facetBytes);
    vertex += last - first;
  }
  return {};
}

// Looks for the colour of the whole object, which Materialise's programs write into the header.
Status BinaryStlReader::LookAtHeader()
{
  this->Source.Seek(0);
  const Result<std::string_view> header = this->Source.Peek(headerBytes);
  KDSTREAM_TRY(header);
  if (header->find("COLOR=") != header->npos)
  {
    this->FileInfo.ignoredAttributes.emplace_back("the colour in the header (COLOR=)");
  }
  return {};
}

void BinaryStlReader::LookAtAttributes(const char* bytes, std::size_t count)
{
  for (std::size_t i = 1; i <= count && !this->HasAttributes; ++i)
  {
    if (bytes[i * facetBytes - 2] != 0 || bytes[i * facetBytes - 1] != 0)
    {
      this->HasAttributes = true;
      this->FileInfo.ignoredAttributes.emplace_back(
        "attribute bytes of triangles (colours, mostly)");
    }
  }
}

bool BinaryStlReader::Decode(const char* bytes, std::size_t count)
{
  bool finite = true;
  for (std::size_t i = 0; i < count; ++i)
  {
    for (std::size_t corner = 0; corner < 3; ++corner)
    {
      const char* const place = bytes + i * facetBytes + (corner + 1) * placeBytes;
      for (std::size_t k = 0; k < 3; ++k)
      {
        const auto value = static_cast<double>(std::bit_cast<float>(LoadLittle(place + 4 * k)));
        this->Batch[3 * i + corner][k] = value;
        finite &= std::isfinite(value);
      }
    }
  }
  return finite;
}

void BinaryStlReader::SpreadNotFinite(std::uint64_t facet, std::size_t first, std::size_t last)
{
  for (std::size_t begin = 0; begin < last; begin += 3)
  {
    Vec3* const corners = this->Batch.data() + begin;
    if (std::all_of(corners, corners + 3, IsFinite))
    {
      continue;
    }
    for (std::size_t i = std::max(begin, first); i < std::min(begin + 3, last); ++i)
    {
      if (!IsFinite(this->Batch[i]))
      {
        this->CountNotFinite(i % 3, facet + i / 3);
      }
    }
    std::fill(corners, corners + 3, notFinite);
    this->Finite = false; // also if the bad vertex is in another read
  }
}

// Counts the bytes after the last facet that the header counts.
Status BinaryStlReader::CheckBytesAfterEnd()
{
  constexpr std::uint64_t mostPadding = 4096;
  const std::uint64_t end = headerBytes + facetBytes * this->Facets;
  const std::uint64_t rest = this->Source.Size() - end;
  if (rest == 0)
  {
    return {};
  }
  this->Source.Seek(end);
  const Result<std::string_view> bytes =
    this->Source.Peek(static_cast<std::size_t>(std::min(rest, mostPadding)));
  KDSTREAM_TRY(bytes);
  const bool zeros = rest <= mostPadding && bytes->find_first_not_of('\0') == bytes->npos;
  const bool facets = !zeros && rest % facetBytes == 0 && LooksLikeFacet(*bytes);
  this->FileInfo.tolerance.Count(zeros    ? Lapse::PaddedEnd
                                 : facets ? Lapse::NotCounted
                                          : Lapse::BytesAfterEnd,
    facets ? rest / facetBytes : rest,
    "byte " + std::to_string(end) + ", after the " + std::to_string(this->Facets) +
      " triangles that the header counts" + (facets ? "; only these are read" : ""));
  return {};
}

bool IsWord(std::string_view word, std::string_view small)
{
  return word.size() == small.size() &&
         std::equal(word.begin(), word.end(), small.begin(),
           [](char c, char expected)
           { return (c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c) == expected; });
}

// Whether the words after "facet" are those with which a facet begins.
bool GoesOnAsFacet(std::string_view rest)
{
  const std::string_view first = TakeWord(rest);
  if (IsWord(first, "outerloop"))
  {
    return true;
  }
  if (IsWord(first, "outer"))
  {
    const std::string_view loop = TakeWord(rest);
    return loop.empty() || IsWord(loop, "loop");
  }
  if (!IsWord(first, "normal"))
  {
    return false;
  }
  for (int k = 0; k < 3; ++k)
  {
    TakeWord(rest);
  }
  const std::string_view outer = TakeWord(rest);
  return IsWord(outer, "outer") || IsWord(outer, "outerloop");
}

// Where the name of a solid ends: at the end of its line (npos), or before the next facet or solid
// in the same line.
std::size_t EndOfName(std::string_view line, bool isEnd)
{
  std::size_t solid = std::string_view::npos;
  std::string_view rest = line;
  for (std::string_view word = TakeWord(rest); !word.empty(); word = TakeWord(rest))
  {
    const auto at = static_cast<std::size_t>(word.data() - line.data());
    solid = solid == std::string_view::npos && IsWord(word, "solid") ? at : solid;
    if (IsWord(word, "facet") && GoesOnAsFacet(rest))
    {
      return isEnd ? solid : at;
    }
  }
  return std::string_view::npos;
}

bool AreThreeNumbers(std::string_view rest)
{
  double value = 0;
  for (int k = 0; k < 3; ++k)
  {
    if (ParseNumber(TakeWord(rest), value) != NumberTextError::None)
    {
      return false;
    }
  }
  return true;
}

// The first word of skipped text that belongs to a facet, whose beginning is then damaged; empty if
// there is none. A single "outer" or "vertex" does not count, because a solid may have this name.
std::string_view WordOfFacet(std::string_view text)
{
  for (std::string_view word = TakeWord(text); !word.empty(); word = TakeWord(text))
  {
    std::string_view rest = text;
    const bool isVertex = IsWord(word, "vertex") && AreThreeNumbers(rest);
    const bool isOuter = IsWord(word, "outer") && IsWord(TakeWord(rest), "loop");
    if (isVertex || isOuter || IsWord(word, "outerloop") || IsWord(word, "endloop") ||
        IsWord(word, "endfacet"))
    {
      return word;
    }
  }
  return {};
}

// Whether a word that stands where a facet could begin is not part of the format, such as "color".
bool IsForeignWord(std::string_view word)
{
  constexpr std::size_t most = 40;
  constexpr std::string_view own[] = { "normal", "outer", "outerloop", "loop", "vertex", "endloop",
    "endfacet" };
  const bool isName =
    !word.empty() && word.size() <= most &&
    (word[0] == '#' || (word[0] >= 'a' && word[0] <= 'z') || (word[0] >= 'A' && word[0] <= 'Z'));
  return isName && std::none_of(std::begin(own), std::end(own),
                     [&](std::string_view each) { return IsWord(word, each); });
}

// Where reading the text continues: the next vertex, and its facet.
struct TextState
{
  bool inSolid = false;
  bool inFacet = false;
  std::size_t corner = 0; // the next corner of the facet
  std::uint64_t facet = 0;
  // Counts so far: solids without an end, unknown words, facets of fewer than three vertices, and
  // the triangles of all other facets.
  std::uint64_t endless = 0, foreign = 0, small = 0, triangles = 0;
  std::string firstForeign{}, firstSmall{};
  std::uint64_t after = 0; // bytes from a Ctrl-Z on, after the last solid
};

class TextStlReader : public StlReader
{
public:
  explicit TextStlReader(ByteSource source)
    : StlReader(std::move(source))
    , Words(this->Source)
  {
  }

  // The first pass: collects what Info returns, and checks that the text is well formed.
  Status Start(const Execution& execution);

private:
  Status ReadPoints(std::vector<Vec3>& points, std::size_t number) override;
  // Goes to the next facet; false at the end of the text.
  Result<bool> NextFacet();
  // Goes to the coordinates of the facet's next vertex; false after the facet's end.
  Result<bool> NextVertex();
  // Skips the text between facets: true at the end of the text, or where a facet begins.
  Result<bool> PassBetween();
  // Skips a name or a remark, up to the facet that follows it, or to the end of the line. It is an
  // error if this would skip a facet: the error then names `word`, or if that is empty the word of
  // the facet.
  Status SkipName(bool isEnd, const std::string& word = {});
  Status BeginFacet();
  Status ReadFacet();
  // The next word; "end solid" is returned as "endsolid".
  Result<std::string_view> NextWord();
  Status Expect(std::string_view expected);
  // The words that may stand between facets.
  const char* Between() const { return this->At.inSolid ? "'facet' or 'endsolid'" : "'solid'"; }
  Error Unexpected(std::string_view word, const std::string& expected) const;
  template <class T>
  Status ReadPoint(Vec3& point);

  TextWords Words;
  TextState At;
  std::vector<Vec3> Facet;   // the corners of the last facet that was read
  PolygonCutter Cutter;      // cuts the facet's polygon
  std::vector<Vec3> Corners; // of the facet's triangles, for ReadPoints
  std::size_t Given = 0;     // corners given so far
};

Error TextStlReader::Unexpected(std::string_view word, const std::string& expected) const
{
  if (word.empty())
  {
    return BadInput("truncated: facet " + std::to_string(this->At.facet) + ": " + expected +
                      " expected at byte " + std::to_string(this->Source.Size()),
      Remedy::CopyAgain);
  }
  return AtFacet(this->At.facet, QuotedText(word) + " where " + expected +
                                   " is expected, before byte " +
                                   std::to_string(this->Words.Position()));
}

Result<std::string_view> TextStlReader::NextWord()
{
  Result<std::string_view> word = this->Words.Next();
  if (!word || !IsWord(*word, "end"))
  {
    return word;
  }
  word = this->Words.Next();
  KDSTREAM_TRY(word);
  for (const std::string_view whole : { "endloop", "endfacet", "endsolid" })
  {
    if (IsWord(*word, whole.substr(3)))
    {
      return whole;
    }
  }
  return this->Unexpected(*word, "'loop', 'facet' or 'solid'");
}

Status TextStlReader::Expect(std::string_view expected)
{
  const Result<std::string_view> word = this->NextWord();
  KDSTREAM_TRY(word);
  return IsWord(*word, expected) ? Status()
                                 : this->Unexpected(*word, "'" + std::string(expected) + "'");
}

Status TextStlReader::SkipName(bool isEnd, const std::string& word)
{
  const Result<std::string_view> line = this->Words.RestOfLine();
  KDSTREAM_TRY(line);
  const std::size_t end = EndOfName(*line, isEnd);
  if (const std::string_view lost = WordOfFacet(line->substr(0, end)); !lost.empty())
  {
    return this->Unexpected(word.empty() ? lost : word, this->Between());
  }
  if (end == std::string_view::npos)
  {
    return this->Words.SkipLine();
  }
  this->Words.Skip(end);
  return {};
}

Result<bool> TextStlReader::PassBetween()
{
  Result<std::string_view> word = this->NextWord();
  KDSTREAM_TRY(word);
  const bool isBetween = !this->At.inSolid && this->At.facet > 0;
  if (isBetween && word->starts_with('\x1A')) // the end of a DOS text file
  {
    this->At.after = this->Source.Size() - (this->Words.Position() - word->size());
    return true;
  }
  if (isBetween && word->starts_with(utf8Mark)) // from joining two files
  {
    word->remove_prefix(utf8Mark.size());
  }
  const bool isSolid = IsWord(*word, "solid"), isEnd = IsWord(*word, "endsolid");
  const bool endsHere = this->At.inSolid && (word->empty() || isSolid) && this->At.facet > 0;
  this->At.endless += endsHere ? 1 : 0;
  if (word->empty() && (endsHere || !this->At.inSolid))
  {
    return true;
  }
  if (this->At.inSolid ? isEnd || (isSolid && endsHere) : isSolid)
  {
    this->At.inSolid = !isEnd;
    KDSTREAM_TRY(this->SkipName(isEnd));
    return false;
  }
  if (this->At.inSolid && IsWord(*word, "facet"))
  {
    KDSTREAM_TRY(this->BeginFacet());
    return true;
  }
  const bool isBefore = !this->At.inSolid && this->At.facet == 0;
  if (isBefore || isSolid || isEnd || IsWord(*word, "facet") || !IsForeignWord(*word))
  {
    return this->Unexpected(*word, this->Between());
  }
  const std::string foreign(*word);
  if (this->At.foreign++ == 0)
  {
    this->At.firstForeign =
      QuotedText(foreign) + ", before byte " + std::to_string(this->Words.Position());
  }
  KDSTREAM_TRY(this->SkipName(false, foreign));
  return false;
}

// Reads what follows "facet". The normal is ignored, so it need not be numbers.
Status TextStlReader::BeginFacet()
{
  static constexpr std::array<std::string_view, 6> begin{ "normal", "", "", "", "outer", "loop" };
  bool isOuter = false;
  for (const std::string_view expected : begin)
  {
    if (isOuter && expected != "loop")
    {
      continue; // there is no normal
    }
    const Result<std::string_view> next = this->Words.Next();
    KDSTREAM_TRY(next);
    if ((expected == "outer" || expected == "normal") && IsWord(*next, "outerloop"))
    {
      break;
    }
    isOuter = expected == "normal" && IsWord(*next, "outer");
    if (isOuter)
    {
      continue;
    }
    if (next->empty() || (!expected.empty() && !IsWord(*next, expected)))
    {
      return this->Unexpected(
        *next, expected.empty() ? "a normal" : "'" + std::string(expected) + "'");
    }
  }
  this->At.inFacet = true;
  this->At.corner = 0;
  return {};
}

Result<bool> TextStlReader::NextFacet()
{
  for (bool passed = false; !passed;)
  {
    const Result<bool> between = this->PassBetween();
    KDSTREAM_TRY(between);
    passed = *between;
  }
  return this->At.inFacet;
}

// Goes to the next vertex of the loop, which may have any number of vertices.
Result<bool> TextStlReader::NextVertex()
{
  const Result<std::string_view> word = this->NextWord();
  KDSTREAM_TRY(word);
  if (IsWord(*word, "vertex"))
  {
    ++this->At.corner;
    return true;
  }
  if (!IsWord(*word, "endloop"))
  {
    return this->Unexpected(*word, this->At.corner < 3 ? "'vertex'" : "'endloop'");
  }
  KDSTREAM_TRY(this->Expect("endfacet"));
  this->At.inFacet = false;
  if (this->At.corner >= 3)
  {
    this->At.triangles += this->At.corner - 2;
  }
  else if (this->At.small++ == 0)
  {
    this->At.firstSmall =
      "facet " + std::to_string(this->At.facet) + ", of " + std::to_string(this->At.corner);
  }
  ++this->At.facet;
  return false;
}

Status TextStlReader::Start(const Execution& execution)
{
  const Result<std::uint64_t> zeros = CropToText(this->Source);
  KDSTREAM_TRY(zeros);
  this->FileInfo.tolerance.Count(Lapse::PaddedEnd, *zeros);
  DecimalPrecision precision;
  for (;;)
  {
    const Result<bool> facet = this->NextFacet();
    KDSTREAM_TRY(facet);
    if (!*facet)
    {
      break;
    }
    for (Result<bool> vertex = this->NextVertex(); !vertex || *vertex; vertex = this->NextVertex())
    {
      KDSTREAM_TRY(vertex);
      for (std::size_t k = 0; k < 3; ++k)
      {
        const Result<std::string_view> word = this->Words.Next();
        KDSTREAM_TRY(word);
        precision.Add(*word);
      }
    }
    if ((this->At.facet - 1) % facetsPerReport == 0)
    {
      const double size = std::max(1.0, double(this->Source.Size()));
      KDSTREAM_TRY(execution.Report("read", double(this->Words.Position()) / size));
    }
  }
  this->FileInfo.scalarType = precision.FloatsSuffice() ? ScalarType::Float32 : ScalarType::Float64;
  const std::uint64_t triangles = this->At.triangles;
  this->FileInfo.tolerance.Count(Lapse::EndMissing, this->At.endless, "'endsolid'");
  this->FileInfo.tolerance.Count(Lapse::FaceTooSmall, this->At.small, this->At.firstSmall);
  this->FileInfo.tolerance.Count(Lapse::BytesAfterEnd, this->At.after,
    "byte " + std::to_string(this->Source.Size() - this->At.after) + ", a Ctrl-Z");
  if (this->At.foreign > 0)
  {
    this->FileInfo.ignoredAttributes.push_back(
      "words between facets that STL does not have (" + this->At.firstForeign + ")");
  }
  this->At = {};
  this->Words.Seek(this->Source.Start());
  return this->SetFacets(triangles);
}

template <class T>
Status TextStlReader::ReadPoint(Vec3& point)
{
  for (std::size_t k = 0; k < 3; ++k)
  {
    const Result<std::string_view> word = this->Words.Next();
    KDSTREAM_TRY(word);
    T value = 0;
    const NumberTextError error = ParseNumber(*word, value);
    if (error != NumberTextError::None)
    {
      return AtFacet(this->At.facet,
        "vertex " + std::to_string(this->At.corner - 1) + ": " + "xyz"[k] + " " +
          QuotedText(*word) +
          (error == NumberTextError::NotANumber ? " is not a number" + DecimalCommaHint(*word)
                                                : std::string(" is too large a number")));
    }
    point[k] = static_cast<double>(value);
  }
  return {};
}

// Reads the next facet of three corners or more, and puts its triangles into Corners.
Status TextStlReader::ReadFacet()
{
  bool finite = true;
  this->Facet.clear();
  while (this->Facet.size() < 3)
  {
    const Result<bool> more = this->NextFacet();
    KDSTREAM_TRY(more);
    if (!*more)
    {
      return BadInput("truncated: the file has changed since it was opened", Remedy::Retry);
    }
    finite = true;
    this->Facet.clear();
    for (Result<bool> vertex = this->NextVertex(); !vertex || *vertex; vertex = this->NextVertex())
    {
      KDSTREAM_TRY(vertex);
      Vec3& point = this->Facet.emplace_back();
      KDSTREAM_TRY(this->FileInfo.scalarType == ScalarType::Float32
                     ? this->ReadPoint<float>(point)
                     : this->ReadPoint<double>(point));
      if (!IsFinite(point))
      {
        this->CountNotFinite(this->At.corner - 1, this->At.facet);
        finite = false;
      }
    }
  }
  this->Given = 0;
  this->Corners.clear();
  if (finite && this->Facet.size() == 3)
  {
    this->Corners = this->Facet;
    return {};
  }
  if (!finite)
  {
    this->Corners.assign(3 * (this->Facet.size() - 2), notFinite);
    return {};
  }
  for (const Triangle& triangle : this->Cutter.Cut(this->Facet))
  {
    for (const VertexId corner : triangle)
    {
      this->Corners.push_back(this->Facet[corner]);
    }
  }
  return {};
}

Status TextStlReader::ReadPoints(std::vector<Vec3>& points, std::size_t number)
{
  MakeRoom(points, number); // the facets were counted before
  for (std::size_t i = 0; i < number; ++i)
  {
    if (this->Given == this->Corners.size())
    {
      KDSTREAM_TRY(this->ReadFacet());
    }
    points.push_back(this->Corners[this->Given++]);
  }
  return {};
}

bool HasNoControls(std::string_view text)
{
  return std::none_of(text.begin(), text.end(),
    [](char c) { return (c >= '\0' && c < ' ' && !IsBlank(c)) || c == 0x7F; });
}

// Whether the file could be text: looks at the bytes where a binary file has its header and first
// triangle. Ignores bytes that copying adds after a text (PlainText.h).
bool LooksLikeText(std::string_view head)
{
  head = head.substr(0, headerBytes + facetBytes);
  head.remove_prefix(head.starts_with(utf8Mark) ? utf8Mark.size() : 0);
  const std::size_t last = head.find_last_not_of(std::string_view("\x1A\0 \t\r\n", 6));
  head = head.substr(0, last == head.npos ? 0 : last + 1);
  head.remove_prefix(
    static_cast<std::size_t>(std::find_if_not(head.begin(), head.end(), IsBlank) - head.begin()));
  return IsWord(head.substr(0, 5), "solid") && HasNoControls(head);
}

// Whether a plausible triangle follows the header. A file with more bytes than its count requires
// needs this as further evidence that it is binary.
bool HasFacet(std::string_view head)
{
  const std::string_view format = FormatOfContent(head);
  return (format.empty() || format == ".stl") && head.size() > headerBytes &&
         LooksLikeFacet(head.substr(headerBytes));
}

}

Result<std::unique_ptr<MeshReader>> OpenStlReader(ByteSource source, const Execution& execution)
{
  const Result<std::string_view> head = source.Peek(headerBytes + facetBytes);
  KDSTREAM_TRY(head);
  const bool hasHeader = head->size() >= headerBytes;
  const std::uint32_t facets = hasHeader ? LoadLittle(head->data() + headerBytes - 4) : 0;
  const std::uint64_t size = headerBytes + std::uint64_t{ facetBytes } * facets;
  // Decides by the content: the size fits exactly; it is text; or there are more bytes than the
  // facets need.
  const bool more = hasHeader && facets > 0 && source.Size() > size;
  // Programs that do not know the number of facets when they begin write 0 or 2^32 - 1.
  const bool streamed = hasHeader && (facets == 0 || facets == 0xFFFFFFFF) &&
                        source.Size() > headerBytes &&
                        (source.Size() - headerBytes) % facetBytes == 0 &&
                        head->find_first_not_of('\0', headerBytes) != head->npos;
  const bool fits = hasHeader && source.Size() == size;
  if (fits || ((more || streamed) && !LooksLikeText(*head) && HasFacet(*head)))
  {
    const std::uint64_t held = (source.Size() - headerBytes) / facetBytes;
    auto reader =
      std::make_unique<BinaryStlReader>(std::move(source), streamed && !fits ? held : facets);
    Status started = reader->Start(facets);
    return started ? Result<std::unique_ptr<MeshReader>>(std::move(reader)) : started.GetError();
  }
  if (LooksLikeText(*head) || IsWideText(*head))
  {
    auto reader = std::make_unique<TextStlReader>(std::move(source));
    Status started = reader->Start(execution);
    return started ? Result<std::unique_ptr<MeshReader>>(std::move(reader)) : started.GetError();
  }
  if (head->empty())
  {
    return BadInput("the file is empty", Remedy::CopyAgain);
  }
  if (!hasHeader)
  {
    return BadInput("is not an STL file", Remedy::Rename);
  }
  if (HasNoControls(*head))
  {
    return BadInput("is not an STL file: a text begins with 'solid'", Remedy::Repair);
  }
  if (const std::uint32_t other = __builtin_bswap32(facets);
      source.Size() == headerBytes + std::uint64_t{ facetBytes } * other)
  {
    return BadInput("is big-endian: its " + std::to_string(other) +
                      " triangles have swapped bytes, but STL is little-endian",
      Remedy::SaveOtherwise);
  }
  return BadInput("the header claims " + std::to_string(facets) + " triangles, " +
                    std::to_string(size) + " bytes with it; the file has " +
                    std::to_string(source.Size()),
    Remedy::CopyAgain);
}

}
