#include "filters/Parallel/MpiTeam.h"

#include "filters/outofcore/RecordFile.h"
#include "filters/outofcore/ScatteredRead.h"

#include <vtkMPICommunicator.h>
#include <vtkMPIController.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <string>

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
    if (!status)
    {
      return status;
    }
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

// The lowest rank with an error tells it to all.
Status MpiTeam::Agree(const Error* own)
{
  if (this->Failed)
  {
    return *this->Failed;
  }
  const int mine = own != nullptr ? static_cast<int>(this->Ranks - this->Mine) : 0;
  int most = 0;
  this->Controller.AllReduce(&mine, &most, 1, vtkCommunicator::MAX_OP);
  if (most == 0)
  {
    return {};
  }
  const int from = static_cast<int>(this->Ranks) - most;
  int head[2] = { 0, 0 }; // code, bytes of the message
  std::string message;
  if (from == static_cast<int>(this->Mine))
  {
    message = own->message;
    head[0] = static_cast<int>(own->code);
    head[1] = static_cast<int>(message.size());
  }
  this->Controller.Broadcast(head, 2, from);
  message.resize(static_cast<std::size_t>(head[1]));
  this->Controller.Broadcast(message.data(), head[1], from);
  this->Failed = Error{ static_cast<ErrorCode>(head[0]), message };
  return *this->Failed;
}

Error MpiTeam::Fail(const Error& error)
{
  return this->Agree(&error).GetError();
}

Status MpiTeam::Sum(std::span<std::uint64_t> numbers)
{
  Status status = this->Agree();
  if (status && !numbers.empty())
  {
    const std::vector<std::uint64_t> mine(numbers.begin(), numbers.end());
    this->Controller.AllReduce(
      mine.data(), numbers.data(), static_cast<vtkIdType>(mine.size()), vtkCommunicator::SUM_OP);
  }
  return status;
}

Status MpiTeam::Spread(std::vector<VertexId>& numbers)
{
  Status status = this->Agree();
  if (status)
  {
    auto count = static_cast<vtkIdType>(numbers.size());
    this->Controller.Broadcast(&count, 1, 0);
    numbers.resize(static_cast<std::size_t>(count));
    this->Controller.Broadcast(numbers.data(), count, 0);
  }
  return status;
}

Status MpiTeam::Share(std::span<std::byte> blocks, unsigned depth)
{
  Status status = this->Agree();
  if (!status)
  {
    return status;
  }
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
  if (!status)
  {
    return status;
  }
  std::vector<double> mine; // the upper ends negative, so that one minimum does for both
  for (const Box& box : boxes)
  {
    mine.insert(mine.end(), box.lo.begin(), box.lo.end());
    std::transform(
      box.hi.begin(), box.hi.end(), std::back_inserter(mine), [](double x) { return -x; });
  }
  std::vector<double> all(mine.size());
  this->Controller.AllReduce(
    mine.data(), all.data(), static_cast<vtkIdType>(mine.size()), vtkCommunicator::MIN_OP);
  for (std::size_t i = 0; i < boxes.size(); ++i)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      boxes[i].lo[k] = all[6 * i + k] + 0.0; // no -0.0
      boxes[i].hi[k] = -all[6 * i + 3 + k] + 0.0;
    }
  }
  return status;
}

Result<std::vector<std::uint64_t>> MpiTeam::Gather(std::uint64_t number)
{
  std::vector<std::uint64_t> numbers(this->Ranks, 0);
  numbers[this->Mine] = number;
  const Status status = this->Sum(numbers);
  return status ? Result<std::vector<std::uint64_t>>(std::move(numbers)) : status.GetError();
}

Result<std::uint64_t> MpiTeam::Most(std::uint64_t number)
{
  const Result<std::vector<std::uint64_t>> numbers = this->Gather(number);
  return numbers ? Result<std::uint64_t>(*std::max_element(numbers->begin(), numbers->end()))
                 : numbers.GetError();
}

Result<double> MpiTeam::AddInOrder(const std::function<Status(double& sum)>& add)
{
  if (Status status = this->Agree(); !status)
  {
    return status.GetError();
  }
  const int mine = static_cast<int>(this->Mine), last = static_cast<int>(this->Ranks) - 1;
  double sum = 0;
  if (mine > 0)
  {
    this->Controller.Receive(&sum, 1, mine - 1, tag);
  }
  const Status added = add(sum); // the others are not left to wait, whatever becomes of it
  if (mine < last)
  {
    this->Controller.Send(&sum, 1, mine + 1, tag);
  }
  this->Controller.Broadcast(&sum, 1, last);
  return added ? Result<double>(sum) : added.GetError();
}

