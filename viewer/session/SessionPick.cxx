// SPDX-License-Identifier: BSD-3-Clause
// What a double tap leads to: the point under the finger, the partition nearest to it, and the
// region around that, as soon as enough of the tree is known.
#include "viewer/session/ViewerSession.h"

#include "filters/core/tree/Region.h"

#include <algorithm>
#include <set>
#include <utility>

namespace kdstream
{

// The tangent of the angle that a finger covers.
double ViewerSession::FingerSlack() const
{
  const double pixels = this->Options.fingerPoints * this->Eye.GetViewport().pixelRatio;
  return pixels / (this->Eye.PixelsPerUnit() * this->Eye.Distance());
}

std::optional<SurfaceHit> ViewerSession::PickUnder(double x, double y) const
{
  return this->Pick(this->Eye.RayOf(x, y), this->FingerSlack());
}

void ViewerSession::DoubleTap(double x, double y)
{
  this->Retry();
  this->DropPick();
  if (const auto hit = this->PickUnder(x, y))
  {
    this->WaitingPick = hit->point;
    this->GiveWayToTap();
  }
  else
  {
    this->Region.reset();
    this->EarlierTaps.clear();
    this->JumpHome();
    this->FollowZoom();
  }
}

// Much may be under way, and it would come first: it is called back, but for the tree.
void ViewerSession::GiveWayToTap()
{
  this->Wanted.KeepTreeOnly();
  this->ChoiceIsDue = true;
}

void ViewerSession::DropPick()
{
  this->WaitingPick.reset();
  this->WaitingCell.reset();
  this->AskedForPick = 0;
}

// As far as what is known of the tree leads; what else is needed, the tree notes as missing.
void ViewerSession::FollowPick()
{
  Model& model = *this->Current;
  if (this->WaitingPick)
  {
    const NearestAnswer nearest =
      NearestKnownPartition(model.tree, model.codec.depths, *this->WaitingPick);
    if (!nearest.known)
    {
      return;
    }
    this->WaitingPick.reset();
    if (nearest.partition)
    {
      this->WaitingCell = NodeOfPartition(*nearest.partition, model.codec.depths);
    }
    else
    {
      this->LastError = "The tree of " + this->ModelId + " has no partitions.";
    }
  }
  if (this->WaitingCell && this->SetRegion(*this->WaitingCell))
  {
    this->DropPick();
    this->GiveWayToTap(); // nor does what waits go before it
  }
}

// False where not enough of the tree is known. REQUIRES: `cell` is a partition's.
bool ViewerSession::SetRegion(NodeId cell)
{
  Model& model = *this->Current;
  const TreeDepths& depths = model.codec.depths;
  PickedRegion region;
  region.cell = cell;
  region.rings = this->Options.rings;
  auto found = FindKnownRegion(model.tree, depths, region.cell, region.rings);
  if (!found)
  {
    return false;
  }
  region.partitions = std::move(*found);
  if (region.partitions.size() > this->MostOfRegion())
  {
    region.partitions.resize(this->MostOfRegion());
  }
  for (const std::uint32_t partition : region.partitions)
  {
    region.boxes.push_back(*model.tree.OfPartition(NodeOfPartition(partition, depths)));
    region.box.Add(region.boxes.back());
  }
  if (this->Region && this->ByView())
  {
    this->AddToRegion(*this->Region);
  }
  this->Region = std::move(region);
  return true;
}

// On average; of a cloud, points.
std::uint64_t ViewerSession::TrianglesOfPartition() const
{
  const ModelDescription& model = this->Current->description;
  return std::max<std::uint64_t>(
    std::max(model.triangles, model.vertices) / std::max<std::uint64_t>(model.partitions, 1), 1);
}

// Partitions.
std::size_t ViewerSession::MostOfRegion() const
{
  const auto most =
    std::max<std::uint64_t>(this->Options.mostRegionTriangles / this->TrianglesOfPartition(), 1);
  return static_cast<std::size_t>(
    std::min<std::uint64_t>(most, this->Options.mostRegionPartitions));
}

// Where less may be held than when it was picked.
void ViewerSession::CutRegion()
{
  if (this->Region && this->Region->partitions.size() > this->MostOfRegion())
  {
    this->Region->partitions.resize(this->MostOfRegion());
    this->Region->boxes.resize(this->MostOfRegion());
    this->EarlierTaps.clear();
  }
}

std::vector<Box> ViewerSession::RegionBoxes() const
{
  return this->Region ? this->Region->boxes : std::vector<Box>();
}

}
