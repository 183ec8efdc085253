// SPDX-License-Identifier: BSD-3-Clause
// Which resolutions are shown where: a mixed-resolution cut of the vertex tree, given by pieces
// (doc/design.md#the-cut-rule). Step "draw" of the pipeline picture.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/pieces/Piece.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

namespace kdstream
{

// A base resolution for everything, and finer pieces that can be shown ("active"). Any set of
// pieces is a cut:
//   1. If all pieces of a finer resolution are active, the finest resolution of this kind is the
//      base.
//   2. A cluster is reached if it is of the base, or its parent is split. A reached cluster of a
//      level R <= d < S is split if all pieces of level d + 1 that hold its children are active.
//   3. Where a cluster of level S is reached, or the base is not coarser than S, each partition is
//      shown at the finest active resolution >= S that covers it.
//   4. Every original vertex is shown by the finest reached node above it.
// So active pieces that are not reached show nothing: MakeClosure gives the pieces that are needed
// to reach them. Levels coarser than R are one piece each, so only rule 1 applies to them.
struct Cut
{
  TreeDepths depths;
  Resolution base;
  std::vector<PieceId> active{}; // ascending, each once
};

// Errors: InvalidArgument if the base is finer than L and not the original, or if an active piece
// is not of this tree, or out of order. O(active).
Status CheckCut(const Cut& cut);

// The finest resolution of which all pieces are active, or the cut's base (rule 1). O(active).
Resolution BaseOf(const Cut& cut);

// Finds a loaded piece, or null.
using PieceLookup = std::function<const Piece*(PieceId)>;

// The pieces that drawing needs, ascending: the active ones, and those of the base that show
// anything. O(active log active + partitions).
std::vector<PieceId> PiecesOf(const Cut& cut);
// The needed pieces that `lookup` does not find, ascending.
std::vector<PieceId> MissingPieces(const Cut& cut, const PieceLookup& lookup);

// The dependency set: the pieces that must be active so that given pieces are shown whole, over a
// base that is loaded.
struct Closure
{
  std::vector<PieceId> pieces;  // ascending: all that are known to be needed, including the wanted
  std::vector<PieceId> missing; // needed pieces that are not loaded, ascending
};

// The pieces that are needed to show all vertices of the wanted pieces at these pieces' resolution
// or finer. Only a loaded piece says which child pieces its clusters have. So call this again when
// the `missing` pieces have arrived, until none is missing. Then `pieces` are the active pieces of
// a cut. base: BaseOf the cut. wanted: in any order; pieces that are not finer than the base are
// ignored. O(v log v) for v vertices of the wanted pieces; for a piece finer than S, the vertices
// of level S count.
Closure MakeClosure(const TreeDepths& depths, Resolution base, std::span<const PieceId> wanted,
  const PieceLookup& lookup);

// For making closures repeatedly. Remembers the closure of each wanted piece once nothing is
// missing for it, because it does not change any more. So only the other pieces are processed
// again.
class Closures
{
public:
  Closure Make(const TreeDepths& depths, Resolution base, std::span<const PieceId> wanted,
    const PieceLookup& lookup);

private:
  TreeDepths Depths;
  Resolution Base;
  std::map<PieceId, std::vector<PieceId>> Whole; // by wanted piece
};

// The own vertex whose interval holds `key`, in a piece of a resolution >= S; or noVertex. O(log).
std::uint32_t IntervalOf(const Piece& piece, VertexKey key);

// Finds clusters of levels coarser than S among the own vertices of pieces.
class ClusterOwners
{
public:
  // An own vertex of a piece that was added.
  struct Place
  {
    std::size_t piece = 0; // the number given to Add
    std::uint32_t vertex = 0;
  };

  // REQUIRES: a piece of a level coarser than S.
  void Add(const Piece& piece, std::size_t number);
  // No value if no piece owns the cluster. O(log pieces), or O(1) if the piece that was found last
  // owns it.
  std::optional<Place> Find(unsigned level, VertexKey rank);

private:
  struct Owner
  {
    VertexKey first = 0;
    std::uint32_t count = 0;
    std::size_t number = 0;
  };
  std::vector<std::map<VertexKey, Owner>> Levels; // by first rank
  std::vector<Owner> Last;                        // the last one found, for each level
};

}
