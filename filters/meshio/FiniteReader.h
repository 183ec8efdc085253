// SPDX-License-Identifier: BSD-3-Clause
// Wraps the readers of all formats: drops points that are not finite, and the faces that use them.
// Part of step "read".
#pragma once

#include "filters/meshio/MeshReader.h"

#include <filesystem>
#include <memory>
#include <string>

namespace kdstream
{

// Reads from `reader`, which may give points that are not finite, and passes on only finite ones,
// as MeshReader.h promises; errors name the file. scratch: as for MeshReader::Open. Memory: about 2
// MiB, and only after a point was dropped (DroppedPoints.h).
std::unique_ptr<MeshReader> WithFinitePoints(
  std::unique_ptr<MeshReader> reader, std::string file, const std::filesystem::path& scratch = {});

}
