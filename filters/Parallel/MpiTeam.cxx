#include "filters/Parallel/MpiTeam.h"

#include "filters/core/BitCast.h"
#include "filters/outofcore/files/RecordFile.h"
#include "filters/outofcore/files/ScatteredRead.h"

#include <vtkMPIController.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstring>
#include <functional>
#include <limits>
#include <string>
#include <thread>

namespace kdstream
{
namespace
{

constexpr std::size_t mostAtOnce = std::size_t{ 1 } << 30; // MPI counts in int
constexpr int tag = 1;

const unsigned char* Data(std::span<const std::byte> bytes)
{
  return reinterpret_cast<const unsigned char*>(bytes.data());
}
unsigned char* Data(std::span<std::byte> bytes)
{
  return reinterpret_cast<unsigned char*>(bytes.data());
}

std::uint64_t CeilOfHalves(std::uint64_t number, unsigned halvings)
{
  return (number + (std::uint64_t{ 1 } << halvings) - 1) >> halvings;
}

// MPI waits by asking all the time; a rank that waits for long leaves its processor to others.
void WaitFor(std::vector<vtkMPICommunicator::Request>& requests)
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

}

Status WriteElementsAt(SpillFile& file, std::size_t elementBytes, std::span<const VertexId> places,
  std::span<const std::byte> elements)
{
  for (std::size_t i = 0; i < places.size();)
  {
    std::size_t end = i + 1;
    while (end < places.size() && places[end] == places[end - 1] + 1)
    {
      ++end;
    }
    const Status status = file.Write(std::uint64_t{ places[i] } * elementBytes,
      elements.subspan(i * elementBytes, (end - i) * elementBytes));
    KDSTREAM_TRY(status);
    i = end;
  }
  return {};
}

MpiTeam::MpiTeam(vtkMPIController& controller)
  : Controller(controller)
  , Mine(static_cast<std::size_t>(controller.GetLocalProcessId()))
  , Ranks(static_cast<std::size_t>(controller.GetNumberOfProcesses()))
{
}

BlockRange MpiTeam::HereOf(std::size_t rank, unsigned depth) const
{
  const auto begin = [&](std::size_t r) -> std::size_t
  {
    const std::uint64_t nodes = std::uint64_t{ 1 } << this->NodeDepth;
    const std::uint64_t node = (r * nodes + this->Ranks - 1) / this->Ranks;
    return depth >= this->NodeDepth ? node << (depth - this->NodeDepth)
                                    : CeilOfHalves(node, this->NodeDepth - depth);
  };
  return { begin(rank), begin(rank + 1) };
}

std::size_t MpiTeam::OwnerOf(std::size_t block, unsigned depth) const
{
  std::size_t low = 0, high = this->Ranks - 1;
  while (low < high)
  {
    const std::size_t middle = (low + high) / 2;
    (block < this->HereOf(middle, depth).end ? high : low) =
      block < this->HereOf(middle, depth).end ? middle : middle + 1;
  }
  return low;
}

std::vector<std::uint64_t> MpiTeam::PlacesOf(std::span<const VertexId> begin, unsigned depth) const
{
  std::vector<std::uint64_t> places;
  for (std::size_t rank = 0; rank < this->Ranks; ++rank)
  {
    places.push_back(begin[this->HereOf(rank, depth).begin]);
  }
  places.push_back(begin.back());
  return places;
}

std::vector<std::uint64_t> PlacesOfRanks(
  const MpiTeam& team, std::span<const VertexId> begin, unsigned depth)
{
  return team.PlacesOf(begin, depth);
}

// Each rank passes on what it knows, twice as much from step to step (Bruck's gathering).
void MpiTeam::TellAll(std::span<const std::uint64_t> mine)
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
    WaitFor(requests);
  }
  std::rotate(known.begin(),
    known.begin() + std::ptrdiff_t((this->Ranks - this->Mine) % this->Ranks * each), known.end());
  this->AllTold = std::move(known);
}

void MpiTeam::BeginSend(std::size_t rank, std::span<const std::byte> bytes, Requests& requests)
{
  for (std::size_t at = 0; at < bytes.size(); at += mostAtOnce)
  {
    const auto part = bytes.subspan(at, std::min(mostAtOnce, bytes.size() - at));
    this->Controller.NoBlockSend(Data(part), static_cast<int>(part.size()), static_cast<int>(rank),
      tag, requests.emplace_back());
  }
}

