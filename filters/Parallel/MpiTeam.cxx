// SPDX-License-Identifier: BSD-3-Clause
#include "filters/Parallel/MpiTeam.h"

#include "filters/Parallel/TeamFiles.h"
#include "filters/core/BitCast.h"
#include "filters/core/CaughtError.h"

#include <algorithm>
#include <array>
#include <functional>
#include <string>

#include <unistd.h>

namespace kdstream
{
namespace
{

// A step of an exchange that the other ranks do at the same time.
template <class Step>
auto Together(const Step& step)
{
  try
  {
    return step();
  }
  catch (...)
  {
    throw BrokenTeam{ CaughtError() };
  }
}

}

MpiTeam::MpiTeam(RankMessages& messages)
  : Messages(messages)
  , Nodes(messages.Count())
{
}

std::string MpiTeam::Where() const
{
  std::array<char, 256> host{};
  ::gethostname(host.data(), host.size() - 1);
  return "rank " + std::to_string(this->Rank()) + " on " + host.data();
}

Error MpiTeam::NameRank(Error error) const
{
  if (this->Count() > 1 && error.code != ErrorCode::Cancelled)
  {
    (error.place.empty() ? error.message : error.place) += " (" + this->Where() + ")";
  }
  return error;
}

// The lowest rank with an error tells it to all.
Status MpiTeam::Agree(std::span<const std::uint64_t> numbers, const Error* own)
{
  if (this->Failed)
  {
    return *this->Failed;
  }
  const std::size_t each = this->Count() + 2;
  std::vector<std::uint64_t> mine(each, 0);
  mine[0] = own != nullptr ? 1 : 0;
  std::copy(numbers.begin(), numbers.end(), mine.begin() + 1);
  this->AllTold = Together([&] { return this->Messages.TellAll(mine); });
  for (std::size_t rank = 0; rank < this->Count(); ++rank)
  {
    if (this->AllTold[rank * each] != 0)
    {
      this->Failed = Together([&] { return this->ErrorOf(rank, own); });
      return *this->Failed;
    }
  }
  return {};
}

// The error of a rank, told to all. own: on this rank, if it has any.
Error MpiTeam::ErrorOf(std::size_t rank, const Error* own)
{
  Error error = rank == this->Rank() ? this->NameRank(*own) : Error{};
  int code[] = { static_cast<int>(error.code) };
  this->Messages.Broadcast(rank, code);
  error.code = static_cast<ErrorCode>(code[0]);
  for (std::string* const text : { &error.message, &error.file, &error.place })
  {
    this->Messages.Broadcast(rank, *text);
  }
  return error;
}

Error MpiTeam::Fail(const Error& error)
{
  return this->Agree({}, &error).GetError();
}

Status MpiTeam::Sum(std::span<std::uint64_t> numbers)
{
  if (numbers.size() > this->Count())
  {
    KDSTREAM_TRY(this->Agree());
    Together([&] { this->Messages.Combine(numbers, std::plus<>()); });
    return {};
  }
  // So few are told while the ranks agree.
  KDSTREAM_TRY(this->Agree(numbers));
  for (std::size_t i = 0; i < numbers.size(); ++i)
  {
    numbers[i] = 0;
    for (std::size_t rank = 0; rank < this->Count(); ++rank)
    {
      numbers[i] += this->Told(rank, i);
    }
  }
  return {};
}

Status MpiTeam::Spread(std::vector<VertexId>& numbers)
{
  const std::uint64_t count = numbers.size();
  KDSTREAM_TRY(this->Agree(std::span(&count, 1)));
  Together(
    [&]
    {
      numbers.resize(static_cast<std::size_t>(this->Told(0, 0)));
      this->Messages.PassDown(std::as_writable_bytes(std::span(numbers)));
    });
  return {};
}

Status MpiTeam::Fetch(SpillFile& file, std::size_t elementBytes, std::span<const VertexId> begin,
  unsigned depth, std::span<const VertexId> wanted)
{
  return FetchElements(*this, file, elementBytes, this->Nodes.PlacesOf(begin, depth), wanted);
}

Status MpiTeam::Share(std::span<std::byte> blocks, unsigned depth)
{
  const std::size_t bytes = blocks.size() >> depth;
  std::vector<std::size_t> offsets, lengths;
  for (std::size_t rank = 0; rank < this->Count(); ++rank)
  {
    const BlockRange range = this->Nodes.BlocksOf(rank, depth);
    offsets.push_back(range.begin * bytes);
    lengths.push_back((range.end - range.begin) * bytes);
  }
  KDSTREAM_TRY(this->Agree());
  Together([&] { this->Messages.GatherParts(blocks, offsets, lengths); });
  return {};
}

Status MpiTeam::JoinBoxes(std::span<Box> boxes)
{
  std::vector<double> mine; // the upper ends negative, so that one minimum does for both
  for (const Box& box : boxes)
  {
    mine.insert(mine.end(), box.lo.begin(), box.lo.end());
    std::transform(
      box.hi.begin(), box.hi.end(), std::back_inserter(mine), [](double x) { return -x; });
  }
  KDSTREAM_TRY(this->Agree());
  Together(
    [&] {
      this->Messages.Combine(std::span(mine), [](double a, double b) { return std::min(a, b); });
    });
  for (std::size_t i = 0; i < boxes.size(); ++i)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      boxes[i].lo[k] = mine[6 * i + k] + 0.0; // no -0.0
      boxes[i].hi[k] = -mine[6 * i + 3 + k] + 0.0;
    }
  }
  return {};
}

