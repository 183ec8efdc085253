// SPDX-License-Identifier: BSD-3-Clause
// The command line of the programs that build stores: kdstream-build and kdstream-build-mpi.
#pragma once

#include "filters/app/StrayPoint.h"
#include "filters/build/Builder.h"
#include "filters/program/Program.h"
#include "filters/texture/BakeTextures.h"
#include "filters/texture/MakeTile.h"

#include <chrono>
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
  std::string columns; // the columns of an .xyz file
  std::string textures = "on", textureQuality = "90";
  std::uint64_t texturePixels = mostPicturePixels;
  TileOptions tiles{}; // set by Interpret, as are the next two
  bool qualityGiven = false, pixelsGiven = false;

  // Whether kdstream-convert reads the input: set by ChooseReader.
  bool converts = false;
  bool plainMaterials = false;       // FoundTextures::isPlain, which ChooseReader sets
  std::optional<StrayPoint> stray{}; // the point that makes the grid coarse, if LosesBits
  std::optional<BakeReport> baked{}; // the result of baking its textures
  std::optional<TileCounts> tiled{}; // the same, and numbers of textures in the original

  // Whether the original keeps its pictures, if it has any.
  bool WantsTiles() const { return this->textures == "on" || this->textures == "tiles"; }
};

// Adds all options; their values are stored in `line`, to which a reference is kept.
void AddBuildOptions(CLI::App& app, BuildCommand& line);

// Fills in line.build from the parsed options. Errors: InvalidArgument.
Status Interpret(const CLI::App& app, BuildCommand& line);

// Sets line.converts: for foreign formats, for surfaces from point clouds, and for meshes with
// textures, unless --textures is off. Returns warnings about the images of textures, one sentence
// each.
std::vector<std::string> ChooseReader(BuildCommand& line);

// The note printed before kdstream-convert reads a textured mesh: about how much memory the
// conversion needs. Empty if it needs no more than the build.
std::string MemoryOfConversion(const BuildCommand& line);

// The share of each step in a build's time, for estimating the time left; empty if unknown.
std::vector<StepShare> SharesOfSteps(const BuildCommand& line);

// Lets the reporter show rates: bytes of the file per second while it is read, later the numbers
// that the build has counted in it. The reporter must outlive the build.
void TellAmounts(BuildCommand& line, ProgressReporter& progress);

// Checks that a server can serve a store of this file name. The part before .kds becomes the
// model's name. Errors: InvalidArgument.
Status CheckStoreName(const std::filesystem::path& store);

// Warns on stderr, before the work begins, if a store of this name would not be served.
void WarnOfEnding(std::string_view program, const BuildCommand& line);

// Whether the grid merges so many vertices that a warning is needed.
bool LosesBits(const BuildReport& report);

// Prints each warning on a line of stderr.
void PrintWarnings(
  std::string_view program, const BuildCommand& line, const std::vector<std::string>& warnings);

// Ends a successful build: prints warnings, notes and the result on stderr, and writes the file of
// statistics if requested. Returns the exit code.
int FinishBuild(std::string_view program, const BuildCommand& line, const BuildReport& report,
  std::chrono::steady_clock::time_point begin);

}
