// SPDX-License-Identifier: BSD-3-Clause
#include "viewer/desktop/Distances.h"

#include "viewer/session/ViewerSession.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace kdstream
{

std::vector<SeenMeasurement> SeenMeasurementsOf(const ViewerSession& session)
{
  const auto pixel = [&](const MeasuredPoint& end)
  { return session.GetCamera().PixelOf(end.point); };
  std::vector<SeenMeasurement> seen;
  for (const Measurement& each : session.Measurements())
  {
    seen.push_back({ each, pixel(each.from), each.to ? pixel(*each.to) : std::nullopt });
  }
  return seen;
}

std::string LengthText(double value, double error)
{
  const double size = std::abs(value);
  const int digits =
    error > 0 ? static_cast<int>(std::ceil(std::log10(std::max(size, error) / error))) + 1 : 6;
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.*g", std::clamp(digits, 1, 9), value);
  return text.data();
}

std::string WithUnit(const std::string& text, const std::string& unit)
{
  return unit.empty() ? text : text + " " + unit;
}

std::string DistanceText(const Measurement& measurement, const std::string& unit)
{
  return WithUnit(LengthText(measurement.Distance(), measurement.Error()), unit);
}

}
