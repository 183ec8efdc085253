// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. find the corners of each face, and their values
// 2. make a vertex for each combination of a point and its values
// 3. make triangles
// 4. make attributes.
#include "filters/convert/VrmlFaces.h"

#include "filters/convert/JoinParts.h"
#include "filters/convert/PointAttributes.h"
#include "filters/core/CutPolygon.h"

#include <algorithm>
#include <map>

namespace kdstream
{
namespace
{

constexpr std::uint32_t noValue = noVertex;
constexpr std::uint32_t unsetValue = noVertex - 1;

// The indices of a corner's colour, normal and texture coordinate.
using Values = std::array<std::uint32_t, 3>;
constexpr Values noValues{ noValue, noValue, noValue };

class FacesReader
{
public:
  FacesReader(const VrmlFaces& faces, const std::string& what)
    : Faces(faces)
    , What(what)
  {
  }

  Result<ForeignMesh> Read()
  {
    Mesh& mesh = this->Out.mesh;
    mesh.points.assign(this->Faces.points.begin(), this->Faces.points.end());
    this->ValuesOf.assign(mesh.points.size(), { unsetValue, unsetValue, unsetValue });
    for (std::size_t begin = 0; begin < this->Faces.index.size();)
    {
      const auto rest = this->Faces.index.subspan(begin);
      const auto end = std::find_if(rest.begin(), rest.end(), [](std::int32_t i) { return i < 0; });
      const auto corners = static_cast<std::size_t>(end - rest.begin());
      KDSTREAM_TRY(this->ReadFace(begin, corners));
      ++this->Face;
      begin += corners + 1;
    }
    this->AddAttributes();
    return std::move(this->Out);
  }

private:
  const std::array<const VrmlChannel*, 3> Channels() const
  {
    return { &this->Faces.colors, &this->Faces.normals, &this->Faces.coordinates };
  }

  std::string PlaceOfFace() const { return this->What + ", face " + std::to_string(this->Face); }

  std::uint32_t ValueOf(const VrmlChannel& channel, std::size_t at, std::int32_t vertex)
  {
    if (channel.count == 0)
    {
      return noValue;
    }
    const std::size_t in = channel.perVertex ? at : this->Face;
    std::int64_t value = channel.perVertex ? vertex : std::int64_t(this->Face);
    if (!channel.index.empty())
    {
      value = in < channel.index.size() ? channel.index[in] : -1;
    }
    if (value < 0 || value >= std::int64_t(channel.count))
    {
      this->Lacks = true;
      return noValue;
    }
    return static_cast<std::uint32_t>(value);
  }

  Status ReadFace(std::size_t begin, std::size_t corners)
  {
    if (corners < 3)
    {
      this->Out.tolerance.Count(Lapse::FaceTooSmall, corners > 0 ? 1 : 0, this->PlaceOfFace());
      return {};
    }
    this->Vertices.clear();
    this->Places.clear();
    this->Lacks = false;
    for (std::size_t i = 0; i < corners; ++i)
    {
      // Reverses the order, but still begins with the same corner.
      const std::size_t at = begin + (this->Faces.clockwise && i > 0 ? corners - i : i);
      const std::int32_t point = this->Faces.index[at];
      if (std::size_t(point) >= this->Faces.points.size())
      {
        return Error{ ErrorCode::InvalidInput,
          this->PlaceOfFace() + " names point " + std::to_string(point) + ", but there are " +
            std::to_string(this->Faces.points.size()) + ", counted from 0" };
      }
      Values values{};
      for (std::size_t k = 0; k < 3; ++k)
      {
        values[k] = this->ValueOf(*this->Channels()[k], at, point);
      }
      const Result<VertexId> vertex = this->VertexOf(static_cast<VertexId>(point), values);
      KDSTREAM_TRY(vertex);
      this->Vertices.push_back(*vertex);
      this->Places.push_back(this->Faces.points[std::size_t(point)]);
    }
    this->Out.tolerance.Count(Lapse::AttributeMissing, this->Lacks ? 1 : 0, this->PlaceOfFace());
    for (const Triangle& t : this->Cutter.Cut(this->Places))
    {
      this->Out.mesh.triangles.push_back(
        { this->Vertices[t[0]], this->Vertices[t[1]], this->Vertices[t[2]] });
    }
    return {};
  }

  Result<VertexId> VertexOf(VertexId point, const Values& values)
  {
    if (this->ValuesOf[point][0] == unsetValue)
    {
      this->ValuesOf[point] = values;
    }
    if (this->ValuesOf[point] == values)
    {
      return point;
    }
    std::vector<Vec3>& points = this->Out.mesh.points;
    if (points.size() >= noVertex - 2)
    {
      return Error{ ErrorCode::LimitExceeded, "more than 4294967292 vertices" };
    }
    const auto [found, added] =
      this->Further.try_emplace({ point, values }, static_cast<VertexId>(points.size()));
    if (added)
    {
      points.push_back(Vec3(points[point]));
      this->ValuesOf.push_back(values);
    }
    return found->second;
  }

  // For a vertex that no face uses: the values of its own number.
  Values ValuesAt(std::size_t vertex) const
  {
    if (this->ValuesOf[vertex][0] != unsetValue)
    {
      return this->ValuesOf[vertex];
    }
    Values values = noValues;
    for (std::size_t k = 0; k < 3; ++k)
    {
      const VrmlChannel& channel = *this->Channels()[k];
      const bool own = channel.perVertex && channel.index.empty() && vertex < channel.count;
      values[k] = own ? static_cast<std::uint32_t>(vertex) : noValue;
    }
    return values;
  }

  void AddAttributes()
  {
    Mesh& mesh = this->Out.mesh;
    const std::size_t count = mesh.points.size();
    if (this->Faces.normals.count > 0)
    {
      this->AddFloats(MakeNormals(count), 1, this->Faces.normalValues);
    }
    if (this->Faces.coordinates.count > 0)
    {
      this->AddFloats(MakePointAttribute("TCoords", AttributeType::Float32, 2, count), 2,
        this->Faces.coordinateValues);
    }
    const bool own = this->Faces.colors.count > 0;
    if (own || this->Faces.hasMaterial)
    {
      std::vector<Color> colors(count, this->Faces.material);
      for (std::size_t i = 0; own && i < count; ++i)
      {
        const std::uint32_t value = this->ValuesAt(i)[0];
        colors[i] = value == noValue ? this->Faces.material : this->Faces.colorValues[value];
      }
      AddColors(mesh, colors);
    }
  }

  template <std::size_t Components>
  void AddFloats(
    Attribute made, std::size_t channel, std::span<const std::array<float, Components>> from)
  {
    for (std::size_t i = 0; i < this->Out.mesh.points.size(); ++i)
    {
      const std::uint32_t value = this->ValuesAt(i)[channel];
      for (std::size_t k = 0; k < Components && value != noValue; ++k)
      {
        made.Set(i, k, double(from[value][k]));
      }
    }
    this->Out.mesh.attributes.push_back(std::move(made));
  }

  const VrmlFaces& Faces;
  const std::string& What;
  ForeignMesh Out;
  std::size_t Face = 0;
  bool Lacks = false; // a corner names a value that does not exist
  std::vector<Values> ValuesOf;
  std::map<std::pair<VertexId, Values>, VertexId> Further;
  std::vector<VertexId> Vertices; // of the current face
  std::vector<Vec3> Places;
  PolygonCutter Cutter;
};

}

Result<ForeignMesh> ReadVrmlFaces(const VrmlFaces& faces, const std::string& what)
{
  return FacesReader(faces, what).Read();
}

}
