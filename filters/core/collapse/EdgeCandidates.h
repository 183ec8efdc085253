// SPDX-License-Identifier: BSD-3-Clause
// A queue of the edges that may collapse, cheapest first. Only for EdgeCollapse.
#pragma once

#include "filters/core/BitCast.h"
#include "filters/core/Types.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace kdstream
{

struct EdgeCandidate
{
  double cost;   // at least 0
  VertexId u, v; // u < v
  std::uint32_t stamp;
  bool measured; // whether the cost includes how far the surface retreats

  // Ordered by cost, then by vertices: the candidate that collapses later is greater.
  bool operator<(const EdgeCandidate& other) const
  {
    return this->cost != other.cost ? this->cost < other.cost
           : this->u != other.u     ? this->u < other.u
           : this->v != other.v     ? this->v < other.v
                                    : this->stamp < other.stamp;
  }
};

// A queue of candidates, cheapest first. Most candidates never reach the front: a collapse nearby
// makes them out of date, or enough vertices have merged before their turn. So they wait unsorted
// in buckets, each of half an octave of cost. Only the cheapest bucket is sorted, by a heap. The
// heap takes those candidates of the bucket that are still current, and later pushed ones that cost
// no more than the bucket's. So candidates leave the queue fully sorted. Push takes O(1), or O(log
// h) into a heap of h candidates; memory is 24 bytes for each candidate in the queue. If vertices
// have hundreds of edges, far more candidates are pushed than are current at the same time. When
// the queue is full, the caller therefore drops those that are out of date (MakeRoom).
class EdgeCandidates
{
public:
  EdgeCandidates()
    : First(2 * buckets, none)
  {
  }

  // Reserves memory for this number of candidates, and for those that are pushed before many are
  // out of date: as much as MakeRoom would add.
  void Reserve(std::size_t candidates) { this->Slots.reserve(RoomFor(candidates)); }
  void Push(const EdgeCandidate& candidate);
  // Whether the next Push may take more memory.
  bool IsFull() const { return this->Free == none && this->Slots.size() == this->Slots.capacity(); }
  // Makes room for more candidates. If at least a third are out of date, drops these; otherwise
  // takes more memory. The order in which candidates leave does not change. O(all), which amounts
  // to O(1) for each Push in between. REQUIRES: as for Pop.
  template <class IsCurrent>
  void MakeRoom(const IsCurrent& isCurrent);
  // Takes out the first candidate for which isCurrent(candidate) is true, and drops all before it.
  // Returns false if no candidate is current. REQUIRES: a candidate that is out of date stays out
  // of date.
  template <class IsCurrent>
  bool Pop(EdgeCandidate& first, const IsCurrent& isCurrent);

private:
  static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
  static constexpr std::size_t leastRoom = 1024;
  static constexpr unsigned shift = 51; // keeps a double's exponent and one binary digit
  static constexpr std::size_t buckets = std::size_t{ 1 } << (63 - shift);

  struct Waiting
  {
    double cost;
    VertexId u, v;
    std::uint32_t stamp;
    std::uint32_t next; // the next one in the same bucket, or the next free one
  };

  static std::size_t RoomFor(std::size_t candidates)
  {
    return candidates + candidates / 2 + leastRoom;
  }
  static std::size_t BucketOf(double cost)
  {
    return cost > 0 ? static_cast<std::size_t>(BitCast<std::uint64_t>(cost) >> shift) : 0;
  }
  static bool IsLater(const EdgeCandidate& a, const EdgeCandidate& b) { return b < a; }
  void PushNear(const EdgeCandidate& candidate);
  template <class IsCurrent>
  void Fill(std::size_t list, const IsCurrent& isCurrent);
  template <class IsCurrent>
  bool FillFromNextBucket(const IsCurrent& isCurrent);

  std::vector<EdgeCandidate> Near; // a heap of the candidates that belong to buckets below Begin
  std::size_t Begin = 0;
  std::size_t Lowest = buckets; // all buckets below it are empty
  // For each bucket two lists: the first entry of those not measured, and of those measured.
  std::vector<std::uint32_t> First;
  std::vector<Waiting> Slots;
  std::uint32_t Free = none;
};

// Inlined wherever it is called: edge collapse pushes ten candidates for each merge.
[[gnu::always_inline]] inline void EdgeCandidates::Push(const EdgeCandidate& candidate)
{
  const std::size_t bucket = BucketOf(candidate.cost);
  if (bucket < this->Begin)
  {
    this->PushNear(candidate);
    return;
  }
  this->Lowest = std::min(this->Lowest, bucket);
  std::uint32_t& first = this->First[2 * bucket + candidate.measured];
  const Waiting waiting{ candidate.cost, candidate.u, candidate.v, candidate.stamp, first };
  if (this->Free == none)
  {
    first = static_cast<std::uint32_t>(this->Slots.size());
    this->Slots.push_back(waiting);
    return;
  }
  first = this->Free;
  this->Free = this->Slots[first].next;
  this->Slots[first] = waiting;
}

inline void EdgeCandidates::PushNear(const EdgeCandidate& candidate)
{
  this->Near.push_back(candidate);
  std::push_heap(this->Near.begin(), this->Near.end(), IsLater);
}

template <class IsCurrent>
void EdgeCandidates::MakeRoom(const IsCurrent& isCurrent)
{
  std::size_t dropped = 0;
  for (std::size_t list = 2 * this->Lowest; list < this->First.size(); ++list)
  {
    std::uint32_t* from = &this->First[list];
    while (*from != none)
    {
      Waiting& waiting = this->Slots[*from];
      if (isCurrent({ waiting.cost, waiting.u, waiting.v, waiting.stamp, list % 2 != 0 }))
      {
        from = &waiting.next;
        continue;
      }
      ++dropped;
      const std::uint32_t slot = std::exchange(*from, waiting.next);
      waiting.next = std::exchange(this->Free, slot);
    }
  }
  if (dropped < this->Slots.size() / 3)
  {
    this->Slots.reserve(RoomFor(this->Slots.size()));
  }
}

template <class IsCurrent>
bool EdgeCandidates::Pop(EdgeCandidate& first, const IsCurrent& isCurrent)
{
  do
  {
    while (!this->Near.empty())
    {
      std::pop_heap(this->Near.begin(), this->Near.end(), IsLater);
      first = this->Near.back();
      this->Near.pop_back();
      if (isCurrent(first))
      {
        return true;
      }
    }
  } while (this->FillFromNextBucket(isCurrent));
  return false;
}

// Returns false if all buckets are empty.
template <class IsCurrent>
bool EdgeCandidates::FillFromNextBucket(const IsCurrent& isCurrent)
{
  std::size_t bucket = this->Lowest;
  while (bucket < buckets && this->First[2 * bucket] == none && this->First[2 * bucket + 1] == none)
  {
    ++bucket;
  }
  this->Lowest = bucket;
  if (bucket == buckets)
  {
    return false;
  }
  this->Fill(2 * bucket, isCurrent);
  this->Fill(2 * bucket + 1, isCurrent);
  std::make_heap(this->Near.begin(), this->Near.end(), IsLater);
  this->Lowest = this->Begin = bucket + 1;
  return true;
}

// Moves the current candidates of a list into Near, which is then no longer a valid heap.
template <class IsCurrent>
void EdgeCandidates::Fill(std::size_t list, const IsCurrent& isCurrent)
{
  std::uint32_t slot = this->First[list];
  this->First[list] = none;
  while (slot != none)
  {
    Waiting& waiting = this->Slots[slot];
    const EdgeCandidate candidate{ waiting.cost, waiting.u, waiting.v, waiting.stamp,
      list % 2 != 0 };
    if (isCurrent(candidate))
    {
      this->Near.push_back(candidate);
    }
    const std::uint32_t next = waiting.next;
    waiting.next = this->Free;
    this->Free = slot;
    slot = next;
  }
}

}
