// SPDX-License-Identifier: BSD-3-Clause
// Tables that reader and writer of ancestors both keep: which entry gives the parent of which
// vertices, and which earlier entries are likely to have the same parent. Layout: doc/formats.md,
// "Ancestors".
//
// Ancestors are stored level by level, fine to coarse, each cluster's parent once. At the finest
// level an entry is a vertex; at every coarser level it is a cluster that some vertex has as its
// ancestor, by ascending rank.
//
// Edge collapses make a cluster of neighbours. So the parent of an entry is mostly the parent of an
// earlier entry that shares an edge with it (EarlierNeighbours). A parent with a single child so
// far is more likely than one with more (SiblingGroups).
#pragma once

#include "filters/codec/Sorting.h"
#include "filters/core/Types.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

namespace kdstream
{

// For each entry of a level, the entries before it that share an edge with it. An entry can be
// named twice.
class EarlierNeighbours
{
public:
  EarlierNeighbours() = default; // none
  // Takes the edges of triangles that go from a lower vertex to a higher one: in a closed surface,
  // each edge once. REQUIRES: corners are below `vertices`. O(vertices + triangles).
  EarlierNeighbours(std::span<const Triangle> triangles, std::size_t vertices)
  {
    this->Collect(vertices,
      [=](const auto& add)
      {
        for (const auto& [a, b, c] : triangles)
        {
          add(a, b);
          add(b, c);
          add(c, a);
        }
      });
  }

  std::span<const std::uint32_t> Of(std::size_t entry) const
  {
    return this->Begin.empty() ? std::span<const std::uint32_t>()
                               : std::span(this->Near.data() + this->Begin[entry],
                                   this->Near.data() + this->Begin[entry + 1]);
  }

  // Goes on to the next coarser level: entries are replaced by their parents, and edges between two
  // children of the same parent disappear. placeOf: for each entry, the place of its parent; all
  // below `entries`. O(entries + edges).
  void Rise(std::span<const std::uint32_t> placeOf, std::size_t entries)
  {
    if (this->Begin.empty())
    {
      return;
    }
    std::swap(this->Begin, this->FinerBegin);
    std::swap(this->Near, this->FinerNear);
    this->Collect(entries,
      [&](const auto& add)
      {
        for (std::size_t entry = 0; entry < placeOf.size(); ++entry)
        {
          for (std::size_t i = this->FinerBegin[entry]; i < this->FinerBegin[entry + 1]; ++i)
          {
            const std::uint32_t a = placeOf[this->FinerNear[i]], b = placeOf[entry];
            add(std::min(a, b), std::max(a, b));
          }
        }
      });
  }

private:
  // Sorts edges by their ends. forEach: calls add(start, end) for all edges, each time in the same
  // order; edges that do not ascend are left out.
  template <class ForEach>
  void Collect(std::size_t entries, const ForEach& forEach)
  {
    // Shifted by one entry: at first where the next edge of each entry goes; in the end, where the
    // edges of each entry begin.
    this->Begin.assign(entries + 2, 0);
    forEach([this](std::uint32_t start, std::uint32_t end)
      { this->Begin[end + std::size_t{ 2 }] += start < end; });
    std::partial_sum(this->Begin.begin(), this->Begin.end(), this->Begin.begin());
    this->Near.resize(this->Begin.back());
    forEach(
      [this](std::uint32_t start, std::uint32_t end)
      {
        if (start < end)
        {
          this->Near[this->Begin[end + std::size_t{ 1 }]++] = start;
        }
      });
    this->Begin.pop_back();
  }

  std::vector<std::uint32_t> Begin, Near;
  std::vector<std::uint32_t> FinerBegin, FinerNear; // kept, so that levels do not allocate again
};

// Groups the entries of one level, one after the other, into siblings, as far as edges show them.
class SiblingGroups
{
public:
  static constexpr std::size_t most = 15; // the most choices of an entry
  // The groups of an entry's neighbours, each once, at most `most`: groups of a single entry first.
  struct Choices
  {
    std::array<std::uint32_t, most> groups;
    std::size_t count = 0, single = 0;

    // The context under which an entry's choice is stored.
    std::size_t Context() const { return std::min<std::size_t>(this->single, 3); }
  };

  explicit SiblingGroups(std::size_t entries)
    : GroupOf(entries)
    , IsSingle(entries)
  {
  }

