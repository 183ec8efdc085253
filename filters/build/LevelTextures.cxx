// SPDX-License-Identifier: BSD-3-Clause
// Textures of levels: see LevelTextures.h. Steps for each piece: 1. Read the piece from the store.
// 2. Find the finer pieces whose boxes overlap its own. 3. Make its texture from theirs.
#include "filters/build/LevelTextures.h"

#include "filters/core/tree/PieceDepth.h"

#include <algorithm>
#include <atomic>
#include <thread>
#include <utility>

namespace kdstream
{
namespace
{

constexpr std::size_t texturesAtOnce = 16;

bool Overlap(const Box& a, const Box& b)
{
  for (std::size_t k = 0; k < 3; ++k)
  {
    if (a.hi[k] < b.lo[k] || b.hi[k] < a.lo[k])
    {
      return false;
    }
  }
  return !a.Empty() && !b.Empty();
}

// Without counts, because the description has none yet.
CodecContext CodecOf(const ModelDescription& model)
{
  CodecContext codec = model.Codec();
  codec.clusters.clear();
  return codec;
}

// Whether to go on, asked by all threads. Only the thread that made it asks the caller's progress;
// the others follow.
class SharedProgress
{
public:
  explicit SharedProgress(const Execution& execution)
    : Caller(execution)
  {
  }

  Status Report(double fraction)
  {
    this->Fraction = fraction;
    return this->Caller.Report("encode", fraction);
  }

  bool GoesOn()
  {
    if (std::this_thread::get_id() == this->Thread &&
        !this->Caller.progress("encode", this->Fraction))
    {
      this->IsStopped = true;
    }
    return !this->IsStopped;
  }

private:
  const Execution& Caller;
  const std::thread::id Thread = std::this_thread::get_id();
  double Fraction = encodedBeforeLevelTextures; // only of that thread
  std::atomic<bool> IsStopped = false;
};

class LevelTextureMaker
{
public:
  LevelTextureMaker(const PieceTextures& textures, const std::vector<Box>& boxes,
    const ModelDescription& model, const StoreWriter& store, SharedProgress& progress)
    : Textures(textures)
    , Boxes(boxes)
    , Model(model)
    , Codec(CodecOf(model))
    , Store(store)
    , Progress(progress)
  {
  }

  Result<EncodedTexture> Make(PieceId id) const
  {
    const Result<Piece> piece = this->Read(id);
    KDSTREAM_TRY(piece);
    Box around = this->Boxes[id.node];
    for (const Vec3& point : piece->positions)
    {
      around.Add(point);
    }
    const Resolution finer = id.resolution.Depth() < this->Model.depths.finest
                               ? Resolution::Level(id.resolution.Depth() + 1U)
                               : Resolution::Original();
    FinerPieces pieces;
    this->FindPlaces(1, PieceDepth(finer, this->Model.depths), around, id.node, pieces);
    for (FinerPieces::Place& place : pieces.places)
    {
      place.id.resolution = finer;
    }
    pieces.read = [&](std::size_t place) { return this->ReadFiner(pieces.places[place].id); };
    pieces.goesOn = [this] { return this->Progress.GoesOn(); };
    return this->Textures.MakeOfLevel(*piece, pieces);
  }

private:
  Result<Piece> Read(PieceId id) const
  {
    const auto blob = this->Store.ReadPiece(id);
    KDSTREAM_TRY(blob);
    return DecodePiece(*blob, id, this->Codec);
  }

  Result<FinerPiece> ReadFiner(PieceId id) const
  {
    Result<Piece> piece = this->Read(id);
    KDSTREAM_TRY(piece);
    Result<std::vector<std::uint8_t>> texture = this->Store.ReadTexture(id);
    KDSTREAM_TRY(texture);
    return FinerPiece{ std::move(*piece), std::move(*texture) };
  }

  // Finds the nodes of this depth below `node` that are below or beside the piece, ascending.
  void FindPlaces(
    NodeId node, unsigned depth, const Box& around, NodeId piece, FinerPieces& pieces) const
  {
    const unsigned at = DepthOfNode(node), ofPiece = DepthOfNode(piece);
    const bool below = at >= ofPiece && node >> (at - ofPiece) == piece;
    if (!below && !Overlap(this->Boxes[node], around))
    {
      return;
    }
    if (at < depth)
    {
      this->FindPlaces(2 * node, depth, around, piece, pieces);
      this->FindPlaces(2 * node + 1, depth, around, piece, pieces);
      return;
    }
    pieces.places.push_back({ { {}, node }, this->Boxes[node], below });
  }

  const PieceTextures& Textures;
  const std::vector<Box>& Boxes;
  const ModelDescription& Model;
  const CodecContext Codec;
  const StoreWriter& Store;
  SharedProgress& Progress;
};

}

Status WriteLevelTextures(const PieceTextures& textures, const std::vector<Box>& boxes,
  const ModelDescription& model, StoreWriter& writer, StepClock& clock, const Execution& execution)
{
  SharedProgress progress(execution);
  const LevelTextureMaker maker(textures, boxes, model, writer, progress);
  double all = 0, made = 0; // numbers of pieces
  for (unsigned depth = 0; depth <= model.depths.finest; ++depth)
  {
    all += double(NodeId{ 1 } << PieceDepth(Resolution::Level(depth), model.depths));
  }
  for (unsigned depth = model.depths.finest + 1; depth-- > 0;)
  {
    const Resolution level = Resolution::Level(depth);
    const NodeId first = NodeId{ 1 } << PieceDepth(level, model.depths);
    for (NodeId done = 0; done < first; done += texturesAtOnce)
    {
      const std::size_t count = std::min<std::size_t>(texturesAtOnce, first - done);
      std::vector<Result<EncodedTexture>> encoded(count, Result<EncodedTexture>(EncodedTexture{}));
      execution.parallelFor(count, 1,
        [&](std::size_t begin, std::size_t end)
        {
          for (std::size_t i = begin; i < end; ++i)
          {
            encoded[i] = maker.Make({ level, first + done + static_cast<NodeId>(i) });
          }
        });
      clock.Finish("encode");
      for (std::size_t i = 0; i < count; ++i)
      {
        KDSTREAM_TRY(encoded[i]);
        KDSTREAM_TRY(writer.AddLevelTexture(
          { level, first + done + static_cast<NodeId>(i) }, encoded[i]->bytes, encoded[i]->texels));
      }
      clock.Finish("write");
      made += double(count);
      constexpr double before = encodedBeforeLevelTextures;
      KDSTREAM_TRY(progress.Report(before + (1 - before) * made / all));
    }
  }
  return {};
}

}
