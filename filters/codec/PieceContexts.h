// SPDX-License-Identifier: BSD-3-Clause
// The contexts of a piece's symbols: under which table each symbol is coded. The numbers are part
// of the format (doc/formats.md).
#pragma once

#include <cstddef>

namespace kdstream::contexts
{

// Contexts of choices among a few.
inline constexpr std::size_t seed = 0;          // a corner of a first triangle
inline constexpr std::size_t groupOf = 1;       // 8 contexts: which of the gate's groups are equal
inline constexpr std::size_t samePartition = 9; // whether a ghost is of the same partition
inline constexpr std::size_t parentOf = 10;     // 2 contexts: of a vertex, or of a cluster
inline constexpr std::size_t siblings = 12;     // 4 for vertices, 4 for clusters: SiblingGroups
inline constexpr std::size_t choices = 20;      // the number of contexts of choices

// Contexts of numbers, and of steps of the walk.
inline constexpr std::size_t steps = 20;            // two steps in a symbol
inline constexpr std::size_t seedVertex = 21;       // the known vertex of a first triangle
inline constexpr std::size_t jumpVertex = 22;       // the third vertex that a step names
inline constexpr std::size_t groupDifference = 23;  // difference from the group last used
inline constexpr std::size_t ghostPartition = 24;   // difference
inline constexpr std::size_t ghostIndex = 25;       // difference, within the same partition
inline constexpr std::size_t ghostOtherIndex = 26;  // index in another partition
inline constexpr std::size_t position = 27;         // up to 3 contexts, by axis (AxisTables)
inline constexpr std::size_t unguidedPosition = 30; // without a parallelogram
inline constexpr std::size_t ownPartition = 31;     // difference
inline constexpr std::size_t ownIndex = 32;         // how many indices lie between
inline constexpr std::size_t ancestor = 33;         // difference from another rank
inline constexpr std::size_t childEnd = 34;
inline constexpr std::size_t childNode = 35; // difference
inline constexpr std::size_t single = 36;    // numbers that occur once in a piece
inline constexpr std::size_t attribute = 37; // a context for each attribute

}
