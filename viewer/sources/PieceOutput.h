// SPDX-License-Identifier: BSD-3-Clause
// Pieces of a model as VTK's data: what vtkKdModelSource gives, without its pipeline.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/store/PieceSource.h"

#include <vtkPartitionedDataSet.h>
#include <vtkPolyData.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <utility>
#include <vector>

namespace kdstream
{

// Which part of the output is wanted here: `piece` of `pieces`, with this number of rings around
// it.
struct OutputShare
{
  std::uint32_t piece = 0, pieces = 1;
  unsigned ghostLevels = 0;
  std::optional<std::set<std::uint32_t>> blocks; // only these partitions; none: all

  // Whether `place`, of `count` places in the tree's order, is in this piece.
  bool Has(std::uint64_t place, std::uint64_t count) const
  {
    return place * this->pieces / count == this->piece;
  }
};

// The original as AddPartitions gives it.
struct OriginalFacts
{
  struct Partition
  {
    Box box; // with its ghosts, as the counts
    std::uint64_t points = 0, cells = 0;
  };
  std::vector<Partition> partitions;
  // For each of the model's arrays the range of the finite values of its first component: empty if
  // it has more than one component, or no finite value.
  std::vector<std::optional<std::pair<double, double>>> ranges;
};

// Decodes all of the original, some pieces at a time. Errors: those of the source.
Result<OriginalFacts> MeasureOriginal(const PieceSource& source, const Execution& execution);

class PieceOutput
{
public:
  // isWanted: which arrays. The arguments outlive this.
  PieceOutput(const PieceSource& source, std::function<bool(const AttributeInfo&)> isWanted,
    const Execution& execution);

  // Partitions of the original, ascending. Errors: those of the source; InvalidInput for pieces
  // that contradict each other. REQUIRES: below the model's partitions.
  Status AddPartitions(const std::vector<std::uint32_t>& chosen, const OutputShare& share,
    vtkPartitionedDataSet& output) const;
  Status GlueInto(
    const std::vector<std::uint32_t>& chosen, const OutputShare& share, vtkPolyData& output) const;

  // A level. REQUIRES: a level of the model.
  Status AddPieces(unsigned level, const OutputShare& share, vtkPartitionedDataSet& output) const;
  Status DrawInto(unsigned level, const OutputShare& share, vtkPolyData& output) const;

  // All of the preview with these pieces in it.
  Status DrawInto(const std::vector<PieceId>& shown, vtkPolyData& output) const;

private:
  Status Fill(Mesh mesh, std::size_t ownPoints, vtkPolyData& output) const;
  struct Selection
  {
    std::set<std::uint32_t> all, own; // chosen partitions; those of this share
    std::vector<PieceId> ids;         // to be read, ascending: with the rings around
  };
  Result<Selection> Select(
    const std::vector<std::uint32_t>& chosen, const OutputShare& share) const;

  const PieceSource& Source;
  std::function<bool(const AttributeInfo&)> IsWanted;
  const Execution& Runs;
};

}
