// SPDX-License-Identifier: BSD-3-Clause
// The results that the phases of a build out of core leave for later ones, as bytes and files.
#pragma once

#include "filters/build/Builder.h"
#include "filters/meshio/Tolerance.h"
#include "filters/outofcore/journal/BuildFolder.h"
#include "filters/outofcore/levels/ExternalLevels.h"
#include "filters/outofcore/pieces/ExternalNumbers.h"

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace kdstream
{

// Facts of the mesh after welding.
struct MeshFacts
{
  std::uint32_t vertices = 0, triangles = 0; // without unused vertices
  std::uint32_t unused = 0;                  // vertices that no triangle uses, in separate files
  std::uint64_t welded = 0;
  std::size_t pointTupleBytes = 0, cellTupleBytes = 0;
  ScalarType scalarType = ScalarType::Float32;
  bool floats = true;                    // whether floats hold every coordinate exactly
  bool weld = true;                      // whether equal vertices were joined
  std::vector<AttributeInfo> attributes; // point arrays first
  std::vector<std::string> ignored;      // arrays of the input
  Tolerance tolerance;                   // of reading the input
};

void Save(BlobWriter& blob, const MeshFacts& facts);
// Missing values are read as zeros; BlobReader::Finish reports them.
MeshFacts LoadMeshFacts(BlobReader& blob);

// Saves values in the blob, and appends files to the list.
void Save(BlobWriter& blob, std::vector<PhaseFile>& files, ExternalLevels&& levels);
// Errors: Damaged; those of TakeFile.
Result<ExternalLevels> LoadExternalLevels(
  BlobReader& blob, const BuildFolder& folder, std::string_view phase);

void Save(BlobWriter& blob, std::vector<PhaseFile>& files, ExternalNumbers&& numbers);
// Errors: Damaged; those of TakeFile.
Result<ExternalNumbers> LoadExternalNumbers(
  BlobReader& blob, const BuildFolder& folder, std::string_view phase);

// All options that determine the content of the files or the store: their names on the command
// line, and their values. An option that is not given has an empty value.
std::vector<std::pair<std::string, std::string>> DescribeOptions(const BuildOptions& options);

}
