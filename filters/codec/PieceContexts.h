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
inline constexpr std::size_t choices = 10;      // how many these are

// Numbers, and steps of the walk.
inline constexpr std::size_t steps = 10;            // two in a symbol
inline constexpr std::size_t seedVertex = 11;       // the known vertex of a first triangle
inline constexpr std::size_t jumpVertex = 12;       // the third vertex that a step names
inline constexpr std::size_t groupDifference = 13;  // to the group last used
inline constexpr std::size_t ghostPartition = 14;   // difference
inline constexpr std::size_t ghostIndex = 15;       // difference within one partition
inline constexpr std::size_t ghostOtherIndex = 16;  // in another one
inline constexpr std::size_t position = 17;         // 3: by axis, or the first alone
inline constexpr std::size_t unguidedPosition = 20; // without a parallelogram
inline constexpr std::size_t deviation = 21;
inline constexpr std::size_t ownPartition = 22;  // difference
inline constexpr std::size_t ownIndex = 23;      // difference
inline constexpr std::size_t ancestorDepth = 24; // how many ancestors differ
inline constexpr std::size_t ancestor = 25;      // difference
inline constexpr std::size_t reachEnd = 26;
inline constexpr std::size_t reachNode = 27; // difference
inline constexpr std::size_t single = 28;    // numbers that a piece has one of
inline constexpr std::size_t attribute = 29; // one for each attribute

}
