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

// One region at a time. Those before it may be kept, as far as the budget goes.
class PickedRegion
{
public:
  // viewTriangles: that may be shown at a time; all regions together take at most half of them.
  PickedRegion(
    ShownModel& model, unsigned rings, const RegionLimits& limits, std::uint64_t viewTriangles);
  PickedRegion(const PickedRegion&) = delete;

  // ---- a pick, which waits until enough of the tree is known
  void PickAt(const Vec3& point);
  // REQUIRES: the node of a partition.
  void PickCell(NodeId cell);
  bool IsPicking() const { return this->Point || this->Cell; }
  // Continues as far as the known part of the tree allows; the tree records as missing what else is
  // needed. True if the region has changed. keepsLast: keeps the region before it, too.
  bool Follow(bool keepsLast);
  // This number of further pages and boxes was asked for: beyond the limit, ends the pick with a
  // message.
  void NoteAsked(std::size_t treeBlobs);
  void DropPick();

  // ---- the region. The rings of this region, which is picked anew, and of the next ones. Clamped
  // to 1-3.
  void SetRings(unsigned rings);
  // Takes smaller limits than when the region was picked.
  void SetTriangles(std::uint64_t triangles, std::uint64_t viewTriangles);
  // pointsPerUnit: of a model unit in the focal plane.
  void FollowZoom(double pointsPerUnit);
  bool IsShown() const { return this->Shown.has_value(); }
  // Whether partitions of earlier regions are left. Forgets those that have left the view.
  bool HasEarlier() const { return !this->Earlier.empty(); }
  void ForgetEarlier(const Camera& camera);
  void ForgetEarlier() { this->Earlier.clear(); }
  // The region, those before it, and a pick.
  void LetGo();

  // Its cell and rings; 0 and 0 without one.
  std::pair<NodeId, unsigned> Key() const;
  // The boxes of its partitions, that of the picked one first; none without a region.
  std::vector<Box> Boxes() const;
  // For an existing region. Appends its partitions, without those that the section cuts away, and
  // those of the regions before.
  void AddTo(std::vector<PieceId>& pieces) const;
  // How many of its partitions the section leaves, and how many of these are shown.
  ViewerStatus::Region GetStatus() const;

private:
  struct Region
  {
    NodeId cell = 1;
    unsigned rings = 1;
    std::vector<std::uint32_t> partitions; // nearest first
    Box box;
    std::vector<Box> boxes; // of these
  };
  bool Find(bool keepsLast);
  std::size_t MostPartitions() const;
  void Keep(const Region& last);
  std::vector<std::uint32_t> Left() const;

  ShownModel& Model;
  unsigned Rings;
  RegionLimits Limits;
  std::uint64_t ViewTriangles;
  // A tap waits for these: its partition, and those around it.
  std::optional<Vec3> Point;
  std::optional<NodeId> Cell;
  std::size_t Asked = 0;
  std::optional<Region> Shown;
  std::vector<std::uint32_t> Earlier; // partitions of regions before, newest first
};

}
