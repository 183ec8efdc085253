// SPDX-License-Identifier: BSD-3-Clause
// For formats whose library turns all decimals into floats: warns of the precision that is lost.
#pragma once

#include "filters/convert/ForeignMesh.h"

#include <optional>

namespace kdstream
{

// Whether floats are coarse: at the largest coordinate, neighbouring floats are farther apart than
// a millionth of the longest side of the bounding box.
bool FloatsAreCoarse(double largest, double side);

// Call this after coordinates were read as floats. Adds a warning if floats are coarse (see above):
// georeferenced coordinates have then lost digits after the decimal point. O(points). largestRead:
// the largest coordinate as it was read, if the mesh's coordinates differ from these.
void WarnOfFloats(ForeignMesh& read, std::optional<double> largestRead = {});

}
