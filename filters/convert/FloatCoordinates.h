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

// To be called where coordinates were read as floats. Adds a warning if neighbouring floats at the
// largest coordinate are farther apart than a millionth of the longest side of the bounding box: of
// georeferenced coordinates the digits after the decimal point are lost. O(points).
// largestRead: of the coordinates as they were read, where those of the mesh are others.
void WarnOfFloats(ForeignMesh& read, std::optional<double> largestRead = {});

}
