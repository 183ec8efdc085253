// The build out of core: see ExternalBuilder.h. Phases:
//   1. mesh     the file read in chunks, vertices welded, triangles renumbered
//   2. tree     the vertices in the order of the leaves, boxes
//   3. faces    triangles and attributes by blocks
//   4. levels   block by block; edges that are not consistently oriented are counted on the way
//   5. numbers  of clusters and vertices
// or, of partitions by an octree, which have no levels,
//   4. edges    that are not consistently oriented
// and then the pieces, from the phases' files into the store.
#include "filters/store/ExternalBuilder.h"

#include "filters/core/EdgeCount.h"
#include "filters/core/TakeResult.h"
#include "filters/meshio/MeshReader.h"
#include "filters/outofcore/BuildFolder.h"
#include "filters/outofcore/CellTriangles.h"
#include "filters/outofcore/ExternalPieces.h"
#include "filters/outofcore/ExternalTree.h"
#include "filters/outofcore/FreeMemory.h"
#include "filters/outofcore/MemoryPlan.h"
#include "filters/outofcore/MeshSpill.h"
#include "filters/outofcore/OctreePartitions.h"
#include "filters/outofcore/PlaceCount.h"
#include "filters/outofcore/RankTuples.h"
#include "filters/store/BuildInput.h"
#include "filters/store/BuildMemory.h"
#include "filters/store/HubCheck.h"
#include "filters/store/ModelDescription.h"
#include "filters/store/PhaseValues.h"
#include "filters/store/PieceWriting.h"

#include <algorithm>
#include <cmath>

namespace kdstream
{
namespace
{

bool IsNegativeZero(double x)
{
  return x == 0 && std::signbit(x);
}

// What --resume has found, for the user.
std::string DescribeResumed(const BuildFolder& folder)
{
  if (folder.FinishedPhases() > 0)
  {
    return "going on after the phase " + folder.LastPhase();
  }
  const std::string nothing = "nothing to resume: ";
  switch (folder.WhatWasFound())
  {
    case BuildFolder::Found::Nothing:
      return nothing + "the earlier build ended before its first phase was finished";
    case BuildFolder::Found::Damaged:
      return nothing + "what the earlier build left cannot be read";
    case BuildFolder::Found::OtherProgram:
      return nothing + "the earlier build was by another version";
    case BuildFolder::Found::OtherInput:
      return nothing + "the earlier build had another input, or this one was changed since";
    case BuildFolder::Found::OtherOptions:
      return nothing + "the earlier build had other options";
    case BuildFolder::Found::SameBuild:
      break;
  }
  return nothing + "files of the earlier build are missing or were changed";
}

class ExternalBuilder
{
public:
  ExternalBuilder(const std::filesystem::path& input, const std::filesystem::path& store,
    const BuildOptions& options, const Execution& execution, const ExternalBuildProbe& probe)
    : Input(input)
    , Store(store)
    , Options(options)
    , Exec(execution)
    , Probe(probe)
    , Memory(probe.stepMemory > 0 ? probe.stepMemory : StepMemory(options.memory))
  {
  }

  Result<BuildReport> Build()
  {
    for (const char* step : { "read", "tree", "faces", "levels", "encode", "write" })
    {
      this->Clock.Finish(step); // also those whose phases are taken over are reported
    }
    Status status = this->OpenFolder();
    using Phase = std::pair<const char*, Status (ExternalBuilder::*)()>;
    std::vector<Phase> phases = { { "mesh", &ExternalBuilder::MakeMesh },
      { "tree", &ExternalBuilder::MakeTree }, { "faces", &ExternalBuilder::MakeFaces } };
    if (this->ByOctree())
    {
      phases.push_back({ "edges", &ExternalBuilder::CountEdges });
    }
    else
    {
      phases.push_back({ "levels", &ExternalBuilder::MakeLevels });
      phases.push_back({ "numbers", &ExternalBuilder::MakeNumbers });
    }
    for (const auto& [name, make] : phases)
    {
      if (status && !this->Folder->Finished(name))
      {
        status = (this->*make)();
        ReturnFreeMemory();
      }
      else if (status)
      {
        ++this->Report.resumedPhases;
      }
    }
    if (status)
    {
      status = this->WriteStore();
    }
    if (!status)
    {
      return status.GetError();
    }
    const SpillCounts counts = this->Folder->Files().Counts();
    this->Report.temporaryBytes = counts.peakBytesOnDisk;
    this->Report.bytesRead = counts.bytesRead;
    this->Report.bytesWritten = counts.bytesWritten;
    this->Report.seconds = this->Clock.Take();
    return std::move(this->Report);
  }

private:
  SpillFolder& Files() { return this->Folder->Files(); }
  bool ByOctree() const { return this->Options.partitioner == Partitioner::Octree; }

