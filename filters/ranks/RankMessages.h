// SPDX-License-Identifier: BSD-3-Clause
// Transports bytes between the processes of a vtkMultiProcessController, the ranks: the base of
// RankGroup.
//
// The functions do not report errors: a rank calls them only when it knows that the other ranks
// call them too.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

class vtkMultiProcessController;

namespace kdstream
{

class RankMessages
{
public:
  struct Outgoing
  {
    std::size_t to;
    std::span<const std::byte> bytes;
  };
  struct Incoming
  {
    std::size_t from;
    std::span<std::byte> bytes;
  };

  // REQUIRES: an initialized controller, which outlives this.
  explicit RankMessages(vtkMultiProcessController& controller);
  RankMessages(const RankMessages&) = delete;
  RankMessages& operator=(const RankMessages&) = delete;
  virtual ~RankMessages();

  std::size_t Rank() const { return this->Mine; }
  std::size_t Count() const { return this->Ranks; }

  // Sends and receives, at most one message to and one from each other rank. The other ranks make
  // their matching calls in the same order. This implementation serves one pair of ranks after the
  // other, in an order that is the same on all ranks, so that it works with any controller.
  virtual void Move(std::span<const Outgoing> out, std::span<const Incoming> in);
  void Send(std::size_t rank, std::span<const std::byte> bytes);
  void Receive(std::size_t rank, std::span<std::byte> bytes);

  // Gathers the numbers of all ranks on every rank, one rank after the other, in log R steps. All
  // ranks call it, with the same count of numbers.
  std::vector<std::uint64_t> TellAll(std::span<const std::uint64_t> mine);
  // Sends bytes from rank 0 to all ranks.
  void PassDown(std::span<std::byte> bytes);
  // Sends from one rank to all ranks.
  void Broadcast(std::size_t from, std::span<int> numbers);
  void Broadcast(std::size_t from, std::string& text);
  // Combines the values of all ranks, element by element; `operation` can be applied in any order.
  // other: scratch memory for the same number of values.
  template <class T, class Operation>
  void Combine(std::span<T> values, std::span<T> other, const Operation& operation)
  {
    // Values go up to rank 0 on the same way on which PassDown sends the result down.
    for (std::size_t step = 1; step < this->Ranks; step *= 2)
    {
      if ((this->Mine & step) != 0)
      {
        this->Send(this->Mine - step, std::as_bytes(values));
        break;
      }
      if (this->Mine + step < this->Ranks)
      {
        this->Receive(this->Mine + step, std::as_writable_bytes(other));
        std::transform(values.begin(), values.end(), other.begin(), values.begin(), operation);
      }
    }
    this->PassDown(std::as_writable_bytes(values));
  }
  // Gathers the parts of all ranks into `whole`: rank r has lengths[r] bytes, from offsets[r] on.
  // mine: a copy of this rank's part.
  void GatherParts(std::span<std::byte> whole, std::span<const std::size_t> offsets,
    std::span<const std::size_t> lengths, std::span<const std::byte> mine);

private:
  vtkMultiProcessController& Controller;
  const std::size_t Mine, Ranks;
};

// MPI counts bytes in int: calls visit(part) for parts of 1 GiB.
template <class Byte, class Visit>
void ForEachMessage(std::span<Byte> bytes, const Visit& visit)
{
  constexpr std::size_t most = std::size_t{ 1 } << 30;
  for (std::size_t at = 0; at < bytes.size(); at += most)
  {
    visit(bytes.subspan(at, std::min(most, bytes.size() - at)));
  }
}

// The tag of all messages of a group.
inline constexpr int messageTagOfGroup = 8108;
static_assert(messageTagOfGroup <= 32767, "MPI promises no greater tags (MPI_TAG_UB)");

}
