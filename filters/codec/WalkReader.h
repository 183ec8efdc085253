// SPDX-License-Identifier: BSD-3-Clause
// Follows the steps of a walk over a piece (TriangleWalk.h), and so finds its triangles.
#pragma once

#include "filters/codec/SymbolCoder.h"
#include "filters/codec/TriangleWalk.h"
#include "filters/core/Types.h"

#include <cstddef>
#include <memory>
#include <span>

namespace kdstream
{

class WalkReader
{
public:
  explicit WalkReader(const WalkCounts& counts)
    : Counts(counts)
    , Arrays(counts)
    , TriangleArray(new Triangle[counts.triangles])
  {
  }

  // Call it once. stepCount: the number of steps. Returns false if this is not a walk with the
  // given counts.
  bool Read(SymbolReader& symbols, std::size_t stepCount);

  // After Read: all vertices in the order of the walk, those without triangles last.
  std::span<const WalkVertex> Vertices() const
  {
    return { this->Arrays.vertices.get(), this->Counts.Vertices() };
  }
  // After Read: the triangles, in the walk's numbers.
  std::span<const Triangle> Triangles() const
  {
    return { this->TriangleArray.get(), this->Counts.triangles };
  }

private:
  WalkCounts Counts;
  WalkArrays Arrays;
  std::unique_ptr<Triangle[]> TriangleArray;
};

}
