// SPDX-License-Identifier: BSD-3-Clause
// Checks whether a model can be coloured as a command line or a session file asks for.
#pragma once

#include "filters/core/Result.h"
#include "viewer/session/appearance/Coloring.h"

namespace kdstream
{

// scalars: the model's arrays. Errors: NotFound if the colours are those of an array that the model
// does not have. The message lists the model's arrays. It suggests the nearest name or, if no name
// is near, says that arrays of faces cannot be shown.
Status CheckColors(const ColorChoice& colors, const ScalarDescriptions& scalars);

}