void MpiTeam::BeginReceive(std::size_t rank, std::span<std::byte> bytes, Requests& requests)
{
  for (std::size_t at = 0; at < bytes.size(); at += mostAtOnce)
  {
    const auto part = bytes.subspan(at, std::min(mostAtOnce, bytes.size() - at));
    this->Controller.NoBlockReceive(Data(part), static_cast<int>(part.size()),
      static_cast<int>(rank), tag, requests.emplace_back());
  }
}

void MpiTeam::Send(std::size_t rank, std::span<const std::byte> bytes)
{
  Requests requests;
  this->BeginSend(rank, bytes, requests);
  WaitFor(requests);
}

void MpiTeam::Receive(std::size_t rank, std::span<std::byte> bytes)
{
  Requests requests;
  this->BeginReceive(rank, bytes, requests);
  WaitFor(requests);
}

// From rank 0 to all: a rank gets it from the one whose number has its lowest bit less, and passes
// it on.
void MpiTeam::PassDown(std::span<std::byte> bytes)
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

// Up the same way that it then comes down.
template <class T, class Operation>
void MpiTeam::Combine(std::span<T> values, const Operation& operation)
{
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

// The lowest rank with an error tells it to all.
Status MpiTeam::Agree(std::span<const std::uint64_t> numbers, const Error* own)
{
  if (this->Failed)
  {
    return *this->Failed;
  }
  const std::size_t each = this->Ranks + 2;
  std::vector<std::uint64_t> mine(each, 0);
  mine[0] = own != nullptr ? 1 : 0;
  std::copy(numbers.begin(), numbers.end(), mine.begin() + 1);
  this->TellAll(mine);
  std::size_t from = 0;
  while (from < this->Ranks && this->AllTold[from * each] == 0)
  {
    ++from;
  }
  if (from == this->Ranks)
  {
    return {};
  }
  int head[2] = { 0, 0 }; // code, bytes of the message
  std::string message;
  if (from == this->Mine)
  {
    message = own->message;
    head[0] = static_cast<int>(own->code);
    head[1] = static_cast<int>(message.size());
  }
  this->Controller.Broadcast(head, 2, static_cast<int>(from));
  message.resize(static_cast<std::size_t>(head[1]));
  this->Controller.Broadcast(message.data(), head[1], static_cast<int>(from));
  this->Failed = Error{ static_cast<ErrorCode>(head[0]), message };
  return *this->Failed;
}

Error MpiTeam::Fail(const Error& error)
{
  return this->Agree({}, &error).GetError();
}

Status MpiTeam::Sum(std::span<std::uint64_t> numbers)
{
  const bool few = numbers.size() <= this->Ranks;
  Status status = this->Agree(few ? numbers : std::span<std::uint64_t>{});
  KDSTREAM_TRY(status);
  if (!few)
  {
    this->Combine(numbers, std::plus<>());
    return status;
  }
  for (std::size_t i = 0; i < numbers.size(); ++i)
  {
    numbers[i] = 0;
    for (std::size_t rank = 0; rank < this->Ranks; ++rank)
    {
      numbers[i] += this->Told(rank, i);
    }
  }
  return status;
}

Status MpiTeam::Spread(std::vector<VertexId>& numbers)
{
  const std::uint64_t count = numbers.size();
  Status status = this->Agree(std::span(&count, 1));
  if (status)
  {
    numbers.resize(static_cast<std::size_t>(this->Told(0, 0)));
    this->PassDown(std::as_writable_bytes(std::span(numbers)));
  }
  return status;
}

Status MpiTeam::Share(std::span<std::byte> blocks, unsigned depth)
{
  Status status = this->Agree();
  KDSTREAM_TRY(status);
  const std::size_t bytes = blocks.size() >> depth;
  std::vector<vtkIdType> lengths, offsets;
  for (std::size_t rank = 0; rank < this->Ranks; ++rank)
  {
    const BlockRange range = this->HereOf(rank, depth);
    lengths.push_back(static_cast<vtkIdType>((range.end - range.begin) * bytes));
    offsets.push_back(static_cast<vtkIdType>(range.begin * bytes));
  }
  const auto own = blocks.subspan(
    static_cast<std::size_t>(offsets[this->Mine]), static_cast<std::size_t>(lengths[this->Mine]));
  const std::vector<std::byte> mine(own.begin(), own.end());
  this->Controller.AllGatherV(Data(std::span<const std::byte>(mine)), Data(blocks),
    lengths[this->Mine], lengths.data(), offsets.data());
  return status;
}

Status MpiTeam::JoinBoxes(std::span<Box> boxes)
{
  Status status = this->Agree();
  KDSTREAM_TRY(status);
  std::vector<double> mine; // the upper ends negative, so that one minimum does for both
  for (const Box& box : boxes)
  {
    mine.insert(mine.end(), box.lo.begin(), box.lo.end());
    std::transform(
      box.hi.begin(), box.hi.end(), std::back_inserter(mine), [](double x) { return -x; });
  }
  this->Combine(std::span(mine), [](double a, double b) { return std::min(a, b); });
  for (std::size_t i = 0; i < boxes.size(); ++i)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      boxes[i].lo[k] = mine[6 * i + k] + 0.0; // no -0.0
      boxes[i].hi[k] = -mine[6 * i + 3 + k] + 0.0;
    }
  }
  return status;
}

