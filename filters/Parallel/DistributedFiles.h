// SPDX-License-Identifier: BSD-3-Clause
// What goes from the files of some ranks to those of others: elements that a rank lacks, intervals
// that change hands, entries of a list that lies in parts. By all ranks at the same time; the error
// of one is that of all (MpiGroup).
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

// Writes elements at ascending places of a file, those that follow each other at once. By one rank.
// Errors: InputOutput.
Status WriteElementsAt(SpillFile& file, std::size_t elementBytes, std::span<const VertexId> places,
  std::span<const std::byte> elements);

// Fetches elements into their places of this rank's file. places: the first one of each rank, and
// the end (NodeShares::PlacesOf). wanted: places in any order; those that are here stay as they
// are.
Status FetchElements(MpiGroup& group, SpillFile& file, std::size_t elementBytes,
  std::span<const std::uint64_t> places, std::span<const VertexId> wanted);

// Moves elements of a file, a few MiB at a time, from one division among the ranks to another: rank
// r has [before[r], before[r + 1]) at first, and [after[r], after[r + 1]) in the end.
Status MoveElements(MpiGroup& group, SpillFile& file, std::size_t elementBytes,
  std::span<const std::uint64_t> before, std::span<const std::uint64_t> after);

// The rank that has an entry of a list that lies in parts: rank r has [begin[r], begin[r + 1]).
std::size_t RankOfEntry(std::span<const VertexId> begin, VertexId entry);

// Entries of such a list, in the order of `wanted`. values: the part that is here.
Result<std::vector<VertexId>> LookUpEntries(MpiGroup& group, std::span<const VertexId> begin,
  const NumberTable& values, std::span<const VertexId> wanted);

}
