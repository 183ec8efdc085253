// SPDX-License-Identifier: BSD-3-Clause
// Pages of the tree's boxes: see PieceCodec.h and doc/formats.md.
#include "filters/codec/PieceCodec.h"

#include "filters/codec/ByteStream.h"
#include "filters/codec/Seal.h"
#include "filters/codec/SymbolCoder.h"
#include "filters/core/BitCast.h"

#include <algorithm>

namespace kdstream
{
namespace
{

constexpr std::string_view treeMagic = "KDT";
constexpr std::size_t sides = 6;                      // of a box
constexpr std::size_t context99 = 6, contextMost = 7; // of bounds
constexpr std::size_t contexts = 8;
constexpr unsigned boundShift = 19;           // of a float: its exponent and 4 bits are told
constexpr std::uint32_t largestBound = 0xFEF; // of a finite float

// The upper bits of the least float that has no others and is not below the bound.
std::uint32_t BitsOfBound(float bound)
{
  const std::uint32_t bits = BitCast<std::uint32_t>(bound + 0.0F); // no -0.0
  return std::min((bits + ((1U << boundShift) - 1)) >> boundShift, largestBound);
}

float BoundOfBits(std::uint64_t bits)
{
  return BitCast<float>(static_cast<std::uint32_t>(bits) << boundShift);
}

// Calls visit(level, piece of the level) for the pieces whose bounds are in a page: level by level,
// nodes ascending.
template <class Visit>
void ForEachBound(NodeId page, const TreeDepths& depths, std::size_t levels, const Visit& visit)
{
  const unsigned top = DepthOfNode(page);
  for (unsigned level = 0; level < levels; ++level)
  {
    const unsigned depth = PieceDepth(Resolution::Level(level), depths);
    const bool here = depth > top ? depth <= top + treePageDepths : depth == 0 && top == 0;
    const NodeId first = here ? (page << (depth - top)) - (NodeId{ 1 } << depth) : 0;
    for (NodeId i = 0; here && i < NodeId{ 1 } << (depth - top); ++i)
    {
      visit(level, first + i);
    }
  }
}

void WriteBounds(
  SymbolWriter& symbols, NodeId page, const TreeDepths& depths, const LevelBounds& bounds)
{
  std::int64_t last = 0;
  ForEachBound(page, depths, bounds.size(),
    [&](unsigned level, std::size_t piece)
    {
      const PieceBounds& bound = bounds[level][piece];
      const std::int64_t nearly = BitsOfBound(bound.most99), all = BitsOfBound(bound.most);
      symbols.Signed(context99, nearly - last);
      symbols.Number(contextMost, static_cast<std::uint64_t>(all - nearly));
      last = nearly;
    });
}

// In the order of ForEachBound. False: they are no bounds.
bool ReadBounds(SymbolReader& symbols, NodeId page, const TreeDepths& depths, std::size_t levels,
  std::vector<PieceBounds>& bounds)
{
  std::uint64_t last = 0;
  bool good = true;
  ForEachBound(page, depths, levels,
    [&](unsigned, std::size_t)
    {
      last += static_cast<std::uint64_t>(symbols.Signed(context99));
      const std::uint64_t further = symbols.Number(contextMost);
      good = good && last <= largestBound && further <= largestBound - last;
      bounds.push_back(
        good ? PieceBounds{ BoundOfBits(last), BoundOfBits(last + further) } : PieceBounds{});
    });
  return good;
}

double& Side(Box& box, std::size_t side)
{
  return side < 3 ? box.lo[side] : box.hi[side - 3];
}

}

std::vector<NodeId> TreePageNodes(NodeId page, const TreeDepths& depths)
{
  const unsigned top = DepthOfNode(page);
  std::vector<NodeId> nodes;
  for (unsigned below = 0; below <= treePageDepths && top + below <= depths.partition; ++below)
  {
    for (NodeId i = 0; i < NodeId{ 1 } << below; ++i)
    {
      nodes.push_back((page << below) + i);
    }
  }
  return nodes;
}

std::vector<NodeId> TreePages(const TreeDepths& depths)
{
  std::vector<NodeId> pages{ 1 };
  for (unsigned depth = treePageDepths; depth < depths.partition; depth += treePageDepths)
  {
    for (NodeId i = 0; i < NodeId{ 1 } << depth; ++i)
    {
      pages.push_back((NodeId{ 1 } << depth) + i);
    }
  }
  return pages;
}

NodeId TreePageOfNode(NodeId node)
{
  const unsigned depth = DepthOfNode(node);
  return depth == 0 ? 1 : node >> ((depth - 1) % treePageDepths + 1);
}

LevelBounds NoBounds(const TreeDepths& depths)
{
  LevelBounds bounds;
  for (unsigned level = 0; level <= depths.finest; ++level)
  {
    bounds.emplace_back(std::size_t{ 1 } << PieceDepth(Resolution::Level(level), depths));
  }
  return bounds;
}

std::vector<std::uint8_t> EncodeTreePage(
  std::span<const Box> boxes, NodeId page, const TreeDepths& depths, const LevelBounds& bounds)
{
  const std::vector<NodeId> nodes = TreePageNodes(page, depths);
  bool floats = true;
  for (const NodeId node : nodes)
  {
    Box box = boxes[node];
    for (std::size_t side = 0; side < sides; ++side)
    {
      floats = floats && double(float(Side(box, side))) == Side(box, side);
    }
  }
  ByteWriter writer;
  WriteBlobHead(writer, treeMagic);
  writer.Byte(floats ? 4 : 8);
  SymbolWriter symbols({ 0, contexts });
  for (std::size_t side = 0; side < sides; ++side)
  {
    std::uint64_t last = 0;
    for (const NodeId node : nodes)
    {
      Box box = boxes[node];
      const std::uint64_t value =
        floats ? OrderedBits(float(Side(box, side))) : OrderedBits(Side(box, side));
      symbols.Signed(side, static_cast<std::int64_t>(value - last));
      last = value;
    }
  }
  WriteBounds(symbols, page, depths, bounds);
  symbols.Finish(writer, 0);
  std::vector<std::uint8_t> blob = writer.Take();
  SealBlob(blob);
  return blob;
}

Status DecodeTreePage(std::span<const std::uint8_t> blob, NodeId page, const TreeDepths& depths,
  std::span<Box> boxes, LevelBounds& bounds)
{
  const auto named = [page](ErrorCode code, const std::string& what) {
    return Error{ code, "tree page " + std::to_string(page) + ": " + what };
  };
  if (page == 0 || DepthOfNode(page) % treePageDepths != 0 ||
      DepthOfNode(page) > depths.partition || boxes.size() != std::size_t{ 2 } << depths.partition)
  {
    return named(ErrorCode::InvalidArgument, "is no page of this tree");
  }
  const auto unsealed = UnsealBlob(blob, treeMagic);
  if (!unsealed)
  {
    return named(unsealed.GetError().code, unsealed.GetError().message);
  }
  ByteReader reader(*unsealed);
  (void)reader.Raw(blobHeadSize);
  const std::uint8_t width = reader.Byte();
  if (width != 4 && width != 8)
  {
    reader.Fail("unknown width of coordinates");
  }
  const std::vector<NodeId> nodes = TreePageNodes(page, depths);
  std::vector<Box> read(nodes.size());
  SymbolReader symbols(unsealed->subspan(reader.Position()), { 0, contexts });
  for (std::size_t side = 0; side < sides; ++side)
  {
    std::uint64_t last = 0;
    for (Box& box : read)
    {
      last += static_cast<std::uint64_t>(symbols.Signed(side));
      if (width == 4 && last >> 32 != 0)
      {
        reader.Fail("coordinate out of range");
        break;
      }
      const double value = width == 4 ? double(FloatOfOrderedBits(static_cast<std::uint32_t>(last)))
                                      : DoubleOfOrderedBits(last);
      if (value != value)
      {
        reader.Fail("coordinate is not a number");
        break;
      }
      Side(box, side) = value;
    }
  }
  std::vector<PieceBounds> readBounds;
  if (!reader.Failed() && !ReadBounds(symbols, page, depths, bounds.size(), readBounds))
  {
    reader.Fail("bounds out of range");
  }
  if (!symbols.AtEnd())
  {
    reader.Fail("bytes beyond the end");
  }
  if (reader.Failed())
  {
    return named(ErrorCode::InvalidInput, reader.Why().message);
  }
  for (std::size_t i = 0; i < nodes.size(); ++i)
  {
    boxes[nodes[i]] = read[i];
  }
  auto next = readBounds.begin();
  ForEachBound(page, depths, bounds.size(),
    [&](unsigned level, std::size_t piece) { bounds[level][piece] = *next++; });
  return {};
}

}
