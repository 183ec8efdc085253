// SPDX-License-Identifier: BSD-3-Clause
// Makes meshes from a store, or from a part that a server has sent: any cut as one surface, or
// partitions glued together. Step "draw" of the pipeline picture, without a viewer.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/core/drawing/Surface.h"
#include "filters/store/PieceSource.h"
#include "filters/store/Store.h"

#include <cstdint>
#include <span>

namespace kdstream
{

// The surface of a cut of the store's vertex tree (DrawSurface), with the attributes that all its
// pieces have. Reads each piece that it needs once. Errors: those of CheckCut and ReadPieces.
Result<Mesh> DrawStoreMesh(
  const PieceSource& store, const Cut& cut, const Execution& execution = {});
// The same as a Surface, which also has the source of each vertex.
Result<Surface> DrawStoreSurface(
  const PieceSource& store, const Cut& cut, const Execution& execution = {});

// The surface of a base resolution and of some pieces that are shown whole, with the triangles that
// connect them (MakeClosure). REQUIRES: pieces of this store.
Result<Mesh> DrawStorePieces(const PieceSource& store, Resolution base,
  std::span<const PieceId> wanted, const Execution& execution = {});

// The original mesh of some partitions (GluePartitions). Errors: those of ReadPieces and
// GluePartitions. REQUIRES: partitions below Info().partitions.
Result<Mesh> GlueStoreMesh(const PieceSource& store, std::span<const std::uint32_t> partitions,
  const Execution& execution = {});

// Appends the vertices that no triangle uses (Store::ReadUnused) to a mesh of all partitions. The
// mesh may have only some of the point arrays. So a lossless original is complete. Errors: those of
// ReadUnused; LimitExceeded for more vertices than a mesh can have.
Status AddUnused(const Store& store, Mesh& mesh);

}
