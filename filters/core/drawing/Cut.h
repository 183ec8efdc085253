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

// A base resolution for everything, and finer pieces that may be shown. Any set of pieces is a cut:
//   1. Where all pieces of a finer resolution are active, the finest such resolution is the base.
//   2. A cluster of a level R <= d < S that is reached (it is of the base, or its parent is split)
//      is split if all pieces of level d + 1 that hold its children are active.
//   3. Where a cluster of level S is reached, or the base is not coarser than S, each partition is
//      shown at the finest active resolution >= S that covers it.
//   4. Everything is shown at the finest node above it that is reached.
// So pieces that are active but not reached show nothing: MakeClosure gives the pieces that are
// needed to reach them. Below R levels are one piece each, so only rule 1 applies to them.
struct Cut
{
  TreeDepths depths;
  Resolution base;
  std::vector<PieceId> active{}; // ascending, each once
};

// Errors: InvalidArgument if the base is finer than L and not the original, or if an active piece
// is not of this tree, or out of order. O(active).
Status CheckCut(const Cut& cut);

// The finest resolution all pieces of which are there (rule 1). O(active).
Resolution BaseOf(const Cut& cut);

// Finds a loaded piece, or null.
using PieceLookup = std::function<const Piece*(PieceId)>;

// The pieces that drawing needs, ascending: those of the base that show anything, and active ones.
// O(active log active + partitions).
std::vector<PieceId> PiecesOf(const Cut& cut);
// The needed pieces that `lookup` does not find, ascending.
std::vector<PieceId> MissingPieces(const Cut& cut, const PieceLookup& lookup);

// The dependency set: the pieces that must be active so that given pieces are shown whole, over a
// base that is loaded.
struct Closure
{
  std::vector<PieceId> pieces;  // ascending: what is known to be needed, the wanted ones too
  std::vector<PieceId> missing; // needed pieces that are not loaded, ascending
};

// The pieces that show all vertices of the wanted pieces at these pieces' resolution or finer. Only
// loaded pieces say which child pieces their clusters have: so call this again when the `missing`
// pieces have arrived, until none is missing. Then `pieces` are the active pieces of a cut. base:
// BaseOf the cut. wanted: in any order; those that are not finer than the base cost nothing. O(v
// log v) for v vertices of the wanted pieces, a wanted piece finer than S counts with the vertices
// of level S.
Closure MakeClosure(const TreeDepths& depths, Resolution base, std::span<const PieceId> wanted,
  const PieceLookup& lookup);

// The same, called repeatedly. Remembers the closure of each wanted piece for which nothing was
// missing; it does not change any more. So only the other pieces are processed again.
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

// The own vertex of a piece >= S whose interval holds `key`, or noVertex. O(log).
std::uint32_t IntervalOf(const Piece& piece, VertexKey key);

// Finds clusters of levels coarser than S among the own vertices of pieces.
class ClusterOwners
{
public:
  // An own vertex of a piece that was added.
  struct Place
  {
    std::size_t piece = 0; // its number
    std::uint32_t vertex = 0;
  };

  // REQUIRES: a piece of a level coarser than S.
  void Add(const Piece& piece, std::size_t number);
  // Nothing where no piece owns the cluster. O(log pieces), O(1) where the last one found owns it.
  std::optional<Place> Find(unsigned level, VertexKey rank);

private:
  struct Owner
  {
    VertexKey first = 0;
    std::uint32_t count = 0;
    std::size_t number = 0;
  };
  std::vector<std::map<VertexKey, Owner>> Levels; // by first rank
  std::vector<Owner> Last;                        // found, of each level
};

}
