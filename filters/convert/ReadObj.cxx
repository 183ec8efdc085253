// Wavefront OBJ, by a reader of our own: VTK's rounds coordinates to floats and does not check
// indices. Steps: 1. every line  2. a vertex for each combination of place, texture coordinate and
// normal that corners use  3. attributes.
#include "filters/convert/ForeignMesh.h"
#include "filters/convert/PointAttributes.h"
#include "filters/meshio/NumberText.h"
#include "filters/meshio/QuotedText.h"
#include "filters/meshio/TextLines.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace kdstream
{
namespace
{

constexpr std::string_view blanks = " \t\r\v\f";
constexpr std::uint64_t linesPerReport = 1 << 16;
constexpr std::uint32_t none = noVertex;

// Numbers of a corner's place, texture coordinate and normal.
using Corner = std::array<std::uint32_t, 3>;

struct HashCorner
{
  std::size_t operator()(const Corner& corner) const
  {
    std::uint64_t hash = 0;
    for (const std::uint32_t part : corner)
    {
      hash = (hash ^ part) * 0x9E3779B97F4A7C15U;
      hash ^= hash >> 29;
    }
    return static_cast<std::size_t>(hash);
  }
};

class ObjReader
{
public:
  explicit ObjReader(TextLines lines)
    : Lines(std::move(lines))
  {
  }

  Result<ForeignMesh> Read(const Execution& execution)
  {
    for (;;)
    {
      const Result<bool> more = this->NextLine();
      if (!more)
      {
        return more.GetError();
      }
      if (!*more)
      {
        break;
      }
      if (Status status = this->AddLine(); !status)
      {
        return status.GetError();
      }
      if (this->Lines.Number() % linesPerReport == 0)
      {
        if (Status status = execution.Report("read", this->Lines.Fraction()); !status)
        {
          return status.GetError();
        }
      }
    }
    if (!this->Recognised)
    {
      return Error{ ErrorCode::InvalidInput, "is not an OBJ file: no line says v, vt, vn or f" };
    }
    return this->Finish();
  }

private:
  // A line that ends with a backslash goes on in the next one.
  Result<bool> NextLine()
  {
    const Result<bool> first = this->Lines.Next();
    if (!first || !*first)
    {
      return first;
    }
    this->Text = this->Lines.Line();
    while (!this->Text.empty() && this->Text.back() == '\\')
    {
      this->Text.back() = ' ';
      const Result<bool> next = this->Lines.Next();
      if (!next)
      {
        return next;
      }
      if (!*next)
      {
        break;
      }
      this->Text += this->Lines.Line();
      if (this->Text.size() > ByteSource::blockSize)
      {
        return this->Lines.Wrong("is longer than 1 MiB");
      }
    }
    this->Text.resize(std::min(this->Text.find('#'), this->Text.size()));
    SplitWords(this->Text, blanks, this->Words);
    return true;
  }

  Status AddLine()
  {
    if (this->Words.empty())
    {
      return {};
    }
    const std::string_view kind = this->Words[0];
    const bool known = kind == "v" || kind == "vt" || kind == "vn" || kind == "f";
    this->Recognised |= known;
    if (kind == "v")
    {
      return this->AddPlace();
    }
    if (kind == "vt")
    {
      return this->AddNumbers(1, 2, this->TextureCoordinates);
    }
    if (kind == "vn")
    {
      return this->AddNumbers(3, 3, this->Normals);
    }
    if (kind == "f")
    {
      return this->AddFace();
    }
    this->Materials |= kind == "mtllib" || kind == "usemtl";
    if (kind == "curv" || kind == "curv2" || kind == "surf" || kind == "l")
    {
      ++this->Other;
    }
    return {};
  }

  Status Number(std::string_view word, double& value) const
  {
    const NumberTextError error = ParseNumber(word, value);
    return error == NumberTextError::None
             ? Status()
             : Status(this->Lines.Wrong(QuotedText(word) + (error == NumberTextError::NotANumber
                                                               ? " is no number"
                                                               : " is too large a number")));
  }

  // v x y z [w], or v x y z r g b [a].
  Status AddPlace()
  {
    const std::size_t numbers = this->Words.size() - 1;
    if (numbers < 3 || numbers > 8)
    {
      return this->Lines.Wrong("a vertex of " + std::to_string(numbers) + " numbers");
    }
    if (this->Places.size() >= none - 1)
    {
      return Error{ ErrorCode::LimitExceeded, "more than 4294967294 vertices" };
    }
    std::array<double, 8> value{};
    for (std::size_t i = 0; i < numbers; ++i)
    {
      if (Status status = this->Number(this->Words[i + 1], value[i]); !status)
      {
        return status;
      }
      if (i < 3 && !std::isfinite(value[i]))
      {
        return this->Lines.Wrong(std::string("vertex ") + std::to_string(this->Places.size()) +
                                 ": " + "xyz"[i] + " is not finite");
      }
    }
    this->Places.push_back({ value[0], value[1], value[2] });
    for (std::size_t k = 0; k < 3; ++k)
    {
      this->Precision.Add(this->Words[k + 1]);
    }
    const bool colored = numbers >= 6;
    if (colored && this->Colors.size() + 3 == this->Places.size() * 3)
    {
      this->Colors.insert(
        this->Colors.end(), { float(value[3]), float(value[4]), float(value[5]) });
    }
    return {};
  }

  Status AddNumbers(std::size_t least, std::size_t kept, std::vector<float>& to)
  {
    if (this->Words.size() <= least || this->Words.size() > 5)
    {
      return this->Lines.Wrong("has " + std::to_string(this->Words.size() - 1) + " numbers");
    }
    for (std::size_t i = 0; i < kept; ++i)
    {
      double value = 0;
      const bool there = i + 1 < this->Words.size();
      if (Status status = there ? this->Number(this->Words[i + 1], value) : Status(); !status)
      {
        return status;
      }
      to.push_back(static_cast<float>(value));
    }
    return {};
  }

  // One number of a corner: from 1 on, or back from the end; none where it is empty.
  Result<std::uint32_t> Index(std::string_view word, std::size_t count, const char* what) const
  {
    std::int64_t index = 0;
    if (ParseNumber(word, index) != NumberTextError::None || index == 0)
    {
      return this->Lines.Wrong(QuotedText(word) + " is no number of a " + what);
    }
    const std::int64_t number = index > 0 ? index - 1 : static_cast<std::int64_t>(count) + index;
    if (number < 0 || number >= static_cast<std::int64_t>(count))
    {
      return this->Lines.Wrong(std::string(what) + " " + std::to_string(index) +
                               " is not there: there are " + std::to_string(count) + " so far");
    }
    return static_cast<std::uint32_t>(number);
  }

  Result<Corner> ParseCorner(std::string_view word) const
  {
    const std::size_t counts[] = { this->Places.size(), this->TextureCoordinates.size() / 2,
      this->Normals.size() / 3 };
    static constexpr const char* names[] = { "vertex", "texture coordinate", "normal" };
    Corner corner{ none, none, none };
    for (std::size_t part = 0; part < 3; ++part)
    {
      const std::size_t slash = std::min(word.find('/'), word.size());
      const std::string_view number = word.substr(0, slash);
      if (part == 0 || !number.empty())
      {
        const Result<std::uint32_t> index = this->Index(number, counts[part], names[part]);
        if (!index)
        {
          return index.GetError();
        }
        corner[part] = *index;
      }
      if (slash == word.size())
      {
        return corner;
      }
      word.remove_prefix(slash + 1);
    }
    return this->Lines.Wrong("a corner of more than three numbers");
  }

  Status AddFace()
  {
    if (this->Words.size() < 4)
    {
      return this->Lines.Wrong("a face of " + std::to_string(this->Words.size() - 1) + " corners");
    }
    std::vector<Corner> corners;
    for (std::size_t i = 1; i < this->Words.size(); ++i)
    {
      const Result<Corner> corner = this->ParseCorner(this->Words[i]);
      if (!corner)
      {
        return corner.GetError();
      }
      corners.push_back(*corner);
    }
    for (std::size_t i = 2; i < corners.size(); ++i)
    {
      this->Corners.insert(this->Corners.end(), { corners[0], corners[i - 1], corners[i] });
    }
    return {};
  }

  // The vertex of a corner: that of its place, if no other combination has taken it.
  Result<VertexId> VertexOf(const Corner& corner, Mesh& mesh)
  {
    Corner& owner = this->Owners[corner[0]];
    if (owner[0] == none)
    {
      owner = corner;
    }
    if (owner == corner)
    {
      return corner[0];
    }
    const auto next = static_cast<VertexId>(mesh.points.size());
    const auto [found, isNew] = this->Further.try_emplace(corner, next);
    if (isNew)
    {
      if (next >= none - 1)
      {
        return Error{ ErrorCode::LimitExceeded, "more than 4294967294 vertices" };
      }
      mesh.points.push_back(mesh.points[corner[0]]);
      this->Owners.push_back(corner);
    }
    return found->second;
  }

  Result<ForeignMesh> Finish()
  {
    ForeignMesh result;
    Mesh& mesh = result.mesh;
    mesh.scalarType = this->Precision.FloatsSuffice() ? ScalarType::Float32 : ScalarType::Float64;
    const std::size_t places = this->Places.size();
    const bool colored = !this->Colors.empty() && this->Colors.size() == places * 3;
    mesh.points = std::move(this->Places);
    this->Owners.assign(places, Corner{ none, none, none });
    for (std::size_t i = 0; i < this->Corners.size(); i += 3)
    {
      Triangle triangle{};
      for (std::size_t k = 0; k < 3; ++k)
      {
        const Result<VertexId> vertex = this->VertexOf(this->Corners[i + k], mesh);
        if (!vertex)
        {
          return vertex.GetError();
        }
        triangle[k] = *vertex;
      }
      mesh.triangles.push_back(triangle);
    }
    for (std::size_t v = 0; v < places; ++v)
    {
      this->Owners[v][0] = static_cast<std::uint32_t>(v);
    }
    if (colored)
    {
      mesh.attributes.push_back(this->TakeColors());
    }
    this->AddAttribute(mesh, 2, this->Normals, MakeNormals(mesh.points.size()));
    this->AddAttribute(mesh, 1, this->TextureCoordinates,
      MakePointAttribute("TCoords", AttributeType::Float32, 2, mesh.points.size()));
    this->Warn(result);
    return result;
  }

  // Values of the places, from 0 to 1, or to 255 where one is above 1.
  Attribute TakeColors() const
  {
    const float most = *std::max_element(this->Colors.begin(), this->Colors.end());
    Attribute colors = MakeColors(this->Owners.size());
    for (std::size_t v = 0; v < this->Owners.size(); ++v)
    {
      for (std::size_t k = 0; k < 3; ++k)
      {
        const double value = double(this->Colors[this->Owners[v][0] * std::size_t{ 3 } + k]);
        colors.Set(v, k, most > 1 ? value : value * 255);
      }
    }
    return colors;
  }

  // Only if a corner uses one. Vertices that no corner gives one have zeros.
  void AddAttribute(
    Mesh& mesh, std::size_t part, const std::vector<float>& values, Attribute attribute) const
  {
    bool used = false;
    for (std::size_t v = 0; v < this->Owners.size(); ++v)
    {
      const std::uint32_t number = this->Owners[v][part];
      for (std::size_t k = 0; number != none && k < attribute.components; ++k)
      {
        attribute.Set(v, k, double(values[std::size_t{ number } * attribute.components + k]));
      }
      used |= number != none;
    }
    if (used)
    {
      mesh.attributes.push_back(std::move(attribute));
    }
  }

  void Warn(ForeignMesh& result) const
  {
    if (this->Materials)
    {
      result.warnings.push_back("materials and their textures are dropped");
    }
    if (this->Other > 0)
    {
      result.warnings.push_back(
        std::to_string(this->Other) + " lines and free-form curves or surfaces are dropped");
    }
    if (!this->Colors.empty() && this->Colors.size() != result.mesh.points.size() * 3 &&
        !FindAttribute(result.mesh.attributes, MakeColors(0)))
    {
      result.warnings.push_back("colours are dropped: not all vertices have one");
    }
  }

  TextLines Lines;
  std::string Text;
  std::vector<std::string_view> Words; // of Text
  bool Recognised = false, Materials = false;
  std::uint64_t Other = 0;
  DecimalPrecision Precision;
  std::vector<Vec3> Places;
  std::vector<float> Colors;             // three a place
  std::vector<float> TextureCoordinates; // two each
  std::vector<float> Normals;            // three each
  std::vector<Corner> Corners;           // three a triangle
  std::vector<Corner> Owners;            // of each vertex: the combination that it is
  std::unordered_map<Corner, VertexId, HashCorner> Further;
};

}

Result<ForeignMesh> ReadObj(const std::filesystem::path& file, const Execution& execution)
{
  Result<ByteSource> source = ByteSource::Open(file);
  return source ? ObjReader(TextLines(std::move(*source))).Read(execution)
                : Result<ForeignMesh>(source.GetError());
}

}
