// SPDX-License-Identifier: BSD-3-Clause
#include "viewer/sources/ViewCut.h"

#include "filters/core/drawing/Cut.h"
#include "viewer/session/Camera.h"
#include "viewer/session/model/KnownTree.h"
#include "viewer/session/model/PieceCache.h"
#include "viewer/session/model/ViewRefinement.h"
#include "viewer/session/model/VisiblePartitions.h"

#include <cmath>
#include <cstddef>
#include <limits>
#include <set>
#include <span>
#include <utility>

namespace kdstream
{
namespace
{

constexpr std::size_t bytesOfTree = std::size_t{ 256 } << 20;
// As in kdstream-view: a model of at most an eighth of the budget is shown four times as fine.
constexpr std::uint64_t smallPart = 8;

// The parts of a model that have been read: as deep in the tree as the camera needs.
class Seen
{
public:
  Seen(const PieceSource& source, const Execution& execution)
    : Source(source)
    , Runs(execution)
    , Depths(source.Info().depths)
    , Tree(this->Depths, true, source.Info().box, bytesOfTree)
    , Partitions(this->Depths)
  {
  }

  // Reads the preview, which shows whether the surface is closed.
  Status Start()
  {
    const PieceId preview{ Resolution::Level(PreviewLevel(this->Depths)), 1 };
    KDSTREAM_TRY(this->Read(std::span(&preview, 1)));
    this->IsClosed = VisiblePartitions::IsNearlyClosed(*this->Pieces.Peek(preview));
    return {};
  }

  void Follow(const Camera& camera, ViewRefinement& refinement)
  {
    this->Partitions.Cull(camera, this->IsClosed);
    refinement.Follow({ camera, this->Tree, this->Pieces, &this->Partitions, false }, {}, {});
  }

  // Reads the missing pages, and the wanted pieces up to level S. These show what is hidden, and
  // finer pieces need them. Returns whether anything new was read: then call Follow again.
  Result<bool> ReadMore(const std::vector<PieceId>& wanted)
  {
    const std::uint64_t known = this->Tree.Version();
    const std::set<protocol::BlobId> pages = this->Tree.TakeMissing();
    for (const protocol::BlobId& page : pages)
    {
      const auto bytes = this->Source.Read(page, this->Runs);
      KDSTREAM_TRY(bytes);
      const Status added = this->Tree.Add(page, *bytes);
      if (!added)
      {
        return Error{ added.GetError().code,
          protocol::BlobName(page) + ": " + added.GetError().message };
      }
    }
    const Resolution preview = Resolution::Level(PreviewLevel(this->Depths));
    std::vector<PieceId> missing = MakeClosure(this->Depths, preview, wanted,
      [this](PieceId piece) {
        return this->Pieces.Peek(piece);
      }).missing;
    std::erase_if(missing,
      [this](PieceId piece) { return piece.resolution > Resolution::Level(this->Depths.stitch); });
    KDSTREAM_TRY(this->Read(missing));
    return this->Tree.Version() != known || !missing.empty();
  }

private:
  Status Read(std::span<const PieceId> ids)
  {
    auto pieces = this->Source.ReadPieces(ids, this->Runs);
    KDSTREAM_TRY(pieces);
    for (Piece& piece : *pieces)
    {
      this->Partitions.Add(piece);
      this->Pieces.Add(std::move(piece));
    }
    return {};
  }

  const PieceSource& Source;
  const Execution& Runs;
  TreeDepths Depths;
  KnownTree Tree;
  VisiblePartitions Partitions;
  PieceCache Pieces{ std::numeric_limits<std::size_t>::max() };
  bool IsClosed = false;
};

}

Result<std::vector<PieceId>> ChooseByView(
  const PieceSource& source, const ViewDemand& demand, const Execution& execution)
{
  const ModelDescription& model = source.Info();
  if (!model.HasLevels())
  {
    return Error{ ErrorCode::Unsupported, "the model has no levels, only partitions" };
  }
  const SceneCamera& scene = demand.camera;
  KDSTREAM_TRY(CheckCamera(scene));
  Camera camera;
  camera.SetViewport({ demand.width, demand.height, 1 });
  camera.LookFrom(scene.eye, scene.focal, scene.up, std::tan(0.5 * scene.verticalFieldOfView));

  RefinementOptions options;
  options.tolerance = demand.tolerance;
  options.triangles = demand.triangles;
  options.smallModel = demand.triangles / smallPart;
  options.bytes = std::numeric_limits<std::size_t>::max();
  ViewRefinement refinement(model, options);
  Execution walk; // progress stays 0: the number of steps is not known
  walk.progress = [&execution](std::string_view, double) { return execution.progress("view", 0); };
  Seen seen(source, walk);
  KDSTREAM_TRY(seen.Start());
  for (;;)
  {
    KDSTREAM_TRY(walk.Report("view", 0));
    seen.Follow(camera, refinement);
    const auto more = seen.ReadMore(refinement.Pieces());
    KDSTREAM_TRY(more);
    if (!*more)
    {
      return refinement.Pieces();
    }
  }
}

}