  // For a function that is the part [begin, end) of a step: it reports its own progress from 0 to 1
  // under any name, what is shown is the step's, which never runs back.
  Execution Part(const char* step, double begin, double end)
  {
    Execution part = this->Exec;
    part.progress = [this, step, begin, end](std::string_view, double fraction)
    {
      if (this->Step != step)
      {
        this->Step = step;
        this->StepDone = 0;
      }
      this->StepDone =
        std::max(this->StepDone, begin + (end - begin) * std::clamp(fraction, 0.0, 1.0));
      return this->Exec.progress(step, this->StepDone);
    };
    return part;
  }

  Status OpenFolder()
  {
    const Result<std::string> fingerprint =
      FingerprintOf({ "kdstream-build " + std::string(KDSTREAM_VERSION),
        this->Options.convertedFrom.empty() ? this->Input : this->Options.convertedFrom,
        DescribeOptions(this->Options) });
    if (!fingerprint)
    {
      return fingerprint.GetError();
    }
    Result<BuildFolder> folder =
      BuildFolder::Open(BuildFolder::PathFor(this->Store, this->Options.temporaryFolder),
        *fingerprint, this->Options.resume, this->Probe.hook);
    if (!folder)
    {
      return folder.GetError();
    }
    this->Folder.emplace(std::move(*folder));
    if (this->Options.resume)
    {
      this->Options.tellResumed(DescribeResumed(*this->Folder));
    }
    return {};
  }

  // Reads and welds.
  Status MakeMesh()
  {
    const Execution opening = this->Part("read", 0, 0.5); // some formats are read twice
    Result<std::unique_ptr<MeshReader>> reader =
      MeshReader::Open(this->Input, opening, this->Files().Path());
    if (!reader)
    {
      return reader.GetError();
    }
    if (Status possible = CheckClaimedPartitions(**reader, this->Options); !possible)
    {
      return possible;
    }
    this->Files().Expect(EstimateTemporaryBytes(
      ClaimedBlocks(**reader), (*reader)->Info().soup, (*reader)->Info().scalarType));
    const std::size_t chunk = static_cast<std::size_t>(
      std::min<std::uint64_t>(this->Memory / 16, std::uint64_t{ 8 } << 20));
    SpilledMesh mesh;
    Status status =
      Take(SpillMesh(this->Files(), **reader, chunk, this->Part("read", this->StepDone, 1)), mesh);
    if (!status)
    {
      return status;
    }
    this->Clock.Finish("read");
    MeshFacts facts;
    facts.triangles = mesh.triangleCount;
    facts.pointTupleBytes = mesh.vertices.tupleBytes;
    facts.cellTupleBytes = mesh.cellTupleBytes;
    facts.scalarType = mesh.scalarType;
    facts.floats = mesh.fitFloats;
    facts.attributes = mesh.attributes;
    facts.ignored = (*reader)->Info().ignoredAttributes;
    facts.weld = this->Options.weld || (*reader)->Info().soup;
    for (const AttributeInfo& attribute : facts.attributes)
    {
      if (!IsAttributeName(attribute.name))
      {
        return Error{ ErrorCode::InvalidInput, "an attribute has a name that is no text" };
      }
    }
    if (facts.weld)
    {
      status = this->Weld(mesh, facts);
    }
    facts.vertices = mesh.vertices.count;
    this->Clock.Finish("tree");
    if (!status)
    {
      return status;
    }
    BlobWriter blob;
    Save(blob, facts);
    PhaseFile files[] = { { "points", std::move(mesh.vertices.points) },
      { "tuples", std::move(mesh.vertices.tuples) }, { "triangles", std::move(mesh.triangles) },
      { "cells", std::move(mesh.cellTuples) } };
    return this->Folder->Finish("mesh", blob, files);
  }

