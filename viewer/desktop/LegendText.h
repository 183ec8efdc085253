// SPDX-License-Identifier: BSD-3-Clause
// The texts of a legend, in the window and in pictures.
#pragma once

#include "viewer/session/appearance/ColorLegend.h"

#include <string>

namespace kdstream
{

// Gives at most six digits.
std::string NumberText(double value);
// Returns "2 ground, 1,800,000": a class's value, its name and its number of vertices.
std::string ClassText(const ColorLegend::Class& each);

}
