// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. Divide the triangles into those that this piece shows and those of its neighbours.
// 2. Add those that it shows.
// 3. Add skirts: lowered copies of the neighbours' triangles, and bands from outer edges.
// 4. Add the vertices with their attributes.
#include "filters/tiles/TileMesh.h"

#include "filters/core/BitCast.h"
#include "filters/core/VectorMath.h"
#include "filters/core/drawing/PartNormals.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <unordered_map>
#include <unordered_set>
#include <utility>

namespace kdstream
{
namespace
{

using Corners = std::array<PicturePlace, 3>;

// The vector scaled to length 1; 0 for a zero vector.
Vec3 UnitOrZero(const Vec3& vector)
{
  const double length = std::hypot(vector[0], vector[1], vector[2]);
  return length > 0 && std::isfinite(length) ? Times(vector, 1 / length) : Vec3{};
}

// A vertex of the tile: the vertex of the piece, lowered or not, and its place in the picture.
struct TileCorner
{
  std::uint32_t vertex = 0; // index in the piece
  bool lowered = false;
  PicturePlace place{};
};

struct TileCornerHash
{
  std::size_t operator()(const TileCorner& corner) const
  {
    const auto place = BitCast<std::uint64_t>(corner.place);
    return (2 * std::size_t{ corner.vertex } + corner.lowered) * 0x9E3779B97F4A7C15U ^
           (place ^ place >> 29U) * 0xBF58476D1CE4E5B9U;
  }
};

struct SameTileCorner
{
  bool operator()(const TileCorner& a, const TileCorner& b) const
  {
    return a.vertex == b.vertex && a.lowered == b.lowered &&
           BitCast<std::uint64_t>(a.place) == BitCast<std::uint64_t>(b.place);
  }
};

// Makes vertices that have the attributes of a mesh or piece.
class TileVertices
{
public:
  TileVertices(TileMesh& out, std::span<const Vec3> points, std::span<const Attribute> attributes,
    std::vector<Vec3> sums, bool normals, double depth)
    : Out(out)
    , Points(points)
    , Sums(std::move(sums))
    , Normals(normals ? FindRole(attributes, AttributeRole::Normals) : nullptr)
    , Colors(FindRole(attributes, AttributeRole::Colors))
    , WithNormals(normals && (this->Normals || !this->Sums.empty()))
    , Depth(depth)
  {
    for (const Attribute& attribute : attributes)
    {
      if (IsTileArray(attribute))
      {
        this->Arrays.push_back(&attribute);
        this->Out.arrays.push_back({ attribute.name, attribute.components, {} });
      }
    }
  }

  void Add(const TileCorner& corner, bool withPicture)
  {
    const std::size_t v = corner.vertex;
    const Vec3 down = corner.lowered ? Times(UnitOrZero(this->Sums[v]), -this->Depth) : Vec3{};
    this->Out.points.push_back(Plus(this->Points[v], down));
    if (this->WithNormals)
    {
      Vec3 normal = this->Normals ? Vec3{ this->Normals->Get(v, 0), this->Normals->Get(v, 1),
        this->Normals->Get(v, 2) }
                                  : this->Sums[v];
      normal = UnitOrZero(normal);
      this->Out.normals.push_back(normal == Vec3{} ? Vec3{ 0, 0, 1 } : normal);
    }
    for (std::size_t a = 0; a < this->Arrays.size(); ++a)
    {
      for (std::size_t k = 0; k < this->Arrays[a]->components; ++k)
      {
        this->Out.arrays[a].values.push_back(float(this->Arrays[a]->Get(v, k)));
      }
    }
    if (withPicture)
    {
      this->Out.places.push_back(corner.place);
    }
    else if (this->Colors)
    {
      std::array<std::uint8_t, 4> color{ 0, 0, 0, 255 };
      for (std::size_t k = 0; k < std::min<std::size_t>(this->Colors->components, 4); ++k)
      {
        color[k] = static_cast<std::uint8_t>(this->Colors->Get(v, k));
      }
      this->Out.colors.push_back(color);
    }
  }

private:
  TileMesh& Out;
  const std::span<const Vec3> Points;
  const std::vector<Vec3> Sums; // of the area vectors around each point; empty for a cloud
  const Attribute* const Normals;
  const Attribute* const Colors;
  std::vector<const Attribute*> Arrays; // the attributes for the arrays of Out
  const bool WithNormals;
  const double Depth;
};

// For each vertex of a piece the sum of the area vectors around it; empty for a cloud.
std::vector<Vec3> SumsOf(const Piece& piece, std::span<const BorderNormal> borders)
{
  if (piece.triangles.empty())
  {
    return {};
  }
  std::vector<Vec3> sums = SumOfNormals(piece.positions, piece.triangles);
  for (std::size_t v = piece.ownVertices; v < sums.size(); ++v)
  {
    const auto found = std::lower_bound(borders.begin(), borders.end(), piece.keys[v],
      [](const BorderNormal& border, VertexKey key) { return border.key < key; });
    if (found != borders.end() && found->key == piece.keys[v])
    {
      sums[v] = { found->normal[0], found->normal[1], found->normal[2] };
    }
  }
  return sums;
}

class TileCut
{
public:
  TileCut(const Piece& piece, const TextureTile* texture, const TileMeshOptions& options)
    : From(piece)
    , Texture(texture)
    , Vertices(this->Out, piece.positions, piece.attributes, SumsOf(piece, options.borders),
        options.normals, options.skirtDepth)
  {
  }

