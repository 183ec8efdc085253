// SPDX-License-Identifier: BSD-3-Clause
// Moves data between the files of ranks: elements that a rank lacks, intervals that move to another
// rank, entries of a distributed list. Called by all ranks at the same time; an error on one rank
// is an error on all (MpiGroup).
#pragma once

#include "filters/Parallel/MpiGroup.h"
#include "filters/Parallel/NumberTable.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/outofcore/files/SpillFile.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// Writes elements at ascending places of a file; consecutive ones with one write. Called by one
// rank. Errors: InputOutput.
Status WriteElementsAt(SpillFile& file, std::size_t elementBytes, std::span<const VertexId> places,
  std::span<const std::byte> elements);

// Fetches elements, and writes them at their places in this rank's file. places: the first place of
// each rank, and the end (NodeShares::PlacesOf). wanted: places in any order; those of this rank
// are skipped.
Status FetchElements(MpiGroup& group, SpillFile& file, std::size_t elementBytes,
  std::span<const std::uint64_t> places, std::span<const VertexId> wanted);

// Moves elements of a file between ranks, a few MiB at a time. Before, rank r has [before[r],
// before[r + 1]); afterwards it has [after[r], after[r + 1]).
Status MoveElements(MpiGroup& group, SpillFile& file, std::size_t elementBytes,
  std::span<const std::uint64_t> before, std::span<const std::uint64_t> after);

// The rank that has an entry of a distributed list: rank r has [begin[r], begin[r + 1]).
std::size_t RankOfEntry(std::span<const VertexId> begin, VertexId entry);

// The entries `wanted` of a distributed list, in this order. values: this rank's part.
Result<std::vector<VertexId>> LookUpEntries(MpiGroup& group, std::span<const VertexId> begin,
  const NumberTable& values, std::span<const VertexId> wanted);

}
