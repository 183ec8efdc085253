// SPDX-License-Identifier: BSD-3-Clause
// Small checks and counts that the three builders (in memory, out of core, on ranks) share: names
// of attributes, vertices that the grid merges. Only for the builders. The steps themselves are in
// the folders of the pipeline picture.
#pragma once

#include "filters/build/Builder.h"
#include "filters/build/ModelFacts.h"
#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/outofcore/mesh/TreeBlock.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

namespace kdstream
{

// The input's name in the store: options.inputName, or the file's name.
std::string InputNameOf(const std::filesystem::path& input, const BuildOptions& options);

// Errors: InvalidInput for an array whose name no store can hold (IsAttributeName).
Status CheckAttributeNames(std::span<const AttributeInfo> attributes);

// How many bytes of a mesh file to process at once if a step may take `memory`.
std::size_t ChunkOfRead(std::uint64_t memory);

// The number of vertices that the grid merges, not counting those that were in the same place
// before. vertices: number of all vertices. mayCoincide: whether some may be in the same place
// before. count: counts distinct places, by placeOf; if placeOf is empty, those of the vertices as
// they are. Errors: those of `count`.
using PlaceOfPoint = std::function<Vec3(const Vec3&)>;
Result<std::uint64_t> CountMergedByGrid(const CoordinateGrid& grid, std::uint64_t vertices,
  bool mayCoincide, const std::function<Result<std::uint64_t>(const PlaceOfPoint&)>& count);

// The number of edges of a block's own vertices that are not consistently oriented (EdgeCount.h).
std::uint64_t CountInconsistentEdges(const TreeBlock& block, const Execution& execution);

// Sets the smallest and the largest size in `facts`; partition p has sizeOf(p) vertices.
void MeasurePartitions(
  ModelFacts& facts, const std::function<std::uint64_t(std::size_t partition)>& sizeOf);

}
