// SPDX-License-Identifier: BSD-3-Clause
// Reads point clouds of laser scanners: LAS, and compressed LAS by LASzip. Step "convert" of the
// pipeline picture.
#include "filters/convert/BytesAfter.h"
#include "filters/convert/ForeignMesh.h"
#include "filters/convert/LasCloud.h"
#include "filters/convert/LasHeader.h"
#include "filters/convert/PointAttributes.h"
#include "filters/convert/ReadLaz.h"
#include "filters/meshio/ByteSource.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace kdstream
{
namespace
{

class LasReader
{
public:
  LasReader(ByteSource& source, const LasHeader& header)
    : Source(source)
    , Header(header)
    , ColorPlace(header.ColorPlace())
    , Cloud(header)
  {
  }

  Result<ForeignMesh> Read(const Execution& execution)
  {
    constexpr std::size_t pointsAtOnce = 4096; // their bytes must fit into one Peek
    KDSTREAM_TRY(this->CheckBytesAfterPoints());
    this->Source.Seek(this->Header.pointsBegin);
    this->Cloud.Reserve(static_cast<std::size_t>(this->Header.points));
    const std::size_t atOnce = std::max<std::size_t>(
      1, std::min(pointsAtOnce, ByteSource::blockSize / this->Header.pointBytes));
    for (std::uint64_t done = 0; done < this->Header.points;)
    {
      const auto count =
        static_cast<std::size_t>(std::min<std::uint64_t>(atOnce, this->Header.points - done));
      const std::size_t bytes = count * this->Header.pointBytes;
      const auto view = this->Source.Peek(bytes);
      KDSTREAM_TRY(view);
      if (view->size() < bytes)
      {
        return BadInput(
          "became shorter while it was read, at point " + std::to_string(done), Remedy::Retry);
      }
      for (std::size_t i = 0; i < count; ++i)
      {
        this->Add(view->data() + i * this->Header.pointBytes);
      }
      this->Source.Consume(bytes);
      done += count;
      KDSTREAM_TRY(execution.Report("read", double(done) / double(this->Header.points)));
    }
    return this->Cloud.Finish();
  }

private:
  // Checks the bytes that the header does not count.
  Status CheckBytesAfterPoints()
  {
    const std::uint64_t counted =
      this->Header.pointsBegin + this->Header.points * this->Header.pointBytes;
    const auto more = CheckBytesAfter(this->Source, counted, this->Header.pointsEnd,
      this->Header.pointBytes, this->Header.points, this->Cloud.Forgiven(),
      [&](std::uint64_t points) { return this->MayBePoints(counted, points); });
    KDSTREAM_TRY(more);
    this->Header.points += *more;
    return CheckPointCount(this->Header.points);
  }

  // Whether bytes after the points, which the header does not count, may be points. If the header's
  // box is right for the counted points, all must be in the box. To find this out, the first and
  // the last of the counted points are checked. If the box is wrong, the bytes may be points.
  Result<bool> MayBePoints(std::uint64_t begin, std::uint64_t points)
  {
    const std::uint64_t bytes = this->Header.pointBytes;
    for (const std::uint64_t place : { this->Header.pointsBegin, begin - bytes })
    {
      const Result<bool> inBox = this->AreInBox(place, 1);
      KDSTREAM_TRY(inBox);
      if (!*inBox)
      {
        return true;
      }
    }
    return this->AreInBox(begin, points);
  }

  Result<bool> AreInBox(std::uint64_t begin, std::uint64_t points)
  {
    this->Source.Seek(begin);
    for (std::uint64_t i = 0; i < points; ++i)
    {
      const auto view = this->Source.Peek(this->Header.pointBytes);
      KDSTREAM_TRY(view);
      if (view->size() < this->Header.pointBytes)
      {
        return false;
      }
      for (std::size_t k = 0; k < 3; ++k)
      {
        const double step = this->Header.scale[k];
        const double value =
          LasNumberAt<std::int32_t>(view->data(), 4 * k) * step + this->Header.offset[k];
        if (!(value >= this->Header.box.lo[k] - std::abs(step) &&
              value <= this->Header.box.hi[k] + std::abs(step)))
        {
          return false;
        }
      }
      this->Source.Consume(this->Header.pointBytes);
    }
    return true;
  }

  void Add(const char* point)
  {
    LasPoint read;
    const bool isLong = this->Header.IsLong();
    const auto flags = LasNumberAt<std::uint8_t>(point, 15); // short points: beside the class
    read.withheld = isLong ? (flags & 4U) != 0 : !this->Header.isOldest && (flags & 128U) != 0;
    std::memcpy(read.place.data(), point, sizeof(read.place));
    read.intensity = LasNumberAt<std::uint16_t>(point, 12);
    read.returnNumber =
      static_cast<std::uint8_t>(LasNumberAt<std::uint8_t>(point, 14) & (isLong ? 15U : 7U));
    read.classification =
      isLong ? LasNumberAt<std::uint8_t>(point, 16)
             : static_cast<std::uint8_t>(this->Header.isOldest ? flags : flags & 31U);
    if (this->ColorPlace)
    {
      std::memcpy(read.color.data(), point + *this->ColorPlace, sizeof(read.color));
    }
    this->Cloud.Add(read);
  }

  ByteSource& Source;
  LasHeader Header;
  std::optional<std::size_t> ColorPlace;
  LasCloud Cloud;
};

}

Result<ForeignMesh> ReadLas(const std::filesystem::path& file, const Execution& execution)
{
  Result<ByteSource> source = ByteSource::Open(file);
  KDSTREAM_TRY(source);
  const auto begin = source->Peek(lasHeaderBytes);
  KDSTREAM_TRY(begin);
  const auto header = ParseLasHeader(begin->substr(0, lasHeaderBytes), source->Size());
  KDSTREAM_TRY(header);
  if (!header->compressed)
  {
    return LasReader(*source, *header).Read(execution);
  }
#ifdef KDSTREAM_HAS_LASZIP
  return ReadLaz(file, *header, execution);
#else
  return Error{ ErrorCode::Unsupported,
    "its points are compressed (LAZ), which is not read: make a .las of it, for example with "
    "laszip -i in.laz -o out.las",
    {}, {}, Remedy::InMessage };
#endif
}

}
