// SPDX-License-Identifier: BSD-3-Clause
// The conductor of a build: runs its steps in order, and writes the store. A back end holds the
// data: in memory (Builder.cxx), in files (ExternalBuilder.cxx) or on ranks
// (Parallel/DistributedBuilder.cxx). Step "build" of the pipeline picture.
#pragma once

#include "filters/build/Builder.h"
#include "filters/build/ModelFacts.h"
#include "filters/build/PieceWriting.h"
#include "filters/build/StepClock.h"
#include "filters/core/Execution.h"
#include "filters/core/pieces/VertexTree.h"
#include "filters/outofcore/files/SpillFile.h"
#include "filters/outofcore/pieces/ExternalPieces.h"
#include "filters/store/StoreWriter.h"

#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace kdstream
{

// What every build has, whatever its back end.
struct BuildState
{
  const BuildOptions& Options;
  const Execution& Exec;
  StepClock Clock{};
  BuildReport Report{};
  ModelFacts Facts{};
  std::vector<Box> Boxes{}; // of the tree's nodes, heap order
};

struct BuildStep
{
  const char* name; // the name in the build folder
  const char* step; // the name in progress reports
  std::function<Status()> make;
};

// The bodies of the steps. A body reports time spent on other steps itself.
class BuildBackEnd
{
public:
  virtual ~BuildBackEnd() = default;
  virtual BuildState& State() = 0;
  // All steps from the input up to the data that ForEachPart visits. After "faces" come the steps
  // that depend on the partitions: "levels" and "numbers", if there are levels.
  virtual Status MakeMesh() = 0;
  virtual Status MakeTree() = 0;
  virtual Status MakeFaces() = 0;
  virtual std::vector<BuildStep> StepsAfterFaces() = 0;
  // Whether an interrupted build has left the results of the step.
  virtual bool IsFinished(const char* /*step*/) const { return false; }
  // Fills in State().Facts and Boxes. Called after all steps.
  virtual Status Describe() = 0;
  virtual std::string InputName() const = 0;
  virtual Result<std::string> DigestOfInput() = 0;
  // Passes all parts of each resolution to `visit`, levels 0 … L and then the original, and calls
  // `finished` after the last part of each resolution.
  virtual Status ForEachPart(
    const PartVisit& visit, const std::function<Status(Resolution)>& finished) = 0;
  virtual Status WriteUnusedList(StoreWriter& writer) = 0;
  virtual SpillCounts Costs() { return {}; }

  // For ranks, which share the pieces: whether this rank writes the store.
  virtual bool WritesStore() const { return true; }
  // writer: null if !WritesStore().
  virtual Status TakePieces(const PieceCutter& cutter, std::size_t count,
    const PieceEncoding& encoding, StoreWriter* writer,
    const std::function<Status(std::size_t)>& written);
  // triangles: of the pieces that this back end has taken.
  virtual Status FinishResolution(
    Resolution resolution, std::uint64_t triangles, StoreWriter* writer);
  // Returns when all ranks have succeeded so far; an error if one has failed.
  virtual Status Agree() { return {}; }
};

// The first steps of every build, without bodies.
inline constexpr std::pair<const char*, const char*> firstSteps[] = { { "mesh", "tree" },
  { "tree", "tree" }, { "faces", "faces" } };

// Builds the store. Errors: those of the back end, of StoreWriter and of TellHomeView; Cancelled.
Result<BuildReport> ConductBuild(BuildBackEnd& backEnd, const std::filesystem::path& store);

}
