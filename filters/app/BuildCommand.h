// SPDX-License-Identifier: BSD-3-Clause
// The command line of the programs that build stores: kdstream-build and kdstream-build-mpi.
#pragma once

#include "filters/build/Builder.h"
#include "filters/program/Program.h"
#include "filters/texture/BakeTextures.h"
#include "filters/texture/MakeTile.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

struct BuildCommand
{
  std::string input, output, stats, reconstruct;
  BuildOptions build;
  std::uint32_t partitions = 0;
  std::string partitioner = "kdtree", maker = "collapse", representative = "quadric", sheets = "on",
              weld = "on";
  std::string precision = "20", median = "auto";
  unsigned threads = 0;
  bool quiet = false;
  std::string columns; // of an .xyz
  std::string textures = "on", textureQuality = "90";
  std::uint64_t texturePixels = mostPicturePixels;
  TileOptions tiles{}; // by Interpret, as are the next two
  bool qualityGiven = false, pixelsGiven = false;

  // Whether kdstream-convert reads the input: set by ChooseReader.
  bool converts = false;
  std::optional<BakeReport> baked{}; // what became of its pictures
  std::optional<TileCounts> tiled{}; // and of them in the original

  // Whether the original keeps its pictures, if there are any.
  bool WantsTiles() const { return this->textures == "on" || this->textures == "tiles"; }
};

// All options; `line` takes what is given. Keeps a reference to it.
void AddBuildOptions(CLI::App& app, BuildCommand& line);

// Fills in line.build from what was parsed. Errors: InvalidArgument.
Status Interpret(const CLI::App& app, BuildCommand& line);

// Sets line.converts: for foreign formats, for surfaces of point clouds, and for meshes that
// pictures paint, unless --textures is off. Returns warnings of pictures, a sentence each.
std::vector<std::string> ChooseReader(BuildCommand& line);

// A note before kdstream-convert reads a textured mesh: about how much memory that takes, if it is
// more than the build's own; else empty.
std::string MemoryOfConversion(const BuildCommand& line);

// The parts of a build's time that its steps take, for the time left; none where they are not
// known.
std::vector<StepShare> SharesOfSteps(const BuildCommand& line);

// Lets the reporter tell rates in what the steps go through: the bytes of the file while it is
// read, then what the build has found in it. The reporter must outlive the build.
void TellAmounts(BuildCommand& line, ProgressReporter& progress);

// Whether a server would serve a store of this name, as far as it ends in .kds: it names the model
// by what comes before. Errors: InvalidArgument.
Status CheckStoreName(const std::filesystem::path& store);

// Says on stderr, before the work, that a store of this name is not served.
void WarnOfEnding(std::string_view program, const BuildCommand& line);

// What a build says on stderr beside errors.
void PrintWarnings(std::string_view program, const BuildCommand& line, const BuildReport& report);

// What the last line of a build says of the model: what was dropped or forgiven of the input, and
// how the model stands if that was guessed; may be empty.
std::string LastWords(const BuildReport& report);

// Writes the file of statistics that was asked for; returns the exit code.
int WriteStats(std::string_view program, const BuildCommand& line, const BuildReport& report);

}
