// SPDX-License-Identifier: BSD-3-Clause
// The texts of a legend, in the window and in pictures.
#pragma once

#include "viewer/session/appearance/ColorLegend.h"

#include <string>

namespace kdstream
{

// Six digits at most.
std::string NumberText(double value);
// "2 ground, 1,800,000".
std::string ClassText(const ColorLegend::Class& each);

}
