// SPDX-License-Identifier: BSD-3-Clause
// The build out of core: see ExternalBuilder.h. Phases:
//   1. mesh     the file read in chunks, vertices welded, those that no triangle uses set aside,
//               triangles renumbered: MeshPhase.h
//   2. tree     the vertices in the order of the leaves, boxes: TreePhase.h
//   3. faces    triangles and attributes by blocks: FacesPhase.h
//   4. those of the partition method: levels and numbers (KdTreeMethod.cxx)
// and then the pieces, from the phases' files into the store.
#include "filters/build/ExternalBuilder.h"

#include "filters/build/BuildMemory.h"
#include "filters/build/ExternalMethod.h"
#include "filters/build/FacesPhase.h"
#include "filters/build/GuessPose.h"
#include "filters/build/InputDigest.h"
#include "filters/build/MeshPhase.h"
#include "filters/build/ModelFacts.h"
#include "filters/build/PhaseValues.h"
#include "filters/build/PieceWriting.h"
#include "filters/build/SharedSteps.h"
#include "filters/build/TreePhase.h"
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

std::vector<BuildPhase> PhasesOf(const ExternalMethod& method)
{
  std::vector<BuildPhase> phases = { { "mesh", "read", MakeMesh }, { "tree", "tree", MakeTree },
    { "faces", "faces", MakeFaces } };
  const std::vector<BuildPhase> later = method.PhasesAfterFaces();
  phases.insert(phases.end(), later.begin(), later.end());
  return phases;
}

// The step, as progress calls it, with which a build goes on after a phase.
std::string StepAfter(std::string_view phase, const BuildOptions& options)
{
  const Result<const ExternalMethod*> method = options.partitioner->External();
  const std::vector<BuildPhase> phases = method ? PhasesOf(**method) : std::vector<BuildPhase>{};
  const auto next = std::find_if(phases.begin(), phases.end(),
    [&](const BuildPhase& candidate) { return candidate.name == phase; });
  return next == phases.end() || next + 1 == phases.end() ? "encode" : (next + 1)->step;
}

// What --resume has found, for the user.
std::string DescribeResumed(const BuildFolder& folder, const BuildOptions& options)
{
  if (folder.FinishedPhases() > 0)
  {
    return "going on with the step " + StepAfter(folder.LastPhase(), options) +
           (folder.HasLostPhases() ? ": files of later ones are missing or were changed" : "");
  }
  const std::string nothing = "nothing to resume: ";
  switch (folder.WhatWasFound())
  {
    case BuildFolder::Found::Nothing:
      return nothing + "the earlier build ended before its first phase was finished";
    case BuildFolder::Found::Damaged:
      return nothing + "what the earlier build left cannot be read";
    case BuildFolder::Found::SameBuild:
      break;
  }
  return nothing + "files of the earlier build are missing or were changed";
}

Result<std::string> FingerprintOfBuild(
  const std::filesystem::path& input, const BuildOptions& options)
{
  return FingerprintOf({ "kdstream-build " + std::string(KDSTREAM_VERSION),
    options.convertedFrom.empty() ? input : options.convertedFrom, DescribeOptions(options),
    options.convertedWith });
}

class ExternalBuilder : private ExternalBuildState
{
public:
  ExternalBuilder(const std::filesystem::path& input, const std::filesystem::path& store,
    const BuildOptions& options, const Execution& execution, const ExternalBuildProbe& probe,
    const ExternalMethod& method)
    : ExternalBuildState{ input, store, options, execution,
      probe.stepMemory > 0 ? probe.stepMemory : StepMemory(options.memory) }
    , Hook(probe.hook)
    , Digest(FilesOfInput(input, options))
    , Method(method)
  {
  }

  Result<BuildReport> Build()
  {
    for (const char* step : { "read", "tree", "faces", "levels", "encode", "write" })
    {
      this->Clock.Finish(step); // also those whose phases are taken over are reported
    }
    const Status built = this->BuildPhases();
    if (!built && this->Report.resumedPhases > 0 &&
        built.GetError().code == ErrorCode::LimitExceeded)
    {
      this->Folder->Keep(true); // for a build with a larger limit
    }
    KDSTREAM_TRY(built);
    ReportCosts(this->Folder->Files().Counts(), this->Clock, this->Report);
    return std::move(this->Report);
  }

private:
  // All phases that are not taken over, and the store.
  Status BuildPhases()
  {
    KDSTREAM_TRY(this->OpenFolder());
    for (const auto& [name, step, make] : PhasesOf(this->Method))
    {
      if (this->Folder->Finished(name))
      {
        ++this->Report.resumedPhases;
        continue;
      }
      KDSTREAM_TRY(make(*this));
      ReturnFreeMemory();
    }
    return this->WriteStore();
  }

  Status OpenFolder()
  {
    const Result<std::string> fingerprint = FingerprintOfBuild(this->Input, this->Options);
    KDSTREAM_TRY(fingerprint);
    Result<BuildFolder> folder =
      BuildFolder::Open(BuildFolder::PathFor(this->Store, this->Options.temporaryFolder),
        *fingerprint, this->Options.resume, this->Hook);
    if (!folder && folder.GetError().code == ErrorCode::LimitExceeded)
    {
      // Another build writes the store: neither the input nor the folder is at fault.
      return OfFile(this->Store.string(), std::move(folder)).GetError();
    }
    KDSTREAM_TRY(folder);
    this->Folder.emplace(std::move(*folder));
    if (this->Options.resume)
    {
      this->Options.tellEarlierBuild(DescribeResumed(*this->Folder, this->Options));
    }
    return {};
  }

