// SPDX-License-Identifier: BSD-3-Clause
// Pages of the tree: what is known of pieces before they are fetched. Layout: doc/formats.md.
//
// A viewer walks down from the root along what it looks at, and fetches the pages on its way. So a
// page is small, and its boxes are rounded: outward, to sixteenths of their parent's. The exact
// boxes of partitions, which a region goes by, are blobs of their own (PartitionBoxes.h).
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

// ---- which node is in which page

// A page belongs to a node and describes the nodes below it: 5 depths, or as many as there are. The
// root's page describes 5 to 9 depths, so that the last pages are whole.
inline constexpr unsigned treePageDepths = 5;

// How many depths the page of `page` tells of. REQUIRES: IsTreePage(page, depths).
unsigned DepthsOfTreePage(NodeId page, const TreeDepths& depths);
// Whether a node has a page: the root, and the nodes of the depths P - 5, P - 10 … down to 5.
bool IsTreePage(NodeId node, const TreeDepths& depths);
// The page that tells of a node: of a page's own node the page above, of the root its own.
// REQUIRES: DepthOfNode(node) <= depths.partition.
NodeId TreePageOfNode(NodeId node, const TreeDepths& depths);
// The nodes that have a page, ascending.
std::vector<NodeId> TreePages(const TreeDepths& depths);

// ---- what a page tells

// Of one piece. Deviations: of the own vertices of a level's piece, model units; what 99 of 100 do
// not exceed, and the largest; 0 of the original's. bytes: of its blob; 0 where there is no such
// piece. All are rounded up where a page tells them (RoundedUp).
struct PieceFacts
{
  float most99 = 0, most = 0;
  std::uint32_t bytes = 0;
  bool operator==(const PieceFacts&) const = default;
};
// As a page tells it: bounds by at most a 16th more (or the largest float), bytes by at most an
// 8th. Idempotent.
PieceFacts RoundedUp(const PieceFacts& facts);

// Of all pieces of a model: of the levels 0 … L, where it has levels, and of the partitions.
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

// The pieces that a page describes: those whose nodes it describes, and of the root's page those of
// the root too; coarse to fine, nodes ascending.
std::vector<PieceId> PiecesOfTreePage(NodeId page, const TreeDepths& depths, bool hasLevels);
// Where in that list a piece stands. REQUIRES: the page tells of it. O(levels).
std::size_t PlaceInTreePage(NodeId page, PieceId piece, const TreeDepths& depths, bool hasLevels);

struct TreePage
{
  NodeId page = 1;
  // By heap number under the page's node, which is 1 (its box is stored by the page above; the
  // root's is the model's). Empty where there are no vertices. The first entry is unused.
  std::vector<Box> boxes;
  std::vector<PieceFacts> facts; // as PiecesOfTreePage

  // REQUIRES: a node at or below the page's, whose depth it tells of.
  const Box& BoxOf(NodeId node) const { return this->boxes[this->PlaceOf(node)]; }
  std::size_t PlaceOf(NodeId node) const
  {
    const unsigned below = DepthOfNode(node) - DepthOfNode(this->page);
    return (std::size_t{ 1 } << below) + (node - (this->page << below));
  }
};

// The box of a node as pages tell it: rounded outward within its parent's, which is rounded
// likewise; the root's is exact. boxes: exact, heap order, each in its parent's, of finite sides or
// empty. O(depth).
Box RoundedBoxOf(std::span<const Box> boxes, NodeId node);

// The boxes of a page as clients will have them, rounded outward: TreePage::boxes. O(nodes).
std::vector<Box> RoundTreePageBoxes(
  std::span<const Box> boxes, NodeId page, const TreeDepths& depths);

// The page as clients will have it: boxes as above, facts rounded up. O(nodes).
TreePage RoundTreePage(
  std::span<const Box> boxes, NodeId page, const TreeDepths& depths, const PieceTable& pieces);

// REQUIRES: a page of RoundTreePage or DecodeTreePage. Deterministic.
std::vector<std::uint8_t> EncodeTreePage(const TreePage& page);

// around: the box of the page's node, as the page above tells it. Any bytes may be given; whatever
// they say, boxes lie in their parent's. Errors: as DecodePiece;
// InvalidArgument where `page` has none, or where `around` is no box of finite sides.
Result<TreePage> DecodeTreePage(std::span<const std::uint8_t> blob, NodeId page, const Box& around,
  const TreeDepths& depths, bool hasLevels);

}
