// SPDX-License-Identifier: BSD-3-Clause
// Reads OFF files as the text of a PLY: see OffHeader.h. Steps:
// 1. read the header
// 2. look at all lines: what they have after places and corners, whether floats are enough
// 3. make a PLY header from this.
#include "filters/meshio/ply/OffHeader.h"

#include "filters/meshio/NumberText.h"
#include "filters/meshio/PlainText.h"
#include "filters/meshio/QuotedText.h"
#include "filters/meshio/TextLines.h"
#include "filters/meshio/TextWords.h"
#include "filters/meshio/ply/PlyReader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <utility>

namespace kdstream
{

namespace
{

constexpr std::size_t longestLine = std::size_t{ 16 } << 20;
constexpr std::uint64_t linesPerReport = 1 << 16;

// The numbers of a line after its place or its corners: at most three of a normal, four of a colour
// and two of a texture coordinate.
struct NumbersAfter
{
  static constexpr std::size_t most = 9;
  std::array<double, most> values{};
  std::size_t count = 0; // of all numbers on the line
};

bool IsNormal(const double* v)
{
  constexpr double rounding = 0.02;
  return std::abs(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] - 1) < rounding;
}

// Finds the columns that all lines of vertices, or all lines of faces, have.
class OffColumns
{
public:
  // others: how many numbers are not colours; a normal counts as three.
  OffColumns(bool hasNormals, std::size_t others)
    : HasNormals(hasNormals)
    , Others(others)
  {
  }

  void Add(const NumbersAfter& after)
  {
    this->Least = this->Lines++ == 0 ? after.count : std::min(this->Least, after.count);
    this->Most = std::max(this->Most, after.count);
    const std::size_t colors = after.count - std::min(after.count, this->Others);
    if (after.count > NumbersAfter::most || (colors != 3 && colors != 4))
    {
      return;
    }
    const double* const v = after.values.data();
    this->NormalsFirst += this->HasNormals && IsNormal(v) ? 1 : 0;
    this->NormalsLast += this->HasNormals && IsNormal(v + colors) ? 1 : 0;
    for (const std::size_t way : { 0, 1 }) // colours after a normal, or before it
    {
      const double* const color = v + (this->HasNormals && way == 0 ? 3 : 0);
      for (std::size_t k = 0; k < colors; ++k)
      {
        this->Greatest[way] = std::max(this->Greatest[way], color[k]);
        this->AreBytes[way] = this->AreBytes[way] && color[k] >= 0 && color[k] <= 255 &&
                              color[k] == std::floor(color[k]);
      }
    }
  }
  // Whether all lines have the numbers that are not colours. andMore: lines may have more numbers.
  bool HaveOthers(bool andMore) const
  {
    return this->Least >= this->Others && (andMore || this->Most == this->Others);
  }
  // The number of colour columns that every line has, three or four; else 0.
  std::size_t Colors() const
  {
    const std::size_t colors = this->Least - std::min(this->Least, this->Others);
    return this->Least == this->Most && (colors == 3 || colors == 4) ? colors : 0;
  }
  bool ColorsFirst() const
  {
    return this->Colors() > 0 && 2 * this->NormalsLast > this->Lines &&
           2 * this->NormalsFirst <= this->Lines;
  }
  void AddColors(PlyElement& element) const
  {
    const std::size_t way = this->ColorsFirst() ? 1 : 0;
    const AttributeType type = this->AreBytes[way] && this->Greatest[way] > 1
                                 ? AttributeType::UInt8
                                 : AttributeType::Float32;
    constexpr std::array<const char*, 4> names{ "red", "green", "blue", "alpha" };
    for (std::size_t k = 0; k < this->Colors(); ++k)
    {
      element.properties.push_back({ names[k], type });
    }
  }

private:
  bool HasNormals;
  std::size_t Others;
  std::uint64_t Lines = 0, NormalsFirst = 0, NormalsLast = 0;
  std::size_t Least = 0, Most = 0;
  std::array<double, 2> Greatest{};
  std::array<bool, 2> AreBytes{ true, true };
};

class OffText
{
public:
  explicit OffText(ByteSource source)
    : Lines(std::move(source), longestLine)
  {
  }

