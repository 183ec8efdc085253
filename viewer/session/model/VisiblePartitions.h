// SPDX-License-Identifier: BSD-3-Clause
// Visibility (frustum and back-face culling): which parts of a model may be visible, according to
// loaded pieces: below step "choose" of the pipeline picture.
#pragma once

#include "filters/core/pieces/Piece.h"
#include "viewer/session/Camera.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <vector>

namespace kdstream
{

// Culling by boxes is not enough: most of a box is empty, and the front of a closed surface hides
// its back. So triangles of loaded pieces are used, which show roughly where the surface is and
// which way it faces:
// - triangles of a level coarser than S, for the pieces of the next level that hold the children of
//   its clusters;
// - triangles of level S, whose clusters each lie in one partition, for the partitions.
//
// What is not loaded is unknown, and counts as visible.
class VisiblePartitions
{
public:
  VisiblePartitions() = default;
  explicit VisiblePartitions(const TreeDepths& depths);

  // Takes a piece of the levels from the preview's to S; others are ignored. O(triangles log
  // partitions).
  void Add(const Piece& piece);
  // Whether a level, given as its single piece, is so nearly closed that its back is hidden: at
  // most one of 200 edges has a single triangle.
  static bool IsNearlyClosed(const Piece& whole);

  // Whether a piece has been added, and its triangles are still known. The piece itself may have
  // been evicted since.
  bool Knows(PieceId piece) const;

  // Sets the camera for the functions below. closed: surfaces that face away are hidden.
  // O(triangles) if the camera has moved, or pieces have arrived. Allows a margin of 10 degrees and
  // of half a triangle for the level's inaccuracy.
  void Cull(const Camera& camera, bool closed);
  // Whether any of a piece of a level up to S may be visible, according to the added pieces of the
  // next coarser level.
  bool MayBeVisible(PieceId piece) const { return this->Visible.count(piece) != 0; }
  // Whether any partition in a node may be visible. O(log partitions).
  bool MayBeVisible(NodeId node) const;

private:
  struct Face // a triangle, relative to a near origin
  {
    std::array<float, 3> centre, normal; // of length 1
    float radius = 0;                    // of a sphere around the triangle
  };
  struct FaceList
  {
    Vec3 origin;
    std::vector<Face> faces;
  };
  struct Partition
  {
    FaceList list;
    bool visible = true;
  };
  struct Below // faces that a level coarser than S has for a piece of the next level
  {
    NodeId node;
    FaceList list;
  };
  class Sight;
  static Face FaceOf(const Piece& piece, const Triangle& t, const Vec3& origin);
  void AddTo(FaceList& list, const Face& face);
  void AddFaces(const Piece& piece);
  void AddFacesAbove(const Piece& piece);
  void MakeRoom();

  TreeDepths Depths;
  std::map<std::uint32_t, Partition> Partitions;
  std::map<PieceId, std::vector<Below>> Above;
  std::set<PieceId> Visible;
  std::size_t Faces = 0;
  std::shared_ptr<const Sight> Last; // the last view culled; null if faces have come since
};

}
