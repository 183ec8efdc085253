// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. sort the edges: those that occur once are on the border
// 2. make cells as wide as the largest reach, and search the cells around each vertex for a near
//    vertex of another tile
// 3. a vertex without a near one is added to its cell, for later vertices.
#include "filters/convert/gltf/JoinedBorders.h"

#include "filters/core/Attribute.h"
#include "filters/core/SeededHash.h"
#include "filters/core/VectorMath.h"
#include "filters/meshio/DroppedPoints.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_map>
#include <utility>

namespace kdstream
{
namespace
{

constexpr double reachOfSide = 0x1p-14; // 16-bit rounding of both tiles, with a factor 2
// Further vertices in a cell are not compared. Only damaged files have this many vertices so close
// together.
constexpr std::size_t mostInCell = 64;

struct CellHash
{
  std::uint64_t seed = 0;
  std::size_t operator()(const Vec3& cell) const { return HashOfPlace(cell, this->seed); }
};

// Gives both vertices the same normal, if their normals differ only by the rounding of tiles.
// Without this, welding would not join them: it requires equal arrays.
void JoinNormals(Mesh& mesh, VertexId from, VertexId to)
{
  constexpr double nearlyEqual = 0.999; // 2.5 degrees; normals of 3 bytes round by half a degree
  const auto normals = std::find_if(mesh.attributes.begin(), mesh.attributes.end(),
    [](const Attribute& array) { return RoleOf(array) == AttributeRole::Normals; });
  if (normals == mesh.attributes.end())
  {
    return;
  }
  double cosine = 0;
  for (std::size_t k = 0; k < 3; ++k)
  {
    cosine += normals->Get(from, k) * normals->Get(to, k);
  }
  for (std::size_t k = 0; k < 3 && cosine > nearlyEqual; ++k)
  {
    normals->Set(to, k, normals->Get(from, k));
  }
}

Vec3 CellOf(const Vec3& point, double side)
{
  return WithPositiveZeros(
    { std::floor(point[0] / side), std::floor(point[1] / side), std::floor(point[2] / side) });
}

}

void JoinedBorders::Add(const Mesh& mesh, std::size_t first, std::uint32_t tile, const Box& box)
{
  std::vector<std::pair<VertexId, VertexId>> edges;
  edges.reserve(3 * (mesh.triangles.size() - first));
  for (std::size_t t = first; t < mesh.triangles.size(); ++t)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      edges.push_back(std::minmax({ mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3] }));
    }
  }
  std::sort(edges.begin(), edges.end());
  std::vector<VertexId> border;
  for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end)
  {
    for (end = begin; end < edges.size() && edges[end] == edges[begin]; ++end)
    {
    }
    if (end == begin + 1)
    {
      border.insert(border.end(), { edges[begin].first, edges[begin].second });
    }
  }
  std::sort(border.begin(), border.end());
  border.erase(std::unique(border.begin(), border.end()), border.end());
  double side = 0;
  for (std::size_t k = 0; k < 3 && !box.Empty(); ++k)
  {
    side = std::max(side, box.hi[k] - box.lo[k]);
  }
  for (const VertexId number : border)
  {
    this->Vertices.push_back({ number, tile, reachOfSide * side });
  }
}

void JoinedBorders::Close(Mesh& mesh) const
{
  double cell = 0;
  for (const Vertex& vertex : this->Vertices)
  {
    cell = std::max(cell, std::isfinite(vertex.reach) ? vertex.reach : 0.0);
  }
  if (!(cell > 0))
  {
    return;
  }
  constexpr std::size_t fewest = 1024;
  std::unordered_map<Vec3, std::vector<const Vertex*>, CellHash> cells(
    fewest, CellHash{ RandomSeed() });
  for (const Vertex& vertex : this->Vertices)
  {
    Vec3& point = mesh.points[vertex.number];
    if (!IsFinite(point))
    {
      continue;
    }
    const Vec3 own = CellOf(point, cell);
    std::optional<std::pair<double, VertexId>> nearest;
    for (int around = 0; around < 27; ++around)
    {
      const Vec3 looked{ own[0] + around % 3 - 1, own[1] + around / 3 % 3 - 1,
        own[2] + around / 9 - 1 };
      const auto found = cells.find(looked);
      for (std::size_t i = 0; found != cells.end() && i < found->second.size(); ++i)
      {
        const Vertex& other = *found->second[i];
        const Vec3& place = mesh.points[other.number];
        const double distance = SquaredDistance(point, place),
                     reach = std::max(vertex.reach, other.reach);
        if (other.tile != vertex.tile && distance <= reach * reach &&
            (!nearest || distance < nearest->first))
        {
          nearest.emplace(distance, other.number);
        }
      }
    }
    if (nearest)
    {
      point = mesh.points[nearest->second];
      JoinNormals(mesh, nearest->second, vertex.number);
      continue;
    }
    std::vector<const Vertex*>& here = cells[own];
    if (here.size() < mostInCell)
    {
      here.push_back(&vertex);
    }
  }
}

}