Result<std::vector<std::uint64_t>> MpiTeam::Gather(std::uint64_t number)
{
  KDSTREAM_TRY(this->Agree(std::span(&number, 1)));
  std::vector<std::uint64_t> numbers;
  for (std::size_t rank = 0; rank < this->Count(); ++rank)
  {
    numbers.push_back(this->Told(rank, 0));
  }
  return numbers;
}

Result<std::uint64_t> MpiTeam::Most(std::uint64_t number)
{
  const Result<std::vector<std::uint64_t>> numbers = this->Gather(number);
  KDSTREAM_TRY(numbers);
  return *std::max_element(numbers->begin(), numbers->end());
}

Result<double> MpiTeam::AddInOrder(const std::function<Status(double& sum)>& add)
{
  KDSTREAM_TRY(this->Agree());
  double sum = 0;
  const Status added = Together(
    [&]
    {
      const std::span<double> one(&sum, 1);
      if (!this->IsFirst())
      {
        this->Messages.Receive(this->Rank() - 1, std::as_writable_bytes(one));
      }
      Status status = add(sum); // the others are not left to wait, whatever becomes of it
      if (this->Rank() + 1 < this->Count())
      {
        this->Messages.Send(this->Rank() + 1, std::as_bytes(one));
      }
      return status;
    });
  KDSTREAM_TRY(added);
  const auto bits = BitCast<std::uint64_t>(sum);
  KDSTREAM_TRY(this->Agree(std::span(&bits, 1)));
  return BitCast<double>(this->Told(this->Count() - 1, 0));
}

Result<bool> MpiTeam::ExchangeBytes(
  const std::vector<std::span<const std::byte>>& out, const Room& room, bool more)
{
  const std::size_t ranks = this->Count();
  std::vector<std::uint64_t> sizes{ more ? std::uint64_t{ 1 } : 0 };
  for (const std::span<const std::byte> bytes : out)
  {
    sizes.push_back(bytes.size());
  }
  KDSTREAM_TRY(this->Agree(sizes));
  bool anyMore = false;
  for (std::size_t rank = 0; rank < ranks; ++rank)
  {
    anyMore = anyMore || this->Told(rank, 0) > 0;
  }
  Together([&] { this->Swap(out, room); });
  return anyMore;
}

// What each rank has for each other one, as Agree has told the sizes.
void MpiTeam::Swap(const std::vector<std::span<const std::byte>>& out, const Room& room)
{
  const std::size_t ranks = this->Count();
  // Before anything is under way: there may be no memory for it.
  std::vector<std::span<std::byte>> in(ranks);
  for (std::size_t from = 0; from < ranks; ++from)
  {
    if (from != this->Rank())
    {
      in[from] = room(from, static_cast<std::size_t>(this->Told(from, 1 + this->Rank())));
    }
  }
  std::vector<RankMessages::Incoming> incoming;
  std::vector<RankMessages::Outgoing> outgoing;
  for (std::size_t step = 1; step < ranks; ++step)
  {
    const std::size_t from = (this->Rank() + ranks - step) % ranks;
    const std::size_t to = (this->Rank() + step) % ranks;
    incoming.push_back({ from, in[from] });
    outgoing.push_back({ to, out[to] });
  }
  this->Messages.Move(outgoing, incoming);
}

}
