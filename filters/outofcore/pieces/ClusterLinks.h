// SPDX-License-Identifier: BSD-3-Clause
// What is needed to number the clusters of a level in files. Only for the numbers out of core.
#pragma once

#include "filters/core/pieces/VertexNumbers.h"
#include "filters/outofcore/files/RecordFile.h"
#include "filters/outofcore/levels/ExternalLevels.h"

#include <cstddef>
#include <span>
#include <vector>

namespace kdstream
{

// The parents of consecutive clusters: clusters of the next coarser level, with numbers in [begin,
// end).
struct ParentLinks
{
  VertexId begin = 0, end = 0;
  std::vector<VertexId> parents; // of each cluster, minus `begin`; empty at level 0
};

struct ClusterLinks
{
  ParentLinks above;
  std::vector<VertexId> lowest; // lowest original vertex of each cluster
  std::vector<Vec3> positions;
  std::vector<VertexId> counts; // number of original vertices of each cluster

  ClusterParents Links() const { return { this->above.parents, this->lowest, this->positions }; }
};

// Reads the parents for a block of a level in files. Errors: InputOutput; Damaged, naming the
// cluster, if a parent is invalid.
Result<ParentLinks> ReadParents(const ExternalLevels& levels, unsigned depth, std::size_t block);
Result<ClusterLinks> ReadLinks(const ExternalLevels& levels, unsigned depth, std::size_t block);

// The number of clusters of a level in files or in memory.
VertexId ClusterCount(const ExternalLevels& levels, unsigned depth);

// Reads the records [begin, end). Errors: InputOutput.
template <SpillRecord Record>
Result<std::vector<Record>> ReadInterval(
  const SpillFile& file, std::uint64_t begin, std::uint64_t end)
{
  std::vector<Record> records(static_cast<std::size_t>(end - begin));
  KDSTREAM_TRY(ReadRecords<Record>(file, begin, std::span<Record>(records)));
  return records;
}

}
