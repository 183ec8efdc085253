// SPDX-License-Identifier: BSD-3-Clause
#include "filters/adapter/RankGroup.h"

#include <vtkCommunicator.h>
#include <vtkMultiProcessController.h>

#include <algorithm>

namespace kdstream
{
namespace
{

constexpr int messageTag = 8107;
static_assert(messageTag <= 32767, "MPI promises no greater tags (MPI_TAG_UB)");
constexpr std::size_t mostAtOnce = std::size_t{ 1 } << 28; // bytes: MPI counts in ints

Error Broken()
{
  return { ErrorCode::InputOutput, "the ranks could not tell each other how far they are" };
}

}

RankGroup::RankGroup(vtkMultiProcessController& controller)
  : Controller(controller)
  , Own(static_cast<std::size_t>(controller.GetLocalProcessId()))
  , Ranks(static_cast<std::size_t>(controller.GetNumberOfProcesses()))
{
}

Status RankGroup::Agree(const Status& own) const
{
  const auto failed = this->Gather(own ? 0 : 1 + static_cast<std::uint64_t>(own.GetError().code));
  KDSTREAM_TRY(failed);
  const auto first =
    std::find_if(failed->begin(), failed->end(), [](std::uint64_t code) { return code != 0; });
  if (first == failed->end())
  {
    return {};
  }
  const auto rank = static_cast<std::size_t>(first - failed->begin());
  std::string text = rank == this->Own
                       ? "rank " + std::to_string(rank) + ": " + own.GetError().message
                       : std::string();
  long long length = static_cast<long long>(text.size());
  this->Controller.Broadcast(&length, 1, static_cast<int>(rank));
  text.resize(static_cast<std::size_t>(length));
  this->Controller.Broadcast(text.data(), length, static_cast<int>(rank));
  return Error{ static_cast<ErrorCode>(*first - 1), text };
}

Status RankGroup::Sum(std::span<std::uint64_t> numbers) const
{
  static_assert(sizeof(long long) == sizeof(std::uint64_t));
  std::vector<long long> own(numbers.begin(), numbers.end()), all(numbers.size());
  const auto count = static_cast<vtkIdType>(own.size());
  if (!this->Controller.AllReduce(own.data(), all.data(), count, vtkCommunicator::SUM_OP))
  {
    return Broken();
  }
  std::copy(all.begin(), all.end(), numbers.begin());
  return {};
}

Status RankGroup::Join(std::span<Box> boxes) const
{
  const auto join = [&](Vec3 Box::*corner, int operation)
  {
    std::vector<double> own, all(3 * boxes.size());
    for (const Box& box : boxes)
    {
      own.insert(own.end(), (box.*corner).begin(), (box.*corner).end());
    }
    const auto count = static_cast<vtkIdType>(own.size());
    const bool done = this->Controller.AllReduce(own.data(), all.data(), count, operation) != 0;
    for (std::size_t i = 0; i < all.size(); ++i)
    {
      (boxes[i / 3].*corner)[i % 3] = all[i];
    }
    return done;
  };
  return join(&Box::lo, vtkCommunicator::MIN_OP) && join(&Box::hi, vtkCommunicator::MAX_OP)
           ? Status()
           : Status(Broken());
}

Result<std::vector<std::uint64_t>> RankGroup::Gather(std::uint64_t number) const
{
  const auto own = static_cast<long long>(number);
  std::vector<long long> all(this->Ranks);
  if (!this->Controller.AllGather(&own, all.data(), 1))
  {
    return Broken();
  }
  return std::vector<std::uint64_t>(all.begin(), all.end());
}

// Pair by pair, in the same order on all ranks, the lower rank first: so nobody waits for who
// waits.
Result<std::vector<RankGroup::Bytes>> RankGroup::Exchange(std::vector<Bytes> out) const
{
  std::vector<Bytes> in(this->Ranks);
  in[this->Own] = std::move(out[this->Own]);
  bool done = true;
  const auto send = [&](std::size_t to)
  {
    const auto size = static_cast<long long>(out[to].size());
    done = done && this->Controller.Send(&size, 1, static_cast<int>(to), messageTag) &&
           this->Send(out[to], to);
    out[to] = {};
  };
  const auto receive = [&](std::size_t from)
  {
    long long size = 0;
    done = done && this->Controller.Receive(&size, 1, static_cast<int>(from), messageTag);
    in[from].resize(static_cast<std::size_t>(done ? size : 0));
    done = done && this->Receive(in[from], from);
  };
  for (std::size_t low = 0; low < this->Ranks; ++low)
  {
    for (std::size_t high = low + 1; high < this->Ranks; ++high)
    {
      if (this->Own == low)
      {
        send(high);
        receive(high);
      }
      else if (this->Own == high)
      {
        receive(low);
        send(low);
      }
    }
  }
  return done ? Result<std::vector<Bytes>>(std::move(in)) : Broken();
}

bool RankGroup::Send(std::span<const unsigned char> bytes, std::size_t to) const
{
  for (std::size_t at = 0; at < bytes.size(); at += mostAtOnce)
  {
    const std::size_t count = std::min(mostAtOnce, bytes.size() - at);
    if (!this->Controller.Send(
          bytes.data() + at, static_cast<vtkIdType>(count), static_cast<int>(to), messageTag))
    {
      return false;
    }
  }
  return true;
}

bool RankGroup::Receive(std::span<unsigned char> bytes, std::size_t from) const
{
  for (std::size_t at = 0; at < bytes.size(); at += mostAtOnce)
  {
    const std::size_t count = std::min(mostAtOnce, bytes.size() - at);
    if (!this->Controller.Receive(
          bytes.data() + at, static_cast<vtkIdType>(count), static_cast<int>(from), messageTag))
    {
      return false;
    }
  }
  return true;
}

}
