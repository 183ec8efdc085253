// SPDX-License-Identifier: BSD-3-Clause
// The memory budget of a viewer, and how it is shared. Between steps "choose" and "keep" of the
// pipeline picture.
#pragma once

#include <cstddef>
#include <cstdint>

namespace kdstream
{

// The default memory limit for a model's tree.
constexpr std::size_t standardTreeBytes = std::size_t{ 16 } << 20;

// The memory that a session may use (SessionOptions::TakeShares).
struct MemoryShares
{
  std::size_t cacheBytes = 0;        // decoded pieces, including those that are shown
  std::size_t treeBytes = 0;         // loaded pages of the model's tree
  std::size_t viewBytes = 0;         // approximate: pieces that the view wants, decoded and drawn
  std::uint64_t triangles = 0;       // of the pieces that the view wants
  std::uint64_t levelTriangles = 0;  // of a level for the whole model
  std::uint64_t regionTriangles = 0; // of the region around a tap
  std::size_t pictureBytes = 0;      // decoded pictures of textures
  bool operator==(const MemoryShares&) const = default;
};

// The shares for a viewer that may show about this number of triangles at a time; the wanted pieces
// may take about this number of bytes, decoded and drawn. A region around a tap takes at most half
// of the triangles (the other half is for the regions before it). Decoded pictures of textures may
// take half as many bytes in addition.
MemoryShares SharesOfBudgets(std::uint64_t triangles, std::size_t viewBytes);

// A budget for all memory of a page: its program's memory, which never shrinks, and graphics
// memory. Pieces may take two fifths of it. The rest is for drawing them, in both memories, for new
// surfaces while the old ones are still shown, and for fragmentation.
//
// The memory of a model's pieces is known in advance only on average. So the real use is measured:
// when it comes near the budget, each growth makes the shares smaller, and the shown surface
// coarser, for the rest of the viewer's life.
class MemoryBudget
{
public:
  static constexpr std::size_t standard = 150'000'000;
  static constexpr std::size_t least = 32'000'000; // with less, too little could be shown
  static constexpr std::size_t most = 400'000'000; // with more, phones kill the page

  // Clamped to the range from `least` to `most`.
  explicit MemoryBudget(std::size_t bytes = standard);

  std::size_t Bytes() const { return this->Budget; }
  MemoryShares Shares() const;

  // taken: all memory used now, bytes. Returns whether the shares have become smaller.
  bool Follow(std::size_t taken);

private:
  std::size_t Budget;
  std::size_t Reached; // use above this makes the shares smaller
  double Part = 1;     // remaining part of the shares
};

}
