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
inline constexpr std::size_t choices = 12;      // how many these are

// Numbers, and steps of the walk.
inline constexpr std::size_t steps = 12;            // two in a symbol
inline constexpr std::size_t seedVertex = 13;       // the known vertex of a first triangle
inline constexpr std::size_t jumpVertex = 14;       // the third vertex that a step names
inline constexpr std::size_t groupDifference = 15;  // to the group last used
inline constexpr std::size_t ghostPartition = 16;   // difference
inline constexpr std::size_t ghostIndex = 17;       // difference within one partition
inline constexpr std::size_t ghostOtherIndex = 18;  // in another one
inline constexpr std::size_t position = 19;         // 3: by axis, or the first alone
inline constexpr std::size_t unguidedPosition = 22; // without a parallelogram
inline constexpr std::size_t ownPartition = 23;     // difference
inline constexpr std::size_t ownIndex = 24;         // how many lie between
inline constexpr std::size_t ancestor = 25;         // difference to the next rank
inline constexpr std::size_t reachEnd = 26;
inline constexpr std::size_t reachNode = 27; // difference
inline constexpr std::size_t single = 28;    // numbers that a piece has one of
inline constexpr std::size_t attribute = 29; // one for each attribute

}
