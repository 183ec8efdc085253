// SPDX-License-Identifier: BSD-3-Clause
// Translates messages of VTK's readers about a file into ours: which element, where, what is wrong.
// Part of step "convert" of the pipeline picture.
#pragma once

#include "filters/core/Result.h"

#include <filesystem>
#include <span>
#include <string>

namespace kdstream
{

// What is wrong with an XML file, chosen from the messages of VTK's reader (VtkMessages.h): the
// first that names a place, as "Polys of piece 0 (line 12): its array 'offsets' has fewer numbers
// than the piece counts". If none does: that VTK cannot read it. Line numbers are found only in the
// first 64 MiB.
std::string XmlDamage(std::span<const std::string> errors, const std::filesystem::path& file);

// InvalidInput. part: what is wrong with which part.
Error DamagedVtk(const std::string& part);

// A warning of VTK's readers; empty for those that say nothing about the mesh.
std::string VtkWarning(const std::string& warning);

}