  Status ReadHeader();
  // Looks at all other lines.
  Status LookAtLines(const Execution& execution);
  PlyHeader MakeHeader(Tolerance& reported) const;
  // Where the lines of vertices and faces begin and end, without comments after them.
  std::uint64_t BodyBegin() const { return this->Body; }
  std::uint64_t BodyEnd() const { return this->End; }

private:
  Result<bool> NextLine();
  Result<std::string_view> HeaderWord();
  Status HeaderNumber(const char* what, std::uint64_t& number);
  Status ReadKind();
  Status PassEdges();
  Status BeginInHeader();
  Status LookAtNumbers(const Execution& execution);
  void ReadNumbersAfter(OffColumns& columns);
  void LookForShort(
    const char* element, std::uint64_t index, std::uint64_t there, std::uint64_t expected);

  TextLines Lines;
  std::string_view Rest; // of the line, without comment
  bool Held = false;     // whether NextLine returns this line once more
  bool HasNormals = false, HasColors = false, HasTexture = false;
  std::uint64_t Vertices = 0, Faces = 0, Body = 0, End = 0, LineBegin = 0;
  bool IsWhole = false;    // there is one line for each vertex and face
  bool IsInHeader = false; // the first vertex is on the line of the counts
  std::string Short;       // about the first line with too few numbers
  OffColumns OfVertices{ false, 0 }, OfFaces{ false, 0 };
  DecimalPrecision Precision;
};

// Goes to the next line that is not blank; false at the end.
Result<bool> OffText::NextLine()
{
  if (std::exchange(this->Held, false))
  {
    return true;
  }
  for (;;)
  {
    this->LineBegin = this->Lines.End();
    const Result<bool> more = this->Lines.Next();
    KDSTREAM_TRY(more);
    if (!*more)
    {
      return false;
    }
    this->Rest = this->Lines.Line().substr(0, FindComment(this->Lines.Line()));
    if (!std::all_of(this->Rest.begin(), this->Rest.end(), IsBlank))
    {
      return true;
    }
  }
}

// The next word, also across lines; empty at the end.
Result<std::string_view> OffText::HeaderWord()
{
  std::string_view word = TakeWord(this->Rest);
  if (word.empty())
  {
    const Result<bool> more = this->NextLine();
    KDSTREAM_TRY(more);
    word = *more ? TakeWord(this->Rest) : word;
  }
  return word;
}

Status OffText::HeaderNumber(const char* what, std::uint64_t& number)
{
  const Result<std::string_view> word = this->HeaderWord();
  KDSTREAM_TRY(word);
  return ParseNumber(*word, number) == NumberTextError::None
           ? Status()
           : this->Lines.Wrong((word->empty() ? "the end" : QuotedText(*word)) +
                               " where the number of " + what + " is expected");
}

// Reads the first word, which says what vertices have.
Status OffText::ReadKind()
{
  const Result<std::string_view> first = this->HeaderWord();
  KDSTREAM_TRY(first);
  constexpr std::string_view off = "off";
  const std::size_t at = LowercaseText(first->substr(0, 16)).find(off);
  const std::string_view kind = first->substr(0, std::min(at, first->size()));
  if (at == std::string_view::npos || kind.find_first_not_of("STCNstc4n") != kind.npos)
  {
    return BadInput("is not an OFF file: it does not begin with OFF", Remedy::Rename);
  }
  // In lower case, n means normals; in nOFF, it means that the number of dimensions follows.
  const bool isSmall = first->substr(at, off.size()) == off;
  // Numbers may follow the word without a blank.
  this->Rest = { first->data() + at + off.size(),
    first->size() - at - off.size() + this->Rest.size() };
  std::string_view next = this->Rest;
  if (LowercaseText(TakeWord(next)) == "binary")
  {
    return Error{ ErrorCode::Unsupported,
      "is a binary OFF file, which is not read: save it as text, or as .ply", {}, {},
      Remedy::InMessage };
  }
  const auto says = [&](const char* letters) { return kind.find_first_of(letters) != kind.npos; };
  const bool hasDimensions = says("n") && !isSmall, hasWeights = says("4");
  this->HasNormals = says("N") || (says("n") && isSmall);
  this->HasColors = says("Cc");
  this->HasTexture = says("Tt");
  std::uint64_t dimensions = hasWeights ? 4 : 3;
  if (hasDimensions)
  {
    KDSTREAM_TRY(this->HeaderNumber("dimensions", dimensions));
  }
  return dimensions == 3 && !hasWeights
           ? Status()
           : Error{ ErrorCode::Unsupported,
               "is an OFF file of points in " + std::to_string(dimensions) + " dimensions" +
                 (hasDimensions && hasWeights ? " with a weight each" : "") +
                 ", which is not read" };
}

// Skips the number of edges. It follows the number of faces, or is the only word on the next line.
Status OffText::PassEdges()
{
  this->Body = this->Lines.End();
  if (!TakeWord(this->Rest).empty())
  {
    std::string_view first = this->Rest;
    this->IsInHeader = !TakeWord(first).empty();
    return this->IsInHeader ? this->BeginInHeader() : Status();
  }
  const Result<bool> more = this->NextLine();
  KDSTREAM_TRY(more);
  std::string_view rest = *more ? this->Rest : std::string_view();
  std::uint64_t edges = 0;
  const bool isNumber = ParseNumber(TakeWord(rest), edges) == NumberTextError::None;
  if (isNumber && TakeWord(rest).empty())
  {
    this->Body = this->Lines.End();
  }
  else
  {
    this->Held = *more;
  }
  this->Rest = this->Held ? this->Rest : std::string_view();
  return {};
}

// Called if the body begins on the line of the header: then numbers matter, not lines.
Status OffText::BeginInHeader()
{
  if (this->HasNormals || this->HasColors || this->HasTexture)
  {
    return this->Lines.Wrong(
      "has vertices after the numbers of vertices, faces and edges, where "
      "colours cannot be distinguished from coordinates: write a line for each "
      "vertex and face",
      Remedy::InMessage);
  }
  const std::string_view line = this->Lines.Line();
  // The bytes of the line that are not in its text: a byte order mark before it, and its line
  // break.
  const std::uint64_t others = this->Lines.End() - this->LineBegin - line.size();
  this->Body = this->LineBegin + (others >= utf8Mark.size() ? utf8Mark.size() : 0) +
               static_cast<std::uint64_t>(this->Rest.data() - line.data());
  return {};
}

Status OffText::ReadHeader()
{
  KDSTREAM_TRY(this->ReadKind());
  KDSTREAM_TRY(this->HeaderNumber("vertices", this->Vertices));
  KDSTREAM_TRY(this->HeaderNumber("faces", this->Faces));
  KDSTREAM_TRY(this->PassEdges());
  return {};
}

void OffText::ReadNumbersAfter(OffColumns& columns)
{
  NumbersAfter after;
  for (std::string_view word = TakeWord(this->Rest); !word.empty(); word = TakeWord(this->Rest))
  {
    if (after.count < NumbersAfter::most)
    {
      static_cast<void>(ParseNumber(word, after.values[after.count]));
    }
    ++after.count;
  }
  columns.Add(after);
}

// Remembers the first line that has fewer numbers than it should have.
void OffText::LookForShort(
  const char* element, std::uint64_t index, std::uint64_t there, std::uint64_t expected)
{
  if (this->Short.empty() && there < expected)
  {
    this->Short = element + (" " + std::to_string(index)) + " (line " +
                  std::to_string(this->Lines.Number()) + ") has " + std::to_string(there) +
                  " of its " + std::to_string(expected) +
                  (element[0] == 'v' ? " coordinates" : " corners");
  }
}

// Called if line breaks do not matter: the file must then have exactly the numbers of the vertices
// and faces. Too few are reported later, when they are read.
Status OffText::LookAtNumbers(const Execution& execution)
{
  const std::string header = "line " + std::to_string(this->Lines.Number());
  std::string_view word = "0"; // the last word read; empty: end of file
  const auto next = [&]() -> Status
  {
    const Result<std::string_view> taken = this->HeaderWord();
    KDSTREAM_TRY(taken);
    word = *taken;
    return {};
  };
  for (std::uint64_t vertex = 0; vertex < this->Vertices && !word.empty(); ++vertex)
  {
    for (std::size_t k = 0; k < 3 && !word.empty(); ++k)
    {
      KDSTREAM_TRY(next());
      this->Precision.Add(word);
    }
    if (vertex % linesPerReport == 0)
    {
      KDSTREAM_TRY(execution.Report("read", this->Lines.Fraction()));
    }
  }
  for (std::uint64_t face = 0; face < this->Faces && !word.empty(); ++face)
  {
    KDSTREAM_TRY(next());
    std::uint64_t corners = 0;
    static_cast<void>(ParseNumber(word, corners));
    for (std::uint64_t corner = 0; corner < corners && !word.empty(); ++corner)
    {
      KDSTREAM_TRY(next());
    }
  }
  if (!word.empty())
  {
    KDSTREAM_TRY(next());
  }
  return word.empty() ? Status()
                      : BadInput(header + ": has more than the numbers of vertices, faces and "
                                          "edges, and with it there are more numbers than those of "
                                          "vertices and faces",
                          Remedy::Repair);
}

Status OffText::LookAtLines(const Execution& execution)
{
  if (this->IsInHeader)
  {
    this->End = this->Lines.Size();
    return this->LookAtNumbers(execution);
  }
  const std::size_t others = (this->HasNormals ? 3U : 0U) + (this->HasTexture ? 2U : 0U);
  this->OfVertices = OffColumns(this->HasNormals, others);
  for (std::uint64_t vertices = 0, faces = 0;;)
  {
    this->IsWhole = vertices == this->Vertices && faces == this->Faces;
    const bool isBegin = vertices + faces == 0;
    this->End = !this->IsWhole ? this->End : isBegin ? this->Body : this->Lines.End();
    const Result<bool> more = this->NextLine();
    KDSTREAM_TRY(more);
    if (!*more && this->IsWhole && !this->Short.empty())
    {
      return Error{ ErrorCode::InvalidInput, this->Short }; // more lines cannot help
    }
    if (!*more || this->IsWhole)
    {
      this->End = *more || !this->IsWhole ? this->Lines.Size() : this->End;
      return {};
    }
    if (this->Lines.Number() % linesPerReport == 0)
    {
      KDSTREAM_TRY(execution.Report("read", this->Lines.Fraction()));
    }
    if (vertices < this->Vertices)
    {
      std::size_t taken = 0;
      for (std::string_view word; taken < 3 && !(word = TakeWord(this->Rest)).empty(); ++taken)
      {
        this->Precision.Add(word);
      }
      this->LookForShort("vertex", vertices++, taken, 3);
      this->ReadNumbersAfter(this->OfVertices);
      continue;
    }
    std::uint64_t corners = 0, taken = 0;
    static_cast<void>(ParseNumber(TakeWord(this->Rest), corners));
    while (taken < corners && !TakeWord(this->Rest).empty())
    {
      ++taken;
    }
    this->LookForShort("face", faces++, taken, corners);
    this->ReadNumbersAfter(this->OfFaces);
  }
}

// If there is not one line for each vertex and face, the header has only what every OFF has.
PlyHeader OffText::MakeHeader(Tolerance& reported) const
{
  PlyHeader header;
  header.hasComments = true;
  const AttributeType type = (this->IsWhole || this->IsInHeader) && this->Precision.FloatsSuffice()
                               ? AttributeType::Float32
                               : AttributeType::Float64;
  PlyElement vertices{ "vertex", this->Vertices, { { "x", type }, { "y", type }, { "z", type } } };
  const auto add = [&](bool isThere, std::initializer_list<const char*> names)
  {
    for (const char* name : names)
    {
      isThere ? vertices.properties.push_back({ name, AttributeType::Float32 }) : void();
    }
  };
  const bool colors = this->HasColors && this->OfVertices.Colors() > 0;
  const bool colorsFirst = colors && this->OfVertices.ColorsFirst();
  if (this->IsWhole && this->OfVertices.HaveOthers(!this->HasColors || colors))
  {
    add(this->HasNormals && !colorsFirst, { "nx", "ny", "nz" });
    if (colors)
    {
      this->OfVertices.AddColors(vertices);
    }
    add(this->HasNormals && colorsFirst, { "nx", "ny", "nz" });
    add(this->HasTexture, { "s", "t" });
  }
  reported.Count(Lapse::PaddedEnd, this->Lines.Padding());
  if (colorsFirst)
  {
    reported.Tell("vertices are read as x y z, colour, normal, as MeshLab writes them: only so the "
                  "normals are of length 1");
  }
  PlyElement faces{ "face", this->Faces, { { "vertex_indices", AttributeType::Int32, true } } };
  if (this->IsWhole && this->OfFaces.Colors() > 0)
  {
    this->OfFaces.AddColors(faces);
  }
  header.elements = { std::move(vertices), std::move(faces) };
  return header;
}

}

Result<std::unique_ptr<MeshReader>> OpenOffReader(
  ByteSource source, const Execution& execution, const std::filesystem::path& scratch)
{
  if (source.Size() == 0)
  {
    return BadInput("the file is empty", Remedy::CopyAgain);
  }
  Result<ByteSource> again = source.Again();
  KDSTREAM_TRY(again);
  OffText text(std::move(*again));
  KDSTREAM_TRY(text.ReadHeader());
  KDSTREAM_TRY(text.LookAtLines(execution));
  source.Crop(text.BodyBegin(), text.BodyEnd());
  Tolerance reported;
  PlyHeader header = text.MakeHeader(reported);
  return PlyReader::OpenAs(std::move(source), std::move(header), scratch, reported);
}

}
