// SPDX-License-Identifier: BSD-3-Clause
// Walks over a piece's triangles (TriangleWalk.h) and writes the steps: part of step "encode".
#pragma once

#include "filters/codec/SymbolCoder.h"
#include "filters/codec/TriangleWalk.h"
#include "filters/core/Types.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

class WalkWriter
{
public:
  // Corners of triangles are numbers of the piece's vertices: first the own ones, 0 … counts.own -
  // 1, then ghosts. REQUIRES: triangles.size() is counts.triangles.
  WalkWriter(std::span<const Triangle> triangles, const WalkCounts& counts)
    : Counts(counts)
    , Arrays(counts)
    , Triangles(triangles)
  {
  }

  // Call it once.
  void Write(SymbolWriter& symbols);

  // After Write: the number of steps written, which a reader needs.
  std::size_t StepCount() const { return this->Steps; }
  // After Write: all vertices in the order of the walk, those without triangles last.
  std::span<const WalkVertex> Vertices() const
  {
    return { this->Arrays.vertices.get(), this->Counts.Vertices() };
  }
  // After Write: the number in the piece of each of these vertices.
  const std::vector<VertexId>& Numbers() const { return this->PieceNumbers; }

private:
  WalkCounts Counts;
  WalkArrays Arrays;
  std::span<const Triangle> Triangles;
  std::vector<VertexId> PieceNumbers;
  std::size_t Steps = 0;
};

}
