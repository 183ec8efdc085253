// SPDX-License-Identifier: BSD-3-Clause
// Bytes between the ranks of an MPI job, on VTK's controller: what MpiTeam is made of.
//
// The functions say nothing of errors: a rank calls them when it knows that the others do, too.
#pragma once

#include <vtkMPICommunicator.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

class vtkMPIController;

namespace kdstream
{

class RankMessages
{
public:
  // What has begun and is not yet known to have ended.
  using Requests = std::vector<vtkMPICommunicator::Request>;

  // REQUIRES: an initialized controller, which outlives this.
  explicit RankMessages(vtkMPIController& controller);

  std::size_t Rank() const { return this->Mine; }
  std::size_t Count() const { return this->Ranks; }

  // Between two ranks. Bytes must stay where they are until WaitFor has returned.
  void BeginSend(std::size_t rank, std::span<const std::byte> bytes, Requests& requests);
  void BeginReceive(std::size_t rank, std::span<std::byte> bytes, Requests& requests);
  void WaitFor(Requests& requests);
  void Send(std::size_t rank, std::span<const std::byte> bytes);
  void Receive(std::size_t rank, std::span<std::byte> bytes);

  // By all ranks, in log R steps. The same numbers of each rank, one rank after the other.
  std::vector<std::uint64_t> TellAll(std::span<const std::uint64_t> mine);
  // From rank 0 to all.
  void PassDown(std::span<std::byte> bytes);
  // From one rank to all.
  void Broadcast(std::size_t from, std::span<int> numbers);
  void Broadcast(std::size_t from, std::string& text);
  // Values of all ranks, one by one; `operation` may be used in any order.
  template <class T, class Operation>
  void Combine(std::span<T> values, const Operation& operation)
  {
    // Up the same way that it then comes down.
    std::vector<T> other(this->Ranks > 1 ? values.size() : 0);
    for (std::size_t step = 1; step < this->Ranks; step *= 2)
    {
      if ((this->Mine & step) != 0)
      {
        this->Send(this->Mine - step, std::as_bytes(values));
        break;
      }
      if (this->Mine + step < this->Ranks)
      {
        this->Receive(this->Mine + step, std::as_writable_bytes(std::span(other)));
        std::transform(values.begin(), values.end(), other.begin(), values.begin(), operation);
      }
    }
    this->PassDown(std::as_writable_bytes(values));
  }
  // The parts that all ranks have of `whole`, in it: rank r has lengths[r] bytes from offsets[r]
  // on.
  void GatherParts(std::span<std::byte> whole, std::span<const std::size_t> offsets,
    std::span<const std::size_t> lengths);

private:
  vtkMPIController& Controller;
  const std::size_t Mine, Ranks;
};

}
