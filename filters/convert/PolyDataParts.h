// SPDX-License-Identifier: BSD-3-Clause
// A vtkPolyData as a mesh with its attributes: for all formats that are read through VTK.
#pragma once

#include "filters/convert/ForeignMesh.h"

#include <vtkPolyData.h>

namespace kdstream
{

// Points, triangles and all arrays, without ghosts (JoinPolyData); what cannot be carried becomes a
// warning. Errors: those of adapter's ReadMesh.
Result<ForeignMesh> ReadPolyData(vtkPolyData& input, const Execution& execution);

}
