// SPDX-License-Identifier: BSD-3-Clause
// Reads a mesh file in chunks into spill files: step "read" of building out of core.
#pragma once

#include "filters/core/Attribute.h"
#include "filters/core/Execution.h"
#include "filters/core/Types.h"
#include "filters/meshio/MeshReader.h"
#include "filters/outofcore/files/SpillFile.h"
#include "filters/outofcore/mesh/ExternalWeld.h"
#include "filters/outofcore/mesh/VertexMap.h"

#include <cstdint>
#include <vector>

namespace kdstream
{

// A mesh in files: vertices by id, triangles by number.
struct SpilledMesh
{
  VertexFiles vertices;
  std::uint32_t triangleCount = 0;
  SpillFile triangles;  // NumberedTriangle, corners are ids
  SpillFile cellTuples; // the cell tuples of each triangle; closed if there are none
  std::size_t cellTupleBytes = 0;
  ScalarType scalarType = ScalarType::Float32;
  std::vector<AttributeInfo> attributes; // point arrays first, as their tuples are
  bool fitFloats = true;                 // whether floats hold every coordinate exactly
};

// Reads the rest of a reader's file. Peak memory: a few chunks of about chunkBytes, for any file;
// more only if a single face needs more. Errors: those of the reader; InvalidInput for no vertices,
// or for an array that no mesh can have (CheckAttributes); LimitExceeded for more than 2^32 - 2
// vertices or triangles; InputOutput; Cancelled. part: whether this is only a part of a mesh; a
// part may have no vertices.
Result<SpilledMesh> SpillMesh(SpillFolder& folder, MeshReader& reader, std::size_t chunkBytes,
  const Execution& execution = {}, bool part = false);

// The same for a mesh in memory, or for a part of one. A part may have no vertices, and its corners
// may be numbers of vertices in other parts. Memory: a copy of its arrays, and 16 bytes a triangle.
// Errors: as above, without those of a reader.
Result<SpilledMesh> SpillMesh(SpillFolder& folder, const Mesh& mesh);

}
