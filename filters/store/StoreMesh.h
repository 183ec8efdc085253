// SPDX-License-Identifier: BSD-3-Clause
// Meshes out of a store, or of what a server has of one: any cut drawn as one surface, or
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
// pieces have. Reads the pieces it needs, each once. Errors: those of CheckCut and ReadPieces.
Result<Mesh> DrawStoreMesh(
  const PieceSource& store, const Cut& cut, const Execution& execution = {});
// The same as a surface, which tells of each vertex where it comes from.
Result<Surface> DrawStoreSurface(
  const PieceSource& store, const Cut& cut, const Execution& execution = {});

// The same of a resolution with some pieces in it that are shown whole, and what lies between
// (MakeClosure). REQUIRES: pieces of this store.
Result<Mesh> DrawStorePieces(const PieceSource& store, Resolution base,
  std::span<const PieceId> wanted, const Execution& execution = {});

// The original mesh of some partitions (GluePartitions). Errors: those of ReadPieces and
// GluePartitions. REQUIRES: partitions below Info().partitions.
Result<Mesh> GlueStoreMesh(const PieceSource& store, std::span<const std::uint32_t> partitions,
  const Execution& execution = {});

// Appends the vertices that no triangle uses (Store::ReadUnused) to the mesh of all partitions, or
// to one with some of its point arrays: so a lossless original is whole. Errors: those of
// ReadUnused; LimitExceeded for more vertices than a mesh has.
Status AddUnused(const Store& store, Mesh& mesh);

}
