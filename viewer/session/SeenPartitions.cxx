// SPDX-License-Identifier: BSD-3-Clause
// Which partitions may be seen: see SeenPartitions.h.
#include "viewer/session/SeenPartitions.h"

#include "viewer/session/Geometry.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace kdstream
{
namespace
{
// 24 MB at most are kept; a view of many more begins anew.
constexpr std::size_t mostFaces = 500'000;
// The sine of the margin.
constexpr double margin = 0.17;
}

SeenPartitions::SeenPartitions(const TreeDepths& depths)
  : Depths(depths)
{
}

Resolution SeenPartitions::Source() const
{
  return Resolution::Level(std::max(this->Depths.stitch, PreviewLevel(this->Depths)));
}

void SeenPartitions::Add(const Piece& piece)
{
  if (piece.id.resolution != this->Source())
  {
    return;
  }
  if (this->Faces > mostFaces)
  {
    this->Known.clear();
    this->Faces = 0;
  }
  const unsigned below = this->Depths.partition - DepthOfNode(piece.id.node);
  const std::uint32_t first = (piece.id.node << below) - (NodeId{ 1 } << this->Depths.partition);
  for (std::uint32_t i = 0; i < std::uint32_t{ 1 } << below; ++i)
  {
    this->Faces -= std::exchange(this->Known[first + i], {}).faces.size();
  }
  for (const Triangle& t : piece.triangles)
  {
    const Face face = FaceOf(piece, t);
    std::optional<std::uint32_t> last[2];
    for (std::size_t k = 0; k < 3; ++k)
    {
      const bool own = t[k] < piece.ownVertices;
      const auto partition = own ? std::optional(PartitionOfKey(piece.keys[t[k]])) : std::nullopt;
      if (partition && partition != last[0] && partition != last[1]) // each once
      {
        this->Known[*partition].faces.push_back(face);
        ++this->Faces;
      }
      last[k % 2] = partition;
    }
  }
}

SeenPartitions::Face SeenPartitions::FaceOf(const Piece& piece, const Triangle& t)
{
  const Vec3 &a = piece.positions[t[0]], &b = piece.positions[t[1]], &c = piece.positions[t[2]];
  Face face;
  face.centre = (a + b + c) * (1.0 / 3);
  face.normal = Normalized(Cross(b - a, c - a));
  face.radius =
    1.5 * std::max({ Length(a - face.centre), Length(b - face.centre), Length(c - face.centre) });
  return face;
}

bool SeenPartitions::IsNearlyClosed(const Piece& whole)
{
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const Triangle& t : whole.triangles)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      edges.push_back(std::minmax(t[k], t[(k + 1) % 3]));
    }
  }
  std::sort(edges.begin(), edges.end());
  std::size_t all = 0, single = 0;
  for (auto edge = edges.begin(); edge != edges.end();)
  {
    const auto next =
      std::find_if(edge, edges.end(), [edge](const auto& other) { return other != *edge; });
    ++all;
    single += next - edge == 1 ? 1 : 0;
    edge = next;
  }
  return all > 0 && single <= all / 200;
}

void SeenPartitions::LookThrough(const Camera& camera, bool closed)
{
  const Vec3 eye = camera.Eye();
  const auto planes = camera.InwardNormals();
  const auto mayBeSeen = [&](const Face& face)
  {
    const Vec3 sight = face.centre - eye;
    return (!closed || Dot(sight, face.normal) <= margin * Length(sight)) &&
           std::all_of(planes.begin(), planes.end(),
             [&](const Vec3& inward) { return Dot(sight, inward) >= -face.radius; });
  };
  for (auto& [number, partition] : this->Known)
  {
    partition.seen = partition.faces.empty() ||
                     std::any_of(partition.faces.begin(), partition.faces.end(), mayBeSeen);
  }
}

bool SeenPartitions::MayBeSeen(NodeId node) const
{
  const unsigned below = this->Depths.partition - DepthOfNode(node);
  const std::uint32_t first = (node << below) - (NodeId{ 1 } << this->Depths.partition);
  const std::uint32_t end = first + (std::uint32_t{ 1 } << below);
  std::uint32_t next = first;
  for (auto known = this->Known.lower_bound(first);
       known != this->Known.end() && known->first < end; ++known, ++next)
  {
    if (known->first != next || known->second.seen)
    {
      return true;
    }
  }
  return next != end; // of some nothing is known
}

}
