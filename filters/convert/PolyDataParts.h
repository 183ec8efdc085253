// SPDX-License-Identifier: BSD-3-Clause
// A vtkPolyData as a mesh with its attributes, and several meshes as one: for all formats that are
// read through VTK.
#pragma once

#include "filters/convert/ForeignMesh.h"

#include <vtkPolyData.h>

#include <span>

namespace kdstream
{

// Points, triangles and all arrays; what cannot be carried becomes a warning. Errors: those of
// adapter's ReadMesh.
Result<ForeignMesh> ReadPolyData(vtkPolyData& input, const Execution& execution);

// One mesh after the other. An attribute stays if all parts that have points have it with one type;
// where only some have colours, the others become white. What is dropped becomes a warning.
ForeignMesh JoinParts(std::span<ForeignMesh> parts);

}
