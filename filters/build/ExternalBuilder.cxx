// SPDX-License-Identifier: BSD-3-Clause
// The build out of core: see ExternalBuilder.h. Phases:
//   1. mesh     the file read in chunks, vertices welded, those that no triangle uses set aside,
//               triangles renumbered: MeshPhase.h
//   2. tree     the vertices in the order of the leaves, boxes: TreePhase.h
//   3. faces    triangles and attributes by blocks: FacesPhase.h
//   4. levels   block by block; edges that are not consistently oriented are counted on the way
//   5. numbers  of clusters and vertices
// or, of partitions by an octree, which have no levels,
//   4. edges    that are not consistently oriented
// and then the pieces, from the phases' files into the store.
#include "filters/build/ExternalBuilder.h"

#include "filters/build/BuildMemory.h"
#include "filters/build/ExternalBuildState.h"
#include "filters/build/FacesPhase.h"
#include "filters/build/GuessHomeView.h"
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
#include "filters/outofcore/levels/LevelGeometricErrors.h"
#include "filters/outofcore/pieces/ExternalPieces.h"
#include "kdstream/Version.h"

#include <algorithm>
#include <functional>
#include <utility>

namespace kdstream
{
namespace
{

// The step, as progress calls it, with which a build goes on after a phase.
std::string StepAfter(std::string_view phase, const BuildOptions& options)
{
  const bool byOctree = options.partitioner == Partitioner::Octree;
  return phase == "mesh"     ? "tree"
         : phase == "tree"   ? "faces"
         : phase == "faces"  ? (byOctree ? "faces" : "levels")
         : phase == "levels" ? "levels" // its last part
                             : "encode";
}

// What --resume has found, for the user.
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

class ExternalBuilder : private ExternalBuildState
{
public:
  ExternalBuilder(const std::filesystem::path& input, const std::filesystem::path& store,
    const BuildOptions& options, const Execution& execution, const ExternalBuildProbe& probe)
    : ExternalBuildState{ input, store, options, execution,
      probe.stepMemory > 0 ? probe.stepMemory : StepMemory(options.memory) }
    , Hook(probe.hook)
    , Digest(FilesOfInput(input, options))
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
    using Phase = std::pair<const char*, std::function<Status()>>;
    std::vector<Phase> phases = { { "mesh", [&] { return MakeMesh(*this); } },
      { "tree", [&] { return MakeTree(*this); } }, { "faces", [&] { return MakeFaces(*this); } } };
    if (this->ByOctree())
    {
      phases.push_back({ "edges", [&] { return this->CountEdges(); } });
    }
    else
    {
      phases.push_back({ "levels", [&] { return this->MakeLevels(); } });
      phases.push_back({ "numbers", [&] { return this->MakeNumbers(); } });
    }
    for (const auto& [name, make] : phases)
    {
      if (this->Folder->Finished(name))
      {
        ++this->Report.resumedPhases;
        continue;
      }
      KDSTREAM_TRY(make());
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

  Status CountEdges()
  {
    MeshFacts facts;
    MeshBlocks mesh;
    KDSTREAM_TRY(LoadBlocks(*this, facts, mesh));
    mesh.attributes.clear(); // they are not looked at
    std::uint64_t inconsistent = 0;
    const Execution part = this->Part("faces", 0.8, 1);
    for (std::size_t b = 0; b < mesh.BlockCount(); ++b)
    {
      const Result<TreeBlock> block = mesh.Load(b);
      KDSTREAM_TRY(block);
      inconsistent += CountInconsistentEdges(*block, this->Exec);
      KDSTREAM_TRY(part.Report("faces", double(b + 1) / double(mesh.BlockCount())));
    }
    this->Clock.Finish("faces");
    BlobWriter blob;
    blob.Add(inconsistent);
    return this->Folder->Finish("edges", blob);
  }

  Status MakeLevels()
  {
    MeshFacts facts;
    MeshBlocks mesh;
    KDSTREAM_TRY(LoadBlocks(*this, facts, mesh));
    std::uint64_t inconsistent = 0;
    ExternalLevels levels;
    KDSTREAM_TRY(Take(
      BuildExternalLevels(this->Files(), mesh, this->Options.levels, this->Part("levels", 0, 0.8),
        [&](const TreeBlock& block) { inconsistent += CountInconsistentEdges(block, this->Exec); }),
      levels));
    this->Clock.Finish("levels");
    BlobWriter blob;
    blob.Add(inconsistent);
    std::vector<PhaseFile> files;
    Save(blob, files, std::move(levels));
    return this->Folder->Finish("levels", blob, files);
  }

  // The mesh as all phases up to "edges" leave it.
  Status LoadEdges(MeshFacts& facts, MeshBlocks& mesh, std::uint64_t& inconsistent)
  {
    KDSTREAM_TRY(LoadBlocks(*this, facts, mesh));
    BlobReader blob = this->Folder->BlobOf("edges");
    inconsistent = blob.Read<std::uint64_t>();
    return blob.Finish();
  }

  // The mesh and its levels as all phases up to "levels" leave them.
  Status LoadLevels(
    MeshFacts& facts, MeshBlocks& mesh, ExternalLevels& levels, std::uint64_t& inconsistent)
  {
    KDSTREAM_TRY(LoadBlocks(*this, facts, mesh));
    BlobReader blob = this->Folder->BlobOf("levels");
    inconsistent = blob.Read<std::uint64_t>();
    return Take(LoadExternalLevels(blob, *this->Folder, "levels"), levels);
  }

  Status MakeNumbers()
  {
    MeshFacts facts;
    MeshBlocks mesh;
    ExternalLevels levels;
    ExternalNumbers numbers;
    std::uint64_t inconsistent = 0;
    KDSTREAM_TRY(this->LoadLevels(facts, mesh, levels, inconsistent));
    KDSTREAM_TRY(
      Take(NumberExternally(this->Files(), mesh, levels, this->Part("levels", 0.8, 1)), numbers));
    this->Clock.Finish("levels");
    BlobWriter blob;
    std::vector<PhaseFile> files;
    Save(blob, files, std::move(numbers));
    return this->Folder->Finish("numbers", blob, files);
  }

  Status LoadNumbers(ExternalNumbers& numbers)
  {
    BlobReader blob = this->Folder->BlobOf("numbers");
    return Take(LoadExternalNumbers(blob, *this->Folder, "numbers"), numbers);
  }

  Status WriteStore()
  {
    MeshFacts facts;
    MeshBlocks mesh;
    ExternalLevels levels;
    ExternalNumbers numbers;
    std::uint64_t inconsistent = 0;
    KDSTREAM_TRY(this->ByOctree() ? this->LoadEdges(facts, mesh, inconsistent)
                                  : this->LoadLevels(facts, mesh, levels, inconsistent));
    if (!this->ByOctree())
    {
      KDSTREAM_TRY(this->LoadNumbers(numbers));
    }
    KDSTREAM_TRY(this->Exec.Report("encode", 0));
    this->Report.ignoredAttributes = facts.ignored;
    this->Report.tolerance = facts.tolerance;
    this->Report.scalarType = facts.scalarType;
    std::vector<double> deviations; // of the levels
    if (!this->ByOctree())
    {
      KDSTREAM_TRY(Take(GeometricErrorsOfLevels(levels, mesh.depths), deviations));
    }
    ModelDescription description = this->Describe(facts, mesh, inconsistent, std::move(deviations));
    KDSTREAM_TRY(kdstream::Take(this->Digest.Take(), description.inputDigest));
    Result<std::unique_ptr<StoreWriter>> writer = StoreWriter::Create(this->Store, description);
    KDSTREAM_TRY(writer);
    KDSTREAM_TRY(this->WriteParts(mesh, levels, numbers, description.Codec(), **writer));
    KDSTREAM_TRY(WriteTreePages(this->Boxes, mesh.depths, **writer));
    KDSTREAM_TRY(this->WriteUnusedList(facts, **writer));
    KDSTREAM_TRY(this->Exec.Report("write", 0));
    KDSTREAM_TRY(TellHomeView(this->Options, description, **writer));
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
    return this->ByOctree() ? this->PartitionBegin.size() - 1
                            : std::uint64_t{ 1 } << mesh.depths.partition;
  }

  ModelDescription Describe(const MeshFacts& facts, const MeshBlocks& mesh,
    std::uint64_t inconsistent, std::vector<double> deviations)
  {
    ModelFacts model;
    model.vertices = facts.vertices;
    model.triangles = facts.triangles;
    model.unused = facts.unused;
    model.welded = facts.welded;
    model.inconsistentEdges = inconsistent;
    model.depths = mesh.depths;
    model.partitions = this->PartitionCount(mesh);
    MeasurePartitions(model,
      [&](std::size_t p) -> std::uint64_t
      {
        return this->ByOctree() ? this->PartitionBegin[p + 1] - this->PartitionBegin[p]
                                : RangeOfCell(facts.vertices, mesh.depths.partition, p).size;
      });
    model.box = mesh.box;
    model.scalarType = facts.scalarType;
    model.attributes = facts.attributes;
    model.deviations = std::move(deviations);
    BuildOptions used = this->Options;
    used.weld = facts.weld;
    return DescribeModel(used, model, InputNameOf(this->Input, this->Options));
  }

  Status WriteParts(const MeshBlocks& mesh, const ExternalLevels& levels,
    const ExternalNumbers& numbers, const CodecContext& codec, StoreWriter& writer)
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
        KDSTREAM_TRY(writer.FinishResolution(resolution, triangles, this->Exec));
        triangles = 0;
      }
      ReturnFreeMemory(mesh.keptMemory);
      return {};
    };
    return this->ByOctree() ? ForEachPartOfPartitions(mesh, this->PartitionBegin, write, this->Exec)
                            : ForEachPart(mesh, levels, numbers, write, this->Exec);
  }

  const FileHook& Hook; // of the build folder's files
  InputDigest Digest;   // of a resumed build, too: its input is not read otherwise
};

}

Status CheckExternalBuild(const BuildOptions& options)
{
  if (options.partitioner == Partitioner::KMeans)
  {
    return Error{
      ErrorCode::LimitExceeded,
      "k-means partitions can only be built in memory: raise --memory, or use another --partitioner"
    };
  }
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
  const ExternalBuildProbe& probe)
{
  KDSTREAM_TRY(CheckExternalBuild(options));
  return ExternalBuilder(input, store, options, execution, probe).Build();
}

}