  Status Weld(SpilledMesh& mesh, MeshFacts& facts)
  {
    ExternalWeld welded;
    Status status = Take(WeldExternally(this->Files(), std::move(mesh.vertices), this->Memory,
                           this->Part("tree", 0, 0.4)),
      welded);
    if (!status)
    {
      return status;
    }
    mesh.vertices = std::move(welded.vertices);
    facts.welded = welded.welded;
    if (!welded.map)
    {
      return {};
    }
    SpillFile renumbered;
    status = Take(this->Files().CreateFile(
                    "triangles", std::uint64_t{ mesh.triangleCount } * sizeof(NumberedTriangle)),
      renumbered);
    if (!status)
    {
      return status;
    }
    std::uint64_t written = 0;
    status = MapTriangles(this->Files(), mesh.triangles, mesh.triangleCount, *welded.map,
      this->Memory, this->Part("tree", 0.4, 0.5),
      [&](std::span<const NumberedTriangle> triangles)
      {
        const Status done = WriteRecords<NumberedTriangle>(renumbered, written, triangles);
        written += triangles.size();
        return done;
      });
    mesh.triangles = std::move(renumbered);
    return status;
  }

  Result<MeshFacts> LoadFacts()
  {
    BlobReader blob = this->Folder->BlobOf("mesh");
    MeshFacts facts = LoadMeshFacts(blob);
    Status status = blob.Finish();
    if (status && this->Options.partitioner == Partitioner::KdTree)
    {
      status = CheckPartitionMemory(
        { facts.vertices, facts.triangles, facts.pointTupleBytes, facts.cellTupleBytes },
        this->Options.tree, this->Options.memory);
    }
    if (!status)
    {
      return status.GetError();
    }
    return facts;
  }

  Status MakeTree()
  {
    MeshFacts facts;
    Status status = Take(this->LoadFacts(), facts);
    return !status        ? status
           : facts.floats ? this->MakeTreeOf<float>(facts)
                          : this->MakeTreeOf<double>(facts);
  }

  template <class Scalar>
  Status MakeTreeOf(const MeshFacts& facts)
  {
    SpillFile points, records;
    bool negativeZeros = false;
    Status status =
      facts.vertices > 0 ? Status{} : Error{ ErrorCode::InvalidInput, "the mesh has no vertices" };
    if (status)
    {
      status = Take(this->Folder->TakeFile("mesh", "points"), points);
    }
    if (status)
    {
      status = Take(this->RecordsOf<Scalar>(points, facts.vertices, negativeZeros), records);
    }
    ExternalPartitions tree;
    if (status)
    {
      status = this->ByOctree()
                 ? Take(PartitionByExternalOctree<Scalar>(this->Files(), records,
                          this->Options.tree, this->Memory, this->Part("tree", 0.5, 1)),
                     tree)
                 : this->MakeKdTree<Scalar>(facts, records, tree);
    }
    if (!status)
    {
      return status;
    }
    this->Clock.Finish("tree");
    BlobWriter blob;
    blob.Add(tree.depths);
    blob.AddList(tree.boxes);
    blob.Add((tree.recordsRead + facts.vertices - 1) / facts.vertices);
    blob.Add(negativeZeros);
    blob.AddList(tree.begin);
    PhaseFile files[] = { { "records", std::move(tree.records) } };
    return this->Folder->Finish("tree", blob, files, { { "mesh", "points" } });
  }

  template <class Scalar>
  Status MakeKdTree(const MeshFacts& facts, SpillFile& records, ExternalPartitions& result)
  {
    Status status = Take(ComputeDepths(facts.vertices, this->Options.tree), result.depths);
    if (!status)
    {
      return status;
    }
    ExternalTree tree;
    ExternalTreeOptions options;
    options.memory = this->Memory;
    options.median = this->Options.median;
    status = Take(BuildExternalTree<Scalar>(
                    this->Files(), records, result.depths, options, this->Part("tree", 0.5, 1)),
      tree);
    result.boxes = std::move(tree.boxes);
    result.records = std::move(tree.records);
    result.recordsRead = facts.vertices; // all are in memory once at least
    for (const ExternalDepthStatistics& depth : tree.statistics.depths)
    {
      result.recordsRead += depth.records + depth.medianRecords;
    }
    return status;
  }

