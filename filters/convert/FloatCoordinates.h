// SPDX-License-Identifier: BSD-3-Clause
// Formats of which a library makes floats, whatever decimals the file has: telling what that costs.
#pragma once

#include "filters/convert/ForeignMesh.h"

#include <optional>

namespace kdstream
{

// Whether neighbouring floats at the largest coordinate are farther apart than a millionth of the
// longest side of the bounding box.
bool FloatsAreCoarse(double largest, double side);

// Call this where coordinates were read as floats. Adds a warning if neighbouring floats at the
// largest coordinate are farther apart than a millionth of the longest side of the bounding box;
// then georeferenced coordinates have lost digits after the decimal point. O(points). largestRead:
// the largest coordinate as it was read, if the mesh's differ.
void WarnOfFloats(ForeignMesh& read, std::optional<double> largestRead = {});

}
