// SPDX-License-Identifier: BSD-3-Clause
// The ranges of the arrays that viewers may colour by, gathered as a store is written: part of step
// "store" of the pipeline picture.
#pragma once

#include "filters/core/pieces/Piece.h"
#include "filters/model/ModelDescription.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace kdstream
{

// Least and most are exact, and the classes. Percentiles are those of a sample of the vertices,
// which is all of them where they are no more than SampleSize(): those whose hashes of partition
// and place in it are the lowest. So the result does not depend on the order of the pieces, and
// with 65,536 vertices the 2nd percentile is the 2nd to within 0.2 nearly always (three times its
// standard deviation).
//
// Memory: at most about 18 MiB, and a map of 256 classes an array.
class ScalarStatistics
{
public:
  // Which of a model's arrays are looked at: those of ArraysOfLevels that are numbers (IsScalar).
  static std::vector<AttributeInfo> ArraysOf(std::span<const AttributeInfo> attributes);

  // attributes: of the model.
  explicit ScalarStatistics(std::span<const AttributeInfo> attributes);

  // The own vertices of a piece of the original, each piece once. REQUIRES: it has the arrays.
  // O(own vertices).
  void Add(const Piece& piece);
  // O(sample log sample).
  std::vector<ScalarDescription> Describe() const;

  // So many vertices: 65,536, fewer where there are more than 8 arrays.
  std::size_t SampleSize() const;

private:
  struct Column
  {
    std::uint64_t finite = 0; // values
    double least = 0, most = 0;
    bool hasClasses = false;
    std::map<double, std::uint64_t> classes;
  };
  void Count(Column& column, double value) const;
  void KeepLowest(std::size_t count);

  std::vector<AttributeInfo> Infos;
  std::vector<Column> Columns;
  std::vector<std::uint64_t> Hashes;         // of the sample
  std::vector<double> Values;                // of the sample: one an array, vertex after vertex
  std::uint64_t Limit = ~std::uint64_t{ 0 }; // no hash above it is in the sample
};

}