  template <class Scalar>
  Result<SpillFile> RecordsOf(const SpillFile& points, std::uint32_t count, bool& negativeZeros)
  {
    Result<SpillFile> records =
      this->Files().CreateFile("vertices", count * std::uint64_t{ sizeof(PointRecord<Scalar>) });
    if (!records)
    {
      return records.GetError();
    }
    struct Slot
    {
      std::vector<PointRecord<Scalar>> records;
      bool negativeZeros = false;
    };
    const BatchShape shape = ShapeOfPass(this->Memory / 8, sizeof(Vec3));
    std::vector<Slot> slots(shape.slots);
    BatchPass<Vec3> batches(shape, this->Exec);
    const Status status = batches.Over(
      points, 0, count,
      [&](std::size_t i, std::span<Vec3> block, std::uint64_t first)
      {
        Slot& slot = slots[i];
        slot.records.clear();
        auto id = static_cast<VertexId>(first);
        for (const Vec3& p : block)
        {
          slot.negativeZeros |= std::any_of(p.begin(), p.end(), IsNegativeZero);
          slot.records.push_back({ { Scalar(p[0]), Scalar(p[1]), Scalar(p[2]) }, id++ });
        }
        return WriteRecords<PointRecord<Scalar>>(
          *records, first, std::span<const PointRecord<Scalar>>(slot.records));
      },
      [](std::size_t, std::uint64_t) { return Status{}; });
    negativeZeros =
      std::any_of(slots.begin(), slots.end(), [](const Slot& slot) { return slot.negativeZeros; });
    return status ? Result<SpillFile>(std::move(*records)) : status.GetError();
  }

  // The mesh as the phases up to "tree" leave it; without triangles and attributes.
  Status LoadMesh(MeshFacts& facts, MeshBlocks& mesh)
  {
    Status status = Take(this->LoadFacts(), facts);
    BlobReader blob = this->Folder->BlobOf("tree");
    mesh.depths = blob.Read<TreeDepths>();
    this->Boxes = blob.ReadList<Box>();
    this->Report.passes = 1 + blob.Read<std::uint64_t>();
    const auto negativeZeros = blob.Read<bool>();
    this->PartitionBegin = blob.ReadList<VertexId>();
    if (status)
    {
      status = blob.Finish();
    }
    if (status && this->Boxes.size() < 2)
    {
      status = Error{ ErrorCode::Damaged, "the tree of an interrupted build has no boxes" };
    }
    if (status)
    {
      status = Take(this->Folder->TakeFile("tree", "records"), mesh.records);
    }
    if (!status)
    {
      return status;
    }
    mesh.vertexCount = facts.vertices;
    mesh.triangleCount = facts.triangles;
    mesh.box = this->Boxes[1];
    mesh.floats = facts.floats;
    mesh.scalarType = facts.scalarType;
    mesh.attributes = facts.attributes;
    mesh.mayCoincide = negativeZeros || !WeldingSeparates(facts.weld, facts.attributes);
    mesh.blockDepth = DepthOfBlocks(
      { facts.vertices, facts.triangles, facts.pointTupleBytes, facts.cellTupleBytes },
      this->Memory, 0, mesh.depths.partition);
    mesh.keptMemory = KeptMemory(this->Memory);
    return this->ByOctree() ? this->JoinPartitions(facts, mesh) : Status{};
  }

  // Blocks of an octree: partitions one after the other, as many as fit.
  Status JoinPartitions(const MeshFacts& facts, MeshBlocks& mesh)
  {
    const std::vector<VertexId>& begin = this->PartitionBegin;
    if (begin.size() < 2 || begin.size() - 1 > this->Boxes.size() / 2 || begin.front() != 0 ||
        begin.back() != facts.vertices || !std::is_sorted(begin.begin(), begin.end()))
    {
      return Error{ ErrorCode::Damaged, "the octree of an interrupted build is not whole" };
    }
    this->MostInBlock = MostBlockVertices(
      { facts.vertices, facts.triangles, facts.pointTupleBytes, facts.cellTupleBytes },
      this->Memory);
    mesh.begin = JoinIntoBlocks(begin, this->MostInBlock);
    for (std::size_t block = 0; block < mesh.BlockCount(); ++block)
    {
      if (const std::uint64_t size = mesh.RangeOf(block).size; size > this->MostInBlock)
      {
        return BeyondMemory("a partition of " + std::to_string(size) +
                              " vertices, of which at most " + std::to_string(this->MostInBlock) +
                              " can be held",
          this->Options.memory);
      }
    }
    return {};
  }

