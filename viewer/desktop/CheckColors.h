// SPDX-License-Identifier: BSD-3-Clause
// Whether a model can be coloured as a command line or a session file asks for.
#pragma once

#include "filters/core/Result.h"
#include "viewer/session/look/Coloring.h"

namespace kdstream
{

// scalars: of the model. Errors: NotFound where the colours are by an array that it has not: with
// those that it has, and the nearest of them; or else that arrays of faces are not shown, which it
// may have.
Status CheckColors(const ColorChoice& colors, const ScalarDescriptions& scalars);

}
