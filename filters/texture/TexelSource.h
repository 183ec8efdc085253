// SPDX-License-Identifier: BSD-3-Clause
// Gives access to the texels of decoded pictures, in memory or in files that may be larger than
// memory (TextureFolder.h). Part of step "encode" of the pipeline picture: texture tiles.
#pragma once

#include "filters/core/Result.h"
#include "filters/texture/Picture.h"
#include "filters/texture/TexturedMesh.h"

#include <array>
#include <cstdint>
#include <vector>

namespace kdstream
{

// A box of texels: columns from the left and rows from above.
struct TexelBox
{
  std::array<std::int64_t, 2> lo{}, hi{}; // hi itself is outside
  std::int64_t Width() const { return this->hi[0] - this->lo[0]; }
  std::int64_t Height() const { return this->hi[1] - this->lo[1]; }
  bool operator==(const TexelBox&) const = default;
};

// Several threads may use this at a time.
class TexelSource
{
public:
  virtual ~TexelSource() = default;

  // The numbers of columns and rows; 0, 0 if the picture could not be read. REQUIRES: a picture of
  // the mesh.
  virtual std::array<std::uint32_t, 2> SizeOf(std::uint32_t picture) const = 0;
  // Reads a box of texels into rgba, four bytes each, row by row. REQUIRES: the box is in the
  // picture. Errors: InputOutput.
  virtual Status Read(std::uint32_t picture, const TexelBox& box, std::uint8_t* rgba) const = 0;
};

// The same for a box that may lie anywhere, because wrap modes continue the picture. Four bytes a
// texel. REQUIRES: the picture has texels.
Result<std::vector<std::uint8_t>> ReadWrapped(const TexelSource& source, std::uint32_t picture,
  const TexelBox& box, TextureWrap wrapU, TextureWrap wrapV);

// Pictures in memory.
class PicturesInMemory : public TexelSource
{
public:
  // A picture without texels is one that could not be read.
  explicit PicturesInMemory(std::vector<Picture> pictures)
    : Pictures(std::move(pictures))
  {
  }
  std::array<std::uint32_t, 2> SizeOf(std::uint32_t picture) const override;
  Status Read(std::uint32_t picture, const TexelBox& box, std::uint8_t* rgba) const override;

private:
  std::vector<Picture> Pictures;
};

}