  Status MakeFaces()
  {
    MeshFacts facts;
    MeshBlocks mesh;
    Status status = this->LoadMesh(facts, mesh);
    VertexMap ranks;
    if (status)
    {
      status = Take((facts.floats ? RankVertices<float> : RankVertices<double>)(this->Files(),
                      mesh.records, facts.vertices, this->Memory, this->Part("faces", 0, 0.2)),
        ranks);
    }
    SpillFile triangles, tuples;
    if (status)
    {
      status = Take(this->Folder->TakeFile("mesh", "triangles"), triangles);
    }
    if (status)
    {
      status = Take(this->Folder->TakeFile("mesh", "tuples"), tuples);
    }
    if (!status)
    {
      return status;
    }
    Result<RecordBuckets<NumberedTriangle>> buckets =
      SortTrianglesIntoCells(this->Files(), triangles, facts.triangles, ranks,
        mesh.begin.empty() ? CellOfRank(facts.vertices, mesh.blockDepth) : CellOfRank(mesh.begin),
        this->Memory, this->Part("faces", 0.2, 0.6));
    if (!buckets)
    {
      return buckets.GetError();
    }
    status = CheckHubs(mesh, *buckets, this->Options.memory);
    if (status && facts.pointTupleBytes > 0)
    {
      status = Take(SortTuplesByRank(this->Files(), tuples, facts.pointTupleBytes, ranks,
                      this->Memory, this->Part("faces", 0.6, 0.8)),
        mesh.pointTuples);
    }
    std::uint64_t merged = 0;
    if (status)
    {
      status = Take(this->CountMergedByGrid(mesh), merged);
    }
    if (!status)
    {
      return status;
    }
    BlobWriter blob;
    blob.Add(merged);
    blob.AddList(mesh.begin);
    SpillFile bucketFile = buckets->Save(blob);
    this->Clock.Finish("faces");
    PhaseFile files[] = { { "triangles", std::move(bucketFile) },
      { "tuples", std::move(mesh.pointTuples) } };
    return this->Folder->Finish(
      "faces", blob, files, { { "mesh", "triangles" }, { "mesh", "tuples" } });
  }

  Result<std::uint64_t> CountMergedByGrid(const MeshBlocks& mesh)
  {
    const CoordinateGrid grid = GridOf(this->Options, mesh.box, mesh.scalarType);
    if (grid.Lossless())
    {
      return std::uint64_t{ 0 };
    }
    const auto count = [&](double begin, const std::function<Vec3(const Vec3&)>& placeOf)
    {
      return (mesh.floats ? CountPlacesExternally<float>
                          : CountPlacesExternally<double>)(this->Files(), mesh.records,
        mesh.vertexCount, placeOf, this->Memory, this->Part("faces", begin, begin + 0.1));
    };
    const Result<std::uint64_t> exact =
      mesh.mayCoincide ? count(0.8, {}) : Result<std::uint64_t>(std::uint64_t{ mesh.vertexCount });
    const Result<std::uint64_t> snapped =
      exact ? count(0.9, [&](const Vec3& p) { return grid.Snap(p); }) : exact;
    return snapped ? Result<std::uint64_t>(*exact - std::min(*exact, *snapped)) : snapped;
  }

  // The blocks that the phase "faces" has made, maybe with another limit. begin: those of an
  // octree.
  Status TakeBlocks(std::vector<VertexId> begin, std::size_t count, MeshBlocks& mesh) const
  {
    unsigned depth = 0;
    while (std::size_t{ 1 } << depth < count)
    {
      ++depth;
    }
    const auto largest = [](const MeshBlocks& blocks)
    {
      std::uint64_t most = 0;
      for (std::size_t block = 0; block < blocks.BlockCount(); ++block)
      {
        most = std::max(most, blocks.RangeOf(block).size);
      }
      return most;
    };
    const std::uint64_t allowed = std::max(largest(mesh), this->MostInBlock);
    mesh.begin = std::move(begin);
    if (this->ByOctree() ? largest(mesh) > allowed : depth < mesh.blockDepth)
    {
      return Error{ ErrorCode::LimitExceeded,
        "the interrupted build had more memory than this one; build without --resume" };
    }
    mesh.blockDepth = depth;
    return {};
  }

