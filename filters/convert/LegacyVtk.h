// SPDX-License-Identifier: BSD-3-Clause
// Where a legacy .vtk file is damaged: VTK's reader says that it is, but seldom where. Part of step
// "convert".
#pragma once

#include <filesystem>
#include <string>

namespace kdstream
{

// The first part that is not as its header says, for a message: "POINTS (line 5) has 20 of its 24
// numbers, then 'POLYGONS' (line 12)"; of a list of cells which cell. Places in binary files are
// bytes. Empty where nothing was found, or the file cannot be read. Goes through the file once, in
// the memory of a block.
std::string DamagedPartOfVtk(const std::filesystem::path& file);

}
