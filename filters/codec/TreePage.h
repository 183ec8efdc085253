// SPDX-License-Identifier: BSD-3-Clause
// Pages of the tree: what a viewer can know of pieces before it fetches them. Layout:
// doc/formats.md.
//
// A viewer walks down from the root to the nodes in its view, and fetches the pages on its way. So
// pages are small, and their boxes are rounded outward to sixteenths of the parent's box. The exact
// boxes of partitions, which decide what a region contains, are blobs of their own
// (PartitionBoxes.h).
#pragma once

#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/core/pieces/Piece.h"
#include "filters/core/tree/PieceDepth.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// ---- Which node is in which page

// A page belongs to a node, and describes the nodes of the 5 depths below it (fewer at the end of
// the tree). The root's page describes 5 to 9 depths, so that the last pages are full.
inline constexpr unsigned treePageDepths = 5;

// The number of depths that the page of `page` describes. REQUIRES: IsTreePage(page, depths).
unsigned DepthsOfTreePage(NodeId page, const TreeDepths& depths);
// Whether a node has a page: the root, and the nodes of the depths P - 5, P - 10 … down to 5.
bool IsTreePage(NodeId node, const TreeDepths& depths);
// The page that describes a node. A page's own node is described by the page above it, the root by
// its own page. REQUIRES: DepthOfNode(node) <= depths.partition.
NodeId TreePageOfNode(NodeId node, const TreeDepths& depths);
// The nodes that have a page, ascending.
std::vector<NodeId> TreePages(const TreeDepths& depths);

// ---- The content of a page

// Facts about one piece. most99, most: of the geometric errors of its own vertices (estimates, in
// model units), the error that 99 of 100 do not exceed, and the largest; 0 for the original. bytes:
// of its blob; 0 if the piece does not exist. A page stores all of them rounded up (RoundedUp).
struct PieceFacts
{
  float most99 = 0, most = 0;
  std::uint32_t bytes = 0;
  bool operator==(const PieceFacts&) const = default;
};
// The facts as a page stores them: errors rounded up by at most a 16th (or to the largest float),
// bytes by at most an 8th. Idempotent.
PieceFacts RoundedUp(const PieceFacts& facts);

// All pieces of a model: of the levels 0 … L, if it has levels, and of the partitions.
class PieceTable
{
public:
  PieceTable() = default;
  PieceTable(const TreeDepths& depths, bool hasLevels);
  // REQUIRES: a piece of the model.
  PieceFacts& At(PieceId id) { return this->Row(id.resolution)[id.node - FirstOfDepth(id.node)]; }
  const PieceFacts& At(PieceId id) const { return const_cast<PieceTable*>(this)->At(id); }
  bool HasLevels() const { return this->Rows.size() > 1; }
  bool operator==(const PieceTable&) const = default;

private:
  static NodeId FirstOfDepth(NodeId node) { return NodeId{ 1 } << DepthOfNode(node); }
  std::vector<PieceFacts>& Row(Resolution resolution)
  {
    return this->Rows[resolution.IsOriginal() ? this->Rows.size() - 1 : resolution.Depth()];
  }
  std::vector<std::vector<PieceFacts>> Rows; // levels 0 …, then the original
};

// The pieces that a page describes: those of the nodes that it describes, on the root's page also
// those of the root. Ordered from coarse to fine, then by node.
std::vector<PieceId> PiecesOfTreePage(NodeId page, const TreeDepths& depths, bool hasLevels);
// The place of a piece in that list. REQUIRES: the page describes it. O(levels).
std::size_t PlaceInTreePage(NodeId page, PieceId piece, const TreeDepths& depths, bool hasLevels);

struct TreePage
{
  NodeId page = 1;
  // By heap number relative to the page's node, which is 1. This node's own box comes from the page
  // above; the root's box is that of the model. A node without vertices has an empty box. The first
  // entry is unused.
  std::vector<Box> boxes;
  std::vector<PieceFacts> facts; // in the order of PiecesOfTreePage

  // REQUIRES: `node` is the page's node or below it, at a depth that the page describes.
  const Box& BoxOf(NodeId node) const { return this->boxes[this->PlaceOf(node)]; }
  std::size_t PlaceOf(NodeId node) const
  {
    const unsigned below = DepthOfNode(node) - DepthOfNode(this->page);
    return (std::size_t{ 1 } << below) + (node - (this->page << below));
  }
};

// The box of a node as pages store it: rounded outward, but within the parent's box, which is
// rounded in the same way. The root's box is exact. boxes: exact, in heap order, each within its
// parent's, finite or empty. O(depth).
Box RoundedBoxOf(std::span<const Box> boxes, NodeId node);

// The boxes of a page as clients will have them, rounded outward: TreePage::boxes. O(nodes).
std::vector<Box> RoundTreePageBoxes(
  std::span<const Box> boxes, NodeId page, const TreeDepths& depths);

// The page as clients will have it: boxes as above, facts rounded up. O(nodes).
TreePage RoundTreePage(
  std::span<const Box> boxes, NodeId page, const TreeDepths& depths, const PieceTable& pieces);

// REQUIRES: a page from RoundTreePage or DecodeTreePage. Deterministic.
std::vector<std::uint8_t> EncodeTreePage(const TreePage& page);

// The bytes may be hostile; decoded boxes always lie within their parent's. around: the box of the
// page's node, as the page above has it. Errors: as DecodePiece; InvalidArgument if the node `page`
// has no page, or `around` is not a finite box.
Result<TreePage> DecodeTreePage(std::span<const std::uint8_t> blob, NodeId page, const Box& around,
  const TreeDepths& depths, bool hasLevels);

}
