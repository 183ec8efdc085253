// SPDX-License-Identifier: BSD-3-Clause
#include "filters/tiles/GlobePlace.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <vector>

namespace kdstream
{

std::optional<GlobePlace> ParseGlobePlace(const std::string& text)
{
  std::vector<double> numbers;
  const char* at = text.data();
  const char* const end = at + text.size();
  for (;;)
  {
    double number = 0;
    const auto read = std::from_chars(at, end, number);
    if (read.ec != std::errc() || !std::isfinite(number))
    {
      return {};
    }
    numbers.push_back(number);
    if (read.ptr == end)
    {
      break;
    }
    if (*read.ptr != ',')
    {
      return {};
    }
    at = read.ptr + 1;
  }
  if (numbers.size() < 3 || numbers.size() > 4 || std::abs(numbers[0]) > 180 ||
      std::abs(numbers[1]) > 90)
  {
    return {};
  }
  numbers.resize(4, 0.0);
  return GlobePlace{ numbers[0], numbers[1], numbers[2], numbers[3] };
}

bool MayHaveDecimalCommas(const std::string& text)
{
  return std::count(text.begin(), text.end(), ',') == 3 && text.find('.') == std::string::npos &&
         ParseGlobePlace(text);
}

// Computed with the ellipsoid of WGS 84: the frame of east, north and up at the place, rotated by
// the heading.
GlobeMatrix MatrixOfPlace(const GlobePlace& place)
{
  constexpr double equator = 6378137, flattening = 1 / 298.257223563;
  constexpr double eccentricity = flattening * (2 - flattening); // squared
  constexpr double degree = 3.14159265358979323846 / 180;
  const double sinLon = std::sin(place.longitude * degree);
  const double cosLon = std::cos(place.longitude * degree);
  const double sinLat = std::sin(place.latitude * degree);
  const double cosLat = std::cos(place.latitude * degree);
  const double radius = equator / std::sqrt(1 - eccentricity * sinLat * sinLat);
  const Vec3 east{ -sinLon, cosLon, 0 };
  const Vec3 north{ -sinLat * cosLon, -sinLat * sinLon, cosLat };
  const Vec3 up{ cosLat * cosLon, cosLat * sinLon, sinLat };
  const Vec3 at{ (radius + place.height) * cosLat * cosLon,
    (radius + place.height) * cosLat * sinLon,
    (radius * (1 - eccentricity) + place.height) * sinLat };
  const double sinHeading = std::sin(place.heading * degree);
  const double cosHeading = std::cos(place.heading * degree);
  GlobeMatrix matrix{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    matrix[k] = cosHeading * east[k] - sinHeading * north[k];
    matrix[4 + k] = sinHeading * east[k] + cosHeading * north[k];
    matrix[8 + k] = up[k];
    matrix[12 + k] = at[k];
  }
  matrix[15] = 1;
  return matrix;
}

}
