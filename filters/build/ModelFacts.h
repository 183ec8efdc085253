// SPDX-License-Identifier: BSD-3-Clause
// What a store says about its model: from the options of the build, and from facts that the build
// has found.
#pragma once

#include "filters/build/Builder.h"

#include <cstdint>
#include <string>
#include <vector>

namespace kdstream
{

// The facts that a build has found, in memory or out of core.
struct ModelFacts
{
  std::uint64_t vertices = 0, triangles = 0; // after welding, without unused vertices
  std::uint64_t unused = 0;                  // vertices that no triangle uses
  std::uint64_t welded = 0, inconsistentEdges = 0;
  TreeDepths depths;
  std::uint64_t partitions = 1;
  std::uint64_t smallestPartition = 0, largestPartition = 0;
  Box box;
  ScalarType scalarType = ScalarType::Float32;
  bool weld = true;                      // whether equal vertices were joined
  std::vector<AttributeInfo> attributes; // point arrays first
  std::vector<double> geometricErrors;   // GeometricErrorBins::Most99 of each level
};

CoordinateGrid GridOf(const BuildOptions& options, const Box& box, ScalarType scalarType);

// All metadata except those that the writer adds: digest, counts and bytes of the resolutions.
ModelDescription DescribeModel(
  const BuildOptions& options, const ModelFacts& facts, const std::string& inputName);

// Whether it is certain that no two vertices are in the same place (here -0.0 and 0.0 are different
// places). Even after welding, vertices can be in the same place if their arrays differ.
bool WeldingSeparates(bool weld, const std::vector<AttributeInfo>& attributes);

}