Status MpiTeam::ExchangeBytes(const std::vector<std::span<const std::byte>>& out, const Room& room)
{
  std::vector<std::uint64_t> bytes(this->Ranks * this->Ranks, 0); // from × to
  for (std::size_t to = 0; to < this->Ranks; ++to)
  {
    bytes[this->Mine * this->Ranks + to] = out[to].size();
  }
  if (Status status = this->Sum(bytes); !status)
  {
    return status;
  }
  std::vector<vtkMPICommunicator::Request> requests;
  const auto forEachPart = [&](std::size_t size, const auto& carry)
  {
    for (std::size_t at = 0; at < size; at += mostAtOnce)
    {
      carry(at, static_cast<int>(std::min(mostAtOnce, size - at)), requests.emplace_back());
    }
  };
  for (std::size_t step = 0; step < this->Ranks; ++step)
  {
    const std::size_t from = (this->Mine + this->Ranks - step) % this->Ranks;
    const std::size_t size = bytes[from * this->Ranks + this->Mine];
    const std::span<std::byte> in = room(from, size);
    if (from == this->Mine)
    {
      std::copy(out[from].begin(), out[from].end(), in.begin());
      continue;
    }
    forEachPart(size,
      [&](std::size_t at, int length, vtkMPICommunicator::Request& request)
      {
        this->Controller.NoBlockReceive(
          Data(in.subspan(at)), length, static_cast<int>(from), tag, request);
      });
  }
  for (std::size_t step = 1; step < this->Ranks; ++step)
  {
    const std::size_t to = (this->Mine + step) % this->Ranks;
    forEachPart(out[to].size(),
      [&](std::size_t at, int length, vtkMPICommunicator::Request& request)
      {
        this->Controller.NoBlockSend(
          Data(out[to].subspan(at)), length, static_cast<int>(to), tag, request);
      });
  }
  for (vtkMPICommunicator::Request& request : requests)
  {
    request.Wait();
  }
  return {};
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
  const Result<std::uint64_t> all = this->Most(rounds);
  Status status = all ? Status{} : Status(all.GetError());
  for (std::uint64_t round = 0; status && round < *all; ++round)
  {
    RankLists<VertexId> some(this->Ranks);
    for (std::size_t rank = 0; rank < this->Ranks; ++rank)
    {
      const std::size_t first = std::min<std::size_t>(round * most, asked[rank].size());
      const std::size_t end = std::min(first + most, asked[rank].size());
      some[rank].assign(
        asked[rank].begin() + std::ptrdiff_t(first), asked[rank].begin() + std::ptrdiff_t(end));
    }
    status = this->FetchSome(file, elementBytes, some);
  }
  return status;
}

// wanted: of each rank, ascending.
Status MpiTeam::FetchSome(
  SpillFile& file, std::size_t elementBytes, const RankLists<VertexId>& wanted)
{
  const Result<RankLists<VertexId>> questions = this->Exchange(wanted);
  if (!questions)
  {
    return questions.GetError();
  }
  RankLists<std::byte> answers(this->Ranks);
  for (std::size_t rank = 0; rank < this->Ranks; ++rank)
  {
    answers[rank].resize((*questions)[rank].size() * elementBytes);
    if (Status status = ReadElementsAt(file, elementBytes, (*questions)[rank], answers[rank]);
        !status)
    {
      return status;
    }
  }
  const Result<RankLists<std::byte>> answered = this->Exchange(answers);
  if (!answered)
  {
    return answered.GetError();
  }
  Status status;
  for (std::size_t rank = 0; status && rank < this->Ranks; ++rank)
  {
    status = WriteElementsAt(file, elementBytes, wanted[rank], (*answered)[rank]);
  }
  return status;
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
  if (!questions)
  {
    return questions.GetError();
  }
  for (std::vector<VertexId>& list : *questions)
  {
    std::for_each(list.begin(), list.end(), [&](VertexId& entry) { entry -= begin[this->Mine]; });
    if (Status status = values.Look(list); !status)
    {
      return status.GetError();
    }
  }
  const Result<RankLists<VertexId>> answers = this->Exchange(*questions);
  if (!answers)
  {
    return answers.GetError();
  }
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
