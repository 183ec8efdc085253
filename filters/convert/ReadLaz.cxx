// SPDX-License-Identifier: BSD-3-Clause
// Reads point clouds of laser scanners in compressed LAS, by LASzip. Step "convert" of the pipeline
// picture.
#include "filters/convert/ReadLaz.h"

#include "filters/convert/LasCloud.h"

#include <laszip/laszip_api.h>

#include <algorithm>

namespace kdstream
{
namespace
{

class LazReader
{
public:
  explicit LazReader(const LasHeader& header)
    : Header(header)
    , Cloud(header)
  {
  }
  ~LazReader()
  {
    if (this->Laszip)
    {
      laszip_close_reader(this->Laszip);
      laszip_destroy(this->Laszip);
    }
  }
  LazReader(const LazReader&) = delete;
  LazReader& operator=(const LazReader&) = delete;

  Result<ForeignMesh> Read(const std::filesystem::path& file, const Execution& execution)
  {
    constexpr std::uint64_t pointsPerReport = 1 << 16;
    laszip_BOOL compressed = 0;
    laszip_point_struct* point = nullptr;
    if (laszip_create(&this->Laszip) != 0 ||
        laszip_open_reader(this->Laszip, file.c_str(), &compressed) != 0 ||
        laszip_get_point_pointer(this->Laszip, &point) != 0)
    {
      return BadInput("it cannot be decompressed", Remedy::CopyAgain);
    }
    for (std::uint64_t i = 0; i < this->Header.points; ++i)
    {
      if (laszip_read_point(this->Laszip) != 0)
      {
        return BadInput("truncated or damaged: point " + std::to_string(i) + " of " +
                          std::to_string(this->Header.points) + " cannot be decompressed",
          Remedy::CopyAgain);
      }
      this->Add(*point);
      if (i % pointsPerReport == 0)
      {
        KDSTREAM_TRY(execution.Report("read", double(i) / double(this->Header.points)));
      }
    }
    return this->Cloud.Finish();
  }

private:
  void Add(const laszip_point_struct& point)
  {
    const bool isLong = this->Header.IsLong();
    LasPoint read;
    read.place = { point.X, point.Y, point.Z };
    read.color = { point.rgb[0], point.rgb[1], point.rgb[2] };
    read.intensity = point.intensity;
    read.returnNumber = isLong ? point.extended_return_number : point.return_number;
    read.classification = isLong ? point.extended_classification : point.classification;
    read.withheld =
      isLong ? (point.extended_classification_flags & 4U) != 0 : point.withheld_flag != 0;
    if (this->Header.isOldest)
    {
      read.classification =
        static_cast<std::uint8_t>(point.classification | point.synthetic_flag << 5U |
                                  point.keypoint_flag << 6U | point.withheld_flag << 7U);
      read.withheld = false;
    }
    this->Cloud.Add(read);
  }

  LasHeader Header;
  LasCloud Cloud;
  laszip_POINTER Laszip = nullptr;
};

}

Result<ForeignMesh> ReadLaz(
  const std::filesystem::path& file, const LasHeader& header, const Execution& execution)
{
  return LazReader(header).Read(file, execution);
}

}
