// SPDX-License-Identifier: BSD-3-Clause
// What a double tap picks: the partition nearest to the point under the finger, and the region
// around it, as soon as enough of the tree is known (paper section 5.4). Step "pick" of the
// pipeline picture.
#pragma once

#include "viewer/session/SessionOptions.h"
#include "viewer/session/model/ShownModel.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <utility>
#include <vector>

namespace kdstream
{

// There is one region at a time. Earlier regions may be kept, as far as the budget allows.
class PickedRegion
{
public:
  // viewTriangles: the triangles that may be shown at a time; all regions together take at most
  // half of them.
  PickedRegion(
    ShownModel& model, unsigned rings, const RegionLimits& limits, std::uint64_t viewTriangles);
  PickedRegion(const PickedRegion&) = delete;

  // ---- a pick, which waits until enough of the tree is known
  void PickAt(const Vec3& point);
  // REQUIRES: the node of a partition.
  void PickCell(NodeId cell);
  bool IsPicking() const { return this->Point || this->Cell; }
  // Continues as far as the known part of the tree allows; the tree records as missing what else is
  // needed. True if the region has changed. keepsLast: the last region is kept, too.
  bool Follow(bool keepsLast);
  // Counts tree pages and boxes that were requested for the pick. If there are too many, the pick
  // ends with a message.
  void NoteAsked(std::size_t treeBlobs);
  void DropPick();

  // ---- the region. Sets the rings of this region, which is picked again, and of later ones.
  // Clamped to 1-3.
  void SetRings(unsigned rings);
  // Sets limits, also for the current region: it becomes smaller if it exceeds them.
  void SetTriangles(std::uint64_t triangles, std::uint64_t viewTriangles);
  // Drops a region that has become too small. pointsPerUnit: points of the screen for one model
  // unit in the focal plane.
  void FollowZoom(double pointsPerUnit);
  bool IsShown() const { return this->Shown.has_value(); }
  // Whether partitions of earlier regions are left. Forgets those that have left the view.
  bool HasEarlier() const { return !this->Earlier.empty(); }
  void ForgetEarlier(const Camera& camera);
  void ForgetEarlier() { this->Earlier.clear(); }
  // Drops the region, earlier regions, and a waiting pick.
  void LetGo();

  // The region's cell and rings; 0 and 0 without a region.
  std::pair<NodeId, unsigned> Key() const;
  // The boxes of the region's partitions, that of the picked one first; none without a region.
  std::vector<Box> Boxes() const;
  // Appends the region's partitions, without those that the section cuts away, and the partitions
  // of earlier regions. REQUIRES, for the next two: a region.
  void AddTo(std::vector<PieceId>& pieces) const;
  // How many of the region's partitions the section leaves, and how many of these are shown.
  ViewerStatus::Region GetStatus() const;

private:
  struct Region
  {
    NodeId cell = 1;
    unsigned rings = 1;
    std::vector<std::uint32_t> partitions; // nearest first
    Box box;
    std::vector<Box> boxes; // of these partitions
  };
  bool Find(bool keepsLast);
  std::size_t MostPartitions() const;
  void Keep(const Region& last);
  std::vector<std::uint32_t> Left() const;

  ShownModel& Model;
  unsigned Rings;
  RegionLimits Limits;
  std::uint64_t ViewTriangles;
  // A waiting pick: the tapped point, until its partition is known; then the partition's node,
  // until the partitions around it are known.
  std::optional<Vec3> Point;
  std::optional<NodeId> Cell;
  std::size_t Asked = 0;
  std::optional<Region> Shown;
  std::vector<std::uint32_t> Earlier; // partitions of earlier regions, newest first
};

}
