// SPDX-License-Identifier: BSD-3-Clause
// Attributes that tell points or cells apart.
#pragma once

#include "filters/core/Attribute.h"

namespace kdstream
{

// Whether the values are ids, as VTK's attributes GlobalIds and PedigreeIds: named so, integers of
// one component. Levels have none: what they tell apart is one there. No scalars (IsScalar).
bool HoldsIds(const AttributeInfo& attribute);

}
