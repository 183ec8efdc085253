// SPDX-License-Identifier: BSD-3-Clause
// Which partitions may be seen: under step "choose" of the README's picture.
#pragma once

#include "filters/core/pieces/Piece.h"
#include "viewer/session/Camera.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

namespace kdstream
{

// A partition's box is in view long before its surface is: most of a box is empty. And what a
// closed surface shows from behind is hidden by its front. The triangles of one level that is
// loaded anyway, the coarsest of which every cluster lies in one partition, tell for each partition
// about where it is and which way it faces. Of what is not loaded nothing is known, and it may be
// seen.
class SeenPartitions
{
public:
  SeenPartitions() = default;
  explicit SeenPartitions(const TreeDepths& depths);

  // The level whose pieces tell: S, or the preview's where that is finer.
  Resolution Source() const;
  // Takes a piece; others than those of Source() are passed over. O(triangles log partitions).
  void Add(const Piece& piece);
  // Whether a level, given as its one piece, is so nearly closed that its back is hidden: of 200
  // edges at most one has a single triangle.
  static bool IsNearlyClosed(const Piece& whole);

  // By this camera the question below is asked. closed: what faces away is hidden. O(triangles).
  void LookThrough(const Camera& camera, bool closed);
  // Whether anything in the node may be seen. A margin of 10 degrees and of half a triangle is left
  // for what the level does not tell. O(log partitions).
  bool MayBeSeen(NodeId node) const;

private:
  struct Face
  {
    Vec3 centre, normal; // of a triangle; of length 1
    double radius = 0;   // of a sphere around it
  };
  static Face FaceOf(const Piece& piece, const Triangle& t);
  struct Partition
  {
    std::vector<Face> faces;
    bool seen = true;
  };

  TreeDepths Depths;
  std::map<std::uint32_t, Partition> Known;
  std::size_t Faces = 0;
};

}
