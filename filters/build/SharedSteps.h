// SPDX-License-Identifier: BSD-3-Clause
// Small checks and counts that the three builders (in memory, out of core, on ranks) do alike, so
// that each stands once: names of attributes, vertices that the grid merges. For the builders
// alone; the steps themselves are in the folders of the pipeline picture.
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

// What the store calls its input: options.inputName, or the file's name.
std::string InputNameOf(const std::filesystem::path& input, const BuildOptions& options);

// Errors: InvalidInput for an array whose name no store can hold (IsAttributeName).
Status CheckAttributeNames(std::span<const AttributeInfo> attributes);

// Bytes of a mesh's file that are worked on at once where a step may take `memory`.
std::size_t ChunkOfRead(std::uint64_t memory);

// How many vertices in different places the grid brings together. vertices: all of them.
// mayCoincide: whether some may be in one place as they are. count: in how many different places
// all vertices are, by placeOf, or as they are where it is empty. Errors: those of `count`.
using PlaceOfPoint = std::function<Vec3(const Vec3&)>;
Result<std::uint64_t> CountMergedByGrid(const CoordinateGrid& grid, std::uint64_t vertices,
  bool mayCoincide, const std::function<Result<std::uint64_t>(const PlaceOfPoint&)>& count);

// Edges of a block's own vertices that are not consistently oriented (EdgeCount.h).
std::uint64_t CountInconsistentEdges(const TreeBlock& block, const Execution& execution);

// Fills in the smallest and the largest of facts.partitions, which have sizeOf(p) vertices.
void MeasurePartitions(
  ModelFacts& facts, const std::function<std::uint64_t(std::size_t partition)>& sizeOf);

}
