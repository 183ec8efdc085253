// SPDX-License-Identifier: BSD-3-Clause
// Translates messages of VTK's readers about a file into ours: which element is wrong, where, and
// in what way. Part of step "convert" of the pipeline picture.
#pragma once

#include "filters/core/Result.h"

#include <filesystem>
#include <span>
#include <string>

namespace kdstream
{

// Says what is wrong with an XML file, from the messages of VTK's reader (VtkMessages.h). Chooses
// the first that names a place, as in "Polys of piece 0 (line 12): its array 'offsets' has fewer
// numbers than the piece counts". If none names a place, says that VTK cannot read the file. Line
// numbers are found only in the first 64 MiB.
std::string XmlDamage(std::span<const std::string> errors, const std::filesystem::path& file);

// An error InvalidInput. part: which part is wrong, and in what way.
Error DamagedVtk(const std::string& part);

// Translates a warning of VTK's readers; empty for warnings that do not concern the mesh.
std::string VtkWarning(const std::string& warning);

}
