// SPDX-License-Identifier: BSD-3-Clause
// The place of a tileset on the globe.
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
  double heading = 0;                 // degrees from north towards east: the direction of the
                                      // model's back
};

// Parses "LON,LAT,HEIGHT" or "LON,LAT,HEIGHT,HEADING": finite numbers; longitude and latitude must
// be valid.
std::optional<GlobePlace> ParseGlobePlace(const std::string& text);

// Whether the text is four whole numbers: then "13,05,47,8" may mean 13.05 and 47.8.
bool MayHaveDecimalCommas(const std::string& text);

// A matrix, column by column as in 3D Tiles. It maps coordinates in metres (x right, y back, z up)
// to geocentric ones.
using GlobeMatrix = std::array<double, 16>;
GlobeMatrix MatrixOfPlace(const GlobePlace& place);

}
