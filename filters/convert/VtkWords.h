// SPDX-License-Identifier: BSD-3-Clause
// What VTK's readers say of a file, in our words: which element, where, what is wrong. Part of step
// "convert" of the pipeline picture.
#pragma once

#include <filesystem>
#include <span>
#include <string>

namespace kdstream
{

// What is wrong with an XML file, of all that VTK's reader said (VtkMessages.h): the first that
// names a place; "Polys of piece 0 (line 12): its array 'offsets' has fewer numbers than the piece
// counts". Where none is known: that VTK cannot read it. Lines are sought in the first 64 MiB.
std::string XmlDamage(std::span<const std::string> errors, const std::filesystem::path& file);

// A warning of VTK's readers; empty for those that tell nothing about the mesh.
std::string VtkWarning(const std::string& warning);

}
