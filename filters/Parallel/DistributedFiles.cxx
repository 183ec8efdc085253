// SPDX-License-Identifier: BSD-3-Clause
#include "filters/Parallel/DistributedFiles.h"

#include "filters/outofcore/files/ScatteredRead.h"

#include <algorithm>
#include <utility>

namespace kdstream
{
namespace
{

// The vertices to request from each other rank, ascending.
RankLists<VertexId> ListsToAsk(
  const MpiGroup& group, std::span<const std::uint64_t> places, std::span<const VertexId> wanted)
{
  std::vector<VertexId> sorted(wanted.begin(), wanted.end());
  std::sort(sorted.begin(), sorted.end());
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  RankLists<VertexId> asked(group.Count());
  for (std::size_t rank = 0, i = 0; rank < group.Count(); ++rank)
  {
    for (; i < sorted.size() && sorted[i] < places[rank + 1]; ++i)
    {
      if (rank != group.Rank())
      {
        asked[rank].push_back(sorted[i]);
      }
    }
  }
  return asked;
}

// One round: exchanges questions with the other ranks, then the answers. wanted: for each other
// rank, ascending. Returns whether any rank wants more.
Result<bool> FetchRound(MpiGroup& group, SpillFile& file, std::size_t elementBytes,
  const RankLists<VertexId>& wanted, bool more)
{
  RankLists<VertexId> questions(group.Count());
  const Result<bool> anyMore = group.ExchangeOthers(wanted, questions, more);
  KDSTREAM_TRY(anyMore);
  RankLists<std::byte> answers(group.Count()), answered(group.Count());
  for (std::size_t rank = 0; rank < group.Count(); ++rank)
  {
    answers[rank].resize(questions[rank].size() * elementBytes);
    KDSTREAM_TRY(ReadElementsAt(file, elementBytes, questions[rank], answers[rank]));
  }
  KDSTREAM_TRY(group.ExchangeOthers(answers, answered, false));
  for (std::size_t rank = 0; rank < group.Count(); ++rank)
  {
    KDSTREAM_TRY(WriteElementsAt(file, elementBytes, wanted[rank], answered[rank]));
  }
  return anyMore;
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
    KDSTREAM_TRY(file.Write(std::uint64_t{ places[i] } * elementBytes,
      elements.subspan(i * elementBytes, (end - i) * elementBytes)));
    i = end;
  }
  return {};
}

Status FetchElements(MpiGroup& group, SpillFile& file, std::size_t elementBytes,
  std::span<const std::uint64_t> places, std::span<const VertexId> wanted)
{
  const RankLists<VertexId> asked = ListsToAsk(group, places, wanted);
  const std::size_t most = ElementsOfRound(elementBytes);
  std::uint64_t rounds = 0;
  for (const std::vector<VertexId>& list : asked)
  {
    rounds = std::max(rounds, RoundsOf(list.size(), most));
  }
  bool more = true;
  for (std::uint64_t round = 0; more; ++round)
  {
    RankLists<VertexId> some(group.Count());
    for (std::size_t rank = 0; rank < group.Count(); ++rank)
    {
      const std::size_t first = std::min<std::size_t>(round * most, asked[rank].size());
      const std::size_t end = std::min(first + most, asked[rank].size());
      some[rank].assign(
        asked[rank].begin() + std::ptrdiff_t(first), asked[rank].begin() + std::ptrdiff_t(end));
    }
    const Result<bool> anyMore = FetchRound(group, file, elementBytes, some, round + 1 < rounds);
    KDSTREAM_TRY(anyMore);
    more = *anyMore;
  }
  return {};
}

Status MoveElements(MpiGroup& group, SpillFile& file, std::size_t elementBytes,
  std::span<const std::uint64_t> before, std::span<const std::uint64_t> after)
{
  const std::size_t here = group.Rank(), ranks = group.Count();
  // The part of the file that moves from one rank to another: its offset, and its number of bytes.
  const auto common = [&](std::size_t from, std::size_t to)
  {
    const std::uint64_t begin = std::max(before[from], after[to]);
    const std::uint64_t end = std::max(begin, std::min(before[from + 1], after[to + 1]));
    return std::pair(begin * elementBytes, (end - begin) * elementBytes);
  };
  std::uint64_t rounds = 0; // of this rank; each part begins with round 0
  for (std::size_t to = 0; to < ranks; ++to)
  {
    const std::uint64_t bytes = to == here ? 0 : common(here, to).second;
    rounds = std::max(rounds, RoundsOf(bytes, roundBytes));
  }
  const auto make = [&](std::uint64_t round, RankLists<std::byte>& out) -> Status
  {
    for (std::size_t to = 0; to < ranks; ++to)
    {
      const auto [begin, bytes] = common(here, to);
      const std::uint64_t at = round * roundBytes;
      if (to != here && at < bytes)
      {
        out[to].resize(static_cast<std::size_t>(std::min<std::uint64_t>(roundBytes, bytes - at)));
        KDSTREAM_TRY(file.Read(begin + at, out[to]));
      }
    }
    return {};
  };
  std::vector<std::uint64_t> written(ranks, 0);
  const auto take = [&](std::size_t from, std::span<const std::byte> bytes)
  {
    const std::uint64_t at = common(from, here).first + written[from];
    written[from] += bytes.size();
    return file.Write(at, bytes);
  };
  return group.ExchangeInRounds<std::byte>(rounds, make, take);
}

std::size_t RankOfEntry(std::span<const VertexId> begin, VertexId entry)
{
  // The last rank that begins at or before the entry. Ranks before it that begin at the same entry
  // are empty.
  const auto following = std::upper_bound(begin.begin(), begin.end() - 1, entry);
  return static_cast<std::size_t>(following - begin.begin() - 1);
}

Result<std::vector<VertexId>> LookUpEntries(MpiGroup& group, std::span<const VertexId> begin,
  const NumberTable& values, std::span<const VertexId> wanted)
{
  RankLists<VertexId> asked(group.Count());
  std::vector<std::uint32_t> rankOf;
  rankOf.reserve(wanted.size());
  for (const VertexId entry : wanted)
  {
    rankOf.push_back(static_cast<std::uint32_t>(RankOfEntry(begin, entry)));
    asked[rankOf.back()].push_back(entry);
  }
  Result<RankLists<VertexId>> questions = group.Exchange(asked);
  KDSTREAM_TRY(questions);
  for (std::vector<VertexId>& list : *questions)
  {
    std::for_each(list.begin(), list.end(), [&](VertexId& entry) { entry -= begin[group.Rank()]; });
    KDSTREAM_TRY(values.Look(list));
  }
  const Result<RankLists<VertexId>> answers = group.Exchange(*questions);
  KDSTREAM_TRY(answers);
  std::vector<std::size_t> next(group.Count(), 0);
  std::vector<VertexId> found;
  found.reserve(wanted.size());
  for (const std::uint32_t rank : rankOf)
  {
    found.push_back((*answers)[rank][next[rank]++]);
  }
  return found;
}

}