Result<std::vector<std::uint64_t>> MpiTeam::Gather(std::uint64_t number)
{
  KDSTREAM_TRY(this->Agree(std::span(&number, 1)));
  std::vector<std::uint64_t> numbers;
  for (std::size_t rank = 0; rank < this->Ranks; ++rank)
  {
    numbers.push_back(this->Told(rank, 0));
  }
  return numbers;
}

Result<std::uint64_t> MpiTeam::Most(std::uint64_t number)
{
  const Result<std::vector<std::uint64_t>> numbers = this->Gather(number);
  return numbers ? Result<std::uint64_t>(*std::max_element(numbers->begin(), numbers->end()))
                 : numbers.GetError();
}

Result<double> MpiTeam::AddInOrder(const std::function<Status(double& sum)>& add)
{
  KDSTREAM_TRY(this->Agree());
  double sum = 0;
  if (this->Mine > 0)
  {
    this->Receive(this->Mine - 1, std::as_writable_bytes(std::span(&sum, 1)));
  }
  const Status added = add(sum); // the others are not left to wait, whatever becomes of it
  if (this->Mine + 1 < this->Ranks)
  {
    this->Send(this->Mine + 1, std::as_bytes(std::span(&sum, 1)));
  }
  KDSTREAM_TRY(added);
  const auto bits = BitCast<std::uint64_t>(sum);
  const Status status = this->Agree(std::span(&bits, 1));
  return status ? Result<double>(BitCast<double>(this->Told(this->Ranks - 1, 0)))
                : status.GetError();
}

Result<bool> MpiTeam::ExchangeBytes(
  const std::vector<std::span<const std::byte>>& out, const Room& room, bool more)
{
  std::vector<std::uint64_t> sizes{ more ? std::uint64_t{ 1 } : 0 };
  for (const std::span<const std::byte> bytes : out)
  {
    sizes.push_back(bytes.size());
  }
  KDSTREAM_TRY(this->Agree(sizes));
  bool anyMore = false;
  for (std::size_t rank = 0; rank < this->Ranks; ++rank)
  {
    anyMore = anyMore || this->Told(rank, 0) > 0;
  }
  Requests requests;
  for (std::size_t step = 1; step < this->Ranks; ++step)
  {
    const std::size_t from = (this->Mine + this->Ranks - step) % this->Ranks;
    const auto size = static_cast<std::size_t>(this->Told(from, 1 + this->Mine));
    this->BeginReceive(from, room(from, size), requests);
  }
  for (std::size_t step = 1; step < this->Ranks; ++step)
  {
    const std::size_t to = (this->Mine + step) % this->Ranks;
    this->BeginSend(to, out[to], requests);
  }
  WaitFor(requests);
  return anyMore;
}

Status MpiTeam::Fetch(SpillFile& file, std::size_t elementBytes, std::span<const VertexId> begin,
  unsigned depth, std::span<const VertexId> wanted)
{
  const std::vector<std::uint64_t> places = this->PlacesOf(begin, depth);
  std::vector<VertexId> sorted(wanted.begin(), wanted.end());
  std::sort(sorted.begin(), sorted.end());
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  RankLists<VertexId> asked(this->Ranks);
  for (std::size_t rank = 0, i = 0; rank < this->Ranks; ++rank)
  {
    for (; i < sorted.size() && sorted[i] < places[rank + 1]; ++i)
    {
      if (rank != this->Mine)
      {
        asked[rank].push_back(sorted[i]);
      }
    }
  }
  const std::size_t most = ElementsOfRound(elementBytes);
  std::uint64_t rounds = 0;
  for (const std::vector<VertexId>& list : asked)
  {
    rounds = std::max(rounds, RoundsOf(list.size(), most));
  }
  Status status;
  bool more = true;
  for (std::uint64_t round = 0; status && more; ++round)
  {
    RankLists<VertexId> some(this->Ranks);
    for (std::size_t rank = 0; rank < this->Ranks; ++rank)
    {
      const std::size_t first = std::min<std::size_t>(round * most, asked[rank].size());
      const std::size_t end = std::min(first + most, asked[rank].size());
      some[rank].assign(
        asked[rank].begin() + std::ptrdiff_t(first), asked[rank].begin() + std::ptrdiff_t(end));
    }
    status = Take(this->FetchSome(file, elementBytes, some, round + 1 < rounds), more);
  }
  return status;
}