  // The mesh as all phases up to "faces" leave it.
  Status LoadBlocks(MeshFacts& facts, MeshBlocks& mesh)
  {
    Status status = this->LoadMesh(facts, mesh);
    if (!status)
    {
      return status;
    }
    BlobReader blob = this->Folder->BlobOf("faces");
    this->Report.mergedByGrid = blob.Read<std::uint64_t>();
    std::vector<VertexId> begin = blob.ReadList<VertexId>();
    SpillFile file;
    status = Take(this->Folder->TakeFile("faces", "triangles"), file);
    if (!status)
    {
      return status;
    }
    Result<RecordBuckets<NumberedTriangle>> buckets =
      RecordBuckets<NumberedTriangle>::Restore(std::move(file), blob);
    if (!buckets)
    {
      return buckets.GetError();
    }
    status = this->TakeBlocks(std::move(begin), buckets->BucketCount(), mesh);
    if (!status)
    {
      return status;
    }
    mesh.triangles.emplace(std::move(*buckets));
    status = Take(this->Folder->TakeFile("faces", "tuples"), mesh.pointTuples);
    return status ? Take(this->Folder->TakeFile("mesh", "cells"), mesh.cellTuples) : status;
  }

  Status CountEdges()
  {
    MeshFacts facts;
    MeshBlocks mesh;
    Status status = this->LoadBlocks(facts, mesh);
    mesh.attributes.clear(); // they are not looked at
    std::uint64_t inconsistent = 0;
    const Execution part = this->Part("faces", 0.8, 1);
    for (std::size_t b = 0; status && b < mesh.BlockCount(); ++b)
    {
      const Result<TreeBlock> block = mesh.Load(b);
      if (!block)
      {
        return block.GetError();
      }
      inconsistent += CountInconsistentEdges(block->mesh.triangles, block->mesh.points.size(),
        this->Exec, [&](VertexId v) { return block->IsOwn(v); });
      status = part.Report("faces", double(b + 1) / double(mesh.BlockCount()));
    }
    if (!status)
    {
      return status;
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
    Status status = this->LoadBlocks(facts, mesh);
    std::uint64_t inconsistent = 0;
    ExternalLevels levels;
    if (status)
    {
      status = Take(
        BuildExternalLevels(this->Files(), mesh, this->Options.levels, this->Part("levels", 0, 0.8),
          [&](const TreeBlock& block)
          {
            inconsistent += CountInconsistentEdges(block.mesh.triangles, block.mesh.points.size(),
              this->Exec, [&](VertexId v) { return block.IsOwn(v); });
          }),
        levels);
    }
    if (!status)
    {
      return status;
    }
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
    if (Status status = this->LoadBlocks(facts, mesh); !status)
    {
      return status;
    }
    BlobReader blob = this->Folder->BlobOf("edges");
    inconsistent = blob.Read<std::uint64_t>();
    return blob.Finish();
  }

  // The mesh and its levels as all phases up to "levels" leave them.
  Status LoadLevels(
    MeshFacts& facts, MeshBlocks& mesh, ExternalLevels& levels, std::uint64_t& inconsistent)
  {
    if (Status status = this->LoadBlocks(facts, mesh); !status)
    {
      return status;
    }
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
    Status status = this->LoadLevels(facts, mesh, levels, inconsistent);
    if (status)
    {
      status =
        Take(NumberExternally(this->Files(), mesh, levels, this->Part("levels", 0.8, 1)), numbers);
    }
    if (!status)
    {
      return status;
    }
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
    Status status = this->ByOctree() ? this->LoadEdges(facts, mesh, inconsistent)
                                     : this->LoadLevels(facts, mesh, levels, inconsistent);
    if (status && !this->ByOctree())
    {
      status = this->LoadNumbers(numbers);
    }
    if (!status)
    {
      return status;
    }
    this->Report.ignoredAttributes = facts.ignored;
    const StoreInfo description = this->Describe(facts, mesh, inconsistent);
    Result<std::unique_ptr<StoreWriter>> writer = StoreWriter::Create(this->Store, description);
    if (!writer)
    {
      return writer.GetError();
    }
    status = WriteTreePages(this->Boxes, mesh.depths, **writer);
    if (status)
    {
      status = this->WriteParts(mesh, levels, numbers, description.Codec(), **writer);
    }
    if (status)
    {
      status = Take((*writer)->Finish(), this->Report.info);
    }
    this->Clock.Finish("write");
    return status;
  }

  std::uint64_t PartitionCount(const MeshBlocks& mesh) const
  {
    return this->ByOctree() ? this->PartitionBegin.size() - 1
                            : std::uint64_t{ 1 } << mesh.depths.partition;
  }

  StoreInfo Describe(const MeshFacts& facts, const MeshBlocks& mesh, std::uint64_t inconsistent)
  {
    ModelFacts model;
    model.vertices = facts.vertices;
    model.triangles = facts.triangles;
    model.welded = facts.welded;
    model.inconsistentEdges = inconsistent;
    model.depths = mesh.depths;
    model.partitions = this->PartitionCount(mesh);
    model.smallestPartition = facts.vertices >> mesh.depths.partition;
    model.largestPartition = (facts.vertices + model.partitions - 1) >> mesh.depths.partition;
    if (this->ByOctree())
    {
      model.smallestPartition = facts.vertices;
      model.largestPartition = 0;
      for (std::size_t p = 0; p < model.partitions; ++p)
      {
        const std::uint64_t size = this->PartitionBegin[p + 1] - this->PartitionBegin[p];
        model.smallestPartition = std::min(model.smallestPartition, size);
        model.largestPartition = std::max(model.largestPartition, size);
      }
    }
    model.box = mesh.box;
    model.scalarType = facts.scalarType;
    model.attributes = facts.attributes;
    BuildOptions used = this->Options;
    used.weld = facts.weld;
    return DescribeModel(used, model,
      this->Options.inputName.empty() ? this->Input.filename().string() : this->Options.inputName);
  }

  Status WriteParts(const MeshBlocks& mesh, const ExternalLevels& levels,
    const ExternalNumbers& numbers, const CodecContext& codec, StoreWriter& writer)
  {
    std::uint64_t triangles = 0; // of the resolution
    const PartVisit write =
      [&](const VertexTree& tree, const Mesh& part, Resolution resolution, const ModelPart& pieces)
    {
      const PieceCutter cutter(tree, part, resolution, this->Exec, pieces);
      const unsigned depth = PieceDepth(resolution, mesh.depths);
      const std::size_t all =
        resolution.IsOriginal() ? this->PartitionCount(mesh) : std::size_t{ 1 } << depth;
      Status status =
        WritePieces(cutter, cutter.PieceCount(), codec, writer, this->Clock, this->Exec,
          [&](std::size_t written)
          {
            const double done = double(pieces.firstPiece + written) / double(all);
            return this->Exec.Report("encode", EncodedPart(resolution, mesh.depths, done));
          });
      triangles += cutter.TriangleCount();
      if (status && pieces.firstPiece + cutter.PieceCount() == all)
      {
        status = writer.FinishResolution(resolution, triangles);
        triangles = 0;
      }
      ReturnFreeMemory(mesh.keptMemory);
      return status;
    };
    return this->ByOctree() ? ForEachPartOfPartitions(mesh, this->PartitionBegin, write, this->Exec)
                            : ForEachPart(mesh, levels, numbers, write, this->Exec);
  }

  const std::filesystem::path Input, Store;
  const BuildOptions& Options;
  const Execution& Exec;
  const ExternalBuildProbe& Probe;
  std::uint64_t Memory;
  std::optional<BuildFolder> Folder;
  StepClock Clock;
  std::string_view Step; // that is shown, and how much of it
  double StepDone = 0;
  std::vector<Box> Boxes;
  std::vector<VertexId> PartitionBegin; // ranks, and the end; of an octree
  std::uint64_t MostInBlock = 0;        // vertices; the same
  BuildReport Report;
};

}

Status CheckExternalBuild(const BuildOptions& options)
{
  if (options.partitioner == Partitioner::KMeans)
  {
    return Error{ ErrorCode::LimitExceeded,
      "stores by k-means, whose iterations go over all vertices, are built in memory alone" };
  }
  if (options.memory < leastMemory)
  {
    return Error{ ErrorCode::LimitExceeded,
      "building out of core takes at least " + Mebibytes(leastMemory) };
  }
  return {};
}

Result<BuildReport> BuildStoreExternally(const std::filesystem::path& input,
  const std::filesystem::path& store, const BuildOptions& options, const Execution& execution,
  const ExternalBuildProbe& probe)
{
  if (const Status possible = CheckExternalBuild(options); !possible)
  {
    return possible.GetError();
  }
  return ExternalBuilder(input, store, options, execution, probe).Build();
}

}
