// SPDX-License-Identifier: BSD-3-Clause
// Random pieces from a seed. No builder would write them, but the codec must still restore them.
#pragma once

#include "filters/core/levels/ClusterLevels.h"
#include "filters/core/pieces/Piece.h"

#include <algorithm>
#include <map>
#include <random>
#include <set>

namespace kdstream::fixtures
{

// A random piece. It has few places, so that vertices coincide; degenerate, repeated and flipped
// triangles; edges that many triangles share; and vertices without triangles.
inline Piece RandomPiece(std::mt19937& random, const TreeDepths& depths)
{
  Piece piece;
  const auto level = static_cast<unsigned>(random() % (depths.finest + 2));
  const Resolution resolution =
    level > depths.finest ? Resolution::Original() : Resolution::Level(level);
  const unsigned depth = PieceDepth(resolution, depths), below = depths.partition - depth;
  piece.id = { resolution, (NodeId{ 1 } << depth) + static_cast<NodeId>(random() % (1U << depth)) };
  const bool ranks = resolution < Resolution::Level(depths.stitch);
  const auto firstPartition =
    static_cast<std::uint32_t>((piece.id.node << below) - (NodeId{ 1 } << depths.partition));
  piece.ownVertices = static_cast<std::uint32_t>(random() % 40);
  std::set<VertexKey> own, ghosts;
  while (own.size() < piece.ownVertices)
  {
    const auto next = static_cast<std::uint32_t>(own.size());
    own.insert(ranks ? 1000 + next
               : resolution.IsOriginal()
                 ? MakeKey(firstPartition, next)
                 : MakeKey(firstPartition + static_cast<std::uint32_t>(random() % (1U << below)),
                     static_cast<std::uint32_t>(random() % 500)));
  }
  for (std::size_t i = random() % 20; i > 0; --i)
  {
    const auto partition = static_cast<std::uint32_t>(random() % (1U << depths.partition));
    if (ranks)
    {
      ghosts.insert(random() % 1000);
    }
    else if (NodeOfPartition(partition, depths) >> below != piece.id.node)
    {
      ghosts.insert(MakeKey(
        partition, static_cast<std::uint32_t>(random() % 3 == 0 ? random() : random() % 99)));
    }
  }
  piece.keys.assign(own.begin(), own.end());
  piece.keys.insert(piece.keys.end(), ghosts.begin(), ghosts.end());
  const auto count = static_cast<std::uint32_t>(piece.keys.size());
  const std::array<double, 8> places{ 0, -0.0, 1, 0.5, 0.25, 1e-300, 5e-324, 0.999 };
  for (std::uint32_t v = 0; v < count; ++v)
  {
    piece.positions.push_back({ places[random() % 8], places[random() % 8],
      random() % 2 == 0 ? places[random() % 8] : double(random()) / 4294967296.0 });
  }
  for (std::size_t i = piece.ownVertices == 0 ? 0 : random() % 120; i > 0; --i)
  {
    const auto any = [&]
    {
      return static_cast<VertexId>(
        random() % std::min(count, 3 + static_cast<std::uint32_t>(random() % count)));
    };
    const VertexId first = static_cast<VertexId>(random() % piece.ownVertices);
    piece.triangles.push_back(RotateLowestFirst({ any(), first, any() }));
    if (random() % 4 == 0)
    {
      const Triangle t = piece.triangles.back();
      piece.triangles.push_back(random() % 2 == 0 ? t : RotateLowestFirst({ t[0], t[2], t[1] }));
    }
  }
  std::sort(piece.triangles.begin(), piece.triangles.end());
  if (!resolution.IsOriginal())
  {
    const unsigned coarse = random() % 2 == 0 ? 1 : 0x7FFFFF;
    for (std::uint32_t v = 0; v < piece.ownVertices; ++v)
    {
      piece.geometricErrors.push_back(
        float(random() % coarse) / float(coarse) * float(random() % 3));
    }
  }
  // Any ranks, but each cluster has one parent.
  const AncestorLevels levels = AncestorLevelsOf(resolution, depths);
  const std::size_t carriers = levels.Rows(piece.ownVertices, piece.GhostCount());
  std::vector<std::map<std::uint32_t, std::uint32_t>> parents(levels.count);
  for (std::size_t i = 0; levels.count > 0 && i < carriers; ++i)
  {
    const auto any = [&]
    { return static_cast<std::uint32_t>(random() % 2 == 0 ? random() % 4 : random() % noVertex); };
    std::vector<std::uint32_t> row(levels.count);
    row.back() = any();
    for (std::size_t d = levels.count; --d > 0;)
    {
      row[d - 1] = parents[d].try_emplace(row[d], any()).first->second;
    }
    piece.ancestors.insert(piece.ancestors.end(), row.begin(), row.end());
  }
  if (HasChildNodes(resolution, depths))
  {
    const unsigned nodeDepth = PieceDepth(Resolution::Level(resolution.Depth() + 1), depths);
    piece.childBegin.push_back(0);
    for (std::uint32_t v = 0; v < piece.ownVertices; ++v)
    {
      std::set<NodeId> nodes;
      for (std::size_t i = 1 + random() % 4; i > 0; --i)
      {
        nodes.insert(
          (NodeId{ 1 } << nodeDepth) + static_cast<NodeId>(random() % (1U << nodeDepth)));
      }
      piece.childNodes.insert(piece.childNodes.end(), nodes.begin(), nodes.end());
      piece.childBegin.push_back(static_cast<std::uint32_t>(piece.childNodes.size()));
    }
  }
  return piece;
}

// Adds arrays of every type with random bits.
inline Piece WithEveryAttribute(Piece piece, std::mt19937& random)
{
  for (unsigned type = 0; type <= static_cast<unsigned>(AttributeType::Float64); ++type)
  {
    for (const auto association : { AttributeAssociation::Point, AttributeAssociation::Cell })
    {
      Attribute attribute{ "array" + std::to_string(type), static_cast<AttributeType>(type),
        association, static_cast<std::uint8_t>(1 + random() % 3), {} };
      const std::size_t tuples = association == AttributeAssociation::Point
                                   ? piece.positions.size()
                                   : piece.triangles.size();
      attribute.values.resize(tuples * attribute.TupleSize());
      for (std::uint8_t& value : attribute.values)
      {
        value = static_cast<std::uint8_t>(random() % 2 == 0 ? 0 : random());
      }
      piece.attributes.push_back(std::move(attribute));
    }
  }
  return piece;
}

}
