// SPDX-License-Identifier: BSD-3-Clause
// The model that is open: see ShownModel.h.
#include "viewer/session/model/ShownModel.h"

#include "viewer/session/model/ViewRefinement.h"
#include "viewer/session/model/VisiblePartitions.h"

#include <algorithm>
#include <utility>

namespace kdstream
{

void ShownModel::Select(const std::string& model)
{
  this->id = model;
  this->failed.SetModel(model);
  this->pieces.Clear();
  this->surface.Reset({});
  this->tiles.Reset({}, {});
  this->section.Reset({});
  this->open.reset();
}

bool ShownModel::Open(const ModelDescription& model, std::size_t treeBytes)
{
  if (model.levels.size() != model.depths.finest + std::size_t{ 1 })
  {
    this->failed.Report(
      this->id + " cannot be shown: it has no levels of detail, only partitions.");
    return false;
  }
  this->open.emplace(Opened{
    model, model.Codec(), KnownTree(model.depths, model.HasLevels(), model.box, treeBytes) });
  this->surface.Reset(model.depths);
  std::vector<double> spacings;
  for (const ResolutionDescription& level : model.levels)
  {
    spacings.push_back(VertexSpacing(model.box, static_cast<double>(level.vertices)));
  }
  spacings.push_back(VertexSpacing(model.box, static_cast<double>(model.vertices)));
  this->tiles.Reset(model, std::move(spacings));
  this->surface.KeepCorners(this->tiles.AreThere(), model.textures && model.textures->levels);
  this->section.Reset(model.box);
  return true;
}

PieceId ShownModel::Preview() const
{
  return { Resolution::Level(PreviewLevel(this->open->description)), 1 };
}

std::uint64_t ShownModel::TrianglesOfPartition() const
{
  const ModelDescription& model = this->open->description;
  return std::max<std::uint64_t>(
    std::max(model.triangles, model.vertices) / std::max<std::uint64_t>(model.partitions, 1), 1);
}

void ShownModel::Add(Piece piece)
{
  if (piece.id.resolution == this->Preview().resolution)
  {
    this->open->isClosed = VisiblePartitions::IsNearlyClosed(piece);
  }
  this->pieces.Add(std::move(piece));
}

void ShownModel::Retry()
{
  this->failed.Retry();
  this->tiles.Retry();
}

void ShownModel::FollowSection()
{
  this->section.Follow(this->Drawn(), this->surface.Version(), this->open && this->open->isClosed);
}

}
