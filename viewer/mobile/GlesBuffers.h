// SPDX-License-Identifier: BSD-3-Clause
// What graphics memory holds of a session's scene: the parts of its surface, the pictures of its
// tiles, the cap of its section. GlesRenderer draws them. Internal to viewer/mobile.
#pragma once

#include "filters/core/Result.h"
#include "viewer/mobile/GlesChunk.h"
#include "viewer/session/SessionTypes.h"
#include "viewer/session/appearance/Coloring.h"
#include "viewer/session/appearance/SceneRules.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace kdstream
{

// Threads and context: as for GlesRenderer.
class GlesBuffers
{
public:
  struct Part
  {
    DrawnSurface::Part drawn;                  // empty for a cloud: a splat depends on all points
    const Surface* surface = nullptr;          // only while it is uploaded
    std::span<const float> radii;              // of a cloud, only while it is uploaded
    Box bounds;                                // relative to the placement's center, not scaled
    std::shared_ptr<const TextureTile> tile{}; // its texture, or null
    GLuint texture = 0;                        // of the tile's picture
    std::vector<GlesChunk> chunks;
  };
  // Positions are relative to the center, then multiplied by the power of two that brings them to
  // -1 … 1.
  struct Placement
  {
    Vec3 center{};
    double scale = 1.0;
    bool operator==(const Placement&) const = default;
  };

  GlesBuffers() = default;
  ~GlesBuffers();
  GlesBuffers(const GlesBuffers&) = delete;
  GlesBuffers& operator=(const GlesBuffers&) = delete;

  // Call this when the context was lost: nothing is deleted.
  void Forget();

  // These four functions are described in GlesRenderer.
  using TileUpload = void (*)(unsigned texture, const TextureTile& tile);
  static void SetTileUpload(TileUpload upload);
  void SetColoring(const Coloring& coloring);
  void SetMorphed(double share) { this->MorphedShare = share; }

  const Coloring& GetColoring() const { return this->Colors; }
  double Morphed() const { return this->MorphedShare; }

  // Uploads what has changed in the scene since the last call: parts of the surface, tiles,
  // colouring, the cap. Buffers that are no longer needed are freed first. outcome: set to the
  // result of uploading the surface, if it was uploaded; errors as for GlesRenderer::Draw.
  void Follow(const ViewerScene& scene, Status& outcome);

  const std::vector<Part>& Parts() const { return this->PartList; }
  const std::vector<GlesChunk>& Cap() const { return this->CapChunks; }
  bool IsCloud() const { return this->Points > 0; }
  const Placement& GetPlacement() const { return this->Place; }
  // A box around all parts, including the places from which they morph; relative to the center, not
  // scaled.
  Box Reach() const;
  double Facet() const { return this->FacetOfAll; } // FacetLength of all parts; not scaled
  std::size_t Bytes() const;                        // O(parts)

private:
  void Free();
  void FreeCap();
  void StopMorphing();
  Status Upload(const ViewerScene& scene);
  Status TakeOver(const ViewerScene& scene, std::vector<Part>& parts);
  void UploadPart(Part& part);
  void FollowTiles(std::vector<Part>& parts);
  void FollowCap(const ViewerScene& scene);
  std::shared_ptr<const TextureTile> TileOf(
    const ViewerScene& scene, const SurfacePart& part) const;

  // Identifies the surface in graphics memory, and its colours.
  struct Content
  {
    std::uint64_t version = 0;
    std::uint64_t colors = 0; // ColorsVersion
    std::shared_ptr<const TileList> tiles;
    bool operator==(const Content&) const = default;
  };
  struct CapPlace
  {
    std::uint64_t version = 0;
    Placement place;
    bool operator==(const CapPlace&) const = default;
  };

  std::vector<Part> PartList;
  std::vector<GlesChunk> CapChunks;
  CapPlace CapHere;             // of the cap in CapChunks
  std::optional<Content> Tried; // what was uploaded last, or failed to be
  // The placement of all parts in graphics memory.
  Placement Place;
  TreeDepths Depths;
  std::uint64_t Colored = 0; // ColorsVersion
  Box Bounds;                // of what is drawn, relative to the center; not scaled
  double FacetOfAll = 0.0;
  std::size_t Points = 0; // points of a cloud; 0 for a mesh with triangles

  Coloring Colors;
  std::uint64_t ColorsVersion = 0; // grows whenever Colors change
  double MorphedShare = 1;
  // The longest way that a morphing vertex goes, in the model's unit; nothing if none morphs.
  std::optional<double> LongestWay;
};

}
