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

// Pieces that follow each other, and their bytes.
struct Batch
{
  std::size_t first = 0, count = 0;
  std::vector<Piece> pieces;
  std::vector<std::vector<std::uint8_t>> blobs;

  void Begin(std::size_t firstPiece, std::size_t pieceCount)
  {
    this->first = firstPiece;
    this->count = pieceCount;
    this->pieces.resize(std::max(this->pieces.size(), pieceCount));
    this->blobs.resize(this->pieces.size());
  }

  void Encode(std::size_t i, const PieceCutter& cutter, const CodecContext& codec)
  {
    this->pieces[i] = cutter.Cut(this->first + i);
    this->blobs[i] = EncodePiece(this->pieces[i], codec);
  }

  Status AddTo(StoreWriter& writer) const
  {
    for (std::size_t i = 0; i < this->count; ++i)
    {
      KDSTREAM_TRY(writer.AddPiece(this->pieces[i], this->blobs[i]));
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

Status EncodePieces(const PieceCutter& cutter, std::size_t count, const CodecContext& codec,
  const PieceSink& add, StepClock& clock, const Execution& execution,
  const std::function<Status(std::size_t)>& done)
{
  const std::size_t atOnce = PiecesAtOnce(cutter);
  std::vector<Piece> pieces(std::min(atOnce, count));
  std::vector<std::vector<std::uint8_t>> blobs(pieces.size());
  for (std::size_t first = 0; first < count; first += atOnce)
  {
    const std::size_t batch = std::min(atOnce, count - first);
    execution.parallelFor(batch, 1,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t i = begin; i < end; ++i)
        {
          pieces[i] = {}; // a large one goes before the next comes
          pieces[i] = cutter.Cut(first + i);
          blobs[i] = EncodePiece(pieces[i], codec);
        }
      });
    clock.Finish("encode");
    for (std::size_t i = 0; i < batch; ++i)
    {
      KDSTREAM_TRY(add(pieces[i], blobs[i]));
    }
    clock.Finish("write");
    KDSTREAM_TRY(done(first + batch));
  }
  return {};
}

Status WritePieces(const PieceCutter& cutter, std::size_t count, const CodecContext& codec,
  StoreWriter& writer, StepClock& clock, const Execution& execution,
  const std::function<Status(std::size_t)>& written)
{
  const std::size_t atOnce = PiecesAtOnce(cutter);
  if (atOnce < 2)
  {
    return EncodePieces(
      cutter, count, codec,
      [&](const Piece& piece, std::span<const std::uint8_t> blob)
      { return writer.AddPiece(piece, blob); },
      clock, execution, written);
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
            added = before.AddTo(writer);
          }
          else
          {
            next.Encode(i - writes, cutter, codec);
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
