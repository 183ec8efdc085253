// SPDX-License-Identifier: BSD-3-Clause
// Shows measured distances: where they are drawn, and their text; in the window and in pictures.
#pragma once

#include "viewer/session/tools/Measurement.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace kdstream
{

class ViewerSession;

// A distance, and the pixels of its ends, from the window's upper left corner; nothing for an end
// behind the eye.
struct SeenMeasurement
{
  Measurement measurement;
  std::optional<std::array<double, 2>> from, to;
};

std::vector<SeenMeasurement> SeenMeasurementsOf(const ViewerSession& session);

// As many digits as the error leaves, six where there is none.
std::string LengthText(double value, double error);
// "3.2 mm"; without a unit only the text.
std::string WithUnit(const std::string& text, const std::string& unit);
// The text beside a measurement's line.
std::string DistanceText(const Measurement& measurement, const std::string& unit);

}