  // REQUIRES: the neighbours are in groups already.
  Choices Around(std::span<const std::uint32_t> neighbours) const
  {
    Choices choices;
    std::array<std::uint32_t, most> others;
    std::size_t otherCount = 0;
    for (const std::uint32_t near : neighbours)
    {
      const std::uint32_t group = this->GroupOf[near];
      const bool single = this->IsSingle[group] != 0;
      auto* found = single ? choices.groups.data() : others.data();
      std::size_t& count = single ? choices.single : otherCount;
      if (choices.single + otherCount < most &&
          std::find(found, found + count, group) == found + count)
      {
        found[count++] = group;
      }
    }
    std::copy_n(others.data(), otherCount, choices.groups.data() + choices.single);
    choices.count = choices.single + otherCount;
    return choices;
  }

  // A group is named by its first entry.
  std::uint32_t Of(std::size_t entry) const { return this->GroupOf[entry]; }
  void Start(std::size_t entry)
  {
    this->GroupOf[entry] = static_cast<std::uint32_t>(entry);
    this->IsSingle[entry] = 1;
  }
  void Join(std::size_t entry, std::uint32_t group)
  {
    this->GroupOf[entry] = group;
    this->IsSingle[group] = 0;
  }

private:
  std::vector<std::uint32_t> GroupOf;
  std::vector<std::uint8_t> IsSingle; // of groups
};

class AncestorTable
{
public:
  // triangles: those of the vertices; empty if parents are stored without the help of edges.
  AncestorTable(std::size_t vertices, std::span<const Triangle> triangles)
    : EntryOf(vertices)
    , Entries(vertices)
  {
    std::iota(this->EntryOf.begin(), this->EntryOf.end(), std::uint32_t{ 0 });
    if (!triangles.empty())
    {
      this->Neighbours = EarlierNeighbours(triangles, vertices);
    }
  }

  // The number of entries of the current level.
  std::size_t Count() const { return this->Entries; }
  std::uint32_t EntryOfVertex(std::size_t vertex) const { return this->EntryOf[vertex]; }
  std::span<const std::uint32_t> EarlierNeighboursOf(std::size_t entry) const
  {
    return this->Neighbours.Of(entry);
  }

  // Goes on to the next coarser level. parents: the parent of each entry; the same for all entries
  // of a group. O(vertices + edges), and O(n log n) for the n groups whose ranks do not ascend.
  void Rise(std::span<const std::uint32_t> parents, const SiblingGroups& groups)
  {
    this->SortGroups(parents, groups);
    // Merge the ranks that ascend with the others.
    this->Places.resize(parents.size());
    this->Entries = 0;
    std::uint64_t last = ~std::uint64_t{ 0 };
    for (std::size_t a = 0, b = 0; a < this->Ascending.size() || b < this->Other.size();)
    {
      const bool takeOther = a == this->Ascending.size() ||
                             (b < this->Other.size() && this->Other[b] < this->Ascending[a]);
      const std::uint64_t next = takeOther ? this->Other[b++] : this->Ascending[a++];
      this->Entries += next >> 32 != last;
      last = next >> 32;
      this->Places[static_cast<std::uint32_t>(next)] =
        static_cast<std::uint32_t>(this->Entries - 1);
    }
    for (std::size_t i = 0; i < parents.size(); ++i)
    {
      this->Places[i] = this->Places[groups.Of(i)];
    }
    for (std::uint32_t& entry : this->EntryOf)
    {
      entry = this->Places[entry];
    }
    this->Neighbours.Rise(this->Places, this->Entries);
  }

private:
  // Lists the groups as rank << 32 | first entry. `Ascending` gets those whose rank is above all
  // ranks before, `Other` the rest, sorted.
  void SortGroups(std::span<const std::uint32_t> parents, const SiblingGroups& groups)
  {
    this->Ascending.clear();
    this->Other.clear();
    for (std::size_t i = 0; i < parents.size(); ++i)
    {
      if (groups.Of(i) == i)
      {
        const std::uint64_t group = std::uint64_t{ parents[i] } << 32 | i;
        const bool above = this->Ascending.empty() || group >> 32 > this->Ascending.back() >> 32;
        (above ? this->Ascending : this->Other).push_back(group);
      }
    }
    SortByMerging(this->Other, this->Spare, std::less<>());
  }

  std::vector<std::uint32_t> EntryOf;
  std::size_t Entries;
  EarlierNeighbours Neighbours;
  // For Rise. Kept so that levels do not allocate memory again.
  std::vector<std::uint64_t> Ascending, Other, Spare;
  std::vector<std::uint32_t> Places; // for each entry the place of its parent
};

}
