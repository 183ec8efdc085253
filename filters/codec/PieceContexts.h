// The contexts of a piece's symbols: which table each is coded under. The numbers are part of the
// format (doc/formats.md).
#pragma once

#include <cstddef>

namespace kdstream::contexts
{

inline constexpr std::size_t step = 0;             // 16: by the gate's surroundings
inline constexpr std::size_t seedIsNew = 16;       // a corner of a first triangle: 1 = a new vertex
inline constexpr std::size_t seedVertex = 17;      // which it is otherwise
inline constexpr std::size_t jumpVertex = 18;      // the third vertex that a step names
inline constexpr std::size_t isOwn = 19;           // 8: by which of the gate's vertices are own
inline constexpr std::size_t groupOf = 27;         // 8: by which of the gate's groups are equal
inline constexpr std::size_t groupDifference = 35; // to the group last used
inline constexpr std::size_t samePartition = 36;   // a ghost's
inline constexpr std::size_t ghostPartition = 37;  // difference
inline constexpr std::size_t ghostIndex = 38;      // difference within one partition
inline constexpr std::size_t ghostOtherIndex = 39; // in another one
inline constexpr std::size_t position = 40;        // 3: by axis, or the first alone
inline constexpr std::size_t unguidedPosition = 43; // without a parallelogram
inline constexpr std::size_t deviation = 44;
inline constexpr std::size_t ownPartition = 45;  // difference
inline constexpr std::size_t ownIndex = 46;      // difference
inline constexpr std::size_t ancestorDepth = 47; // how many ancestors differ
inline constexpr std::size_t ancestor = 48;      // difference
inline constexpr std::size_t reachEnd = 49;
inline constexpr std::size_t reachNode = 50; // difference
inline constexpr std::size_t single = 51;    // numbers that a piece has one of
inline constexpr std::size_t attribute = 52; // one for each attribute

}
