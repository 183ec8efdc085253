// SPDX-License-Identifier: BSD-3-Clause
// A piece as bytes and back: step "encode" and "decode" of the README's picture. Layout:
// doc/formats.md.
//
// Triangles are coded by a walk over the surface, positions by parallelograms along it, everything
// as symbols of an entropy coder (PieceReader.h, PieceWriter.h). Compiles to WebAssembly. The blob
// ends with a checksum of itself (Seal.h), which the decoder checks first and does not rely on:
// what follows is as careful with bytes that are well sealed.
#pragma once

#include "filters/codec/CoordinateGrid.h"
#include "filters/core/Result.h"
#include "filters/core/pieces/Piece.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// What a decoder has to know of the model beside the blob.
struct CodecContext
{
  TreeDepths depths;
  CoordinateGrid grid;
  // Of each level, how many of the grid's steps lie between the points that it uses (SpacingFor);
  // empty: 1 of all.
  std::vector<std::uint32_t> spacings{};

  CoordinateGrid GridOf(Resolution resolution) const
  {
    return resolution.IsOriginal() || resolution.Depth() >= this->spacings.size()
             ? this->grid
             : this->grid.Spaced(this->spacings[resolution.Depth()]);
  }
};

// What parts of a blob take, in bytes: of piece, triangles and positions, which of the vertices are
// ghosts, numbers of own vertices, their keys, keys of ghosts, ancestors.
struct EncodedBytes
{
  double all = 0, triangles = 0, positions = 0, numbers = 0, ownKeys = 0, ghostKeys = 0,
         ancestors = 0;
};

// Encodes a piece but for its deviations, which a store tells of a whole piece. REQUIRES:
// CheckPiece(piece, context.depths); vertices with the same ancestor at a level have the same ones
// at all coarser levels; on a grid, positions anywhere. Deterministic; O(size). spent: for
// benchmarks.
std::vector<std::uint8_t> EncodePiece(
  const Piece& piece, const CodecContext& context, EncodedBytes* spent = nullptr);

// Decodes the blob of piece `expected`. Any bytes may be given: lengths are bounded by the size of
// the blob before memory is taken (at most 2 KiB for a byte of it, the piece and what is needed on
// the way), time by both, and the piece passes CheckPiece. Errors: Damaged where the
// checksum is wrong (see Seal.h); InvalidInput with the byte offset; Unsupported for an unknown
// codec version.
Result<Piece> DecodePiece(
  std::span<const std::uint8_t> blob, PieceId expected, const CodecContext& context);

// What is known of a level's piece before it is fetched: what its own vertices deviate by, model
// units; what 99 of 100 do not exceed, and the largest. Rounded up where a page tells it.
struct PieceBounds
{
  float most99 = 0, most = 0;
  bool operator==(const PieceBounds&) const = default;
};
// Of each level, of each of its pieces, nodes ascending; empty where a model has no levels.
using LevelBounds = std::vector<std::vector<PieceBounds>>;
// Zeros for the pieces of the levels 0 … L.
LevelBounds NoBounds(const TreeDepths& depths);

// A page of the tree: the box of `node` (whose depth is a multiple of 11) and the boxes of the 11
// depths below it, as far as the partitions, and the bounds of the levels' pieces whose nodes are
// in no page above. Boxes are exact doubles, or floats where every value is one.
inline constexpr unsigned treePageDepths = 11;
std::vector<NodeId> TreePageNodes(
  NodeId page, const TreeDepths& depths);                // the nodes in it, depth by depth
std::vector<NodeId> TreePages(const TreeDepths& depths); // the roots of all pages
NodeId TreePageOfNode(
  NodeId node); // the page that holds a node's box (a page's own root: the page above, if any)

std::vector<std::uint8_t> EncodeTreePage(std::span<const Box> boxes, NodeId page,
  const TreeDepths& depths, const LevelBounds& bounds = {});
// Writes the page's boxes into `boxes` (heap order, 2^(P+1) entries), and its bounds into `bounds`,
// which is as large as NoBounds makes it, or empty where the model has no levels. Errors as
// DecodePiece.
Status DecodeTreePage(std::span<const std::uint8_t> blob, NodeId page, const TreeDepths& depths,
  std::span<Box> boxes, LevelBounds& bounds);

}
