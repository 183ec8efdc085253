// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/JoinParts.h"

#include "filters/convert/PointAttributes.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <unordered_set>

namespace kdstream
{
namespace
{

bool IsColor(const Attribute& attribute)
{
  return RoleOf(attribute) == AttributeRole::Colors;
}

// Gives the mesh colours, white if it has none. With `alpha`, colours of three components get a
// fourth.
void GiveColors(Mesh& mesh, bool alpha)
{
  auto found = std::find_if(mesh.attributes.begin(), mesh.attributes.end(), IsColor);
  Attribute colors = MakeColors(mesh.points.size(), alpha);
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
  {
    for (std::size_t k = 0; k < colors.components; ++k)
    {
      const bool known = found != mesh.attributes.end() && k < found->components;
      colors.values[i * colors.components + k] =
        known ? found->values[i * found->components + k] : 255;
    }
  }
  if (found != mesh.attributes.end())
  {
    mesh.attributes.erase(found);
  }
  mesh.attributes.push_back(std::move(colors));
}

// Collects warnings, each only once.
class Warnings
{
public:
  void Add(const std::string& warning, std::vector<std::string>& warnings)
  {
    if (this->Given.insert(warning).second)
    {
      warnings.push_back(warning);
    }
  }

private:
  std::unordered_set<std::string> Given;
};

// Counts for each array how many parts with points have it.
class ArrayCount
{
public:
  explicit ArrayCount(std::span<const ForeignMesh> parts)
  {
    for (const ForeignMesh& part : parts)
    {
      this->Parts += part.mesh.points.empty() ? 0 : 1;
      for (const Attribute& attribute : part.mesh.attributes)
      {
        this->Counts[KeyOf(attribute)] += part.mesh.points.empty() ? 0 : 1;
      }
    }
  }
  bool IsInAll(const AttributeInfo& info) const
  {
    const auto found = this->Counts.find(KeyOf(info));
    return found != this->Counts.end() && found->second == this->Parts;
  }

private:
  static std::tuple<std::string, int, int, int> KeyOf(const AttributeInfo& info)
  {
    return { info.name, int(info.type), int(info.association), info.components };
  }

  std::map<std::tuple<std::string, int, int, int>, std::size_t> Counts;
  std::size_t Parts = 0;
};

void UnifyColors(std::span<ForeignMesh> parts)
{
  std::size_t with = 0, withAlpha = 0;
  for (const ForeignMesh& part : parts)
  {
    const auto& attributes = part.mesh.attributes;
    const auto found = std::find_if(attributes.begin(), attributes.end(), IsColor);
    with += found != attributes.end();
    withAlpha += found != attributes.end() && found->components == 4;
  }
  if (with > 0 && (with < parts.size() || (withAlpha > 0 && withAlpha < with)))
  {
    for (ForeignMesh& part : parts)
    {
      GiveColors(part.mesh, withAlpha > 0);
    }
  }
}

}

void AddColors(Mesh& mesh, const std::vector<Color>& colors)
{
  const bool opaque =
    std::all_of(colors.begin(), colors.end(), [](const Color& c) { return c[3] >= 1; });
  Attribute attribute = MakeColors(colors.size(), !opaque);
  for (std::size_t i = 0; i < colors.size(); ++i)
  {
    for (std::size_t k = 0; k < attribute.components; ++k)
    {
      attribute.Set(i, k, 255 * colors[i][k]);
    }
  }
  mesh.attributes.push_back(std::move(attribute));
}

Result<ForeignMesh> JoinParts(std::span<ForeignMesh> parts)
{
  std::uint64_t points = 0;
  for (const ForeignMesh& part : parts)
  {
    points += part.mesh.points.size();
  }
  KDSTREAM_TRY(CheckPointCount(points));
  ForeignMesh joined;
  UnifyColors(parts);
  Mesh& mesh = joined.mesh;
  mesh.scalarType = ScalarType::Float32;
  const ArrayCount arrays(parts);
  Warnings warnings;
  for (const ForeignMesh& part : parts)
  {
    for (const Attribute& attribute : part.mesh.attributes)
    {
      if (!arrays.IsInAll(attribute))
      {
        warnings.Add(
          "array \"" + attribute.name + "\" is dropped: not all parts have it", joined.warnings);
      }
      else if (!FindAttribute(mesh.attributes, attribute))
      {
        Attribute empty;
        static_cast<AttributeInfo&>(empty) = attribute;
        mesh.attributes.push_back(std::move(empty));
      }
    }
    for (const std::string& warning : part.warnings)
    {
      warnings.Add(warning, joined.warnings);
    }
  }
  for (const ForeignMesh& part : parts)
  {
    if (part.mesh.points.empty())
    {
      continue;
    }
    const auto offset = static_cast<VertexId>(mesh.points.size());
    mesh.points.insert(mesh.points.end(), part.mesh.points.begin(), part.mesh.points.end());
    for (const Triangle& t : part.mesh.triangles)
    {
      mesh.triangles.push_back({ t[0] + offset, t[1] + offset, t[2] + offset });
    }
    if (part.mesh.scalarType == ScalarType::Float64)
    {
      mesh.scalarType = ScalarType::Float64;
    }
    for (Attribute& attribute : mesh.attributes)
    {
      const Attribute* const from = FindAttribute(part.mesh.attributes, attribute);
      attribute.values.insert(attribute.values.end(), from->values.begin(), from->values.end());
    }
  }
  return joined;
}

}
