// SPDX-License-Identifier: BSD-3-Clause
// Whether a model can be coloured as a command line or a session file asks for.
#pragma once

#include "filters/core/Result.h"
#include "viewer/session/appearance/Coloring.h"

namespace kdstream
{

// scalars: of the model. Errors: NotFound if the colours are by an array that the model does not
// have. The message lists the arrays, and suggests the nearest name, or says that arrays of faces,
// which the model may have, are not shown.
Status CheckColors(const ColorChoice& colors, const ScalarDescriptions& scalars);

}
