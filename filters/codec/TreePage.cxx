// SPDX-License-Identifier: BSD-3-Clause
// Pages of the tree: see TreePage.h and doc/formats.md.
#include "filters/codec/TreePage.h"

#include "filters/codec/ByteStream.h"
#include "filters/codec/Seal.h"
#include "filters/codec/SymbolCoder.h"
#include "filters/core/BitCast.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

namespace kdstream
{
namespace
{

constexpr std::string_view treeMagic = "KDT";
constexpr unsigned boxSteps = 16; // sides of a box lie on these steps of the parent's box
enum TreeContext : std::size_t
{
  treeEmpty, // a choice
  treeInner,
  treeOuter,
  treeBound99,
  treeBoundMost,
  treeBytes,
  treeContexts
};
constexpr SymbolContexts contextsOfTree{ 1, treeContexts };

// ---- facts

constexpr unsigned boundShift = 19;           // a float's exponent and 4 bits are stored
constexpr std::uint32_t largestBound = 0xFEF; // of a finite float
constexpr std::uint32_t largestBytes = 192;   // of 64 MiB

// The upper bits of the least float that is not below the bound and has only zeros in its other
// bits.
std::uint32_t CodeOfBound(float bound)
{
  const std::uint32_t bits = BitCast<std::uint32_t>(bound + 0.0F); // no -0.0
  return std::min((bits + ((1U << boundShift) - 1)) >> boundShift, largestBound);
}

float BoundOfCode(std::uint32_t code)
{
  return BitCast<float>(code << boundShift);
}

// The four highest bits of the number, and how many bits follow.
std::uint32_t CodeOfBytes(std::uint32_t bytes)
{
  const auto follow =
    static_cast<unsigned>(std::max(static_cast<int>(std::bit_width(bytes)), 4) - 4);
  const std::uint64_t upper = (bytes + (std::uint64_t{ 1 } << follow) - 1) >> follow;
  return std::min((follow << 3) + static_cast<std::uint32_t>(upper), largestBytes);
}

std::uint32_t BytesOfCode(std::uint32_t code)
{
  return code < 16 ? code : (8 + (code & 7)) << ((code >> 3) - 1);
}

struct FactCodes
{
  std::uint32_t most99 = 0, most = 0, bytes = 0;
};

FactCodes CodesOf(const PieceFacts& facts)
{
  return { CodeOfBound(facts.most99), CodeOfBound(facts.most), CodeOfBytes(facts.bytes) };
}

PieceFacts FactsOf(const FactCodes& codes)
{
  return { BoundOfCode(codes.most99), BoundOfCode(codes.most), BytesOfCode(codes.bytes) };
}

void WriteFacts(SymbolWriter& symbols, const std::vector<PieceFacts>& pieces)
{
  FactCodes last;
  for (const PieceFacts& facts : pieces)
  {
    const FactCodes codes = CodesOf(facts);
    symbols.Signed(treeBound99, std::int64_t{ codes.most99 } - last.most99);
    symbols.Number(treeBoundMost, codes.most - codes.most99);
    symbols.Signed(treeBytes, std::int64_t{ codes.bytes } - last.bytes);
    last = codes;
  }
}

// Adds the difference to `last`. Returns false if the result is not a code.
bool ReadCode(std::int64_t difference, std::uint32_t largest, std::uint32_t& last)
{
  const std::int64_t least = -std::int64_t{ last }, most = std::int64_t{ largest } - last;
  if (difference < least || difference > most)
  {
    return false;
  }
  last = static_cast<std::uint32_t>(last + difference);
  return true;
}

// Returns false if they are not facts of pieces.
bool ReadFacts(SymbolReader& symbols, std::size_t count, std::vector<PieceFacts>& pieces)
{
  FactCodes last;
  for (; count > 0; --count)
  {
    const bool near = ReadCode(symbols.Signed(treeBound99), largestBound, last.most99);
    const std::uint64_t further = symbols.Number(treeBoundMost);
    const bool sized = ReadCode(symbols.Signed(treeBytes), largestBytes, last.bytes);
    if (!near || !sized || further > largestBound - last.most99)
    {
      return false;
    }
    last.most = last.most99 + static_cast<std::uint32_t>(further);
    pieces.push_back(FactsOf(last));
  }
  return true;
}

// ---- boxes

// The coordinate of plane `step`, 0 … 16, of the planes that divide a side of the parent's box.
double PlaneAt(double lo, double hi, std::uint64_t step)
{
  return step == 0 ? lo : step == boxSteps ? hi : lo + (hi - lo) * (double(step) / boxSteps);
}

// The last plane that is not above `value`.
std::uint64_t StepBelow(double lo, double hi, double value)
{
  std::uint64_t step = hi > lo ? boxSteps : 0;
  while (step > 0 && PlaneAt(lo, hi, step) > value)
  {
    --step;
  }
  return step;
}

// The first plane that is not below `value`.
std::uint64_t StepAbove(double lo, double hi, double value)
{
  std::uint64_t step = hi > lo ? 0 : boxSteps;
  while (step < boxSteps && PlaneAt(lo, hi, step) < value)
  {
    ++step;
  }
  return step;
}

Box RoundedIn(const Box& box, const Box& parent)
{
  Box rounded;
  for (std::size_t k = 0; k < 3 && !box.Empty(); ++k)
  {
    const double lo = parent.lo[k], hi = parent.hi[k];
    rounded.lo[k] = PlaneAt(lo, hi, StepBelow(lo, hi, box.lo[k]));
    rounded.hi[k] = PlaneAt(lo, hi, StepAbove(lo, hi, box.hi[k]));
  }
  return rounded;
}

std::size_t LongestSide(const Box& box)
{
  std::size_t longest = 0;
  for (std::size_t k = 1; k < 3; ++k)
  {
    longest = box.hi[k] - box.lo[k] > box.hi[longest] - box.lo[longest] ? k : longest;
  }
  return longest;
}

// Calls visit(axis, upper, inner) for the sides of a child's box. inner: whether it is the side
// near the middle of the parent, where the parent's vertices were most likely divided.
template <class Visit>
bool ForEachSide(const Box& parent, bool secondChild, const Visit& visit)
{
  const std::size_t split = LongestSide(parent);
  bool good = true;
  for (std::size_t k = 0; k < 3; ++k)
  {
    good = good && visit(k, false, k == split && secondChild);
    good = good && visit(k, true, k == split && !secondChild);
  }
  return good;
}

// Writes for each side how many steps it is from the parent's side, or, for the inner one, from the
// middle.
void WriteBox(SymbolWriter& symbols, const Box& box, const Box& parent, bool secondChild)
{
  ForEachSide(parent, secondChild,
    [&](std::size_t k, bool upper, bool inner)
    {
      const double lo = parent.lo[k], hi = parent.hi[k];
      const std::uint64_t step =
        upper ? boxSteps - StepAbove(lo, hi, box.hi[k]) : StepBelow(lo, hi, box.lo[k]);
      if (inner)
      {
        symbols.Signed(treeInner, static_cast<std::int64_t>(step) - std::int64_t{ boxSteps / 2 });
      }
      else
      {
        symbols.Number(treeOuter, step);
      }
      return true;
    });
}

// Returns false if it is not a box.
bool ReadBox(SymbolReader& symbols, Box& box, const Box& parent, bool secondChild)
{
  const bool good = ForEachSide(parent, secondChild,
    [&](std::size_t k, bool upper, bool inner)
    {
      const std::uint64_t step =
        inner ? static_cast<std::uint64_t>(symbols.Signed(treeInner)) + boxSteps / 2
              : symbols.Number(treeOuter);
      if (step > boxSteps)
      {
        return false;
      }
      (upper ? box.hi : box.lo)[k] =
        PlaneAt(parent.lo[k], parent.hi[k], upper ? boxSteps - step : step);
      return true;
    });
  return good && box.lo[0] <= box.hi[0] && box.lo[1] <= box.hi[1] && box.lo[2] <= box.hi[2];
}

bool IsFiniteOrEmpty(const Box& box)
{
  bool finite = true;
  for (std::size_t k = 0; k < 3; ++k)
  {
    finite = finite && std::isfinite(box.lo[k]) && std::isfinite(box.hi[k] - box.lo[k]);
  }
  return finite || box.Empty();
}

// The boxes of a page before it is read: only the box of the page's own node is known.
std::vector<Box> EmptyBoxes(NodeId page, const Box& around, const TreeDepths& depths)
{
  std::vector<Box> boxes(std::size_t{ 2 } << DepthsOfTreePage(page, depths));
  boxes[1] = around;
  return boxes;
}

}

// ---- Which node is in which page

bool IsTreePage(NodeId node, const TreeDepths& depths)
{
  if (node == 0)
  {
    return false;
  }
  const unsigned depth = DepthOfNode(node);
  return depth == 0 || (depth >= treePageDepths && depth < depths.partition &&
                         (depths.partition - depth) % treePageDepths == 0);
}

unsigned DepthsOfTreePage(NodeId page, const TreeDepths& depths)
{
  const unsigned deepest = depths.partition;
  return DepthOfNode(page) > 0          ? treePageDepths
         : deepest < 2 * treePageDepths ? deepest
                                        : treePageDepths + deepest % treePageDepths;
}

NodeId TreePageOfNode(NodeId node, const TreeDepths& depths)
{
  NodeId page = node;
  do
  {
    page = std::max<NodeId>(page >> 1, 1);
  } while (!IsTreePage(page, depths));
  return page;
}

std::vector<NodeId> TreePages(const TreeDepths& depths)
{
  std::vector<NodeId> pages{ 1 };
  for (unsigned depth = DepthsOfTreePage(1, depths); depth < depths.partition;
       depth += treePageDepths)
  {
    for (NodeId i = 0; i < NodeId{ 1 } << depth; ++i)
    {
      pages.push_back((NodeId{ 1 } << depth) + i);
    }
  }
  return pages;
}

// ---- The content of a page

PieceFacts RoundedUp(const PieceFacts& facts)
{
  return FactsOf(CodesOf(facts));
}

PieceTable::PieceTable(const TreeDepths& depths, bool hasLevels)
{
  for (unsigned level = 0; hasLevels && level <= depths.finest; ++level)
  {
    this->Rows.emplace_back(std::size_t{ 1 } << PieceDepth(Resolution::Level(level), depths));
  }
  this->Rows.emplace_back(std::size_t{ 1 } << depths.partition);
}

namespace
{

// Calls visit(resolution, first node, count of nodes) for each resolution that a page describes,
// coarse to fine, until it returns false.
template <class Visit>
void ForEachRow(NodeId page, const TreeDepths& depths, bool hasLevels, const Visit& visit)
{
  const unsigned top = DepthOfNode(page), most = top + DepthsOfTreePage(page, depths);
  const auto goOn = [&](Resolution resolution)
  {
    const unsigned depth = PieceDepth(resolution, depths);
    const bool isInPage = (depth > top || page == 1) && depth <= most;
    return !isInPage || visit(resolution, page << (depth - top), NodeId{ 1 } << (depth - top));
  };
  for (unsigned level = 0; hasLevels && level <= depths.finest; ++level)
  {
    if (!goOn(Resolution::Level(level)))
    {
      return;
    }
  }
  goOn(Resolution::Original());
}

}

std::vector<PieceId> PiecesOfTreePage(NodeId page, const TreeDepths& depths, bool hasLevels)
{
  std::vector<PieceId> pieces;
  ForEachRow(page, depths, hasLevels,
    [&pieces](Resolution resolution, NodeId first, NodeId count)
    {
      for (NodeId i = 0; i < count; ++i)
      {
        pieces.push_back({ resolution, first + i });
      }
      return true;
    });
  return pieces;
}

std::size_t PlaceInTreePage(NodeId page, PieceId piece, const TreeDepths& depths, bool hasLevels)
{
  std::size_t place = 0;
  ForEachRow(page, depths, hasLevels,
    [&place, piece](Resolution resolution, NodeId first, NodeId count)
    {
      const bool here = resolution == piece.resolution;
      place += here ? piece.node - first : count;
      return !here;
    });
  return place;
}

Box RoundedBoxOf(std::span<const Box> boxes, NodeId node)
{
  return node == 1 ? boxes[1] : RoundedIn(boxes[node], RoundedBoxOf(boxes, node / 2));
}

std::vector<Box> RoundTreePageBoxes(
  std::span<const Box> boxes, NodeId page, const TreeDepths& depths)
{
  std::vector<Box> result = EmptyBoxes(page, RoundedBoxOf(boxes, page), depths);
  for (NodeId i = 2; i < result.size(); ++i)
  {
    const unsigned below = DepthOfNode(i);
    const NodeId node = (page << below) + (i - (NodeId{ 1 } << below));
    result[i] = RoundedIn(boxes[node], result[i / 2]);
  }
  return result;
}

TreePage RoundTreePage(
  std::span<const Box> boxes, NodeId page, const TreeDepths& depths, const PieceTable& pieces)
{
  TreePage result{ page, RoundTreePageBoxes(boxes, page, depths), {} };
  for (const PieceId piece : PiecesOfTreePage(page, depths, pieces.HasLevels()))
  {
    result.facts.push_back(RoundedUp(pieces.At(piece)));
  }
  return result;
}

std::vector<std::uint8_t> EncodeTreePage(const TreePage& page)
{
  SymbolWriter symbols(contextsOfTree);
  for (std::size_t i = 2; i < page.boxes.size(); ++i)
  {
    const Box &box = page.boxes[i], &parent = page.boxes[i / 2];
    if (!parent.Empty())
    {
      symbols.Choice(treeEmpty, box.Empty() ? 1 : 0);
      if (!box.Empty())
      {
        WriteBox(symbols, box, parent, i % 2 == 1);
      }
    }
  }
  WriteFacts(symbols, page.facts);
  ByteWriter writer;
  WriteBlobHead(writer, treeMagic);
  symbols.Finish(writer, 0);
  std::vector<std::uint8_t> blob = writer.Take();
  SealBlob(blob);
  return blob;
}

Result<TreePage> DecodeTreePage(std::span<const std::uint8_t> blob, NodeId page, const Box& around,
  const TreeDepths& depths, bool hasLevels)
{
  const auto named = [page](ErrorCode code, const std::string& what) {
    return Error{ code, "tree page " + std::to_string(page) + ": " + what };
  };
  if (!IsTreePage(page, depths) || !IsFiniteOrEmpty(around))
  {
    return named(ErrorCode::InvalidArgument, "is not a page of this tree");
  }
  const auto unsealed = UnsealBlob(blob, treeMagic);
  if (!unsealed)
  {
    return named(unsealed.GetError().code, unsealed.GetError().message);
  }
  SymbolReader symbols(unsealed->subspan(blobHeadSize), contextsOfTree);
  TreePage result{ page, EmptyBoxes(page, around, depths), {} };
  for (std::size_t i = 2; i < result.boxes.size(); ++i)
  {
    const Box& parent = result.boxes[i / 2];
    if (!parent.Empty() && symbols.Choice(treeEmpty) == 0 &&
        !ReadBox(symbols, result.boxes[i], parent, i % 2 == 1))
    {
      return named(ErrorCode::InvalidInput, "a box is not inside its parent's box");
    }
  }
  if (!ReadFacts(symbols, PiecesOfTreePage(page, depths, hasLevels).size(), result.facts))
  {
    return named(ErrorCode::InvalidInput, "bounds or bytes of a piece out of range");
  }
  if (!symbols.AtEnd())
  {
    return named(ErrorCode::InvalidInput, "extra bytes at the end");
  }
  return result;
}

}