  TileMesh Cut()
  {
    if (this->From.primitive == PrimitiveType::Points)
    {
      for (std::uint32_t v = 0; v < this->From.ownVertices; ++v)
      {
        this->Vertices.Add({ v }, false);
      }
      return std::move(this->Out);
    }
    std::vector<std::size_t> shown, others;
    for (std::size_t t = 0; t < this->From.triangles.size(); ++t)
    {
      (this->From.Owns(this->From.triangles[t]) ? shown : others).push_back(t);
    }
    if (shown.empty())
    {
      return {};
    }
    for (const std::size_t t : shown)
    {
      this->Out.triangles.push_back(this->Add(t, { false, false, false }));
    }
    for (const std::size_t t : others)
    {
      this->AddLowered(t);
    }
    this->AddBands(shown, others);
    if (this->Texture)
    {
      this->Out.picture = this->Texture->image;
      this->Out.pictureFormat = this->Texture->format;
    }
    return std::move(this->Out);
  }

private:
  bool IsOwn(VertexId v) const { return v < this->From.ownVertices; }

  PicturePlace PlaceOf(std::size_t t, std::size_t k) const
  {
    if (!this->Texture)
    {
      return {};
    }
    const TileCoordinate& place = this->Texture->corners[t][k];
    return { std::clamp(place[0] / float(this->Texture->width), 0.0F, 1.0F) + 0.0F,
      std::clamp(place[1] / float(this->Texture->height), 0.0F, 1.0F) + 0.0F };
  }

  VertexId Number(const TileCorner& corner)
  {
    const auto [entry, isNew] =
      this->Numbers.try_emplace(corner, static_cast<VertexId>(this->Out.points.size()));
    if (isNew)
    {
      this->Vertices.Add(corner, this->Texture != nullptr);
    }
    return entry->second;
  }

  Triangle Add(std::size_t t, const std::array<bool, 3>& lowered)
  {
    Triangle added{};
    for (std::size_t k = 0; k < 3; ++k)
    {
      added[k] = this->Number({ this->From.triangles[t][k], lowered[k], this->PlaceOf(t, k) });
    }
    return added;
  }

  void AddLowered(std::size_t t)
  {
    std::array<bool, 3> lowered{};
    for (std::size_t k = 0; k < 3; ++k)
    {
      lowered[k] = !this->IsOwn(this->From.triangles[t][k]);
    }
    this->Out.skirts.push_back(this->Add(t, lowered));
  }

  static std::uint64_t EdgeOf(VertexId from, VertexId to)
  {
    return std::uint64_t{ from } << 32U | to;
  }

  std::unordered_set<std::uint64_t> EdgesOf(const std::vector<std::size_t>& triangles) const
  {
    std::unordered_set<std::uint64_t> edges;
    for (const std::size_t t : triangles)
    {
      const Triangle& corners = this->From.triangles[t];
      for (std::size_t k = 0; k < 3; ++k)
      {
        edges.insert(EdgeOf(corners[k], corners[(k + 1) % 3]));
      }
    }
    return edges;
  }

