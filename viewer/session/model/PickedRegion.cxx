// SPDX-License-Identifier: BSD-3-Clause
// What a double tap picks: see PickedRegion.h.
#include "viewer/session/model/PickedRegion.h"

#include "filters/core/tree/Region.h"

#include <algorithm>

namespace kdstream
{

PickedRegion::PickedRegion(
  ShownModel& model, unsigned rings, const RegionLimits& limits, std::uint64_t viewTriangles)
  : Model(model)
  , Rings(std::clamp(rings, 1u, 3u))
  , Limits(limits)
  , ViewTriangles(viewTriangles)
{
}

// ---- a pick

void PickedRegion::PickAt(const Vec3& point)
{
  this->DropPick();
  this->Point = point;
}

void PickedRegion::PickCell(NodeId cell)
{
  this->DropPick();
  this->Cell = cell;
}

void PickedRegion::DropPick()
{
  this->Point.reset();
  this->Cell.reset();
  this->Asked = 0;
}

bool PickedRegion::Follow(bool keepsLast)
{
  if (this->Point)
  {
    const TreeDepths& depths = this->Model.Depths();
    const NearestAnswer nearest =
      NearestKnownPartition(this->Model.open->tree, depths, *this->Point);
    if (!nearest.known)
    {
      return false;
    }
    this->Point.reset();
    if (nearest.partition)
    {
      this->Cell = NodeOfPartition(*nearest.partition, depths);
    }
    else
    {
      this->Model.failed.Report("The tree of " + this->Model.id + " has no partitions.");
    }
  }
  if (!this->Cell || !this->Find(keepsLast))
  {
    return false;
  }
  this->DropPick();
  return true;
}

// Finds the region around the picked cell. False if not enough of the tree is known.
bool PickedRegion::Find(bool keepsLast)
{
  KnownTree& tree = this->Model.open->tree;
  const TreeDepths& depths = this->Model.Depths();
  auto found = FindKnownRegion(tree, depths, *this->Cell, this->Rings);
  if (!found)
  {
    return false;
  }
  Region region{ *this->Cell, this->Rings, std::move(*found), {}, {} };
  if (region.partitions.size() > this->MostPartitions())
  {
    region.partitions.resize(this->MostPartitions());
  }
  for (const std::uint32_t partition : region.partitions)
  {
    region.boxes.push_back(*tree.OfPartition(NodeOfPartition(partition, depths)));
    region.box.Add(region.boxes.back());
  }
  if (this->Shown && keepsLast)
  {
    this->Keep(*this->Shown);
  }
  this->Shown = std::move(region);
  return true;
}

void PickedRegion::NoteAsked(std::size_t treeBlobs)
{
  this->Asked += this->IsPicking() ? treeBlobs : 0;
  if (this->Asked > this->Limits.treeBlobs)
  {
    this->Model.failed.Report(
      "The region around the tap is too large: it has too many partitions.");
    this->DropPick();
  }
}

// ---- the region

void PickedRegion::SetRings(unsigned rings)
{
  this->Rings = std::clamp(rings, 1u, 3u);
  if (this->Shown && this->Shown->rings != this->Rings)
  {
    this->PickCell(this->Shown->cell);
  }
}

std::size_t PickedRegion::MostPartitions() const
{
  const auto most =
    std::max<std::uint64_t>(this->Limits.triangles / this->Model.TrianglesOfPartition(), 1);
  return static_cast<std::size_t>(std::min<std::uint64_t>(most, this->Limits.partitions));
}

void PickedRegion::SetTriangles(std::uint64_t triangles, std::uint64_t viewTriangles)
{
  this->Limits.triangles = triangles;
  this->ViewTriangles = viewTriangles;
  if (this->Shown && this->Shown->partitions.size() > this->MostPartitions())
  {
    this->Shown->partitions.resize(this->MostPartitions());
    this->Shown->boxes.resize(this->MostPartitions());
    this->Earlier.clear();
  }
}

void PickedRegion::FollowZoom(double pointsPerUnit)
{
  if (this->Shown &&
      Length(this->Shown->box.hi - this->Shown->box.lo) * pointsPerUnit < this->Limits.points)
  {
    this->Shown.reset();
  }
}

// Adds the partitions of the last region to those of earlier regions. Keeps at most as many as fit
// the budget, and as a single region may have; the oldest go first.
void PickedRegion::Keep(const Region& last)
{
  this->Earlier.insert(this->Earlier.begin(), last.partitions.begin(), last.partitions.end());
  const auto most = std::min<std::uint64_t>(
    this->MostPartitions(), this->ViewTriangles / 2 / this->Model.TrianglesOfPartition());
  std::set<std::uint32_t> once;
  std::erase_if(this->Earlier,
    [&](std::uint32_t partition) { return once.size() >= most || !once.insert(partition).second; });
}

void PickedRegion::ForgetEarlier(const Camera& camera)
{
  const SectionPlane* section = this->Model.Plane();
  std::erase_if(this->Earlier,
    [&](std::uint32_t partition)
    {
      const Box* box = this->Model.open->tree.Around(this->Model.Partition(partition).node);
      const bool isGone = box && section && section->CutsAwayAllOf(*box);
      return isGone || (box && !camera.MaySee(*box));
    });
}

void PickedRegion::LetGo()
{
  this->DropPick();
  this->Shown.reset();
  this->Earlier.clear();
}

std::pair<NodeId, unsigned> PickedRegion::Key() const
{
  return this->Shown ? std::pair(this->Shown->cell, this->Shown->rings)
                     : std::pair<NodeId, unsigned>();
}

std::vector<Box> PickedRegion::Boxes() const
{
  return this->Shown ? this->Shown->boxes : std::vector<Box>();
}

// The partitions that the section does not cut away.
std::vector<std::uint32_t> PickedRegion::Left() const
{
  std::vector<std::uint32_t> left;
  const SectionPlane* section = this->Model.Plane();
  for (std::size_t i = 0; i < this->Shown->partitions.size(); ++i)
  {
    if (!section || !section->CutsAwayAllOf(this->Shown->boxes[i]))
    {
      left.push_back(this->Shown->partitions[i]);
    }
  }
  return left;
}

void PickedRegion::AddTo(std::vector<PieceId>& pieces) const
{
  for (const std::vector<std::uint32_t>& partitions : { this->Left(), this->Earlier })
  {
    for (const std::uint32_t partition : partitions)
    {
      pieces.push_back(this->Model.Partition(partition));
    }
  }
}

ViewerStatus::Region PickedRegion::GetStatus() const
{
  ViewerStatus::Region status{ this->Shown->cell, this->Shown->rings, 0, 0 };
  for (const std::uint32_t partition : this->Left())
  {
    ++status.partitions;
    status.shown += this->Model.surface.IsRefined(partition) ? 1 : 0;
  }
  return status;
}

}
