// SPDX-License-Identifier: BSD-3-Clause
// How far the original is from the levels of a store, found while its pieces are written. For
// StoreWriter alone.
#pragma once

#include "filters/codec/PieceCodec.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/core/pieces/Piece.h"
#include "filters/core/pieces/SurfaceBound.h"
#include "filters/model/ModelDescription.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

namespace kdstream
{

// Measures each piece of the original to all levels as they are stored. The same figures, bit for
// bit, in whatever order pieces come: what all builders write alike.
class LevelBounds
{
public:
  // A level's piece as it was written; called by one thread at a time.
  using ReadBlob = std::function<Result<std::vector<std::uint8_t>>(PieceId)>;

  // model: its levels' spacings are known.
  LevelBounds(const ModelDescription& model, ReadBlob read);

  // Keeps a box around a piece of a level: 24 bytes.
  void AddLevelPiece(const Piece& piece);
  // least: that the level is not said to be nearer.
  void FinishLevel(unsigned depth, bool hasTriangles, double least);

  // Any number of threads may measure pieces. REQUIRES: all levels are finished. O(v) on average;
  // memory some 6 decoded pieces of each level. Errors: those of reading and decoding.
  Status Measure(const Piece& original);

  // Whether a piece was measured.
  bool HasMeasured() const { return this->Measured.load(); }
  // Of each level, model units: no point of the input that was measured is farther from the
  // level's surface, or its points where it has no triangles. Never less than of a finer level.
  std::vector<double> Bounds() const;

private:
  // A piece of a level, ready to be searched.
  struct LevelPart
  {
    NodeId node = 1;
    SearchedPart surface;
    std::vector<VertexKey> keys;    // of own vertices
    std::vector<std::uint8_t> used; // whether a triangle has them
    double spacing = 0;
  };
  using Part = std::shared_ptr<const LevelPart>;
  struct KeptPart
  {
    Part part;
    std::uint64_t asked = 0; // when
  };
  struct Extent
  {
    std::array<float, 3> lo{}, hi{};
  };
  struct LevelState
  {
    std::vector<Extent> extents; // by node, from the first of its depth on
    bool hasTriangles = false;
    std::map<NodeId, KeptPart> kept;
  };

  // A piece of the original, ready to be measured while the piece is there.
  struct OriginalPart
  {
    MeasuredPart clusters; // of the finest level
    std::vector<VertexKey> keys;
  };

  OriginalPart PartOfOriginal(
    const Piece& piece, std::span<const Triangle> triangles, const LevelPart& finest) const;
  static std::vector<VertexId> RepresentativesOf(
    std::span<const VertexKey> clusters, const LevelPart& level);
  Result<Part> LoadOf(unsigned depth, std::uint32_t partition);
  Result<Part> Load(unsigned depth, NodeId node);
  Result<Part> Decode(unsigned depth, NodeId node) const;
  Status LookFarther(unsigned depth, NodeId except, const Vec3& place, double& squared);

  CodecContext Codec;
  PrimitiveType Primitive;
  double Closeness = 1; // of what is looked at as a whole; the larger, the less close
  ReadBlob Read;
  std::mutex Loading; // held while `kept` is used
  std::uint64_t Asked = 0;
  std::vector<LevelState> Levels;
  std::vector<std::atomic<double>> Farthest; // of each level
  std::atomic<bool> Measured = false;
};

}
