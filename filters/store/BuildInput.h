// The first step of a build: a file becomes a mesh in memory that a store can hold. Step "read" of
// the README's picture.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/meshio/MeshReader.h"
#include "filters/store/Builder.h"

namespace kdstream
{

// Reads all there is. Stops as soon as options.memory does not allow what has been read, or what
// the header claims in a file that is large enough for it. Errors: those of MeshReader,
// LimitExceeded, Cancelled.
Result<Mesh> ReadMesh(
  MeshReader& reader, const BuildOptions& options, const Execution& execution = {});

// Puts point arrays first, as pieces have them. Errors: InvalidInput where the mesh has no vertices
// or an attribute that no store can hold (CheckAttributes, IsAttributeName).
Status PrepareMesh(Mesh& mesh);

}
