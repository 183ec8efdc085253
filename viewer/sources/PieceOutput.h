// SPDX-License-Identifier: BSD-3-Clause
// Converts pieces of a model to VTK's data: the output of vtkKdModelSource, without the pipeline.
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

// Which part of the output is requested: `piece` of `pieces`, with `ghostLevels` rings around it.
struct OutputShare
{
  std::uint32_t piece = 0, pieces = 1;
  unsigned ghostLevels = 0;
  std::optional<std::set<std::uint32_t>> blocks; // only these partitions; nothing: all

  // Whether `place`, of `count` places in the tree's order, is in this piece.
  bool Has(std::uint64_t place, std::uint64_t count) const
  {
    return place * this->pieces / count == this->piece;
  }
};

// Facts about the original as AddPartitions outputs it.
struct OriginalFacts
{
  struct Partition
  {
    Box box; // with ghosts, which the counts include, too
    std::uint64_t points = 0, cells = 0;
  };
  std::vector<Partition> partitions;
  // For each of the model's arrays that has one component, the range of its finite values. Empty
  // for other arrays, and if there are no finite values.
  std::vector<std::optional<std::pair<double, double>>> ranges;
};

// Decodes all of the original, some pieces at a time. Errors: those of the source.
Result<OriginalFacts> MeasureOriginal(const PieceSource& source, const Execution& execution);

class PieceOutput
{
public:
  // isWanted: whether to output an array. The arguments must outlive this object.
  PieceOutput(const PieceSource& source, std::function<bool(const AttributeInfo&)> isWanted,
    const Execution& execution);

  // Outputs partitions of the original: apart, or glued to one mesh. chosen: ascending. Errors:
  // those of the source; InvalidInput for pieces that contradict each other. REQUIRES: the model
  // has these partitions.
  Status AddPartitions(const std::vector<std::uint32_t>& chosen, const OutputShare& share,
    vtkPartitionedDataSet& output) const;
  Status GlueInto(
    const std::vector<std::uint32_t>& chosen, const OutputShare& share, vtkPolyData& output) const;

  // Outputs a level: its pieces, or one surface. REQUIRES: the model has this level.
  Status AddPieces(unsigned level, const OutputShare& share, vtkPartitionedDataSet& output) const;
  Status DrawInto(unsigned level, const OutputShare& share, vtkPolyData& output) const;

  // Outputs the whole preview, with these pieces in place of its parts.
  Status DrawInto(const std::vector<PieceId>& shown, vtkPolyData& output) const;

private:
  Status Fill(Mesh mesh, std::size_t ownPoints, vtkPolyData& output) const;
  struct Selection
  {
    std::set<std::uint32_t> all, own; // chosen partitions; those of this share
    std::vector<PieceId> ids;         // pieces to read, ascending, including the rings
  };
  Result<Selection> Select(
    const std::vector<std::uint32_t>& chosen, const OutputShare& share) const;

  const PieceSource& Source;
  std::function<bool(const AttributeInfo&)> IsWanted;
  const Execution& Runs;
};

}
