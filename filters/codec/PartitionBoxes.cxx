// SPDX-License-Identifier: BSD-3-Clause
// The exact boxes of partitions: see PartitionBoxes.h and doc/formats.md.
#include "filters/codec/PartitionBoxes.h"

#include "filters/codec/ByteStream.h"
#include "filters/codec/Seal.h"
#include "filters/codec/SymbolCoder.h"

#include <algorithm>
#include <optional>
#include <string>

namespace kdstream
{
namespace
{

constexpr std::string_view boxesMagic = "KDB";
constexpr std::size_t sides = 6; // of a box, each with its own context

double& Side(Box& box, std::size_t side)
{
  return side < 3 ? box.lo[side] : box.hi[side - 3];
}

double SideOf(const Box& box, std::size_t side)
{
  return side < 3 ? box.lo[side] : box.hi[side - 3];
}

NodeId FirstPartition(NodeId node, const TreeDepths& depths)
{
  return node << (depths.partition - DepthOfPartitionBoxes(depths));
}

std::size_t PartitionsOfBoxes(const TreeDepths& depths)
{
  return std::size_t{ 1 } << (depths.partition - DepthOfPartitionBoxes(depths));
}

bool AreFloats(std::span<const Box> boxes)
{
  return std::all_of(boxes.begin(), boxes.end(),
    [](const Box& box)
    {
      const auto isFloat = [](double value) { return double(float(value)) == value; };
      return std::all_of(box.lo.begin(), box.lo.end(), isFloat) &&
             std::all_of(box.hi.begin(), box.hi.end(), isFloat);
    });
}

// The number with these bits; no value if the bits are not a number of this width.
std::optional<double> SideOfBits(std::uint64_t bits, unsigned width)
{
  if (width == 4 && bits >> 32 != 0)
  {
    return {};
  }
  const double value = width == 4 ? double(FloatOfOrderedBits(static_cast<std::uint32_t>(bits)))
                                  : DoubleOfOrderedBits(bits);
  return value == value ? std::optional(value) : std::nullopt;
}

}

unsigned DepthOfPartitionBoxes(const TreeDepths& depths)
{
  return depths.partition - std::min(depths.partition, partitionBoxesDepths);
}

bool HasPartitionBoxes(NodeId node, const TreeDepths& depths)
{
  return node != 0 && DepthOfNode(node) == DepthOfPartitionBoxes(depths);
}

NodeId BoxesOfPartition(NodeId partition, const TreeDepths& depths)
{
  return partition >> (depths.partition - DepthOfPartitionBoxes(depths));
}

std::vector<NodeId> AllPartitionBoxes(const TreeDepths& depths)
{
  const NodeId first = NodeId{ 1 } << DepthOfPartitionBoxes(depths);
  std::vector<NodeId> nodes(first);
  for (NodeId i = 0; i < first; ++i)
  {
    nodes[i] = first + i;
  }
  return nodes;
}

std::vector<std::uint8_t> EncodePartitionBoxes(
  std::span<const Box> boxes, NodeId node, const TreeDepths& depths)
{
  const auto selected = boxes.subspan(FirstPartition(node, depths), PartitionsOfBoxes(depths));
  const bool floats = AreFloats(selected);
  ByteWriter writer;
  WriteBlobHead(writer, boxesMagic);
  writer.Byte(floats ? 4 : 8);
  SymbolWriter symbols({ 0, sides });
  for (std::size_t side = 0; side < sides; ++side)
  {
    std::uint64_t last = 0;
    for (const Box& box : selected)
    {
      const double value = SideOf(box, side);
      const std::uint64_t bits = floats ? OrderedBits(float(value)) : OrderedBits(value);
      symbols.Signed(side, static_cast<std::int64_t>(bits - last));
      last = bits;
    }
  }
  symbols.Finish(writer, 0);
  std::vector<std::uint8_t> blob = writer.Take();
  SealBlob(blob);
  return blob;
}

Result<std::vector<Box>> DecodePartitionBoxes(
  std::span<const std::uint8_t> blob, NodeId node, const TreeDepths& depths)
{
  const auto named = [node](ErrorCode code, const std::string& what) {
    return Error{ code, "boxes " + std::to_string(node) + ": " + what };
  };
  if (!HasPartitionBoxes(node, depths))
  {
    return named(ErrorCode::InvalidArgument, "the tree has no boxes at this node");
  }
  const auto unsealed = UnsealBlob(blob, boxesMagic);
  if (!unsealed)
  {
    return named(unsealed.GetError().code, unsealed.GetError().message);
  }
  ByteReader reader(*unsealed);
  (void)reader.Raw(blobHeadSize);
  const std::uint8_t width = reader.Byte();
  if (reader.Failed() || (width != 4 && width != 8))
  {
    return named(ErrorCode::InvalidInput, "unknown size of coordinates");
  }
  std::vector<Box> boxes(PartitionsOfBoxes(depths));
  SymbolReader symbols(unsealed->subspan(reader.Position()), { 0, sides });
  for (std::size_t side = 0; side < sides; ++side)
  {
    std::uint64_t last = 0;
    for (Box& box : boxes)
    {
      last += static_cast<std::uint64_t>(symbols.Signed(side));
      const std::optional<double> value = SideOfBits(last, width);
      if (!value)
      {
        return named(ErrorCode::InvalidInput, "a coordinate is not a number");
      }
      Side(box, side) = *value;
    }
  }
  if (!symbols.AtEnd())
  {
    return named(ErrorCode::InvalidInput, "extra bytes at the end");
  }
  return boxes;
}

void UniteBoxes(std::span<Box> boxes)
{
  for (std::size_t node = boxes.size() / 2; node-- > 1;)
  {
    boxes[node] = {};
    boxes[node].Add(boxes[2 * node]);
    boxes[node].Add(boxes[2 * node + 1]);
  }
}

std::vector<Box> BoxesAbove(std::span<const Box> partitions)
{
  std::vector<Box> boxes(2 * partitions.size());
  std::copy(partitions.begin(), partitions.end(),
    boxes.begin() + static_cast<std::ptrdiff_t>(partitions.size()));
  UniteBoxes(boxes);
  return boxes;
}

}
