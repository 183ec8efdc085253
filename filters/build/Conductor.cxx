// SPDX-License-Identifier: BSD-3-Clause
// The conductor of a build: see Conductor.h. First the steps of the back end; then the model's
// description, pieces, textures of levels, pages of the tree, unused vertices, home view.
#include "filters/build/Conductor.h"

#include "filters/build/GuessHomeView.h"
#include "filters/build/LevelTextures.h"
#include "filters/core/TakeResult.h"

#include <algorithm>
#include <utility>

namespace kdstream
{
namespace
{

Status MakeSteps(BuildBackEnd& backEnd)
{
  const std::function<Status()> firstBodies[] = { [&] { return backEnd.MakeMesh(); },
    [&] { return backEnd.MakeTree(); }, [&] { return backEnd.MakeFaces(); } };
  std::vector<BuildStep> steps = backEnd.StepsAfterFaces();
  for (std::size_t i = std::size(firstSteps); i > 0; --i)
  {
    steps.insert(
      steps.begin(), { firstSteps[i - 1].first, firstSteps[i - 1].second, firstBodies[i - 1] });
  }
  for (const BuildStep& step : steps)
  {
    if (backEnd.IsFinished(step.name))
    {
      ++backEnd.State().Report.resumedPhases;
      continue;
    }
    KDSTREAM_TRY(step.make());
    backEnd.State().Clock.Finish(step.step);
  }
  return {};
}

bool HasLevelTextures(const ModelDescription& model)
{
  return model.textures && model.textures->levels;
}

Status WriteParts(BuildBackEnd& backEnd, const ModelDescription& model, StoreWriter* writer)
{
  BuildState& build = backEnd.State();
  CodecContext codec = model.Codec();
  codec.coarseColors = HasLevelTextures(model);
  const PieceEncoding encoding{ codec, build.Options.textures.get() };
  const double ofPieces = HasLevelTextures(model) ? encodedBeforeLevelTextures : 1;
  std::uint64_t triangles = 0; // of the resolution
  const PartVisit write = [&](const VertexTree& tree, const Mesh& mesh, Resolution resolution,
                            const ModelPart& part) -> Status
  {
    const PieceCutter cutter(tree, mesh, resolution, build.Exec, part);
    const std::size_t all = resolution.IsOriginal()
                              ? static_cast<std::size_t>(build.Facts.partitions)
                              : std::size_t{ 1 } << PieceDepth(resolution, build.Facts.depths);
    // The last leaves of a baseline's tree are empty, and have no pieces.
    const std::size_t count = std::min(cutter.PieceCount(), all - part.firstPiece);
    KDSTREAM_TRY(backEnd.TakePieces(cutter, count, encoding, writer,
      [&](std::size_t written)
      {
        const double done = double(part.firstPiece + written) / double(all);
        return build.Exec.Report(
          "encode", ofPieces * EncodedPart(resolution, build.Facts.depths, done));
      }));
    triangles += cutter.TriangleCount();
    return {};
  };
  return backEnd.ForEachPart(write, [&](Resolution resolution)
    { return backEnd.FinishResolution(resolution, std::exchange(triangles, 0), writer); });
}

Status WriteStore(BuildBackEnd& backEnd, const std::filesystem::path& store)
{
  BuildState& build = backEnd.State();
  KDSTREAM_TRY(backEnd.Describe());
  KDSTREAM_TRY(build.Exec.Report("encode", 0));
  ModelDescription description = DescribeModel(build.Options, build.Facts, backEnd.InputName());
  KDSTREAM_TRY(Take(backEnd.DigestOfInput(), description.inputDigest));
  std::unique_ptr<StoreWriter> writer;
  if (backEnd.WritesStore())
  {
    KDSTREAM_TRY(Take(StoreWriter::Create(store, description), writer));
  }
  KDSTREAM_TRY(WriteParts(backEnd, description, writer.get()));
  if (writer && HasLevelTextures(description))
  {
    KDSTREAM_TRY(WriteLevelTextures(
      *build.Options.textures, build.Boxes, description, *writer, build.Clock, build.Exec));
  }
  if (writer)
  {
    KDSTREAM_TRY(WriteTreePages(build.Boxes, build.Facts.depths, *writer));
    KDSTREAM_TRY(backEnd.WriteUnusedList(*writer));
  }
  KDSTREAM_TRY(build.Exec.Report("write", 0));
  if (writer)
  {
    KDSTREAM_TRY(TellHomeView(build.Options, description, *writer));
  }
  build.Report.info = description;
  KDSTREAM_TRY(backEnd.Agree()); // before the store is renamed to its final name
  if (writer)
  {
    KDSTREAM_TRY(Take(writer->Finish(), build.Report.info));
  }
  build.Clock.Finish("write");
  return backEnd.Agree();
}

}

Status BuildBackEnd::TakePieces(const PieceCutter& cutter, std::size_t count,
  const PieceEncoding& encoding, StoreWriter* writer,
  const std::function<Status(std::size_t)>& written)
{
  BuildState& build = this->State();
  return WritePieces(cutter, count, encoding, *writer, build.Clock, build.Exec, written);
}

Status BuildBackEnd::FinishResolution(
  Resolution resolution, std::uint64_t triangles, StoreWriter* writer)
{
  return writer->FinishResolution(resolution, triangles, this->State().Exec);
}

Result<BuildReport> ConductBuild(BuildBackEnd& backEnd, const std::filesystem::path& store)
{
  BuildState& build = backEnd.State();
  KDSTREAM_TRY(MakeSteps(backEnd));
  KDSTREAM_TRY(WriteStore(backEnd, store));
  const SpillCounts counts = backEnd.Costs();
  BuildReport& report = build.Report;
  report.scalarType = build.Facts.scalarType;
  report.temporaryBytes = counts.peakBytesOnDisk;
  report.bytesRead = counts.bytesRead;
  report.bytesWritten = counts.bytesWritten;
  report.seconds = build.Clock.Take();
  return std::move(report);
}

}
