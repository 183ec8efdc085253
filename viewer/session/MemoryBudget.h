// SPDX-License-Identifier: BSD-3-Clause
// What a viewer may take of memory, and what of that may be what. Between steps "choose" and "keep"
// of the pipeline picture.
#pragma once

#include <cstddef>
#include <cstdint>

namespace kdstream
{

// Of a model's tree, where nothing else is said.
constexpr std::size_t standardTreeBytes = std::size_t{ 16 } << 20;

// What a session may hold (SessionOptions::TakeShares).
struct MemoryShares
{
  std::size_t cacheBytes = 0;        // decoded pieces, those that are shown among them
  std::size_t treeBytes = 0;         // of the model's tree
  std::size_t viewBytes = 0;         // about, of pieces that the view wants, decoded and drawn
  std::uint64_t triangles = 0;       // that the view wants
  std::uint64_t levelTriangles = 0;  // of a level for the whole model
  std::uint64_t regionTriangles = 0; // of the region around a tap
  std::size_t pictureBytes = 0;      // decoded pictures of textures
  bool operator==(const MemoryShares&) const = default;
};

// What one may hold that may show about so many triangles at a time, where what the view wants may
// take about so many bytes, decoded and drawn. A region around a tap takes at most half of the
// triangles (the other half is for the regions before it). Half as many bytes again are for decoded
// pictures of textures.
MemoryShares SharesOfBudgets(std::uint64_t triangles, std::size_t viewBytes);

// A budget for all that a page takes: the memory of its program, which never shrinks again, and
// that of the graphics. Pieces may take two fifths of it. The rest is for what is drawn of them,
// in both memories, for what is made anew while the old is still shown, and for the gaps between.
//
// How much a model's pieces take is known beforehand on average only. So what is really taken is
// followed: once that nears the budget, each growth makes the shares smaller, and what is shown
// coarser, for as long as the viewer lives.
class MemoryBudget
{
public:
  static constexpr std::size_t standard = 150'000'000;
  static constexpr std::size_t least = 32'000'000; // without which little could be shown
  static constexpr std::size_t most = 400'000'000; // where phones end a page

  // Brought into the range of least to most.
  explicit MemoryBudget(std::size_t bytes = standard);

  std::size_t Bytes() const { return this->Budget; }
  MemoryShares Shares() const;

  // So many bytes are taken now, of all kinds. Whether the shares are smaller for that.
  bool Follow(std::size_t taken);

private:
  std::size_t Budget;
  std::size_t Reached; // that was answered by smaller shares, or need not be
  double Part = 1;     // of the shares that is left
};

}
