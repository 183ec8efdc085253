// SPDX-License-Identifier: BSD-3-Clause
#include "filters/Parallel/MpiGroup.h"

#include "filters/Parallel/DistributedFiles.h"
#include "filters/core/BitCast.h"

#include <algorithm>
#include <functional>

namespace kdstream
{

MpiGroup::MpiGroup(RankMessages& messages)
  : RankGroup(messages)
  , Nodes(messages.Count())
{
}

MpiGroup::~MpiGroup() = default;

Status MpiGroup::Spread(std::vector<VertexId>& numbers)
{
  const auto counts = this->Gather(numbers.size());
  KDSTREAM_TRY(counts);
  KDSTREAM_TRY(
    this->AgreeOnRoom([&] { numbers.resize(static_cast<std::size_t>(counts->front())); }));
  Collective([&] { this->Messages.PassDown(std::as_writable_bytes(std::span(numbers))); });
  return {};
}

Status MpiGroup::Fetch(SpillFile& file, std::size_t elementBytes, std::span<const VertexId> begin,
  unsigned depth, std::span<const VertexId> wanted)
{
  return FetchElements(*this, file, elementBytes, this->Nodes.PlacesOf(begin, depth), wanted);
}

Status MpiGroup::Share(std::span<std::byte> blocks, unsigned depth)
{
  const std::size_t bytes = blocks.size() >> depth;
  std::vector<std::size_t> offsets, lengths;
  for (std::size_t rank = 0; rank < this->Count(); ++rank)
  {
    const BlockRange range = this->Nodes.BlocksOf(rank, depth);
    offsets.push_back(range.begin * bytes);
    lengths.push_back((range.end - range.begin) * bytes);
  }
  std::vector<std::byte> mine;
  KDSTREAM_TRY(this->AgreeOnRoom(
    [&]
    {
      const auto part = blocks.subspan(offsets[this->Rank()], lengths[this->Rank()]);
      mine.assign(part.begin(), part.end());
    }));
  Collective([&] { this->Messages.GatherParts(blocks, offsets, lengths, mine); });
  return {};
}

Result<std::uint64_t> MpiGroup::Most(std::uint64_t number)
{
  const Result<std::vector<std::uint64_t>> numbers = this->Gather(number);
  KDSTREAM_TRY(numbers);
  return *std::max_element(numbers->begin(), numbers->end());
}

Result<double> MpiGroup::AddInOrder(const std::function<Status(double& sum)>& add)
{
  KDSTREAM_TRY(this->AgreeOn());
  double sum = 0;
  const std::span<double> one(&sum, 1);
  if (!this->IsFirst())
  {
    Collective([&] { this->Messages.Receive(this->Rank() - 1, std::as_writable_bytes(one)); });
  }
  Status added;
  try
  {
    added = add(sum);
  }
  catch (...)
  {
    added = CaughtError();
  }
  if (this->Rank() + 1 < this->Count()) // otherwise the next rank would wait for ever
  {
    Collective([&] { this->Messages.Send(this->Rank() + 1, std::as_bytes(one)); });
  }
  KDSTREAM_TRY(added);
  const auto bits = BitCast<std::uint64_t>(sum);
  KDSTREAM_TRY(this->AgreeOn(std::span(&bits, 1)));
  return BitCast<double>(this->Received(this->Count() - 1, 0));
}

}
