// SPDX-License-Identifier: BSD-3-Clause
// The contexts of a piece's symbols: which table each is coded under. The numbers are part of the
// format (doc/formats.md).
#pragma once

#include <cstddef>

namespace kdstream::contexts
{

// Choices among a few.
inline constexpr std::size_t seed = 0;          // a corner of a first triangle
inline constexpr std::size_t groupOf = 1;       // 8: by which of the gate's groups are equal
inline constexpr std::size_t samePartition = 9; // a ghost's
inline constexpr std::size_t parentOf = 10;     // 2: of a vertex, or of a cluster
inline constexpr std::size_t siblings = 12;     // 4 of a vertex, 4 of a cluster: SiblingGroups
inline constexpr std::size_t choices = 20;      // how many these are

// Numbers, and steps of the walk.
inline constexpr std::size_t steps = 20;            // two in a symbol
inline constexpr std::size_t seedVertex = 21;       // the known vertex of a first triangle
inline constexpr std::size_t jumpVertex = 22;       // the third vertex that a step names
inline constexpr std::size_t groupDifference = 23;  // to the group last used
inline constexpr std::size_t ghostPartition = 24;   // difference
inline constexpr std::size_t ghostIndex = 25;       // difference within one partition
inline constexpr std::size_t ghostOtherIndex = 26;  // in another one
inline constexpr std::size_t position = 27;         // 3: by axis (AxisTables), or fewer
inline constexpr std::size_t unguidedPosition = 30; // without a parallelogram
inline constexpr std::size_t ownPartition = 31;     // difference
inline constexpr std::size_t ownIndex = 32;         // how many lie between
inline constexpr std::size_t ancestor = 33;         // difference to another rank
inline constexpr std::size_t childEnd = 34;
inline constexpr std::size_t childNode = 35; // difference
inline constexpr std::size_t single = 36;    // numbers that a piece has one of
inline constexpr std::size_t attribute = 37; // one for each attribute

}