  Status WriteStore()
  {
    MeshFacts facts;
    MeshBlocks mesh;
    StoreParts parts;
    KDSTREAM_TRY(Take(this->Method.LoadParts(*this, facts, mesh), parts));
    KDSTREAM_TRY(this->Exec.Report("encode", 0));
    this->Report.ignoredAttributes = facts.ignored;
    this->Report.tolerance = facts.tolerance;
    this->Report.scalarType = facts.scalarType;
    ModelDescription description = this->Describe(facts, mesh, parts);
    KDSTREAM_TRY(kdstream::Take(this->Digest.Take(), description.inputDigest));
    Result<std::unique_ptr<StoreWriter>> writer = StoreWriter::Create(this->Store, description);
    KDSTREAM_TRY(writer);
    KDSTREAM_TRY(this->WriteParts(mesh, parts, description.Codec(), **writer));
    KDSTREAM_TRY(WriteTreePages(this->Boxes, mesh.depths, **writer));
    KDSTREAM_TRY(this->WriteUnusedList(facts, **writer));
    KDSTREAM_TRY(this->Exec.Report("write", 0));
    KDSTREAM_TRY(TellPose(this->Options, description, **writer));
    KDSTREAM_TRY(Take((*writer)->Finish(), this->Report.info));
    this->Clock.Finish("write");
    return {};
  }

  Status WriteUnusedList(const MeshFacts& facts, StoreWriter& writer) const
  {
    VertexFiles unused;
    unused.count = facts.unused;
    unused.tupleBytes = facts.pointTupleBytes;
    KDSTREAM_TRY(Take(this->Folder->TakeFile("mesh", "unused points"), unused.points));
    KDSTREAM_TRY(Take(this->Folder->TakeFile("mesh", "unused tuples"), unused.tuples));
    return WriteUnused(unused, facts.attributes, facts.scalarType, writer, this->Exec);
  }

  std::uint64_t PartitionCount(const MeshBlocks& mesh) const
  {
    return this->PartitionBegin.empty() ? std::uint64_t{ 1 } << mesh.depths.partition
                                        : this->PartitionBegin.size() - 1;
  }

  ModelDescription Describe(const MeshFacts& facts, const MeshBlocks& mesh, StoreParts& parts) const
  {
    ModelFacts model;
    model.vertices = facts.vertices;
    model.triangles = facts.triangles;
    model.unused = facts.unused;
    model.welded = facts.welded;
    model.inconsistentEdges = parts.inconsistentEdges;
    model.depths = mesh.depths;
    model.partitions = this->PartitionCount(mesh);
    MeasurePartitions(model,
      [&](std::size_t p) -> std::uint64_t
      {
        return this->PartitionBegin.empty()
                 ? RangeOfCell(facts.vertices, mesh.depths.partition, p).size
                 : this->PartitionBegin[p + 1] - this->PartitionBegin[p];
      });
    model.box = mesh.box;
    model.scalarType = facts.scalarType;
    model.attributes = facts.attributes;
    model.deviations = std::move(parts.deviations);
    BuildOptions used = this->Options;
    used.weld = facts.weld;
    return DescribeModel(used, model, InputNameOf(this->Input, this->Options));
  }

  Status WriteParts(
    const MeshBlocks& mesh, const StoreParts& parts, const CodecContext& codec, StoreWriter& writer)
  {
    std::uint64_t triangles = 0; // of the resolution
    const PartVisit write = [&](const VertexTree& tree, const Mesh& part, Resolution resolution,
                              const ModelPart& pieces) -> Status
    {
      const PieceCutter cutter(tree, part, resolution, this->Exec, pieces);
      const unsigned depth = PieceDepth(resolution, mesh.depths);
      const std::size_t all =
        resolution.IsOriginal() ? this->PartitionCount(mesh) : std::size_t{ 1 } << depth;
      KDSTREAM_TRY(WritePieces(cutter, cutter.PieceCount(), { codec, this->Options.textures.get() },
        writer, this->Clock, this->Exec,
        [&](std::size_t written)
        {
          const double done = double(pieces.firstPiece + written) / double(all);
          return this->Exec.Report("encode", EncodedPart(resolution, mesh.depths, done));
        }));
      triangles += cutter.TriangleCount();
      if (pieces.firstPiece + cutter.PieceCount() == all)
      {
        KDSTREAM_TRY(writer.FinishResolution(resolution, triangles));
        triangles = 0;
      }
      ReturnFreeMemory(mesh.keptMemory);
      return {};
    };
    return parts.forEach(write);
  }

  const FileHook& Hook; // of the build folder's files
  InputDigest Digest;   // of a resumed build, too: its input is not read otherwise
  const ExternalMethod& Method;
};

}

Status CheckExternalBuild(const BuildOptions& options)
{
  KDSTREAM_TRY(options.partitioner->External());
  if (options.memory < leastMemory)
  {
    return Error{ ErrorCode::LimitExceeded,
      "building out of core takes at least " + Mebibytes(leastMemory) };
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
  const std::string found = "a killed build of this store has left files";
  return left->fingerprint == *fingerprint
           ? found + ": with --resume it would go on with the step " +
               StepAfter(left->lastPhase, options) + "; this build starts over"
           : found +
               ", which this build removes: " + DescribeOtherBuild(left->fingerprint, *fingerprint);
}

Result<BuildReport> BuildStoreExternally(const std::filesystem::path& input,
  const std::filesystem::path& store, const BuildOptions& options, const Execution& execution,
  const ExternalBuildProbe& probe)
{
  KDSTREAM_TRY(CheckExternalBuild(options));
  return ExternalBuilder(input, store, options, execution, probe, **options.partitioner->External())
    .Build();
}

}
