// SPDX-License-Identifier: BSD-3-Clause
// The ranks that build one model: what they tell each other, and how an error of one becomes the
// error of all. For kdstream-build-mpi and vtkKdStoreWriter; no step of building is here.
//
// A rank is a process of an MPI job, or of a vtkMultiProcessController. Who has which blocks is
// NodeShares' matter, how bytes get from one rank to the other RankMessages', and what goes from
// file to file TeamFiles'. Where a step goes wrong on one rank it leaves by the error, up to the
// caller, who calls Fail. The others learn it when they next tell each other something: every call
// agrees first that nobody has failed. What goes wrong while bytes are under way cannot be told any
// more: that is a BrokenTeam.
#pragma once

#include "filters/Parallel/NodeShares.h"
#include "filters/Parallel/RankMessages.h"
#include "filters/core/Types.h"
#include "filters/outofcore/levels/BlockTeam.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace kdstream
{

// One list for each rank: what goes to it, or what has come from it.
template <class T>
using RankLists = std::vector<std::vector<T>>;

// Bytes that a rank sends in one round of an exchange in rounds, about; and at most as many
// elements of a size.
inline constexpr std::size_t roundBytes = std::size_t{ 1 } << 22;
constexpr std::size_t ElementsOfRound(std::size_t elementBytes)
{
  return elementBytes < roundBytes ? roundBytes / elementBytes : 1;
}
// The rounds that so many elements take.
constexpr std::uint64_t RoundsOf(std::uint64_t elements, std::size_t ofRound)
{
  return (elements + ofRound - 1) / ofRound;
}

// Thrown, on one rank, in the middle of an exchange (there was no memory for what came): the others
// wait for bytes that do not come, and only the end of this process ends them, too.
struct BrokenTeam
{
  Error error;
};

class MpiTeam : public BlockTeam
{
public:
  // REQUIRES: messages that outlive the team.
  explicit MpiTeam(RankMessages& messages);

  std::size_t Rank() const { return this->Messages.Rank(); }
  std::size_t Count() const { return this->Messages.Count(); }

  // This rank for messages: "rank 1 on node7".
  std::string Where() const;
  // An error of this rank, which names it then, unless it is the only one or was interrupted.
  Error NameRank(Error error) const;

  // Who has which blocks.
  NodeShares& Shares() { return this->Nodes; }
  const NodeShares& Shares() const { return this->Nodes; }
  std::size_t OwnerOf(std::size_t block, unsigned depth) const
  {
    return this->Nodes.OwnerOf(block, depth);
  }

  bool IsFirst() const override { return this->Rank() == 0; }
  BlockRange Here(unsigned depth) const override
  {
    return this->Nodes.BlocksOf(this->Rank(), depth);
  }
  Status Sum(std::span<std::uint64_t> numbers) override;
  Status Spread(std::vector<VertexId>& numbers) override;
  Status Fetch(SpillFile& file, std::size_t elementBytes, std::span<const VertexId> begin,
    unsigned depth, std::span<const VertexId> wanted) override;

  // Equally many bytes for each block of a depth: gets those of other ranks' blocks.
  Status Share(std::span<std::byte> blocks, unsigned depth);
  // The smallest lower and greatest upper ends of all ranks' boxes, one by one.
  Status JoinBoxes(std::span<Box> boxes);
  // One number of each rank, by rank.
  Result<std::vector<std::uint64_t>> Gather(std::uint64_t number);
  // The greatest of all ranks' numbers.
  Result<std::uint64_t> Most(std::uint64_t number) override;
  // One sum of what all ranks add to it, rank after rank.
  Result<double> AddInOrder(const std::function<Status(double& sum)>& add);

  // Sends a list to each rank and gets one of each; those to the rank itself are copied.
  template <class T>
  Result<RankLists<T>> Exchange(const RankLists<T>& lists)
  {
    RankLists<T> in(this->Count());
    KDSTREAM_TRY(this->ExchangeOthers(lists, in, false));
    in[this->Rank()] = lists[this->Rank()];
    return in;
  }

  // The same in rounds, so that what is under way does not grow with what there is in all:
  // make(round, lists) -> Status fills the empty lists of one of this rank's rounds, take(from,
  // span) -> Status gets what came; by all ranks as often as the one that has most rounds.
  template <class T, class Make, class TakeList>
  Status ExchangeInRounds(std::uint64_t rounds, const Make& make, const TakeList& take)
  {
    RankLists<T> out(this->Count()), in(this->Count());
    bool more = true;
    for (std::uint64_t round = 0; more; ++round)
    {
      for (std::vector<T>& list : out)
      {
        list.clear();
      }
      if (round < rounds)
      {
        KDSTREAM_TRY(make(round, out));
      }
      const Result<bool> anyMore = this->ExchangeOthers(out, in, round + 1 < rounds);
      KDSTREAM_TRY(anyMore);
      more = *anyMore;
      for (std::size_t from = 0; from < this->Count(); ++from)
      {
        const std::vector<T>& list = (from == this->Rank() ? out : in)[from];
        KDSTREAM_TRY(take(from, std::span<const T>(list)));
      }
    }
    return {};
  }

  // One round of an exchange, which the two above are made of: lists to and from the other ranks;
  // those from them take the place of what is in `in`. Whether any rank has more to send.
  template <class T>
  Result<bool> ExchangeOthers(const RankLists<T>& lists, RankLists<T>& in, bool more)
  {
    static_assert(std::is_trivially_copyable_v<T>);
    std::vector<std::span<const std::byte>> out;
    for (const std::vector<T>& list : lists)
    {
      out.push_back(std::as_bytes(std::span<const T>(list)));
    }
    return this->ExchangeBytes(
      out,
      [&](std::size_t from, std::size_t bytes)
      {
        in[from].resize(bytes / sizeof(T));
        return std::as_writable_bytes(std::span<T>(in[from]));
      },
      more);
  }

  // Tells all others that this rank cannot go on, and returns the error that all end with, which
  // names its rank: its own, or that of a lower rank that failed at the same time. Once it has come
  // through a call above it is known to all.
  Error Fail(const Error& error);
  // The same with an error that all ranks have found at the same time, in the same words.
  Error FailTogether(const Error& error)
  {
    this->Failed = error;
    return error;
  }
  // All are done: the error of a rank that is not.
  Status Finish() { return this->Agree(); }

private:
  using Room = std::function<std::span<std::byte>(std::size_t from, std::size_t bytes)>;

  Result<bool> ExchangeBytes(
    const std::vector<std::span<const std::byte>>& out, const Room& room, bool more);
  void Swap(const std::vector<std::span<const std::byte>>& out, const Room& room);
  // What every call begins with: nobody has failed. Each rank tells the others some numbers on the
  // way, Count() + 1 at most. REQUIRES: own, or the same count of numbers on all ranks.
  Status Agree(std::span<const std::uint64_t> numbers = {}, const Error* own = nullptr);
  std::uint64_t Told(std::size_t rank, std::size_t number) const
  {
    return this->AllTold[rank * (this->Count() + 2) + 1 + number];
  }
  Error ErrorOf(std::size_t rank, const Error* own);

  RankMessages& Messages;
  NodeShares Nodes;
  std::optional<Error> Failed;
  std::vector<std::uint64_t> AllTold; // of each rank whether it has failed, and numbers
};

}
