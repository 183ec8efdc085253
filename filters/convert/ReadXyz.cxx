// SPDX-License-Identifier: BSD-3-Clause
// Point clouds as text. Steps: 1. every line's numbers  2. what the columns mean  3. points and
// attributes.
#include "filters/convert/ForeignMesh.h"
#include "filters/convert/PointAttributes.h"
#include "filters/meshio/NumberText.h"
#include "filters/meshio/QuotedText.h"
#include "filters/meshio/TextLines.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kdstream
{
namespace
{

constexpr std::string_view separators = " \t,;\r\v\f";
constexpr std::uint64_t linesPerReport = 1 << 16;

bool IsComment(std::string_view line)
{
  const std::size_t begin = line.find_first_not_of(separators);
  return begin == std::string_view::npos || line[begin] == '#' || line.substr(begin, 2) == "//";
}

bool IsCount(const std::vector<std::string_view>& words)
{
  return words.size() == 1 && words[0].find_first_not_of("0123456789") == std::string_view::npos;
}

// What three columns after the coordinates can be.
struct TripleKind
{
  bool unit = true;      // every one is of length one, or none: zero or not finite
  bool someUnit = false; // one is of length one
  bool colors = true;    // every one is of whole numbers from 0 to 255

  bool Normals() const { return this->unit && this->someUnit; }

  void Add(const float* value)
  {
    double square = 0;
    for (std::size_t k = 0; k < 3; ++k)
    {
      const double v = double(value[k]);
      square += v * v;
      this->colors &= v >= 0 && v <= 255 && v == std::floor(v);
    }
    const bool one = std::abs(square - 1) < 0.02;
    this->someUnit |= one;
    this->unit &= one || square == 0 || !std::isfinite(square);
  }
};

class XyzReader
{
public:
  explicit XyzReader(TextLines lines)
    : Lines(std::move(lines))
  {
  }

  Result<ForeignMesh> Read(const Execution& execution)
  {
    for (;;)
    {
      const Result<bool> more = this->Lines.Next();
      KDSTREAM_TRY(more);
      if (!*more)
      {
        break;
      }
      KDSTREAM_TRY(this->AddLine());
      if (this->Lines.Number() % linesPerReport == 0)
      {
        KDSTREAM_TRY(execution.Report("read", this->Lines.Fraction()));
      }
    }
    return this->Finish();
  }

private:
  Status AddLine()
  {
    if (IsComment(this->Lines.Line()))
    {
      return {};
    }
    SplitWords(this->Lines.Line(), separators, this->Words);
    if (this->Columns == 0)
    {
      if (!this->CountSeen && IsCount(this->Words))
      {
        this->CountSeen = true;
        return {};
      }
      KDSTREAM_TRY(this->SetColumns());
    }
    if (this->Words.size() != this->Columns)
    {
      return this->Lines.Wrong("has " + std::to_string(this->Words.size()) +
                               " columns; those before have " + std::to_string(this->Columns));
    }
    return this->AddPoint();
  }

  Status SetColumns()
  {
    constexpr std::array<std::size_t, 5> known{ 3, 4, 6, 7, 9 };
    this->Columns = this->Words.size();
    if (std::find(known.begin(), known.end(), this->Columns) == known.end())
    {
      return this->Lines.Wrong("has " + std::to_string(this->Columns) +
                               " columns; points have 3 (x y z), 4 (and an intensity), 6 (and r g "
                               "b or nx ny nz), 7 (and intensity r g b) or 9 (and r g b nx ny nz)");
    }
    return {};
  }

  Status AddPoint()
  {
    Vec3 point{};
    std::array<float, 6> rest{};
    for (std::size_t i = 0; i < this->Columns; ++i)
    {
      const std::string_view word = this->Words[i];
      const NumberTextError error =
        i < 3 ? ParseNumber(word, point[i]) : ParseNumber(word, rest[i - 3]);
      if (error != NumberTextError::None)
      {
        return this->Lines.Wrong(
          QuotedText(word) +
          (error == NumberTextError::NotANumber ? " is no number" : " is too large a number"));
      }
    }
    const std::size_t extra = this->Columns - 3;
    const bool finite =
      std::all_of(point.begin(), point.end(), [](double v) { return std::isfinite(v); });
    if (!finite)
    {
      ++this->Dropped;
      return {};
    }
    if (this->Points.size() >= noVertex - 1)
    {
      return Error{ ErrorCode::LimitExceeded, "more than 4294967294 points" };
    }
    this->Points.push_back(point);
    for (std::size_t k = 0; k < 3; ++k)
    {
      this->Precision.Add(this->Words[k]);
    }
    this->Extra.insert(this->Extra.end(), rest.begin(), rest.begin() + std::ptrdiff_t(extra));
    if (extra >= 3)
    {
      this->First.Add(rest.data() + extra % 3);
    }
    if (extra == 6)
    {
      this->Second.Add(rest.data() + 3);
    }
    return {};
  }

  Result<ForeignMesh> Finish()
  {
    ForeignMesh result;
    Mesh& mesh = result.mesh;
    mesh.scalarType = this->Precision.FloatsSuffice() ? ScalarType::Float32 : ScalarType::Float64;
    mesh.points = std::move(this->Points);
    const std::size_t extra = this->Columns > 3 ? this->Columns - 3 : 0;
    if (extra % 3 == 1)
    {
      mesh.attributes.push_back(this->Column(
        MakePointAttribute("Intensity", AttributeType::Float32, 1, mesh.points.size()), 0));
    }
    if (extra == 3)
    {
      this->AddTriple(result, this->First, this->First.colors, 0);
    }
    else if (extra > 3)
    {
      // Beside an intensity or a normal, three numbers are a colour.
      if (!this->First.colors)
      {
        return Error{ ErrorCode::InvalidInput,
          "columns " + std::to_string(4 + extra % 3) + " to " + std::to_string(6 + extra % 3) +
            " should be colours, whole numbers from 0 to 255" };
      }
      mesh.attributes.push_back(this->Column(MakeColors(mesh.points.size()), extra % 3));
    }
    if (extra == 6)
    {
      this->AddTriple(result, this->Second, false, 3);
    }
    if (this->Dropped > 0)
    {
      result.warnings.push_back(this->Dropped == 1 ? "1 point is not finite and was dropped"
                                                   : std::to_string(this->Dropped) +
                                                       " points are not finite and were dropped");
    }
    return result;
  }

  // Three columns from `first` as normals, as colours if they may be, or as what they are: numbers.
  void AddTriple(
    ForeignMesh& result, const TripleKind& kind, bool maybeColors, std::size_t first) const
  {
    const std::size_t tuples = result.mesh.points.size();
    std::vector<Attribute>& attributes = result.mesh.attributes;
    const std::string columns =
      "columns " + std::to_string(4 + first) + " to " + std::to_string(6 + first);
    if (kind.Normals())
    {
      attributes.push_back(this->Column(MakeNormals(tuples), first));
      if (maybeColors)
      {
        result.warnings.push_back(columns + " are taken as normals; they could be colours too");
      }
    }
    else if (maybeColors)
    {
      attributes.push_back(this->Column(MakeColors(tuples), first));
    }
    else
    {
      std::string names;
      for (std::size_t k = 0; k < 3; ++k)
      {
        const std::string name = "column" + std::to_string(4 + first + k);
        names += (k == 0 ? "" : ", ") + name;
        attributes.push_back(
          this->Column(MakePointAttribute(name, AttributeType::Float32, 1, tuples), first + k));
      }
      result.warnings.push_back(columns + " are neither normals of length one nor whole numbers " +
                                "from 0 to 255: kept as " + names);
    }
  }

  // Fills an attribute with columns from `first`, counted from the one after z.
  Attribute Column(Attribute attribute, std::size_t first) const
  {
    const std::size_t extra = this->Columns - 3;
    for (std::size_t i = 0; i < attribute.TupleCount(); ++i)
    {
      for (std::size_t k = 0; k < attribute.components; ++k)
      {
        attribute.Set(i, k, double(this->Extra[i * extra + first + k]));
      }
    }
    return attribute;
  }

  TextLines Lines;
  std::vector<std::string_view> Words;
  std::size_t Columns = 0; // 0: not known yet
  bool CountSeen = false;
  std::vector<Vec3> Points;
  std::vector<float> Extra; // the columns after z
  TripleKind First;         // of the first three of them, or of those after an intensity
  TripleKind Second;        // of the last three of six
  DecimalPrecision Precision;
  std::uint64_t Dropped = 0;
};

}

Result<ForeignMesh> ReadXyz(const std::filesystem::path& file, const Execution& execution)
{
  Result<ByteSource> source = ByteSource::Open(file);
  return source ? XyzReader(TextLines(std::move(*source))).Read(execution)
                : Result<ForeignMesh>(source.GetError());
}

}
