// The ranks of an MPI job that build one model: who has which blocks, and how bytes get from one to
// the other, on VTK's controller. For kdstream-build-mpi; no step of building is here.
//
// A rank is a process of the job. Nodes of one depth of the tree are dealt out in intervals that
// follow each other; blocks of other depths go with them. Where a step goes wrong on one rank the
// others learn it when they next carry something: every call agrees first that nobody has failed.
#pragma once

#include "filters/Parallel/NumberTable.h"
#include "filters/core/TakeResult.h"
#include "filters/core/Types.h"
#include "filters/outofcore/levels/BlockTeam.h"

#include <vtkMPICommunicator.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

class vtkMPIController;

namespace kdstream
{

// One list for each rank: what goes to it, or what has come from it.
template <class T>
using RankLists = std::vector<std::vector<T>>;

class MpiTeam : public BlockTeam
{
public:
  // REQUIRES: an initialized controller, which outlives the team.
  explicit MpiTeam(vtkMPIController& controller);

  std::size_t Rank() const { return this->Mine; }
  std::size_t Count() const { return this->Ranks; }

  // Deals out the nodes of a depth: rank r gets about as many as the others, rank 0 at least one.
  void Divide(unsigned depth) { this->NodeDepth = depth; }
  unsigned DividedDepth() const { return this->NodeDepth; }
  BlockRange HereOf(std::size_t rank, unsigned depth) const;
  std::size_t OwnerOf(std::size_t block, unsigned depth) const;

  bool IsFirst() const override { return this->Mine == 0; }
  BlockRange Here(unsigned depth) const override { return this->HereOf(this->Mine, depth); }
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
  // Elements of a file, a few MiB at a time, that were here by one division of its places are
  // afterwards by another: rank r has [before[r], before[r + 1]), and then [after[r], after[r +
  // 1]).
  Status Move(SpillFile& file, std::size_t elementBytes, std::span<const std::uint64_t> before,
    std::span<const std::uint64_t> after);
  // Entries of a list that lies in parts: rank r has [begin[r], begin[r + 1]), here `values`.
  Result<std::vector<VertexId>> LookUp(
    std::span<const VertexId> begin, const NumberTable& values, std::span<const VertexId> wanted);

  // Sends a list to each rank and gets one of each; those to the rank itself are copied.
  template <class T>
  Result<RankLists<T>> Exchange(const RankLists<T>& lists)
  {
    RankLists<T> in(this->Ranks);
    const Result<bool> exchanged = this->ExchangeOthers(lists, in, false);
    KDSTREAM_TRY(exchanged);
    in[this->Mine] = lists[this->Mine];
    return in;
  }

  // The same in rounds, so that what is under way does not grow with what there is in all:
  // make(round, lists) -> Status fills the empty lists of one of this rank's rounds, take(from,
  // span) -> Status gets what came; by all ranks as often as the one that has most rounds.
  template <class T, class Make, class TakeList>
  Status ExchangeInRounds(std::uint64_t rounds, const Make& make, const TakeList& take)
  {
    RankLists<T> out(this->Ranks), in(this->Ranks);
    Status status;
    bool more = true;
    for (std::uint64_t round = 0; status && more; ++round)
    {
      for (std::vector<T>& list : out)
      {
        list.clear();
      }
      status = round < rounds ? make(round, out) : Status{};
      status = status ? Take(this->ExchangeOthers(out, in, round + 1 < rounds), more) : status;
      for (std::size_t from = 0; status && from < this->Ranks; ++from)
      {
        status = take(from, std::span<const T>((from == this->Mine ? out : in)[from]));
      }
    }
    return status;
  }

  // Tells all others that this rank cannot go on, and returns the error that all end with: its own,
  // or that of a lower rank that failed at the same time. Once it has come through a call above it
  // is known to all.
  Error Fail(const Error& error);
  // All are done: the error of a rank that is not.
  Status Finish() { return this->Agree(); }

private:
  using Requests = std::vector<vtkMPICommunicator::Request>;
  using Room = std::function<std::span<std::byte>(std::size_t from, std::size_t bytes)>;

  // Lists to and from the other ranks; those from them take the place of what is in `in`. Whether
  // any rank has more to send.
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
  Result<bool> ExchangeBytes(
    const std::vector<std::span<const std::byte>>& out, const Room& room, bool more);
  Result<bool> FetchSome(
    SpillFile& file, std::size_t elementBytes, const RankLists<VertexId>& wanted, bool more);
  // What every call begins with: nobody has failed. Each rank tells the others some numbers on the
  // way, Ranks + 1 at most. REQUIRES: own, or the same count of numbers on all ranks.
  Status Agree(std::span<const std::uint64_t> numbers = {}, const Error* own = nullptr);
  void TellAll(std::span<const std::uint64_t> mine);
  void BeginSend(std::size_t rank, std::span<const std::byte> bytes, Requests& requests);
  void BeginReceive(std::size_t rank, std::span<std::byte> bytes, Requests& requests);
  void Send(std::size_t rank, std::span<const std::byte> bytes);
  void Receive(std::size_t rank, std::span<std::byte> bytes);
  void PassDown(std::span<std::byte> bytes);
  // Values of all ranks, one by one; `operation` may be used in any order.
  template <class T, class Operation>
  void Combine(std::span<T> values, const Operation& operation);
  std::uint64_t Told(std::size_t rank, std::size_t number) const
  {
    return this->AllTold[rank * (this->Ranks + 2) + 1 + number];
  }
  // The first place of each rank, and the end.
  std::vector<std::uint64_t> PlacesOf(std::span<const VertexId> begin, unsigned depth) const;

  vtkMPIController& Controller;
  std::size_t Mine, Ranks;
  unsigned NodeDepth = 0;
  std::optional<Error> Failed;
  std::vector<std::uint64_t> AllTold; // of each rank whether it has failed, and numbers

  friend std::vector<std::uint64_t> PlacesOfRanks(
    const MpiTeam& team, std::span<const VertexId> begin, unsigned depth);
};

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

// Writes elements at ascending places of a file, those that follow each other at once. Errors:
// InputOutput.
Status WriteElementsAt(SpillFile& file, std::size_t elementBytes, std::span<const VertexId> places,
  std::span<const std::byte> elements);

// For MpiTeam::Move: the first place of each rank, and the end, of a list whose blocks, cells of
// `depth`, begin at begin[block].
std::vector<std::uint64_t> PlacesOfRanks(
  const MpiTeam& team, std::span<const VertexId> begin, unsigned depth);

}
