// SPDX-License-Identifier: BSD-3-Clause
// Point clouds of laser scanners: uncompressed LAS. Step "convert" of the README's picture.
#include "filters/convert/BytesBehind.h"
#include "filters/convert/ForeignMesh.h"
#include "filters/convert/LasHeader.h"
#include "filters/convert/PointAttributes.h"
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
  {
  }

  Result<ForeignMesh> Read(const Execution& execution)
  {
    constexpr std::size_t pointsAtOnce = 4096; // a block of them fits what Peek takes
    KDSTREAM_TRY(this->LookBehindPoints());
    this->Source.Seek(this->Header.pointsBegin);
    this->Reserve(static_cast<std::size_t>(this->Header.points));
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
    return this->Finish();
  }

private:
  // What the header does not count.
  Status LookBehindPoints()
  {
    const std::uint64_t counted =
      this->Header.pointsBegin + this->Header.points * this->Header.pointBytes;
    const auto more = LookBehind(this->Source, counted, this->Header.pointsEnd,
      this->Header.pointBytes, this->Header.points, this->Output.tolerance);
    KDSTREAM_TRY(more);
    this->Header.points += *more;
    return this->Header.points < noVertex
             ? Status()
             : Error{ ErrorCode::LimitExceeded,
                 std::to_string(this->Header.points) + " points are more than a model may have" };
  }

  void Reserve(std::size_t points)
  {
    this->Points.reserve(points);
    this->Intensities.reserve(points);
    this->Classes.reserve(points);
    this->Returns.reserve(points);
    this->Colors.reserve(this->ColorPlace ? points : 0);
  }

  void Add(const char* point)
  {
    const bool isLong = this->Header.IsLong();
    const auto flags = ReadAt<std::uint8_t>(point, 15); // in short points with the class
    if (isLong ? (flags & 4U) != 0 : (flags & 128U) != 0)
    {
      ++this->Withheld;
      return;
    }
    Vec3& place = this->Points.emplace_back();
    for (std::size_t k = 0; k < 3; ++k)
    {
      place[k] =
        ReadAt<std::int32_t>(point, 4 * k) * this->Header.scale[k] + this->Header.offset[k];
    }
    this->Intensities.push_back(ReadAt<std::uint16_t>(point, 12));
    this->Returns.push_back(
      static_cast<std::uint8_t>(ReadAt<std::uint8_t>(point, 14) & (isLong ? 15U : 7U)));
    this->Classes.push_back(
      isLong ? ReadAt<std::uint8_t>(point, 16) : static_cast<std::uint8_t>(flags & 31U));
    if (this->ColorPlace)
    {
      auto& color = this->Colors.emplace_back();
      std::memcpy(color.data(), point + *this->ColorPlace, sizeof(color));
      for (const std::uint16_t channel : color)
      {
        this->DimChannels += channel > 0 && channel <= 255 ? 1 : 0;
        this->BrightChannels += channel > 255 ? 1 : 0;
      }
    }
  }

  // An array that says nothing, one value for all, is left out.
  template <class T>
  void AddArray(
    ForeignMesh& result, const char* name, AttributeType type, const std::vector<T>& values)
  {
    if (std::adjacent_find(values.begin(), values.end(), std::not_equal_to<>()) == values.end())
    {
      return;
    }
    Attribute& array =
      result.mesh.attributes.emplace_back(MakePointAttribute(name, type, 1, values.size()));
    std::memcpy(array.values.data(), values.data(), array.values.size());
  }

  Result<ForeignMesh> Finish()
  {
    if (this->Points.empty())
    {
      return Error{ ErrorCode::InvalidInput, "all of its points are marked as withheld" };
    }
    ForeignMesh result = std::move(this->Output);
    result.mesh.scalarType = ScalarType::Float64;
    result.mesh.points = std::move(this->Points);
    if (this->DimChannels + this->BrightChannels > 0)
    {
      this->AddColors(result);
    }
    this->AddArray(result, "intensity", AttributeType::UInt16, this->Intensities);
    this->AddArray(result, "classification", AttributeType::UInt8, this->Classes);
    this->AddArray(result, "return_number", AttributeType::UInt8, this->Returns);
    if (this->Withheld > 0)
    {
      result.warnings.push_back(
        std::to_string(this->Withheld) + (this->Withheld == 1
                                             ? " point is marked as withheld and was dropped"
                                             : " points are marked as withheld and were dropped"));
    }
    return result;
  }

  // 16 bits a channel; but many writers put 8 bits into them: most of the channels that are not 0
  // decide.
  void AddColors(ForeignMesh& result)
  {
    const bool eightBits = this->DimChannels > this->BrightChannels;
    if (eightBits && this->BrightChannels > 0)
    {
      result.tolerance.Tell("colours are read as of 8 bits, as most of their channels are: " +
                            std::to_string(this->BrightChannels) + " of " +
                            std::to_string(this->DimChannels + this->BrightChannels) +
                            " are above 255 and count as 255");
    }
    else if (!eightBits && this->DimChannels > this->BrightChannels / 8)
    {
      result.tolerance.Tell("colours are read as of 16 bits, as most of their channels are: " +
                            std::to_string(this->DimChannels) + " of " +
                            std::to_string(this->DimChannels + this->BrightChannels) +
                            " would fit 8 bits and become black");
    }
    Attribute& colors = result.mesh.attributes.emplace_back(MakeColors(this->Colors.size()));
    auto out = colors.values.begin();
    for (const auto& color : this->Colors)
    {
      out = std::transform(color.begin(), color.end(), out,
        [eightBits](std::uint16_t channel)
        {
          return static_cast<std::uint8_t>(
            eightBits ? std::min<std::uint16_t>(channel, 255) : channel >> 8U);
        });
    }
  }

  ByteSource& Source;
  LasHeader Header;
  std::optional<std::size_t> ColorPlace;
  std::vector<Vec3> Points;
  std::vector<std::uint16_t> Intensities;
  std::vector<std::uint8_t> Classes, Returns;
  std::vector<std::array<std::uint16_t, 3>> Colors;
  ForeignMesh Output;
  std::uint64_t DimChannels = 0, BrightChannels = 0; // to 255, and above
  std::uint64_t Withheld = 0;
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
  return LasReader(*source, *header).Read(execution);
}

}
