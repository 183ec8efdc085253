// SPDX-License-Identifier: BSD-3-Clause
#include "filters/ranks/RankMessages.h"

#include <vtkMultiProcessController.h>

#include <bit>
#include <tuple>

namespace kdstream
{
namespace
{

const unsigned char* Data(std::span<const std::byte> bytes)
{
  return reinterpret_cast<const unsigned char*>(bytes.data());
}
unsigned char* Data(std::span<std::byte> bytes)
{
  return reinterpret_cast<unsigned char*>(bytes.data());
}

}

RankMessages::RankMessages(vtkMultiProcessController& controller)
  : Controller(controller)
  , Mine(static_cast<std::size_t>(controller.GetLocalProcessId()))
  , Ranks(static_cast<std::size_t>(controller.GetNumberOfProcesses()))
{
}

RankMessages::~RankMessages() = default;

// Serves pairs of ranks in ascending order; in a pair the lower rank sends first. So there is no
// deadlock: of all pairs that wait, the first one can proceed.
void RankMessages::Move(std::span<const Outgoing> out, std::span<const Incoming> in)
{
  struct Step
  {
    std::size_t other, index;
    bool sends;
  };
  std::vector<Step> steps;
  for (std::size_t i = 0; i < out.size(); ++i)
  {
    steps.push_back({ out[i].to, i, true });
  }
  for (std::size_t i = 0; i < in.size(); ++i)
  {
    steps.push_back({ in[i].from, i, false });
  }
  const auto order = [this](const Step& step)
  {
    const bool isLower = this->Mine < step.other;
    return std::tuple(std::min(this->Mine, step.other), std::max(this->Mine, step.other),
      step.sends == isLower ? 0 : 1);
  };
  std::sort(
    steps.begin(), steps.end(), [&](const Step& a, const Step& b) { return order(a) < order(b); });
  for (const Step& step : steps)
  {
    const int other = static_cast<int>(step.other);
    if (step.sends)
    {
      ForEachMessage(out[step.index].bytes,
        [&](std::span<const std::byte> part)
        {
          this->Controller.Send(
            Data(part), static_cast<vtkIdType>(part.size()), other, messageTagOfGroup);
        });
    }
    else
    {
      ForEachMessage(in[step.index].bytes,
        [&](std::span<std::byte> part)
        {
          this->Controller.Receive(
            Data(part), static_cast<vtkIdType>(part.size()), other, messageTagOfGroup);
        });
    }
  }
}

void RankMessages::Send(std::size_t rank, std::span<const std::byte> bytes)
{
  const Outgoing out[] = { { rank, bytes } };
  this->Move(out, {});
}

void RankMessages::Receive(std::size_t rank, std::span<std::byte> bytes)
{
  const Incoming in[] = { { rank, bytes } };
  this->Move({}, in);
}

// Each rank passes on the numbers that it knows; they double from step to step (Bruck's algorithm).
std::vector<std::uint64_t> RankMessages::TellAll(std::span<const std::uint64_t> mine)
{
  const std::size_t each = mine.size();
  // The numbers of this rank and of the ranks after it.
  std::vector<std::uint64_t> known(mine.begin(), mine.end());
  known.resize(each * this->Ranks);
  for (std::size_t distance = 1; distance < this->Ranks; distance *= 2)
  {
    const std::size_t count = each * std::min(distance, this->Ranks - distance);
    const Outgoing out[] = { { (this->Mine + this->Ranks - distance) % this->Ranks,
      std::as_bytes(std::span(known).first(count)) } };
    const Incoming in[] = { { (this->Mine + distance) % this->Ranks,
      std::as_writable_bytes(std::span(known).subspan(each * distance, count)) } };
    this->Move(out, in);
  }
  std::rotate(known.begin(),
    known.begin() + std::ptrdiff_t((this->Ranks - this->Mine) % this->Ranks * each), known.end());
  return known;
}

// A rank receives the bytes from the rank whose number lacks the lowest set bit of its own number,
// and passes them on.
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
  std::span<const std::size_t> lengths, std::span<const std::byte> mine)
{
  std::vector<vtkIdType> vtkLengths(lengths.begin(), lengths.end());
  std::vector<vtkIdType> vtkOffsets(offsets.begin(), offsets.end());
  this->Controller.AllGatherV(
    Data(mine), Data(whole), vtkLengths[this->Mine], vtkLengths.data(), vtkOffsets.data());
}

}
