// SPDX-License-Identifier: BSD-3-Clause
// Which parts of a model may be visible: see VisiblePartitions.h.
#include "viewer/session/model/VisiblePartitions.h"

#include "viewer/session/Geometry.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

namespace kdstream
{
namespace
{
// At most 14 MB are kept; beyond that, everything known is dropped.
constexpr std::size_t mostFaces = 500'000;
constexpr double margin = 0.17; // the sine of 10 degrees

// The nodes of pieces of the next level that hold children of a triangle's own corners, each once.
std::vector<NodeId> NodesBelow(const Piece& piece, const Triangle& t)
{
  std::vector<NodeId> nodes;
  for (const std::uint32_t v : t)
  {
    for (std::uint32_t i = v < piece.ownVertices ? piece.childBegin[v] : 0;
         v < piece.ownVertices && i < piece.childBegin[v + 1]; ++i)
    {
      if (std::find(nodes.begin(), nodes.end(), piece.childNodes[i]) == nodes.end())
      {
        nodes.push_back(piece.childNodes[i]);
      }
    }
  }
  return nodes;
}
}

// Which faces a camera may see.
class VisiblePartitions::Sight
{
public:
  Sight(const Camera& camera, bool closed)
    : Eye(camera.Eye())
    , Planes(camera.InwardNormals())
    , Closed(closed)
  {
  }

  bool operator==(const Sight&) const = default;

  bool MaySee(const FaceList& list) const
  {
    const Vec3 toOrigin = list.origin - this->Eye;
    return std::any_of(list.faces.begin(), list.faces.end(),
      [&](const Face& face) { return this->MaySee(face, toOrigin); });
  }

private:
  static Vec3 Wide(const std::array<float, 3>& v) { return { v[0], v[1], v[2] }; }

  bool MaySee(const Face& face, const Vec3& toOrigin) const
  {
    const Vec3 sight = toOrigin + Wide(face.centre);
    return (!this->Closed || Dot(sight, Wide(face.normal)) <= margin * Length(sight)) &&
           std::all_of(this->Planes.begin(), this->Planes.end(),
             [&](const Vec3& inward) { return Dot(sight, inward) >= -face.radius; });
  }

