// SPDX-License-Identifier: BSD-3-Clause
#include "filters/store/GeometricErrorList.h"

#include "filters/core/BitCast.h"
#include "filters/core/SystemReason.h"
#include "filters/files/Folders.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <utility>

namespace kdstream
{
namespace
{

// The bits of a float that one pass distinguishes.
constexpr unsigned digits = 16;

Error CannotPutAside(const std::filesystem::path& folder)
{
  return SystemError(
    "deviations cannot be written to a temporary file in " + folder.string(), errno);
}

// The bits of a number that is not negative. They are in the same order as the numbers.
std::uint32_t BitsOf(float geometricError)
{
  return BitCast<std::uint32_t>(geometricError + 0.0F); // no -0.0
}

}

GeometricErrorList::GeometricErrorList(std::filesystem::path folder, std::size_t inMemory)
  : Folder(std::move(folder))
  , InMemory(std::max<std::size_t>(1, inMemory))
{
}

GeometricErrorList::~GeometricErrorList()
{
  if (this->File >= 0)
  {
    ::close(this->File);
  }
}

Status GeometricErrorList::Add(std::span<const float> geometricErrors)
{
  while (!geometricErrors.empty())
  {
    if (this->Last.size() == this->InMemory)
    {
      KDSTREAM_TRY(this->Flush());
    }
    const std::size_t count = std::min(geometricErrors.size(), this->InMemory - this->Last.size());
    this->Last.insert(
      this->Last.end(), geometricErrors.begin(), geometricErrors.begin() + std::ptrdiff_t(count));
    geometricErrors = geometricErrors.subspan(count);
  }
  return {};
}

Status GeometricErrorList::Flush()
{
  if (this->File < 0 && (this->File = OpenNameless(this->Folder)) < 0)
  {
    return CannotPutAside(this->Folder);
  }
  std::span<const std::byte> bytes = std::as_bytes(std::span(this->Last));
  std::uint64_t at = this->InFile * sizeof(float);
  while (!bytes.empty())
  {
    const ssize_t written =
      ::pwrite(this->File, bytes.data(), bytes.size(), static_cast<off_t>(at));
    if (written <= 0 && errno != EINTR)
    {
      return CannotPutAside(this->Folder);
    }
    const auto done = static_cast<std::size_t>(std::max<ssize_t>(0, written));
    bytes = bytes.subspan(done);
    at += done;
  }
  this->InFile += this->Last.size();
  this->Last.clear();
  return {};
}

// Calls visit(bits) for all geometric errors.
template <class Visit>
Status GeometricErrorList::ForEach(const Visit& visit) const
{
  std::vector<float> block(std::min<std::uint64_t>(this->InFile, std::uint64_t{ 1 } << 16));
  for (std::uint64_t at = 0; at < this->InFile;)
  {
    const std::size_t wanted = std::min<std::uint64_t>(block.size(), this->InFile - at);
    const ssize_t read = ::pread(
      this->File, block.data(), wanted * sizeof(float), static_cast<off_t>(at * sizeof(float)));
    if (read < 0 && errno == EINTR)
    {
      continue;
    }
    const std::size_t count = read < 0 ? 0 : static_cast<std::size_t>(read) / sizeof(float);
    if (count == 0)
    {
      return CannotPutAside(this->Folder);
    }
    for (std::size_t i = 0; i < count; ++i)
    {
      visit(BitsOf(block[i]));
    }
    at += count;
  }
  for (const float geometricError : this->Last)
  {
    visit(BitsOf(geometricError));
  }
  return {};
}

Result<GeometricErrorList::Summary> GeometricErrorList::Finish()
{
  const std::uint64_t all = this->InFile + this->Last.size();
  if (all == 0)
  {
    return Summary{};
  }
  std::vector<std::uint64_t> bins(std::size_t{ 1 } << digits, 0);
  std::uint32_t largest = 0;
  KDSTREAM_TRY(this->ForEach(
    [&](std::uint32_t bits)
    {
      ++bins[bits >> digits];
      largest = std::max(largest, bits);
    }));
  // How many values come before the wanted one: first of all, then of its bin.
  std::uint64_t rest = (all - 1) * 99 / 100;
  const auto find = [&]
  {
    std::uint32_t bin = 0;
    while (rest >= bins[bin])
    {
      rest -= bins[bin++];
    }
    return bin;
  };
  const std::uint32_t upper = find();
  std::fill(bins.begin(), bins.end(), 0);
  KDSTREAM_TRY(this->ForEach([&](std::uint32_t bits)
    { bins[bits & (bins.size() - 1)] += (bits >> digits) == upper ? 1 : 0; }));
  const std::uint32_t lower = find();
  this->Last.clear();
  this->InFile = 0;
  return Summary{ BitCast<float>(upper << digits | lower), BitCast<float>(largest) };
}

}
