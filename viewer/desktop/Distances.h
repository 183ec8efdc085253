// SPDX-License-Identifier: BSD-3-Clause
// Shows measured distances, in the window and in pictures: where they are drawn, and their text.
#pragma once

#include "viewer/session/tools/Measurement.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace kdstream
{

class ViewerSession;

// A distance, and where its ends are seen: pixels from the window's upper left corner; nothing for
// an end behind the eye.
struct SeenMeasurement
{
  Measurement measurement;
  std::optional<std::array<double, 2>> from, to;
};

std::vector<SeenMeasurement> SeenMeasurementsOf(const ViewerSession& session);

// Gives as many digits as are certain with this error; six digits if the error is 0.
std::string LengthText(double value, double error);
// Returns "3.2 mm"; without a unit, only the text.
std::string WithUnit(const std::string& text, const std::string& unit);
// The text beside a measurement's line.
std::string DistanceText(const Measurement& measurement, const std::string& unit);

}
