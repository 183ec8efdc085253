// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/LasHeader.h"

#include "filters/convert/PointAttributes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace kdstream
{
namespace
{

// Bytes of a point for formats from 0 on; files may add further bytes.
constexpr std::array<std::size_t, 11> leastPointBytes{ 20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67 };

Error Wrong(const std::string& what, Remedy remedy = Remedy::Unknown)
{
  return BadInput(what, remedy);
}

// How many points the header claims. Version 1.4 has a separate number for this, which counts
// unless it is 0.
std::uint64_t ClaimedPoints(std::string_view begin, unsigned minor)
{
  const std::uint64_t many = minor >= 4 ? LasNumberAt<std::uint64_t>(begin.data(), 247) : 0;
  return many > 0 ? many : LasNumberAt<std::uint32_t>(begin.data(), 107);
}

Status TakePlacement(std::string_view begin, LasHeader& header)
{
  for (std::size_t k = 0; k < 3; ++k)
  {
    header.scale[k] = LasNumberAt<double>(begin.data(), 131 + 8 * k);
    header.offset[k] = LasNumberAt<double>(begin.data(), 155 + 8 * k);
    header.box.hi[k] = LasNumberAt<double>(begin.data(), 179 + 16 * k);
    header.box.lo[k] = LasNumberAt<double>(begin.data(), 187 + 16 * k);
    // These are multiplied and added; the results must stay finite for every point.
    const bool isFinite = std::isfinite(header.scale[k] * 4294967296.0) &&
                          std::isfinite(header.offset[k]) && header.scale[k] != 0;
    if (!isFinite)
    {
      return Wrong(
        std::string("the scale or the offset of ") + "xyz"[k] + " is not a usable number");
    }
  }
  return {};
}

// Where the data after the points begin, if the header names any: waves (1.3), or variable-length
// records after the points (1.4).
std::uint64_t EndOfPoints(
  std::string_view begin, unsigned minor, std::uint64_t pointsBegin, std::uint64_t fileSize)
{
  std::uint64_t end = fileSize;
  const auto endAt = [&](std::uint64_t place)
  { end = place >= pointsBegin ? std::min(end, place) : end; };
  if (minor >= 3 && begin.size() >= 235)
  {
    endAt(LasNumberAt<std::uint64_t>(begin.data(), 227));
  }
  if (minor >= 4 && LasNumberAt<std::uint32_t>(begin.data(), 243) > 0)
  {
    endAt(LasNumberAt<std::uint64_t>(begin.data(), 235));
  }
  return end;
}

// Finds where the points are, and checks that the file has them all.
Status TakePoints(std::string_view begin, unsigned minor, std::uint64_t fileSize, LasHeader& header)
{
  header.pointsBegin = LasNumberAt<std::uint32_t>(begin.data(), 96);
  header.pointBytes = LasNumberAt<std::uint16_t>(begin.data(), 105);
  header.points = ClaimedPoints(begin, minor);
  if (header.pointBytes < leastPointBytes[header.format])
  {
    return Wrong("a point of format " + std::to_string(header.format) + " takes " +
                 std::to_string(leastPointBytes[header.format]) + " bytes, not " +
                 std::to_string(header.pointBytes));
  }
  header.extraBytes = header.pointBytes - leastPointBytes[header.format];
  if (header.pointsBegin < LasNumberAt<std::uint16_t>(begin.data(), 94) ||
      header.pointsBegin > fileSize)
  {
    return Wrong("its points begin at byte " + std::to_string(header.pointsBegin) +
                 ", in the header or after the end of the file");
  }
  if (header.compressed)
  {
    return header.points == 0 ? Status(Wrong("its header counts no points"))
                              : CheckPointCount(header.points);
  }
  const std::uint64_t held = (fileSize - header.pointsBegin) / header.pointBytes;
  if (header.points > held)
  {
    return Wrong("truncated: the header claims " + std::to_string(header.points) +
                   " points, but the file holds " + std::to_string(held),
      Remedy::CopyAgain);
  }
  header.pointsEnd = std::max(header.pointsBegin + header.points * header.pointBytes,
    EndOfPoints(begin, minor, header.pointsBegin, fileSize));
  const std::uint64_t most = (header.pointsEnd - header.pointsBegin) / header.pointBytes;
  if (header.points == 0)
  {
    return most == 0
             ? Wrong("has no points")
             : Wrong("its header counts no points, but the file holds " + std::to_string(most) +
                       " after it: the program that wrote it did not finish; repair the "
                       "header, for example with lasinfo -repair",
                 Remedy::InMessage);
  }
  return CheckPointCount(header.points);
}

}

std::optional<std::size_t> LasHeader::ColorPlace() const
{
  switch (this->format)
  {
    case 2:
      return 20;
    case 3:
    case 5:
      return 28;
    case 7:
    case 8:
    case 10:
      return 30;
    default:
      return {};
  }
}

Result<LasHeader> ParseLasHeader(std::string_view begin, std::uint64_t fileSize)
{
  if (!begin.starts_with("LASF"))
  {
    return Wrong("is not a LAS file", Remedy::Rename);
  }
  constexpr std::size_t oldest = 227; // bytes of a header of version 1.0
  if (begin.size() < oldest)
  {
    return Wrong("truncated: ends inside its header", Remedy::CopyAgain);
  }
  const unsigned major = LasNumberAt<std::uint8_t>(begin.data(), 24),
                 minor = LasNumberAt<std::uint8_t>(begin.data(), 25);
  if (major != 1 || minor > 4)
  {
    return Error{ ErrorCode::Unsupported, "has version " + std::to_string(major) + "." +
                                            std::to_string(minor) +
                                            " of LAS; versions 1.0 to 1.4 can be read" };
  }
  if (minor == 4 && begin.size() < lasHeaderBytes)
  {
    return Wrong("truncated: ends inside its header", Remedy::CopyAgain);
  }
  LasHeader header;
  const unsigned format = LasNumberAt<std::uint8_t>(begin.data(), 104);
  header.format = format & 63U;
  header.compressed = format != header.format; // LAZ sets the two highest bits
  header.isOldest = minor == 0;
  if (header.format >= leastPointBytes.size())
  {
    return Error{ ErrorCode::Unsupported,
      "its points have format " + std::to_string(header.format) + "; formats 0 to 10 can be read" };
  }
  KDSTREAM_TRY(TakePlacement(begin, header));
  KDSTREAM_TRY(TakePoints(begin, minor, fileSize, header));
  return header;
}

}
