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

// Minimum, maximum and classes are exact. Percentiles are those of a sample of the vertices: the
// SampleSize() vertices with the lowest hashes of partition and index, or all vertices if there are
// not more. So the result does not depend on the order of the pieces. With 65,536 vertices the 2nd
// percentile is nearly always exact to within 0.2 percent of all vertices (three times its standard
// deviation).
//
// Memory: at most about 18 MiB, and a map of 256 classes for each array.
class ScalarStatistics
{
public:
  // The arrays of a model for which ranges are gathered: those of ArraysOfLevels that are numbers
  // (IsScalar).
  static std::vector<AttributeInfo> ArraysOf(std::span<const AttributeInfo> attributes);

  // attributes: all of the model.
  explicit ScalarStatistics(std::span<const AttributeInfo> attributes);

  // Adds the own vertices of a piece of the original; call it once for each piece. REQUIRES: the
  // piece has the arrays. O(own vertices).
  void Add(const Piece& piece);
  // O(sample log sample).
  std::vector<ScalarDescription> Describe() const;

  // The size of the sample: 65,536 vertices, fewer if there are more than 8 arrays.
  std::size_t SampleSize() const;

private:
  struct Column
  {
    std::uint64_t finite = 0; // number of finite values
    double least = 0, most = 0;
    bool hasClasses = false;
    std::map<double, std::uint64_t> classes;
  };
  void Count(Column& column, double value) const;
  void KeepLowest(std::size_t count);

  std::vector<AttributeInfo> Infos;
  std::vector<Column> Columns;
  std::vector<std::uint64_t> Hashes; // of the vertices in the sample
  // For each vertex of the sample, one value of each array.
  std::vector<double> Values;
  std::uint64_t Limit = ~std::uint64_t{ 0 }; // hashes above this do not enter the sample
};

}
