// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer's entry to the decoders of pieces, textures, tree pages and boxes. The first bytes
// choose the tree's depths, the grid and the piece; the rest is the blob. It is decoded once as it
// is, and once with a correct checksum appended, so that the decoders after the check are reached.
// A decoded piece must pass CheckPiece, and must encode to a blob that decodes to the same piece.
#include "filters/codec/PartitionBoxes.h"
#include "filters/codec/PieceCodec.h"
#include "filters/codec/Seal.h"
#include "filters/codec/TextureTile.h"
#include "filters/codec/TreePage.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <vector>

using namespace kdstream;

namespace
{

void DecodeTree(std::span<const std::uint8_t> blob, const CodecContext& context)
{
  const TreeDepths& depths = context.depths;
  const Box around{ { -1, 0, 1e9 }, { 1, 3, 1e9 + 1 } };
  (void)DecodeTreePage(blob, 1, around, depths, false).HasValue();
  if (const auto decoded = DecodeTreePage(blob, 1, around, depths, true))
  {
    const auto again = DecodeTreePage(EncodeTreePage(*decoded), 1, around, depths, true);
    if (!again || again->boxes != decoded->boxes || again->facts != decoded->facts)
    {
      std::abort();
    }
  }
  const NodeId node = NodeId{ 1 } << DepthOfPartitionBoxes(depths);
  if (const auto decoded = DecodePartitionBoxes(blob, node, depths))
  {
    std::vector<Box> boxes(std::size_t{ 2 } << depths.partition);
    std::copy(
      decoded->begin(), decoded->end(), boxes.begin() + (std::ptrdiff_t{ 1 } << depths.partition));
    const auto again =
      DecodePartitionBoxes(EncodePartitionBoxes(boxes, node, depths), node, depths);
    if (!again || *again != *decoded)
    {
      std::abort();
    }
  }
}

// Decodes the tile for a strip with the number of triangles that its head specifies.
void DecodeTexture(std::span<const std::uint8_t> blob)
{
  const auto head = ReadTextureTileHead(blob);
  if (!head || head->triangles > 4096)
  {
    return;
  }
  std::vector<Triangle> triangles;
  std::vector<Vec3> points{ { 0, 0, 0 }, { 0, 1, 0 } };
  for (VertexId v = 0; v < head->triangles; ++v)
  {
    triangles.push_back({ v, v + 1, v + 2 });
    points.push_back({ v / 8.0, double(v % 2), double(v % 3) });
  }
  const auto tile = DecodeTextureTile(blob, triangles, points);
  if (tile)
  {
    const auto again = DecodeTextureTile(EncodeTextureTile(*tile, triangles), triangles, points);
    if (!again || again->corners != tile->corners || again->image != tile->image)
    {
      std::abort();
    }
  }
}

void Decode(std::span<const std::uint8_t> blob, PieceId id, const CodecContext& context)
{
  if (const Result<Piece> piece = DecodePiece(blob, id, context))
  {
    const Result<Piece> again = DecodePiece(EncodePiece(*piece, context), id, context);
    if (!again || again->triangles != piece->triangles || again->keys != piece->keys ||
        again->attributes != piece->attributes)
    {
      std::abort();
    }
  }
  DecodeTree(blob, context);
  DecodeTexture(blob);
}

}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  if (size < 4)
  {
    return 0;
  }
  CodecContext context;
  context.depths.partition = data[0] % 6;
  context.depths.finest = context.depths.partition + data[1] % 14;
  context.depths.stitch = std::min(context.depths.finest, context.depths.partition + 4);
  context.depths.onePiece = data[1] % 4; // then levels coarser than S have parents and child nodes
  context.grid =
    data[2] % 3 == 0
      ? CoordinateGrid::Over({ { 0, 0, 0 }, { 1, 1, 1 } }, 20, ScalarType::Float32)
      : CoordinateGrid::Exact(data[2] % 3 == 1 ? ScalarType::Float32 : ScalarType::Float64);
  context.spacings.assign(context.depths.finest + 1, 1U + data[2] * data[2]);
  const unsigned level = data[3] % (context.depths.finest + 2);
  const Resolution resolution =
    level > context.depths.finest ? Resolution::Original() : Resolution::Level(level);
  const PieceId id{ resolution, NodeId{ 1 } << PieceDepth(resolution, context.depths) };
  const std::span<const std::uint8_t> blob(data + 4, size - 4);

  Decode(blob, id, context);
  std::vector<std::uint8_t> sealed(blob.begin(), blob.end());
  SealBlob(sealed);
  Decode(sealed, id, context);
  return 0;
}
