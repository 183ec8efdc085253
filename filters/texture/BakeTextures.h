// SPDX-License-Identifier: BSD-3-Clause
// Bakes pictures into colours of vertices. Part of step "read" of the pipeline picture.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/texture/Picture.h"
#include "filters/texture/TexturedMesh.h"

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace kdstream
{

struct TextureOptions
{
  bool bake = true;                             // false: pictures are left out
  std::uint64_t mostPixels = mostPicturePixels; // of one picture
  // A folder for the pictures and materials that tiles need (TextureFolder.h); the mesh then also
  // gets their arrays (TextureArrays.h). Empty: no tiles are wanted.
  std::filesystem::path textureFolder{};
};

struct BakeReport
{
  std::uint64_t pictures = 0; // number of pictures that were read
  // Texels that triangles cover, counted once for each triangle. If the picture repeats or is
  // clamped, each texel counts at most once. A missing picture has none.
  double texels = 0;
  double texelsPerVertex = 0; // by number of places
  // The difference between the texels and the interpolated colours of the vertices: the root mean
  // square over the area, in 8-bit steps of a channel.
  double loss = 0;
  std::vector<std::string> warnings; // one sentence each, naming the picture or the element

  // A sentence for users, if pictures are not kept: how many texels a vertex has, and what is lost.
  std::string TellLoss() const;
  // A sentence for users, if the original keeps the pictures.
  std::string TellLevels() const;
};

// Adds the point array "RGB" (uint8 × 3), or "RGBA" (× 4) if a vertex is not opaque, to
// textured.mesh. Replaces arrays with any of these names. REQUIRES: corners and an existing
// material for each triangle; existing pictures, or noPicture.
//
// The colour of a vertex is the mean, in linear light, of the texels that its triangles cover. The
// weight of a texel is its area on the surface, times the vertex's interpolation weight there.
// - Vertices in one place (bit-equal coordinates) with equal normals get the same colour. So
//   vertices that are split along seams of charts become one again when the mesh is welded.
// - Triangles whose corners have no coordinates, or whose picture cannot be read, count with their
//   material's colour. Vertices without triangles are white.
// - Triangles without area count only at vertices that have no others.
//
// Each triangle is sampled in equal parts: about two for each texel, and at least nine. But all
// triangles of a picture together have at most eight parts for each of its texels, plus 64 for each
// triangle. So coordinates that repeat a picture a million times take no longer. Pictures are
// decoded in order, with one at a time in memory. Time: O(parts); memory: 64 bytes a vertex, one
// picture and its file. The result depends only on the input. Errors: Cancelled. Source: a common
// method; the limits are ours.
Result<BakeReport> BakeTextures(TexturedMesh& textured,
  std::uint64_t mostPixels = mostPicturePixels, const Execution& execution = {});

// The same; if options.textureFolder is set, also writes what tiles need, and then holds no picture
// in memory (TextureFolderWriter::AddPicture). If it is not set and a picture was read, the last
// warning is TellLoss(). tints: factors by which vertex colours multiply the pictures
// (TintPictures.h); the baked colours do not contain them. If the pictures would become too large
// in this way, they are not kept, and a warning says so. Errors: also InputOutput of the folder.
Result<BakeReport> BakeAndKeepTextures(TexturedMesh& textured, const TextureOptions& options,
  const Execution& execution = {}, std::span<const Color> tints = {});

}
