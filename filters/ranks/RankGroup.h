// SPDX-License-Identifier: BSD-3-Clause
// A group of ranks that work together: how they communicate, and how an error of one rank becomes
// an error of all. For kdstream-build-mpi and the filters that have a Controller.
//
// A rank is a process of an MPI job, or of a vtkMultiProcessController; RankMessages transports the
// bytes. If a step fails on one rank, by an error or an exception, this rank returns from the step
// up to the caller of Run or Fail. The other ranks learn of it in their next collective call,
// because every call first agrees that no rank has failed. Before bytes are sent, all ranks agree
// once more that they have memory for the bytes that they will receive. If a rank does not even
// have memory for a few numbers, it cannot report its failure any more: then it throws BrokenGroup.
#pragma once

#include "filters/core/CaughtError.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/ranks/RankMessages.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

class vtkMultiProcessController;

namespace kdstream
{

// One list for each rank: the elements sent to it, or received from it.
template <class T>
using RankLists = std::vector<std::vector<T>>;

// About how many bytes a rank sends in one round of an exchange in rounds; and how many elements of
// a given size this is.
inline constexpr std::size_t roundBytes = std::size_t{ 1 } << 22;
constexpr std::size_t ElementsOfRound(std::size_t elementBytes)
{
  return elementBytes < roundBytes ? roundBytes / elementBytes : 1;
}
// The number of rounds for this number of elements.
constexpr std::uint64_t RoundsOf(std::uint64_t elements, std::size_t ofRound)
{
  return (elements + ofRound - 1) / ofRound;
}

// Thrown on a rank that cannot reach the others any more. The others would wait forever, but the
// end of this process ends them too.
struct BrokenGroup
{
  Error error;
};

// All functions except Rank, Count, Where and NameRank must be called by all ranks, in the same
// order.
class RankGroup
{
public:
  // REQUIRES: the messages, or the controller, outlive the group.
  explicit RankGroup(RankMessages& messages);
  explicit RankGroup(vtkMultiProcessController& controller);

  std::size_t Rank() const { return this->Messages.Rank(); }
  std::size_t Count() const { return this->Messages.Count(); }

  // The name of this rank for messages: "rank 1 on node7".
  std::string Where() const;
  // Adds the name of this rank to one of its errors, unless it is the only rank or was interrupted.
  Error NameRank(Error error) const;

  // The common result of all ranks: success, or the error of the lowest rank that failed, with its
  // number.
  Status Agree(const Status& own);
  // Adds the numbers of all ranks, element by element.
  Status Sum(std::span<std::uint64_t> numbers);
  // Replaces each box by the smallest box that contains this box of all ranks.
  Status JoinBoxes(std::span<Box> boxes);
  // The numbers of all ranks, by rank.
  Result<std::vector<std::uint64_t>> Gather(std::uint64_t number);
  // Whether `has` is true on all ranks.
  Result<bool> AllHave(bool has);
  // The sum of the counts of the ranks before this one, and the sum over all ranks.
  Result<std::pair<std::uint64_t, std::uint64_t>> CountBefore(std::uint64_t count);

  // Sends a list to each rank, and receives one from each. The list to the rank itself is copied.
  template <class T>
  Result<RankLists<T>> Exchange(const RankLists<T>& lists)
  {
    RankLists<T> in(this->Count());
    KDSTREAM_TRY(this->ExchangeOthers(lists, in, false));
    in[this->Rank()] = lists[this->Rank()];
    return in;
  }
  // The same for lists that are not needed any more.
  template <class T>
  Result<RankLists<T>> Exchange(RankLists<T>&& lists)
  {
    RankLists<T> in(this->Count());
    KDSTREAM_TRY(this->ExchangeOthers(lists, in, false));
    in[this->Rank()] = std::move(lists[this->Rank()]);
    return in;
  }

  // Exchanges lists in rounds, so that the bytes in flight do not grow with the total.
  // make(round, lists) -> Status fills the empty lists `lists`, one for each rank, for a round.
  // take(from, span) -> Status takes the elements that rank `from` has sent. rounds: of this rank.
  // If other ranks need more rounds, this rank takes part in them with empty lists.
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

  // One round of an exchange, on which the functions above are based: sends the lists to the other
  // ranks, and replaces the content of `in` by the lists received. Returns whether any rank has
  // more to send.
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