  // Adds a band from each outer edge of the displayed triangles down to the same edge with its
  // ghosts lowered. Some edges have an own vertex but no adjacent triangle of another piece. These
  // are the border of the surface itself, with nothing behind, and get no band.
  void AddBands(const std::vector<std::size_t>& shown, const std::vector<std::size_t>& others)
  {
    const auto inner = this->EdgesOf(shown), outer = this->EdgesOf(others);
    for (const std::size_t t : shown)
    {
      const Triangle& corners = this->From.triangles[t];
      for (std::size_t k = 0; k < 3; ++k)
      {
        const std::size_t next = (k + 1) % 3;
        const VertexId p = corners[k], q = corners[next];
        const bool ownP = this->IsOwn(p), ownQ = this->IsOwn(q);
        const std::uint64_t back = EdgeOf(q, p);
        if (p == q || (ownP && ownQ) || inner.count(back) > 0 ||
            ((ownP || ownQ) && outer.count(back) == 0))
        {
          continue;
        }
        const PicturePlace placeP = this->PlaceOf(t, k), placeQ = this->PlaceOf(t, next);
        const VertexId upperP = this->Number({ p, false, placeP });
        const VertexId upperQ = this->Number({ q, false, placeQ });
        const VertexId lowerP = this->Number({ p, !ownP, placeP });
        const VertexId lowerQ = this->Number({ q, !ownQ, placeQ });
        for (const Triangle& added :
          { Triangle{ upperQ, upperP, lowerP }, Triangle{ upperQ, lowerP, lowerQ } })
        {
          if (added[0] != added[1] && added[1] != added[2] && added[2] != added[0])
          {
            this->Out.skirts.push_back(added);
          }
        }
      }
    }
  }

  const Piece& From;
  const TextureTile* const Texture;
  TileMesh Out;
  TileVertices Vertices;
  std::unordered_map<TileCorner, VertexId, TileCornerHash, SameTileCorner> Numbers;
};

}

bool IsTileArray(const AttributeInfo& array)
{
  constexpr std::uint8_t mostComponents = 4;
  const AttributeRole role = RoleOf(array);
  return array.association == AttributeAssociation::Point && array.components >= 1 &&
         array.components <= mostComponents && role != AttributeRole::Normals &&
         role != AttributeRole::Colors;
}

bool IsExactInTiles(const AttributeInfo& array)
{
  return SizeOf(array.type) <= 2 || array.type == AttributeType::Float32;
}

std::vector<BorderNormal> BorderNormalsOf(const Piece& piece)
{
  if (piece.GhostCount() == 0)
  {
    return {};
  }
  std::vector<bool> onBorder(piece.ownVertices, false);
  for (const Triangle& t : piece.triangles)
  {
    const bool crosses = *std::max_element(t.begin(), t.end()) >= piece.ownVertices;
    for (const VertexId v : t)
    {
      if (crosses && v < piece.ownVertices)
      {
        onBorder[v] = true;
      }
    }
  }
  const std::vector<Vec3> sums = SumOfNormals(piece.positions, piece.triangles);
  std::vector<BorderNormal> borders;
  for (std::uint32_t v = 0; v < piece.ownVertices; ++v)
  {
    if (onBorder[v])
    {
      const Vec3 unit = UnitOrZero(sums[v]);
      borders.push_back({ piece.keys[v], { float(unit[0]), float(unit[1]), float(unit[2]) } });
    }
  }
  return borders;
}

TileMesh CutTileMesh(const Piece& piece, const TextureTile* texture, const TileMeshOptions& options)
{
  return TileCut(piece, texture, options).Cut();
}

bool ShowsTriangles(const Piece& piece)
{
  return std::any_of(piece.triangles.begin(), piece.triangles.end(),
    [&piece](const Triangle& triangle) { return piece.Owns(triangle); });
}

TileMesh WholeTileMesh(const Mesh& mesh, bool normals)
{
  TileMesh out;
  TileVertices vertices(out, mesh.points, mesh.attributes,
    mesh.triangles.empty() ? std::vector<Vec3>() : SumOfNormals(mesh.points, mesh.triangles),
    normals, 0);
  for (std::uint32_t v = 0; v < mesh.points.size(); ++v)
  {
    vertices.Add({ v }, false);
  }
  out.triangles = mesh.triangles;
  return out;
}

}
