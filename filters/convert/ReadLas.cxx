// SPDX-License-Identifier: BSD-3-Clause
// Point clouds of laser scanners: LAS, compressed ones by LASzip. Step "convert" of the README's
// picture.
#include "filters/convert/BytesBehind.h"
#include "filters/convert/ForeignMesh.h"
#include "filters/convert/LasCloud.h"
#include "filters/convert/LasHeader.h"
#include "filters/convert/ReadLaz.h"
#include "filters/meshio/ByteSource.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace kdstream
{
namespace
{

template <class T>
T ReadAt(const char* point, std::size_t place)
{
  T value;
  std::memcpy(&value, point + place, sizeof(value));
  return value;
}

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
    constexpr std::size_t pointsAtOnce = 4096; // a block of them fits what Peek takes
    KDSTREAM_TRY(this->LookBehindPoints());
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
        return Error{ ErrorCode::InvalidInput,
          "was cut while it was read, at point " + std::to_string(done) };
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
  // What the header does not count.
  Status LookBehindPoints()
  {
    const std::uint64_t counted =
      this->Header.pointsBegin + this->Header.points * this->Header.pointBytes;
    const auto more = LookBehind(this->Source, counted, this->Header.pointsEnd,
      this->Header.pointBytes, this->Header.points, this->Cloud.Forgiven());
    KDSTREAM_TRY(more);
    this->Header.points += *more;
    return this->Header.points < noVertex
             ? Status()
             : Error{ ErrorCode::LimitExceeded,
                 std::to_string(this->Header.points) + " points are more than a model may have" };
  }

  void Add(const char* point)
  {
    LasPoint read;
    const bool isLong = this->Header.IsLong();
    const auto flags = ReadAt<std::uint8_t>(point, 15); // in short points with the class
    read.withheld = isLong ? (flags & 4U) != 0 : (flags & 128U) != 0;
    std::memcpy(read.place.data(), point, sizeof(read.place));
    read.intensity = ReadAt<std::uint16_t>(point, 12);
    read.returnNumber =
      static_cast<std::uint8_t>(ReadAt<std::uint8_t>(point, 14) & (isLong ? 15U : 7U));
    read.classification =
      isLong ? ReadAt<std::uint8_t>(point, 16) : static_cast<std::uint8_t>(flags & 31U);
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
    "laszip -i in.laz -o out.las" };
#endif
}

}