  // Finds keys that divide the sorted keys of all ranks into one share for each rank; ShareOf gives
  // the rank to which a key goes. A share has at most a quarter more keys than the average; equal
  // keys stay together. sorted: this rank's keys. About 4 * Count()^2 keys are on all ranks for a
  // moment.
  template <class Key>
  Result<std::vector<Key>> PartInOrder(std::span<const Key> sorted)
  {
    std::uint64_t all = sorted.size();
    KDSTREAM_TRY(this->Sum(std::span(&all, 1)));
    // Each key of the sample stands for this number of its rank's keys: itself and those before it.
    // So between two keys of the sample each rank has at most this number of keys.
    const auto stride = static_cast<std::size_t>(
      std::max<std::uint64_t>(1, all / (4 * this->Count() * this->Count())));
    std::vector<Key> sample;
    for (std::size_t i = stride; i <= sorted.size(); i += stride)
    {
      sample.push_back(sorted[i - 1]);
    }
    const auto received = this->Exchange(RankLists<Key>(this->Count(), sample));
    KDSTREAM_TRY(received);
    sample.clear();
    for (const std::vector<Key>& theirs : *received)
    {
      sample.insert(sample.end(), theirs.begin(), theirs.end());
    }
    std::sort(sample.begin(), sample.end());
    std::vector<Key> ends; // of all shares except the last
    for (std::size_t rank = 1; rank < this->Count() && !sample.empty(); ++rank)
    {
      ends.push_back(sample[(rank * sample.size() + this->Count() - 1) / this->Count() - 1]);
    }
    return ends;
  }
  template <class Key>
  static std::size_t ShareOf(const Key& key, const std::vector<Key>& ends)
  {
    return static_cast<std::size_t>(std::lower_bound(ends.begin(), ends.end(), key) - ends.begin());
  }

  // Reports to all other ranks that this rank cannot continue. Returns the error with which all
  // ranks end. It names the failed rank, which is this one, or a lower one that failed at the same
  // time. After one of the calls above has returned this error, all ranks know it.
  Error Fail(const Error& error);
  // The same for an error that all ranks have found at the same time, with the same message.
  Error FailCollectively(const Error& error)
  {
    this->Failed = error;
    return error;
  }
  // Called when this rank is done. Returns the error of a rank that has failed, if any.
  Status Finish() { return this->AgreeOn(); }

  // Runs work() -> Result or Status on all ranks together. An exception becomes an error of all
  // ranks too, except BrokenGroup, which is passed on.
  template <class Work>
  auto Run(const Work& work) -> decltype(work())
  {
    decltype(work()) done = Error{};
    try
    {
      done = work();
    }
    catch (const BrokenGroup&)
    {
      throw;
    }
    catch (...)
    {
      done = CaughtError();
    }
    const Status all = done ? this->Finish() : Status(this->Fail(done.GetError()));
    return all ? std::move(done) : decltype(work())(all.GetError());
  }

protected:
  // Begins every call: agrees that no rank has failed. In the same exchange each rank sends the
  // others a few numbers, at most Count() + 1. REQUIRES: `own` is not null, or all ranks give the
  // same count of numbers.
  Status AgreeOn(std::span<const std::uint64_t> numbers = {}, const Error* own = nullptr);
  std::uint64_t Received(std::size_t rank, std::size_t number) const
  {
    return this->AllReceived[rank * (this->Count() + 2) + 1 + number];
  }
  // Calls make(), which allocates memory, and agrees whether it has succeeded on all ranks.
  template <class Make>
  Status AgreeOnRoom(const Make& make)
  {
    std::optional<Error> error;
    try
    {
      make();
    }
    catch (...)
    {
      error = CaughtError();
    }
    return this->AgreeOn({}, error ? &*error : nullptr);
  }
  // Runs a step that the other ranks run at the same time.
  template <class Step>
  static auto Collective(const Step& step)
  {
    try
    {
      return step();
    }
    catch (...)
    {
      throw BrokenGroup{ CaughtError() };
    }
  }

private:
  using Room = std::function<std::span<std::byte>(std::size_t from, std::size_t bytes)>;

  Result<bool> ExchangeBytes(
    const std::vector<std::span<const std::byte>>& out, const Room& room, bool more);
  void Swap(const std::vector<std::span<const std::byte>>& out,
    const std::vector<std::span<std::byte>>& in);
  Error ErrorOf(std::size_t rank, const Error* own);

  std::unique_ptr<RankMessages> Own; // if made from a controller
  std::optional<Error> Failed;
  std::vector<std::uint64_t> AllReceived; // of each rank: whether it has failed, and its numbers

protected:
  RankMessages& Messages;
};

// A message of several lists, one after the other, each preceded by its length.
class RankMessage
{
public:
  explicit RankMessage(std::vector<unsigned char> bytes = {})
    : Bytes(std::move(bytes))
  {
  }
  template <class T>
  void Put(const std::vector<T>& list)
  {
    const std::uint64_t size = list.size() * sizeof(T);
    this->Append(&size, sizeof(size));
    this->Append(list.data(), size);
  }
  template <class T>
  std::vector<T> Take()
  {
    std::uint64_t size = 0;
    this->Copy(&size, sizeof(size));
    std::vector<T> list(size / sizeof(T));
    this->Copy(list.data(), size);
    return list;
  }
  bool AtEnd() const { return this->At == this->Bytes.size(); }
  std::vector<unsigned char> Release() { return std::move(this->Bytes); }

private:
  void Append(const void* from, std::size_t size)
  {
    const auto* const begin = static_cast<const unsigned char*>(from);
    this->Bytes.insert(this->Bytes.end(), begin, begin + size);
  }
  void Copy(void* to, std::size_t size)
  {
    std::copy_n(
      this->Bytes.begin() + std::ptrdiff_t(this->At), size, static_cast<unsigned char*>(to));
    this->At += size;
  }

  std::vector<unsigned char> Bytes;
  std::size_t At = 0;
};

}
