// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/pieces/Piece.h"

#include "filters/core/SortTriangles.h"

#include <algorithm>
#include <cmath>

namespace kdstream
{
namespace
{

Error Bad(const std::string& what)
{
  return { ErrorCode::InvalidInput, "piece: " + what };
}

// One function for all messages with a number: building each message where it is used would make
// the web page larger.
Error Bad(const char* before, std::uint64_t number, const char* after)
{
  return Bad(before + std::to_string(number) + after);
}

// Checks that keys ascend, own ones lie in the piece's node, and ghosts outside it.
Status CheckKeys(const Piece& piece, const TreeDepths& depths)
{
  const bool byPartition =
    piece.id.resolution.IsOriginal() || piece.id.resolution.Depth() >= depths.stitch;
  const unsigned below = depths.partition - DepthOfNode(piece.id.node);
  for (std::uint32_t v = 0; v < piece.VertexCount(); ++v)
  {
    const bool own = v < piece.ownVertices;
    if (v != 0 && v != piece.ownVertices && piece.keys[v] <= piece.keys[v - 1])
    {
      return Bad("key of vertex ", v, " does not ascend");
    }
    if (byPartition)
    {
      const std::uint32_t partition = PartitionOfKey(piece.keys[v]);
      if (partition >= NodeId{ 1 } << depths.partition)
      {
        return Bad("vertex ", v, " belongs to a partition that is not in the tree");
      }
      if ((NodeOfPartition(partition, depths) >> below == piece.id.node) != own)
      {
        return Bad("vertex ", v,
          own ? " lies outside its piece's node" : ", a ghost, lies inside its piece's node");
      }
    }
    else if (piece.keys[v] >= noVertex)
    {
      return Bad("rank of vertex ", v, " is too large");
    }
  }
  return {};
}

// Checks that own vertices of the original are 0, 1, 2 …, and that ranks of own vertices of a level
// coarser than S are consecutive.
Status CheckOwnKeys(const Piece& piece, const TreeDepths& depths)
{
  const bool dense =
    piece.id.resolution.IsOriginal() || piece.id.resolution.Depth() < depths.stitch;
  if (!dense || piece.ownVertices == 0)
  {
    return {};
  }
  if (piece.id.resolution.IsOriginal() && IndexOfKey(piece.keys[0]) != 0)
  {
    return Bad("own vertices do not start at index 0");
  }
  if (piece.keys[piece.ownVertices - 1] - piece.keys[0] != piece.ownVertices - 1)
  {
    return Bad("own vertices are not numbered consecutively");
  }
  for (std::uint32_t v = piece.ownVertices; v < piece.VertexCount(); ++v)
  {
    if (piece.keys[v] >= piece.keys[0] && piece.keys[v] <= piece.keys[piece.ownVertices - 1])
    {
      return Bad("ghost ", v, " has the key of an own vertex");
    }
  }
  return {};
}

Status CheckChildNodes(const Piece& piece, const TreeDepths& depths)
{
  const bool has = HasChildNodes(piece.id.resolution, depths);
  if (piece.childBegin.size() != (has ? piece.ownVertices + std::size_t{ 1 } : 0))
  {
    return Bad("the child nodes have ", piece.childBegin.size(), " entries");
  }
  if (!has)
  {
    return piece.childNodes.empty() ? Status{} : Status{ Bad("there must be no child nodes") };
  }
  const unsigned next = piece.id.resolution.Depth() + 1;
  const unsigned nodeDepth = PieceDepth(Resolution::Level(next), depths);
  if (piece.childBegin.front() != 0 || piece.childBegin.back() != piece.childNodes.size())
  {
    return Bad("the vertices do not have all child nodes");
  }
  for (std::size_t i = 0; i + 1 < piece.childBegin.size(); ++i)
  {
    const std::uint32_t begin = piece.childBegin[i], end = piece.childBegin[i + 1];
    if (begin >= end)
    {
      return Bad("vertex ", i, " has no child nodes");
    }
    if (end > piece.childNodes.size())
    {
      return Bad("the child nodes of vertex ", i, " end after the last one");
    }
    for (std::uint32_t k = begin; k < end; ++k)
    {
      if (piece.childNodes[k] >> nodeDepth != 1)
      {
        return Bad("child node ", piece.childNodes[k], " is not a piece of the next level");
      }
      if (k > begin && piece.childNodes[k] <= piece.childNodes[k - 1])
      {
        return Bad("the child nodes of vertex ", i, " do not ascend");
      }
    }
  }
  return {};
}

// Checks that a cluster has the same parent in all lists where it occurs.
Status CheckAncestors(const Piece& piece, const TreeDepths& depths)
{
  const AncestorLevels levels = AncestorLevelsOf(piece.id.resolution, depths);
  if (piece.ancestors.size() !=
      levels.Rows(piece.ownVertices, piece.GhostCount()) * std::uint64_t{ levels.count })
  {
    return Bad("the numbers of ancestors and vertices differ");
  }
  if (std::find(piece.ancestors.begin(), piece.ancestors.end(), noVertex) != piece.ancestors.end())
  {
    return Bad("rank of an ancestor is too large");
  }
  std::vector<std::uint64_t> links; // cluster, its parent
  for (unsigned k = 1; k < levels.count; ++k)
  {
    links.clear();
    for (std::size_t at = k; at < piece.ancestors.size(); at += levels.count)
    {
      const std::uint64_t link =
        std::uint64_t{ piece.ancestors[at] } << 32 | piece.ancestors[at - 1];
      if (links.empty() || links.back() != link) // neighbours have the same ancestors
      {
        links.push_back(link);
      }
    }
    std::sort(links.begin(), links.end());
    for (std::size_t i = 1; i < links.size(); ++i)
    {
      if (links[i] != links[i - 1] && links[i] >> 32 == links[i - 1] >> 32)
      {
        return Bad("cluster ", links[i] >> 32, " has two parents");
      }
    }
  }
  return {};
}

Status CheckTriangles(const Piece& piece)
{
  const std::uint32_t count = piece.VertexCount();
  Triangle last{};
  for (std::size_t i = 0; i < piece.triangles.size(); ++i)
  {
    const Triangle& t = piece.triangles[i];
    if (t[0] >= count || t[1] >= count || t[2] >= count)
    {
      return Bad("triangle ", i, " has an index out of range");
    }
    if (t[0] >= piece.ownVertices)
    {
      return Bad("triangle ", i, " touches no own vertex");
    }
    const bool first = (t[0] < t[1] && t[0] < t[2]) || t == RotateLowestFirst(t); // cheap first
    // Compares two corners as one number, because a processor can hardly predict which of them
    // decides.
    const std::uint64_t edge = std::uint64_t{ t[0] } << 32 | t[1];
    const std::uint64_t lastEdge = std::uint64_t{ last[0] } << 32 | last[1];
    const bool ascends = edge > lastEdge || (edge == lastEdge && t[2] >= last[2]);
    last = t;
    if (!first || !ascends)
    {
      return Bad("triangle ", i, " is out of order");
    }
  }
  if (piece.primitive == PrimitiveType::Points && !piece.triangles.empty())
  {
    return Bad("a point cloud has triangles");
  }
  return {};
}

}

PieceId PieceOfPartition(Resolution resolution, std::uint32_t partition, const TreeDepths& depths)
{
  return { resolution,
    NodeOfPartition(partition, depths) >> (depths.partition - PieceDepth(resolution, depths)) };
}

std::span<const std::uint32_t> Piece::AncestorsOf(std::uint32_t v, const TreeDepths& depths) const
{
  if (this->ancestors.empty())
  {
    return {};
  }
  const AncestorLevels levels = AncestorLevelsOf(this->id.resolution, depths);
  if (!levels.own && v < this->ownVertices)
  {
    return {};
  }
  const std::size_t row = levels.own ? v : v - this->ownVertices;
  return { this->ancestors.data() + row * levels.count, levels.count };
}

Status CheckPiece(const Piece& piece, const TreeDepths& depths)
{
  const Resolution resolution = piece.id.resolution;
  if ((!resolution.IsOriginal() && resolution.Depth() > depths.finest) || piece.id.node == 0 ||
      DepthOfNode(piece.id.node) != PieceDepth(resolution, depths))
  {
    return Bad("node ", piece.id.node, " is not a piece of this resolution");
  }
  const std::size_t count = piece.positions.size();
  if (piece.keys.size() != count || piece.ownVertices > count || count >= noVertex)
  {
    return Bad("the counts of vertices differ");
  }
  if (!piece.geometricErrors.empty() &&
      (resolution.IsOriginal() || piece.geometricErrors.size() != piece.ownVertices))
  {
    return Bad("the numbers of deviations and own vertices differ");
  }
  for (std::size_t v = 0; v < count; ++v)
  {
    const Vec3& p = piece.positions[v];
    if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2]))
    {
      return Bad("vertex ", v, " is not finite");
    }
  }
  for (const auto check : { CheckKeys, CheckOwnKeys, CheckAncestors, CheckChildNodes })
  {
    KDSTREAM_TRY(check(piece, depths));
  }
  KDSTREAM_TRY(CheckTriangles(piece));
  if (Status status =
        CheckAttributes(piece.attributes, piece.positions.size(), piece.triangles.size());
      !status)
  {
    return Bad(status.GetError().message);
  }
  return {};
}

Status CheckRanks(
  const Piece& piece, const TreeDepths& depths, std::span<const std::uint64_t> clusters)
{
  const Resolution resolution = piece.id.resolution;
  const bool ranked = !resolution.IsOriginal() && resolution.Depth() < depths.stitch;
  if (ranked && resolution.Depth() < clusters.size())
  {
    for (const VertexKey rank : piece.keys)
    {
      if (rank >= clusters[resolution.Depth()])
      {
        return Bad("rank ", rank, " is beyond its level");
      }
    }
  }
  const AncestorLevels levels = AncestorLevelsOf(resolution, depths);
  for (std::size_t at = 0; at < piece.ancestors.size(); ++at)
  {
    const std::size_t level = levels.coarsest + at % levels.count;
    if (level < clusters.size() && piece.ancestors[at] >= clusters[level])
    {
      return Bad("rank ", piece.ancestors[at], " of an ancestor is beyond its level");
    }
  }
  return {};
}

}
