// SPDX-License-Identifier: BSD-3-Clause
#include "filters/Parallel/ShareDigest.h"

#include "filters/build/InputDigest.h"

#include <algorithm>

namespace kdstream
{
namespace
{

// Adds the data of one rank to the digest, on rank 0.
Status AddOf(
  std::size_t rank, std::span<const std::byte> values, MpiGroup& group, ByteDigest& digest)
{
  const auto own = group.Rank() == rank ? values : std::span<const std::byte>();
  const auto make = [&](std::uint64_t round, RankLists<std::byte>& out) -> Status
  {
    const auto left = own.subspan(static_cast<std::size_t>(round) * roundBytes);
    const auto part = left.first(std::min(roundBytes, left.size()));
    out[0].assign(part.begin(), part.end());
    return {};
  };
  const auto take = [&](std::size_t, std::span<const std::byte> bytes) -> Status
  {
    digest.Add(bytes);
    return {};
  };
  return group.ExchangeInRounds<std::byte>(RoundsOf(own.size(), roundBytes), make, take);
}

}

Result<std::string> DigestOfShares(MpiGroup& group, const Mesh& share)
{
  ByteDigest digest;
  const auto add = [&](std::span<const std::byte> head, std::span<const std::byte> values,
                     std::size_t size) -> Status
  {
    std::uint64_t count = values.size() / size;
    KDSTREAM_TRY(group.Sum(std::span(&count, 1)));
    digest.Add(head);
    digest.AddNumber(count);
    for (std::size_t rank = 0; rank < group.Count(); ++rank)
    {
      KDSTREAM_TRY(AddOf(rank, values, group, digest));
    }
    return {};
  };
  KDSTREAM_TRY(ForEachDigested(share, add));
  return digest.Text();
}

}
