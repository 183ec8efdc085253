// SPDX-License-Identifier: BSD-3-Clause
// Reads elements of a spill file at ascending places, many of them close together; each page is
// read once.
#pragma once

#include "filters/outofcore/files/RecordFile.h"
#include "filters/outofcore/files/SpillFile.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace kdstream
{

inline constexpr std::size_t scatteredPageBytes = std::size_t{ 1 } << 13;

// Reads the elements at `places` (ascending), each of `elementBytes`, into `out`, one after the
// other. O(places); memory: one page. Errors: those of SpillFile. REQUIRES: out.size() ==
// places.size() × elementBytes.
inline Status ReadElementsAt(const SpillFile& file, std::size_t elementBytes,
  std::span<const VertexId> places, std::span<std::byte> out)
{
  const std::uint64_t perPage = std::max<std::size_t>(1, scatteredPageBytes / elementBytes);
  const std::uint64_t count = file.Size() / elementBytes;
  std::vector<std::byte> page;
  std::uint64_t first = 0, end = 0; // bytes of the page
  for (std::size_t i = 0; i < places.size(); ++i)
  {
    if (places[i] >= end)
    {
      first = places[i] / perPage * perPage;
      end =
        std::max<std::uint64_t>(std::min(count, first + perPage), places[i] + std::uint64_t{ 1 });
      page.resize(static_cast<std::size_t>((end - first) * elementBytes));
      KDSTREAM_TRY(file.Read(first * elementBytes, page));
    }
    std::memcpy(out.data() + i * elementBytes, page.data() + (places[i] - first) * elementBytes,
      elementBytes);
  }
  return {};
}

template <SpillRecord Record>
Status ReadRecordsAt(const SpillFile& file, std::span<const VertexId> places, std::span<Record> out)
{
  return ReadElementsAt(file, sizeof(Record), places, std::as_writable_bytes(out));
}

}
