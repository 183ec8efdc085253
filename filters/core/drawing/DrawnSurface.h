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

// How a part looked in the previous surface, for renderers that animate the change (geomorph). For
// each point of the part: the position and normal (of any length) of the parent vertex that showed
// it before (SurfaceParts::Parents).
struct PartGeomorph
{
  std::vector<Vec3> points, normals;
};

// Immutable. If a part and its normals are the same objects as in an earlier surface, the renderer
// need not rebuild them.
class DrawnSurface
{
public:
  struct Part
  {
    std::shared_ptr<const SurfacePart> part;
    PartNormals::Normals normals;
    std::shared_ptr<const PartGeomorph> geomorph; // null if nothing moves
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

  // All parts in one (MergeParts). Made at the first call. Threads: one at a time.
  const Surface& Whole() const;

private:
  std::vector<Part> All;
  std::size_t Points = 0, Triangles = 0;
  mutable std::optional<Surface> Merged;
};

}
