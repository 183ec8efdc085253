// SPDX-License-Identifier: BSD-3-Clause
// Formats of which a library makes floats, whatever decimals the file has: telling what that costs.
#pragma once

#include "filters/convert/ForeignMesh.h"

namespace kdstream
{

// To be called where coordinates were read as floats. Adds a warning if neighbouring floats at the
// largest coordinate are farther apart than a millionth of the longest side of the bounding box: of
// georeferenced coordinates the digits behind the point are lost. O(points).
void WarnOfFloats(ForeignMesh& read);

}
