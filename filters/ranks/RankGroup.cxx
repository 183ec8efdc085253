// SPDX-License-Identifier: BSD-3-Clause
#include "filters/ranks/RankGroup.h"

#include <array>

#include <unistd.h>

namespace kdstream
{

RankGroup::RankGroup(RankMessages& messages)
  : Messages(messages)
{
}

RankGroup::RankGroup(vtkMultiProcessController& controller)
  : Own(std::make_unique<RankMessages>(controller))
  , Messages(*this->Own)
{
}

std::string RankGroup::Where() const
{
  std::array<char, 256> host{};
  ::gethostname(host.data(), host.size() - 1);
  return "rank " + std::to_string(this->Rank()) + " on " + host.data();
}

Error RankGroup::NameRank(Error error) const
{
  if (this->Count() > 1 && error.code != ErrorCode::Cancelled)
  {
    (error.place.empty() ? error.message : error.place) += " (" + this->Where() + ")";
  }
  return error;
}

// If ranks have failed, the lowest of them sends its error to all.
Status RankGroup::AgreeOn(std::span<const std::uint64_t> numbers, const Error* own)
{
  if (this->Failed)
  {
    return *this->Failed;
  }
  const std::size_t each = this->Count() + 2;
  Collective(
    [&]
    {
      std::vector<std::uint64_t> mine(each, 0);
      mine[0] = own != nullptr ? 1 : 0;
      std::copy(numbers.begin(), numbers.end(), mine.begin() + 1);
      this->AllReceived = this->Messages.TellAll(mine);
    });
  for (std::size_t rank = 0; rank < this->Count(); ++rank)
  {
    if (this->AllReceived[rank * each] != 0)
    {
      this->Failed = Collective([&] { return this->ErrorOf(rank, own); });
      return *this->Failed;
    }
  }
  return {};
}

// Sends the error of a rank to all, and returns it. own: this rank's error, if it has one.
Error RankGroup::ErrorOf(std::size_t rank, const Error* own)
{
  Error error = rank == this->Rank() ? this->NameRank(*own) : Error{};
  int code[] = { static_cast<int>(error.code), static_cast<int>(error.remedy) };
  this->Messages.Broadcast(rank, code);
  error.code = static_cast<ErrorCode>(code[0]);
  error.remedy = static_cast<Remedy>(code[1]);
  for (std::string* const text : { &error.message, &error.file, &error.place })
  {
    this->Messages.Broadcast(rank, *text);
  }
  return error;
}

Status RankGroup::Agree(const Status& own)
{
  return this->AgreeOn({}, own ? nullptr : &own.GetError());
}

Error RankGroup::Fail(const Error& error)
{
  return this->AgreeOn({}, &error).GetError();
}

Status RankGroup::Sum(std::span<std::uint64_t> numbers)
{
  if (numbers.size() > this->Count())
  {
    std::vector<std::uint64_t> others;
    KDSTREAM_TRY(this->AgreeOnRoom([&] { others.resize(numbers.size()); }));
    Collective([&] { this->Messages.Combine(numbers, std::span(others), std::plus<>()); });
    return {};
  }
  // The values are exchanged in the same call in which the ranks agree.
  KDSTREAM_TRY(this->AgreeOn(numbers));
  for (std::size_t i = 0; i < numbers.size(); ++i)
  {
    numbers[i] = 0;
    for (std::size_t rank = 0; rank < this->Count(); ++rank)
    {
      numbers[i] += this->Received(rank, i);
    }
  }
  return {};
}

Status RankGroup::JoinBoxes(std::span<Box> boxes)
{
  std::vector<double> mine, others; // upper ends negated: then minima serve both ends
  KDSTREAM_TRY(this->AgreeOnRoom(
    [&]
    {
      others.resize(6 * boxes.size());
      for (const Box& box : boxes)
      {
        mine.insert(mine.end(), box.lo.begin(), box.lo.end());
        std::transform(
          box.hi.begin(), box.hi.end(), std::back_inserter(mine), [](double x) { return -x; });
      }
    }));
  Collective(
    [&]
    {
      this->Messages.Combine(
        std::span(mine), std::span(others), [](double a, double b) { return std::min(a, b); });
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

Result<std::vector<std::uint64_t>> RankGroup::Gather(std::uint64_t number)
{
  KDSTREAM_TRY(this->AgreeOn(std::span(&number, 1)));
  std::vector<std::uint64_t> numbers;
  for (std::size_t rank = 0; rank < this->Count(); ++rank)
  {
    numbers.push_back(this->Received(rank, 0));
  }
  return numbers;
}

Result<bool> RankGroup::AllHave(bool has)
{
  std::uint64_t lacking = has ? 0 : 1;
  KDSTREAM_TRY(this->Sum(std::span(&lacking, 1)));
  return lacking == 0;
}

Result<std::pair<std::uint64_t, std::uint64_t>> RankGroup::CountBefore(std::uint64_t count)
{
  const auto counts = this->Gather(count);
  KDSTREAM_TRY(counts);
  const auto own = counts->begin() + std::ptrdiff_t(this->Rank());
  const std::uint64_t before = std::accumulate(counts->begin(), own, std::uint64_t{ 0 });
  return std::pair{ before, std::accumulate(own, counts->end(), before) };
}

Result<bool> RankGroup::ExchangeBytes(
  const std::vector<std::span<const std::byte>>& out, const Room& room, bool more)
{
  const std::size_t ranks = this->Count();
  std::vector<std::uint64_t> sizes{ more ? std::uint64_t{ 1 } : 0 };
  for (const std::span<const std::byte> bytes : out)
  {
    sizes.push_back(bytes.size());
  }
  KDSTREAM_TRY(this->AgreeOn(sizes));
  bool anyMore = false;
  std::vector<std::size_t> coming(ranks, 0);
  for (std::size_t rank = 0; rank < ranks; ++rank)
  {
    anyMore = anyMore || this->Received(rank, 0) > 0;
    coming[rank] = static_cast<std::size_t>(this->Received(rank, 1 + this->Rank()));
  }
  std::vector<std::span<std::byte>> in(ranks);
  KDSTREAM_TRY(this->AgreeOnRoom(
    [&]
    {
      for (std::size_t from = 0; from < ranks; ++from)
      {
        if (from != this->Rank())
        {
          in[from] = room(from, coming[from]);
        }
      }
    }));
  Collective([&] { this->Swap(out, in); });
  return anyMore;
}

// Exchanges data between all pairs of ranks.
void RankGroup::Swap(
  const std::vector<std::span<const std::byte>>& out, const std::vector<std::span<std::byte>>& in)
{
  const std::size_t ranks = this->Count();
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
