// SPDX-License-Identifier: BSD-3-Clause
// Where a tileset stands on the globe.
#pragma once

#include "filters/core/Types.h"

#include <array>
#include <optional>
#include <string>

namespace kdstream
{

struct GlobePlace
{
  double longitude = 0, latitude = 0; // degrees, WGS 84
  double height = 0;                  // metres above the ellipsoid
  double heading = 0;                 // degrees from north to east: where the model's back looks
};

// "LON,LAT,HEIGHT" or "LON,LAT,HEIGHT,HEADING": finite numbers, the first two of the globe.
std::optional<GlobePlace> ParseGlobePlace(const std::string& text);

// Whether that is four whole numbers: "13,05,47,8" may be 13.05 and 47.8.
bool MayHaveDecimalCommas(const std::string& text);

// Column by column, as 3D Tiles has it: from coordinates in metres whose x is right, y back and z
// up to geocentric ones.
using GlobeMatrix = std::array<double, 16>;
GlobeMatrix MatrixOfPlace(const GlobePlace& place);

}
