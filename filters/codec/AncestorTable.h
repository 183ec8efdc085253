// SPDX-License-Identifier: BSD-3-Clause
// Which entries tell the parents of which vertices: what reader and writer of ancestors both know.
// Layout: doc/formats.md, "Ancestors".
//
// The ancestors of the vertices that carry them are told level by level, fine to coarse, each
// cluster's parent once: at the finest level an entry is a vertex, at every coarser one a cluster
// that some vertex has as its ancestor, by ascending rank.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

namespace kdstream
{

class AncestorTable
{
public:
  explicit AncestorTable(std::size_t vertices)
    : EntryOf(vertices)
    , Entries(vertices)
  {
    std::iota(this->EntryOf.begin(), this->EntryOf.end(), std::uint32_t{ 0 });
  }

  // How many entries the level has.
  std::size_t Count() const { return this->Entries; }
  std::uint32_t EntryOfVertex(std::size_t vertex) const { return this->EntryOf[vertex]; }

  // Goes on to the next coarser level. parents: of each entry. O(vertices + entries log entries).
  void Rise(std::span<const std::uint32_t> parents)
  {
    std::vector<std::uint32_t> ranks(parents.begin(), parents.end());
    if (!std::is_sorted(ranks.begin(), ranks.end()))
    {
      std::sort(ranks.begin(), ranks.end());
    }
    ranks.erase(std::unique(ranks.begin(), ranks.end()), ranks.end());
    std::vector<std::uint32_t> place(parents.size());
    for (std::size_t i = 0; i < parents.size(); ++i)
    {
      place[i] = static_cast<std::uint32_t>(
        std::lower_bound(ranks.begin(), ranks.end(), parents[i]) - ranks.begin());
    }
    for (std::uint32_t& entry : this->EntryOf)
    {
      entry = place[entry];
    }
    this->Entries = ranks.size();
  }

private:
  std::vector<std::uint32_t> EntryOf;
  std::size_t Entries;
};

}
