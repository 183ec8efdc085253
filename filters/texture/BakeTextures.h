// SPDX-License-Identifier: BSD-3-Clause
// Pictures as colours of vertices. Part of step "read" of the pipeline picture.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/texture/Picture.h"
#include "filters/texture/TexturedMesh.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace kdstream
{

struct TextureOptions
{
  bool bake = true;                             // false: pictures are left out
  std::uint64_t mostPixels = mostPicturePixels; // of one picture
  // The folder for pictures and materials of tiles (TextureFolder.h); the mesh then gets their
  // arrays (TextureArrays.h). Empty: no tiles are wanted.
  std::filesystem::path textureFolder{};
};

struct BakeReport
{
  std::uint64_t pictures = 0; // that were read
  // Texels that triangles cover, counted once for each triangle; if the picture repeats or is
  // clamped, each texel at most once. None for a missing picture.
  double texels = 0;
  double texelsPerVertex = 0; // over all places
  // The difference between texels and the vertices' interpolated colours: the root of its mean
  // square over the area, in 8-bit steps of a channel.
  double loss = 0;
  std::vector<std::string> warnings; // a sentence each, that names the picture or the element

  // For users, where pictures are not kept: how many texels a vertex has, and what is lost.
  std::string TellLoss() const;
  // For users, where the original keeps them.
  std::string TellLevels() const;
};

// Adds the point array "RGB" (uint8 × 3, or "RGBA" × 4 where a vertex is not opaque) to
// textured.mesh, in place of any of these names. REQUIRES: a tuple of corners and an existing
// material for each triangle; existing pictures, or noPicture.
//
// The colour of a vertex is the mean, in linear light, of the texels that its triangles cover. A
// texel's weight is its area on the surface, times the vertex's interpolation weight there.
// - Vertices in one place (bit-equal coordinates) with equal normals have one colour, so vertices
//   that are split along the seams of charts become one again when the mesh is welded.
// - Triangles whose corners have no coordinates, or whose picture cannot be read, count with their
//   material's colour. Vertices without triangles are white.
// - Triangles without area count only at vertices that have no others.
//
// Each triangle is sampled in equal parts: about two for each texel, nine at least, but at most
// eight for each texel of the picture and 64 for each triangle. So coordinates that repeat a
// picture a million times take no longer. Pictures are decoded one after the other, in their order,
// with one in memory. Time: O(parts); memory: 64 bytes a vertex, one picture and its file. The
// result depends only on the input. Errors: Cancelled. Source: a common method; the limits are
// ours.
Result<BakeReport> BakeTextures(TexturedMesh& textured,
  std::uint64_t mostPixels = mostPicturePixels, const Execution& execution = {});

// The same, and also what tiles need, if options.textureFolder is set; then no picture is in memory
// (TextureFolderWriter::AddPicture). Without it, if a picture was read, the last warning is
// TellLoss(). Errors: also InputOutput of the folder.
Result<BakeReport> BakeAndKeepTextures(
  TexturedMesh& textured, const TextureOptions& options, const Execution& execution = {});

}
