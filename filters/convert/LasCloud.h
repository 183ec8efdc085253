// SPDX-License-Identifier: BSD-3-Clause
// Turns the points of a .las or .laz file, one by one, into a cloud.
#pragma once

#include "filters/convert/ForeignMesh.h"
#include "filters/convert/LasHeader.h"
#include "filters/convert/PointAttributes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

namespace kdstream
{

struct LasPoint
{
  std::array<std::int32_t, 3> place{};
  std::array<std::uint16_t, 3> color{};
  std::uint16_t intensity = 0;
  std::uint8_t returnNumber = 0, classification = 0;
  bool withheld = false;
};

class LasCloud
{
public:
  explicit LasCloud(const LasHeader& header)
    : Header(header)
    , HasColors(header.ColorPlace().has_value())
  {
  }

  void Reserve(std::size_t points)
  {
    this->Points.reserve(points);
    this->Intensities.reserve(points);
    this->Classes.reserve(points);
    this->Returns.reserve(points);
    this->Colors.reserve(this->HasColors ? points : 0);
  }

  void Add(const LasPoint& point)
  {
    ++this->Added;
    if (point.withheld)
    {
      this->Output.tolerance.Count(
        Lapse::PointWithheld, 1, "point " + std::to_string(this->Added - 1));
      return;
    }
    Vec3& place = this->Points.emplace_back();
    for (std::size_t k = 0; k < 3; ++k)
    {
      place[k] = point.place[k] * this->Header.scale[k] + this->Header.offset[k];
    }
    this->Intensities.push_back(point.intensity);
    this->Returns.push_back(point.returnNumber);
    this->Classes.push_back(point.classification);
    if (this->HasColors)
    {
      this->Colors.push_back(point.color);
      for (const std::uint16_t channel : point.color)
      {
        this->DimChannels += channel > 0 && channel <= 255 ? 1 : 0;
        this->BrightChannels += channel > 255 ? 1 : 0;
      }
    }
  }

  // The warnings about the file.
  Tolerance& Forgiven() { return this->Output.tolerance; }

  // Errors: InvalidInput if no point is left.
  Result<ForeignMesh> Finish()
  {
    if (this->Points.empty())
    {
      return Error{ ErrorCode::InvalidInput, "all of its points are marked as withheld" };
    }
    ForeignMesh result = std::move(this->Output);
    result.mesh.scalarType = ScalarType::Float64;
    this->CheckBox(result);
    result.mesh.points = std::move(this->Points);
    if (this->DimChannels + this->BrightChannels > 0)
    {
      this->AddColors(result);
    }
    this->AddArray(result, "intensity", AttributeType::UInt16, this->Intensities);
    this->AddArray(result, "classification", AttributeType::UInt8, this->Classes);
    this->AddArray(result, "return_number", AttributeType::UInt8, this->Returns);
    if (this->Header.extraBytes > 0)
    {
      result.tolerance.Tell(
        "each point has " + std::to_string(this->Header.extraBytes) +
        " bytes after its format's fields (extra dimensions), which are left out");
    }
    return result;
  }

private:
  // The header's box is not used. But where it does not hold the points, its scale or offset may be
  // wrong as well. Many programs leave a box of zeros.
  void CheckBox(ForeignMesh& result) const
  {
    const Box& box = this->Header.box;
    if (box.lo == box.hi && box.lo == Vec3{})
    {
      return;
    }
    const auto isOutside = [this, &box](const Vec3& point)
    {
      bool outside = false;
      for (std::size_t k = 0; k < 3; ++k)
      {
        const double most = 2 * std::abs(this->Header.scale[k]); // some boxes are rounded
        outside = outside || point[k] < box.lo[k] - most || point[k] > box.hi[k] + most;
      }
      return outside;
    };
    const auto outside = std::count_if(this->Points.begin(), this->Points.end(), isOutside);
    if (outside > 0)
    {
      result.tolerance.Tell(
        std::to_string(outside) + " of " + std::to_string(this->Points.size()) +
        " points are outside of the box that the header states: if its scale or "
        "offset is wrong as well, so are the coordinates");
    }
  }

  // Adds an array, unless all its values are the same.
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

  // LAS colours have 16 bits a channel, but many writers store 8-bit values. The majority of the
  // channels that are not 0 decides.
  void AddColors(ForeignMesh& result)
  {
    const bool eightBits = this->DimChannels > this->BrightChannels;
    if (eightBits && this->BrightChannels > 0)
    {
      result.tolerance.Tell("colours are read as 8-bit values, because most channels are: " +
                            std::to_string(this->BrightChannels) + " of " +
                            std::to_string(this->DimChannels + this->BrightChannels) +
                            " are above 255 and count as 255");
    }
    else if (!eightBits && this->DimChannels > this->BrightChannels / 8)
    {
      result.tolerance.Tell("colours are read as 16-bit values, because most channels are: " +
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

  LasHeader Header;
  bool HasColors;
  std::vector<Vec3> Points;
  std::vector<std::uint16_t> Intensities;
  std::vector<std::uint8_t> Classes, Returns;
  std::vector<std::array<std::uint16_t, 3>> Colors;
  ForeignMesh Output;
  std::uint64_t DimChannels = 0, BrightChannels = 0; // up to 255, and above 255
  std::uint64_t Added = 0;
};

}
