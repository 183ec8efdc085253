// SPDX-License-Identifier: BSD-3-Clause
// The normals of a surface that is drawn in parts. Step "draw" of the pipeline picture.
#pragma once

#include "filters/core/drawing/SurfaceParts.h"

#include <memory>
#include <span>
#include <vector>

namespace kdstream
{

// For each point the sum of the area vectors (times two) of its triangles; 0 for a point without
// triangles. O(points + triangles). REQUIRES: indices below the number of points.
std::vector<Vec3> SumOfNormals(std::span<const Vec3> points, std::span<const Triangle> triangles);

// For each point of each part the sum of the area vectors (times two) of all triangles around it in
// the whole surface; 0 for points without triangles. Updated from one cut to the next.
class PartNormals
{
public:
  using Normals = std::shared_ptr<const std::vector<Vec3>>; // one a point of the part

  // Updates the normals for these parts. Normals that do not change stay the same object. The
  // result depends only on the parts, not on earlier ones. O(points + triangles) of the parts that
  // differ and of their neighbours, and O(log) for each other part. REQUIRES: triangles name points
  // of their part.
  void GoTo(const SurfacePartList& parts);

  // In the order of the parts.
  const std::vector<Normals>& Of() const { return this->All; }

private:
  struct Known // of one part
  {
    std::shared_ptr<const SurfacePart> part;
    std::vector<Vec3> given;             // what the part's triangles add at each of its points
    std::vector<const Known*> borrowers; // parts that borrow its points, in their order
    std::vector<Vec3> own;               // the own points' new sums, until passed to all borrowers
    bool isNew = true;
    bool due = true;         // whether the sums may have changed
    bool ownChanged = false; // whether they have changed, or belong to other points
    Normals normals;

    Vec3 SumOf(std::size_t ownPoint) const
    {
      return this->due ? this->own[ownPoint] : (*this->normals)[ownPoint];
    }
  };

  void TakeParts(const SurfacePartList& parts);
  void AskLendersOf(const SurfacePart& part);
  static void SumUp(Known& known);
  Normals Spread(const Known& known) const;
  Known* Find(PieceId piece) const;

  std::vector<std::unique_ptr<Known>> Numbered; // one a part
  std::vector<Normals> All;
};

}
