// SPDX-License-Identifier: BSD-3-Clause
#include "filters/build/PieceWriting.h"

#include "filters/codec/PartitionBoxes.h"
#include "filters/codec/TreePage.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace kdstream
{
namespace
{

// Cuts and encodes piece i of the cutter. The previous content of `encoded` is freed first, because
// it may be large.
Status Encode(
  const PieceCutter& cutter, std::size_t i, const PieceEncoding& encoding, EncodedPiece& encoded)
{
  encoded = {};
  encoded.piece = cutter.Cut(i);
  if (encoding.textures && encoded.piece.id.resolution.IsOriginal())
  {
    Result<EncodedTexture> texture = encoding.textures->Make(encoded.piece);
    KDSTREAM_TRY(texture);
    encoded.texture = std::move(*texture);
  }
  encoded.blob = EncodePiece(encoded.piece, encoding.codec);
  return {};
}

// Consecutive pieces and their bytes.
struct Batch
{
  std::size_t first = 0, count = 0;
  std::vector<EncodedPiece> pieces;
  std::vector<Status> statuses;

  void Begin(std::size_t firstPiece, std::size_t pieceCount)
  {
    this->first = firstPiece;
    this->count = pieceCount;
    this->pieces.resize(std::max(this->pieces.size(), pieceCount));
    this->statuses.assign(this->pieces.size(), {});
  }

  void Encode(std::size_t i, const PieceCutter& cutter, const PieceEncoding& encoding)
  {
    this->statuses[i] = kdstream::Encode(cutter, this->first + i, encoding, this->pieces[i]);
  }

  Status Write(StoreWriter& writer) const
  {
    for (std::size_t i = 0; i < this->count; ++i)
    {
      KDSTREAM_TRY(this->statuses[i]);
      KDSTREAM_TRY(AddToStore(writer, this->pieces[i]));
    }
    return {};
  }
};

std::size_t PiecesAtOnce(const PieceCutter& cutter)
{
  const std::size_t vertices = cutter.VertexCount() / std::max<std::size_t>(1, cutter.PieceCount());
  return std::clamp<std::size_t>(
    encodeBatchVertices / std::max<std::size_t>(1, vertices), 1, encodeBatch);
}

}

Status AddToStore(StoreWriter& writer, const EncodedPiece& encoded)
{
  const Piece& piece = encoded.piece;
  KDSTREAM_TRY(writer.AddPiece(piece, encoded.blob));
  if (!encoded.texture)
  {
    return {};
  }
  // The nodes of a depth begin at a power of two.
  const std::uint32_t partition = piece.id.node - (NodeId{ 1 } << DepthOfNode(piece.id.node));
  return writer.AddTexture(partition, encoded.texture->bytes, encoded.texture->texels);
}

Status EncodePieces(const PieceCutter& cutter, std::size_t count, const PieceEncoding& encoding,
  const PieceSink& add, StepClock& clock, const Execution& execution,
  const std::function<Status(std::size_t)>& done)
{
  const std::size_t atOnce = PiecesAtOnce(cutter);
  Batch batch;
  for (std::size_t first = 0; first < count; first += atOnce)
  {
    batch.Begin(first, std::min(atOnce, count - first));
    execution.parallelFor(batch.count, 1,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t i = begin; i < end; ++i)
        {
          batch.Encode(i, cutter, encoding);
        }
      });
    clock.Finish("encode");
    for (std::size_t i = 0; i < batch.count; ++i)
    {
      KDSTREAM_TRY(batch.statuses[i]);
      KDSTREAM_TRY(add(batch.pieces[i]));
    }
    clock.Finish("write");
    KDSTREAM_TRY(done(first + batch.count));
  }
  return {};
}

Status WritePieces(const PieceCutter& cutter, std::size_t count, const PieceEncoding& encoding,
  StoreWriter& writer, StepClock& clock, const Execution& execution,
  const std::function<Status(std::size_t)>& written)
{
  const std::size_t atOnce = PiecesAtOnce(cutter);
  if (atOnce < 2)
  {
    return EncodePieces(
      cutter, count, encoding,
      [&](const EncodedPiece& encoded) { return AddToStore(writer, encoded); }, clock, execution,
      written);
  }
  const std::size_t most = atOnce / 2; // two batches are in memory
  std::array<Batch, 2> batches;
  for (std::size_t first = 0;; first += most)
  {
    Batch& next = batches[first / most % 2];
    Batch& before = batches[(first / most + 1) % 2];
    next.Begin(first, first < count ? std::min(most, count - first) : 0);
    const std::size_t writes = before.count > 0 ? 1 : 0;
    Status added;
    execution.parallelFor(writes + next.count, 1,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t i = begin; i < end; ++i)
        {
          if (i < writes)
          {
            added = before.Write(writer);
          }
          else
          {
            next.Encode(i - writes, cutter, encoding);
          }
        }
      });
    clock.Finish(next.count > 0 ? "encode" : "write");
    KDSTREAM_TRY(added);
    if (writes > 0)
    {
      KDSTREAM_TRY(written(before.first + before.count));
    }
    if (next.count == 0)
    {
      return {};
    }
  }
}

double EncodedPart(Resolution resolution, const TreeDepths& depths, double done)
{
  constexpr double ofLevels = 0.25;
  if (resolution.IsOriginal())
  {
    return ofLevels + (1 - ofLevels) * done;
  }
  const double clusters = std::ldexp(1.0, static_cast<int>(resolution.Depth()));
  const double all = std::ldexp(2.0, static_cast<int>(depths.finest)) - 1;
  return ofLevels * (clusters - 1 + clusters * done) / all;
}

Status WriteTreePages(const std::vector<Box>& boxes, const TreeDepths& depths, StoreWriter& writer)
{
  for (const NodeId node : AllPartitionBoxes(depths))
  {
    KDSTREAM_TRY(writer.AddBoxes(node, EncodePartitionBoxes(boxes, node, depths)));
  }
  for (const NodeId page : TreePages(depths))
  {
    KDSTREAM_TRY(writer.AddTreePage(
      page, EncodeTreePage(RoundTreePage(boxes, page, depths, writer.Pieces()))));
  }
  return {};
}

}
