// SPDX-License-Identifier: BSD-3-Clause
// A surface as renderers take it: in parts, with normals for lighting. Step "draw" of the pipeline
// picture.
#pragma once

#include "filters/core/drawing/PartNormals.h"
#include "filters/core/drawing/SurfaceParts.h"

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

namespace kdstream
{

// How a part looked in the previous surface, for renderers that animate the change (geomorph): for
// each of its points the position and normal (of any length) of its parent vertex, which showed it
// before (SurfaceParts::Parents).
struct PartGeomorph
{
  std::vector<Vec3> points, normals;
};

// Immutable. If parts and normals are the same objects as in an earlier surface, they need not be
// drawn anew.
class DrawnSurface
{
public:
  struct Part
  {
    std::shared_ptr<const SurfacePart> part;
    PartNormals::Normals normals;
    std::shared_ptr<const PartGeomorph> geomorph; // null where nothing moves
    bool LooksLike(const Part& other) const
    {
      return this->part == other.part && this->normals == other.normals;
    }
  };

  DrawnSurface() = default;
  // normals: from PartNormals, one list for each part.
  DrawnSurface(SurfacePartList parts, const std::vector<PartNormals::Normals>& normals);
  // The same, with parts that morph from the previous surface. parents: from SurfaceParts.
  // O(points) of the parts that differ.
  DrawnSurface(SurfacePartList parts, const std::vector<PartNormals::Normals>& normals,
    const DrawnSurface& before, const std::vector<ParentPoints>& parents);
  // Any surface, as a single part. If its triangles name missing points, it has no normals.
  explicit DrawnSurface(Surface whole);

  const std::vector<Part>& Parts() const { return this->All; }
  std::size_t PointCount() const { return this->Points; }
  std::size_t TriangleCount() const { return this->Triangles; }
  bool HasGeomorphs() const;

  // All parts in one (MergeParts), made when it is asked for first. Threads: one at a time.
  const Surface& Whole() const;

private:
  std::vector<Part> All;
  std::size_t Points = 0, Triangles = 0;
  mutable std::optional<Surface> Merged;
};

}
