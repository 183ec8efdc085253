// SPDX-License-Identifier: BSD-3-Clause
// What every reader of a format is wrapped in: points that are not finite go, with their faces.
// Part of step "read".
#pragma once

#include "filters/meshio/MeshReader.h"

#include <filesystem>
#include <memory>
#include <string>

namespace kdstream
{

// Gives of what `reader` gives, which may have points that are not finite, only what is finite, as
// MeshReader.h promises; errors name the file. scratch: as for MeshReader::Open. Memory: some 2
// MiB, and those only once a point was dropped (DroppedPoints.h).
std::unique_ptr<MeshReader> WithFinitePoints(
  std::unique_ptr<MeshReader> reader, std::string file, const std::filesystem::path& scratch = {});

}
