// SPDX-License-Identifier: BSD-3-Clause
// The build out of core: see ExternalBuilder.h. Phases:
//   1. mesh: read the file in chunks, weld vertices, set aside those that no triangle uses,
//      renumber triangles (MeshPhase.cxx)
//   2. tree: put the vertices into the order of the leaves, compute boxes (TreePhase.cxx)
//   3. faces: sort triangles and attributes into blocks (FacesPhase.cxx)
//   4. the phases of the partition method: levels and numbers (KdTreeMethod.cxx)
// Then the pieces are written from the files of the phases into the store.
#include "filters/build/ExternalBuilder.h"

#include "filters/build/BuildMemory.h"
#include "filters/build/BuildPhases.h"
#include "filters/build/ExternalMethod.h"
#include "filters/build/InputDigest.h"
#include "filters/build/PhaseValues.h"
#include "filters/build/SharedSteps.h"
#include "filters/build/UnusedParts.h"
#include "filters/core/TakeResult.h"
#include "filters/outofcore/files/ReturnFreeMemory.h"
#include "filters/outofcore/journal/BuildFingerprint.h"
#include "kdstream/Version.h"

#include <algorithm>
#include <functional>
#include <utility>

namespace kdstream
{
namespace
{

// The name, in progress reports, of the step with which a build continues after a phase.
std::string StepAfter(std::string_view phase, const BuildOptions& options)
{
  std::vector<std::pair<std::string_view, const char*>> steps(
    std::begin(firstSteps), std::end(firstSteps));
  if (const Result<const ExternalMethod*> method = options.partitioner->External())
  {
    for (const BuildPhase& later : (*method)->PhasesAfterFaces())
    {
      steps.emplace_back(later.name, later.step);
    }
  }
  const auto found =
    std::find_if(steps.begin(), steps.end(), [&](const auto& step) { return step.first == phase; });
  return found == steps.end() || found + 1 == steps.end() ? "encode" : (found + 1)->second;
}

// A message that says what --resume has found.
std::string DescribeResumed(const BuildFolder& folder, const BuildOptions& options)
{
  if (folder.FinishedPhases() > 0)
  {
    return "continuing with the step " + StepAfter(folder.LastPhase(), options) +
           (folder.HasLostPhases() ? ": files of later steps are missing or changed" : "");
  }
  const std::string nothing = "nothing to resume: ";
  switch (folder.WhatWasFound())
  {
    case BuildFolder::Found::Nothing:
      return nothing + "the earlier build ended before its first phase was finished";
    case BuildFolder::Found::Damaged:
      return nothing + "the files of the earlier build cannot be read";
    case BuildFolder::Found::SameBuild:
      break;
  }
  return nothing + "files of the earlier build are missing or changed";
}

Result<std::string> FingerprintOfBuild(
  const std::filesystem::path& input, const BuildOptions& options)
{
  return FingerprintOf({ "kdstream-build " + std::string(KDSTREAM_VERSION),
    options.convertedFrom.empty() ? input : options.convertedFrom, DescribeOptions(options),
    options.convertedWith });
}

class ExternalBuilder : public BuildBackEnd
{
public:
  ExternalBuilder(const std::filesystem::path& input, const std::filesystem::path& store,
    const BuildOptions& options, const Execution& execution, const ExternalBuildProbe& probe,
    const ExternalMethod& method, OpenedInput opened)
    : Build{ { options, execution, std::move(opened.clock) }, input, store,
      probe.stepMemory > 0 ? probe.stepMemory : StepMemory(options.memory),
      std::move(opened.reader) }
    , Hook(probe.hook)
    , Digest(FilesOfInput(input, options))
    , Method(method)
  {
    for (const char* step : { "read", "tree", "faces", "levels", "encode", "write" })
    {
      this->Build.Clock.Finish(step); // so steps of resumed phases are reported too
    }
  }

  Result<BuildReport> Run()
  {
    KDSTREAM_TRY(this->OpenFolder());
    Result<BuildReport> built = ConductBuild(*this, this->Build.Store);
    if (!built && this->Build.Report.resumedPhases > 0 &&
        built.GetError().code == ErrorCode::LimitExceeded)
    {
      this->Build.Folder->Keep(true); // so that a build with a larger limit can continue
    }
    return built;
  }

  BuildState& State() override { return this->Build; }
  Status MakeMesh() override { return this->Make(kdstream::MakeMesh); }
  Status MakeTree() override { return this->Make(kdstream::MakeTree); }
  Status MakeFaces() override { return this->Make(kdstream::MakeFaces); }
  std::vector<BuildStep> StepsAfterFaces() override
  {
    std::vector<BuildStep> steps;
    for (const BuildPhase& phase : this->Method.PhasesAfterFaces())
    {
      steps.push_back(
        { phase.name, phase.step, [this, make = phase.make] { return this->Make(make); } });
    }
    return steps;
  }
  bool IsFinished(const char* step) const override { return this->Build.Folder->Finished(step); }