// wanted: of each other rank, ascending. Whether any rank wants more.
Result<bool> MpiTeam::FetchSome(
  SpillFile& file, std::size_t elementBytes, const RankLists<VertexId>& wanted, bool more)
{
  RankLists<VertexId> questions(this->Ranks);
  const Result<bool> anyMore = this->ExchangeOthers(wanted, questions, more);
  KDSTREAM_TRY(anyMore);
  RankLists<std::byte> answers(this->Ranks), answered(this->Ranks);
  for (std::size_t rank = 0; rank < this->Ranks; ++rank)
  {
    answers[rank].resize(questions[rank].size() * elementBytes);
    KDSTREAM_TRY(ReadElementsAt(file, elementBytes, questions[rank], answers[rank]));
  }
  const Result<bool> exchanged = this->ExchangeOthers(answers, answered, false);
  Status status = exchanged ? Status{} : Status(exchanged.GetError());
  for (std::size_t rank = 0; status && rank < this->Ranks; ++rank)
  {
    status = WriteElementsAt(file, elementBytes, wanted[rank], answered[rank]);
  }
  return status ? anyMore : status.GetError();
}

Status MpiTeam::Move(SpillFile& file, std::size_t elementBytes,
  std::span<const std::uint64_t> before, std::span<const std::uint64_t> after)
{
  const auto common = [&](std::size_t from, std::size_t to)
  {
    const std::uint64_t begin = std::max(before[from], after[to]);
    const std::uint64_t end = std::max(begin, std::min(before[from + 1], after[to + 1]));
    return std::pair(begin * elementBytes, (end - begin) * elementBytes);
  };
  std::uint64_t rounds = 0; // of this rank's; every part of a file begins with one
  for (std::size_t to = 0; to < this->Ranks; ++to)
  {
    const std::uint64_t bytes = to == this->Mine ? 0 : common(this->Mine, to).second;
    rounds = std::max(rounds, RoundsOf(bytes, roundBytes));
  }
  std::vector<std::uint64_t> written(this->Ranks, 0);
  return this->ExchangeInRounds<std::byte>(
    rounds,
    [&](std::uint64_t round, RankLists<std::byte>& out)
    {
      Status status;
      for (std::size_t to = 0; status && to < this->Ranks; ++to)
      {
        const auto [begin, bytes] = common(this->Mine, to);
        const std::uint64_t at = round * roundBytes;
        if (to != this->Mine && at < bytes)
        {
          out[to].resize(static_cast<std::size_t>(std::min<std::uint64_t>(roundBytes, bytes - at)));
          status = file.Read(begin + at, out[to]);
        }
      }
      return status;
    },
    [&](std::size_t from, std::span<const std::byte> bytes)
    {
      const Status status = file.Write(common(from, this->Mine).first + written[from], bytes);
      written[from] += bytes.size();
      return status;
    });
}

Result<std::vector<VertexId>> MpiTeam::LookUp(
  std::span<const VertexId> begin, const NumberTable& values, std::span<const VertexId> wanted)
{
  RankLists<VertexId> asked(this->Ranks);
  std::vector<std::uint32_t> rankOf;
  rankOf.reserve(wanted.size());
  for (const VertexId entry : wanted)
  {
    // The last rank that begins at or before it: those in front of that may have none.
    const auto behind = std::upper_bound(begin.begin(), begin.end() - 1, entry);
    rankOf.push_back(static_cast<std::uint32_t>(behind - begin.begin() - 1));
    asked[rankOf.back()].push_back(entry);
  }
  Result<RankLists<VertexId>> questions = this->Exchange(asked);
  KDSTREAM_TRY(questions);
  for (std::vector<VertexId>& list : *questions)
  {
    std::for_each(list.begin(), list.end(), [&](VertexId& entry) { entry -= begin[this->Mine]; });
    KDSTREAM_TRY(values.Look(list));
  }
  const Result<RankLists<VertexId>> answers = this->Exchange(*questions);
  KDSTREAM_TRY(answers);
  std::vector<std::size_t> next(this->Ranks, 0);
  std::vector<VertexId> found;
  found.reserve(wanted.size());
  for (const std::uint32_t rank : rankOf)
  {
    found.push_back((*answers)[rank][next[rank]++]);
  }
  return found;
}

}
