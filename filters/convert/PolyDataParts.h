// SPDX-License-Identifier: BSD-3-Clause
// Turns a vtkPolyData into a mesh with its attributes, for all formats that are read through VTK.
#pragma once

#include "filters/convert/ForeignMesh.h"

#include <vtkPolyData.h>

namespace kdstream
{

// Points, triangles and all arrays, without ghosts (JoinPolyData); a warning lists what cannot be
// carried. Errors: those of adapter's ReadMesh.
Result<ForeignMesh> ReadPolyData(vtkPolyData& input, const Execution& execution);

}