  Vec3 Eye;
  std::array<Vec3, 5> Planes;
  bool Closed;
};

VisiblePartitions::VisiblePartitions(const TreeDepths& depths)
  : Depths(depths)
{
}

void VisiblePartitions::Add(const Piece& piece)
{
  const auto preview = Resolution::Level(PreviewLevel(this->Depths));
  const auto stitch = std::max(Resolution::Level(this->Depths.stitch), preview);
  if (piece.id.resolution == stitch)
  {
    this->MakeRoom();
    this->AddFaces(piece);
  }
  else if (piece.id.resolution >= preview && piece.id.resolution < stitch)
  {
    this->MakeRoom();
    this->AddFacesAbove(piece);
  }
}

// Call before faces are added: drops everything known if there are too many faces.
void VisiblePartitions::MakeRoom()
{
  this->Last.reset();
  if (this->Faces > mostFaces)
  {
    this->Partitions.clear();
    this->Above.clear();
    this->Faces = 0;
  }
}

VisiblePartitions::Face VisiblePartitions::FaceOf(
  const Piece& piece, const Triangle& t, const Vec3& origin)
{
  const auto narrow = [](const Vec3& v)
  {
    return std::array<float, 3>{ static_cast<float>(v[0]), static_cast<float>(v[1]),
      static_cast<float>(v[2]) };
  };
  const Vec3 a = piece.positions[t[0]] - origin, b = piece.positions[t[1]] - origin,
             c = piece.positions[t[2]] - origin;
  const Vec3 centre = (a + b + c) * (1.0 / 3);
  const double radius =
    1.5 * std::max({ Length(a - centre), Length(b - centre), Length(c - centre) });
  return { narrow(centre), narrow(Normalized(Cross(b - a, c - a))), static_cast<float>(radius) };
}

void VisiblePartitions::AddTo(FaceList& list, const Face& face)
{
  list.faces.push_back(face);
  ++this->Faces;
}

void VisiblePartitions::AddFaces(const Piece& piece)
{
  const unsigned below = this->Depths.partition - DepthOfNode(piece.id.node);
  const std::uint32_t first = (piece.id.node << below) - (NodeId{ 1 } << this->Depths.partition);
  for (std::uint32_t i = 0; i < std::uint32_t{ 1 } << below; ++i)
  {
    this->Faces -= std::exchange(this->Partitions[first + i], {}).list.faces.size();
  }
  const Vec3 origin = piece.positions.empty() ? Vec3{} : piece.positions.front();
  for (const Triangle& t : piece.triangles)
  {
    const Face face = FaceOf(piece, t, origin);
    std::optional<std::uint32_t> last[2];
    for (std::size_t k = 0; k < 3; ++k)
    {
      const bool own = t[k] < piece.ownVertices;
      const auto partition = own ? std::optional(PartitionOfKey(piece.keys[t[k]])) : std::nullopt;
      if (partition && partition != last[0] && partition != last[1]) // each once
      {
        FaceList& list = this->Partitions[*partition].list;
        list.origin = origin;
        this->AddTo(list, face);
      }
      last[k % 2] = partition;
    }
  }
}

// Adds each triangle to the pieces that hold the children of its own corners.
void VisiblePartitions::AddFacesAbove(const Piece& piece)
{
  std::vector<Below>& all = this->Above[piece.id];
  for (const Below& below : std::exchange(all, {}))
  {
    this->Faces -= below.list.faces.size();
  }
  const Vec3 origin = piece.positions.empty() ? Vec3{} : piece.positions.front();
  for (const Triangle& t : piece.triangles)
  {
    const Face face = FaceOf(piece, t, origin);
    const std::vector<NodeId> nodes = NodesBelow(piece, t);
    for (const NodeId node : nodes)
    {
      auto below = std::find_if(
        all.begin(), all.end(), [node](const Below& each) { return each.node == node; });
      if (below == all.end())
      {
        below = all.insert(all.end(), { node, { origin, {} } });
      }
      this->AddTo(below->list, face);
    }
  }
}

bool VisiblePartitions::Knows(PieceId piece) const
{
  const unsigned below = this->Depths.partition - DepthOfNode(piece.node);
  const std::uint32_t first = (piece.node << below) - (NodeId{ 1 } << this->Depths.partition);
  return this->Above.count(piece) != 0 ||
         (piece.resolution >= Resolution::Level(this->Depths.stitch) &&
           this->Partitions.count(first) != 0);
}

bool VisiblePartitions::IsNearlyClosed(const Piece& whole)
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

void VisiblePartitions::Cull(const Camera& camera, bool closed)
{
  const Sight sight(camera, closed);
  if (this->Last && *this->Last == sight)
  {
    return;
  }
  this->Last = std::make_shared<Sight>(sight);
  for (auto& [number, partition] : this->Partitions)
  {
    partition.visible = partition.list.faces.empty() || sight.MaySee(partition.list);
  }
  this->Visible.clear();
  for (const auto& [piece, all] : this->Above)
  {
    const Resolution next = Resolution::Level(piece.resolution.Depth() + 1);
    for (const Below& below : all)
    {
      if (sight.MaySee(below.list))
      {
        this->Visible.insert({ next, below.node });
      }
    }
  }
}

bool VisiblePartitions::MayBeVisible(NodeId node) const
{
  const unsigned below = this->Depths.partition - DepthOfNode(node);
  const std::uint32_t first = (node << below) - (NodeId{ 1 } << this->Depths.partition);
  const std::uint32_t end = first + (std::uint32_t{ 1 } << below);
  std::uint32_t next = first;
  for (auto known = this->Partitions.lower_bound(first);
       known != this->Partitions.end() && known->first < end; ++known, ++next)
  {
    if (known->first != next || known->second.visible)
    {
      return true;
    }
  }
  return next != end; // some partitions are unknown
}

}
