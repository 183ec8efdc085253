// SPDX-License-Identifier: BSD-3-Clause
#include "filters/Parallel/RankMessages.h"

#include <vtkMPIController.h>

#include <bit>
#include <chrono>
#include <thread>

namespace kdstream
{
namespace
{

constexpr std::size_t bytesAtOnce = std::size_t{ 1 } << 30; // MPI counts in int
constexpr int tag = 1;

const unsigned char* Data(std::span<const std::byte> bytes)
{
  return reinterpret_cast<const unsigned char*>(bytes.data());
}
unsigned char* Data(std::span<std::byte> bytes)
{
  return reinterpret_cast<unsigned char*>(bytes.data());
}

}

RankMessages::RankMessages(vtkMPIController& controller)
  : Controller(controller)
  , Mine(static_cast<std::size_t>(controller.GetLocalProcessId()))
  , Ranks(static_cast<std::size_t>(controller.GetNumberOfProcesses()))
{
}

void RankMessages::BeginSend(std::size_t rank, std::span<const std::byte> bytes, Requests& requests)
{
  for (std::size_t at = 0; at < bytes.size(); at += bytesAtOnce)
  {
    const auto part = bytes.subspan(at, std::min(bytesAtOnce, bytes.size() - at));
    this->Controller.NoBlockSend(Data(part), static_cast<int>(part.size()), static_cast<int>(rank),
      tag, requests.emplace_back());
  }
}

void RankMessages::BeginReceive(std::size_t rank, std::span<std::byte> bytes, Requests& requests)
{
  for (std::size_t at = 0; at < bytes.size(); at += bytesAtOnce)
  {
    const auto part = bytes.subspan(at, std::min(bytesAtOnce, bytes.size() - at));
    this->Controller.NoBlockReceive(Data(part), static_cast<int>(part.size()),
      static_cast<int>(rank), tag, requests.emplace_back());
  }
}

// MPI waits by asking all the time; a rank that waits for long leaves its processor to others.
void RankMessages::WaitFor(Requests& requests)
{
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::microseconds atOnce(30), mostAsleep(200);
  const Clock::time_point begin = Clock::now();
  std::chrono::microseconds asleep(10);
  for (vtkMPICommunicator::Request& request : requests)
  {
    while (!request.Test())
    {
      if (Clock::now() - begin > atOnce)
      {
        std::this_thread::sleep_for(asleep);
        asleep = std::min(2 * asleep, mostAsleep);
      }
    }
  }
}

void RankMessages::Send(std::size_t rank, std::span<const std::byte> bytes)
{
  Requests requests;
  this->BeginSend(rank, bytes, requests);
  this->WaitFor(requests);
}

void RankMessages::Receive(std::size_t rank, std::span<std::byte> bytes)
{
  Requests requests;
  this->BeginReceive(rank, bytes, requests);
  this->WaitFor(requests);
}

// Each rank passes on what it knows, twice as much from step to step (Bruck's gathering).
std::vector<std::uint64_t> RankMessages::TellAll(std::span<const std::uint64_t> mine)
{
  const std::size_t each = mine.size();
  std::vector<std::uint64_t> known(mine.begin(), mine.end()); // of this rank and those behind it
  known.resize(each * this->Ranks);
  for (std::size_t distance = 1; distance < this->Ranks; distance *= 2)
  {
    const std::size_t count = each * std::min(distance, this->Ranks - distance);
    Requests requests;
    this->BeginReceive((this->Mine + distance) % this->Ranks,
      std::as_writable_bytes(std::span(known).subspan(each * distance, count)), requests);
    this->BeginSend((this->Mine + this->Ranks - distance) % this->Ranks,
      std::as_bytes(std::span(known).first(count)), requests);
    this->WaitFor(requests);
  }
  std::rotate(known.begin(),
    known.begin() + std::ptrdiff_t((this->Ranks - this->Mine) % this->Ranks * each), known.end());
  return known;
}

// A rank gets it from the one whose number has its lowest bit less, and passes it on.
void RankMessages::PassDown(std::span<std::byte> bytes)
{
  std::size_t step = std::bit_ceil(this->Ranks);
  if (this->Mine > 0)
  {
    step = this->Mine & (~this->Mine + 1);
    this->Receive(this->Mine - step, bytes);
  }
  for (step /= 2; step > 0; step /= 2)
  {
    if (this->Mine + step < this->Ranks)
    {
      this->Send(this->Mine + step, bytes);
    }
  }
}

void RankMessages::Broadcast(std::size_t from, std::span<int> numbers)
{
  this->Controller.Broadcast(
    numbers.data(), static_cast<int>(numbers.size()), static_cast<int>(from));
}

void RankMessages::Broadcast(std::size_t from, std::string& text)
{
  int size[] = { static_cast<int>(text.size()) };
  this->Broadcast(from, size);
  text.resize(static_cast<std::size_t>(size[0]));
  this->Controller.Broadcast(text.data(), size[0], static_cast<int>(from));
}

void RankMessages::GatherParts(std::span<std::byte> whole, std::span<const std::size_t> offsets,
  std::span<const std::size_t> lengths)
{
  const auto part = whole.subspan(offsets[this->Mine], lengths[this->Mine]);
  const std::vector<std::byte> mine(part.begin(), part.end());
  std::vector<vtkIdType> vtkLengths(lengths.begin(), lengths.end());
  std::vector<vtkIdType> vtkOffsets(offsets.begin(), offsets.end());
  this->Controller.AllGatherV(Data(std::span<const std::byte>(mine)), Data(whole),
    vtkLengths[this->Mine], vtkLengths.data(), vtkOffsets.data());
}

}