  Status Describe() override
  {
    KDSTREAM_TRY(Take(this->Method.LoadParts(this->Build, this->Read, this->Mesh), this->Parts));
    this->Build.Report.ignoredAttributes = this->Read.ignored;
    this->Build.Report.tolerance = this->Read.tolerance;
    const std::vector<VertexId>& begin = this->Build.PartitionBegin;
    ModelFacts& model = this->Build.Facts;
    model.vertices = this->Read.vertices;
    model.triangles = this->Read.triangles;
    model.unused = this->Read.unused;
    model.welded = this->Read.welded;
    model.weld = this->Read.weld;
    model.inconsistentEdges = this->Parts.inconsistentEdges;
    model.depths = this->Mesh.depths;
    model.partitions =
      begin.empty() ? std::uint64_t{ 1 } << model.depths.partition : begin.size() - 1;
    MeasurePartitions(model,
      [&](std::size_t p) -> std::uint64_t
      {
        return begin.empty() ? RangeOfCell(model.vertices, model.depths.partition, p).size
                             : begin[p + 1] - begin[p];
      });
    model.box = this->Mesh.box;
    model.scalarType = this->Read.scalarType;
    model.attributes = this->Read.attributes;
    model.geometricErrors = std::move(this->Parts.geometricErrors);
    return {};
  }

  std::string InputName() const override
  {
    return InputNameOf(this->Build.Input, this->Build.Options);
  }
  Result<std::string> DigestOfInput() override { return this->Digest.Take(); }

  Status ForEachPart(
    const PartVisit& visit, const std::function<Status(Resolution)>& finished) override
  {
    return this->Parts.forEach(
      [&](const VertexTree& tree, const kdstream::Mesh& mesh, Resolution resolution,
        const ModelPart& part) -> Status
      {
        KDSTREAM_TRY(visit(tree, mesh, resolution, part));
        ReturnFreeMemory(this->Mesh.keptMemory);
        return {};
      },
      finished);
  }

  Status WriteUnusedList(StoreWriter& writer) override
  {
    const BuildFolder& folder = *this->Build.Folder;
    VertexFiles unused;
    unused.count = this->Read.unused;
    unused.tupleBytes = this->Read.pointTupleBytes;
    KDSTREAM_TRY(Take(folder.TakeFile("mesh", "unused points"), unused.points));
    KDSTREAM_TRY(Take(folder.TakeFile("mesh", "unused tuples"), unused.tuples));
    return WriteUnused(
      unused, this->Read.attributes, this->Read.scalarType, writer, this->Build.Exec);
  }

  SpillCounts Costs() override { return this->Build.Files().Counts(); }

private:
  Status Make(Status (*phase)(ExternalBuildState&))
  {
    KDSTREAM_TRY(phase(this->Build));
    ReturnFreeMemory();
    return {};
  }

  Status OpenFolder()
  {
    const Result<std::string> fingerprint =
      FingerprintOfBuild(this->Build.Input, this->Build.Options);
    KDSTREAM_TRY(fingerprint);
    Result<BuildFolder> folder = BuildFolder::Open(
      BuildFolder::PathFor(this->Build.Store, this->Build.Options.temporaryFolder), *fingerprint,
      this->Build.Options.resume, this->Hook);
    if (!folder && folder.GetError().code == ErrorCode::LimitExceeded)
    {
      // Another build is writing the store; neither the input nor the folder is at fault.
      return OfFile(this->Build.Store.string(), std::move(folder)).GetError();
    }
    KDSTREAM_TRY(folder);
    this->Build.Folder.emplace(std::move(*folder));
    if (this->Build.Options.resume)
    {
      this->Build.Options.tellEarlierBuild(
        DescribeResumed(*this->Build.Folder, this->Build.Options));
    }
    return {};
  }

  ExternalBuildState Build;
  const FileHook& Hook; // for the files of the build folder
  InputDigest Digest;   // a resumed build needs it too, and does not read the input otherwise
  const ExternalMethod& Method;
  // What Describe loads:
  MeshFacts Read;
  MeshBlocks Mesh;
  StoreParts Parts;
};

}

Status CheckExternalBuild(const BuildOptions& options)
{
  KDSTREAM_TRY(options.partitioner->External());
  if (options.memory < leastMemory)
  {
    return Error{ ErrorCode::LimitExceeded,
      "building out of core needs at least " + Mebibytes(leastMemory) };
  }
  return {};
}

std::string DescribeResumable(const std::filesystem::path& input,
  const std::filesystem::path& store, const BuildOptions& options)
{
  const Result<std::string> fingerprint = FingerprintOfBuild(input, options);
  const std::optional<LeftBuild> left =
    BuildFolder::LeftIn(BuildFolder::PathFor(store, options.temporaryFolder));
  if (!fingerprint || !left)
  {
    return {};
  }
  const std::string found = "there are files of a killed build of this store";
  return left->fingerprint == *fingerprint
           ? found + ": --resume would continue it with the step " +
               StepAfter(left->lastPhase, options) + "; this build starts over"
           : found +
               ", which this build removes: " + DescribeOtherBuild(left->fingerprint, *fingerprint);
}

Result<BuildReport> BuildStoreExternally(const std::filesystem::path& input,
  const std::filesystem::path& store, const BuildOptions& options, const Execution& execution,
  const ExternalBuildProbe& probe, OpenedInput opened)
{
  KDSTREAM_TRY(CheckExternalBuild(options));
  return ExternalBuilder(
    input, store, options, execution, probe, **options.partitioner->External(), std::move(opened))
    .Run();
}

}
