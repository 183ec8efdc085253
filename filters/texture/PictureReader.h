// SPDX-License-Identifier: BSD-3-Clause
// A mesh's pictures, one after the other: into memory, or into the folder of a build's tiles. Part
// of step "read" of the README's picture.
#pragma once

#include "filters/texture/PaintFolder.h"
#include "filters/texture/PictureTexels.h"
#include "filters/texture/TexturedMesh.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace kdstream
{

// In memory, or in a file.
struct ReadablePicture
{
  Picture memory;
  std::optional<MappedPicture> mapped;

  TexelLayout Texels() const
  {
    return this->mapped ? this->mapped->Texels()
                        : TexelLayout{ this->memory.width, this->memory.height,
                            this->memory.components, this->memory.texels.data() };
  }
};

class PictureReader
{
public:
  // folder: where decoded pictures go; null: into memory. Keeps references.
  PictureReader(
    const std::vector<PictureSource>& pictures, std::uint64_t mostPixels, PaintFolderWriter* folder)
    : Pictures(pictures)
    , MostPixels(mostPixels)
    , Folder(folder)
  {
  }

  // Nothing, and a warning, where it cannot be read. Errors: InputOutput of the folder.
  Result<std::optional<ReadablePicture>> Read(std::uint32_t number);
  // So far: of twenty pictures that could not be read, and how many more there are; and of those
  // that are not what their names say.
  std::vector<std::string> Warnings() const;

private:
  Result<ReadablePicture> Decode(std::uint32_t number, std::span<const std::uint8_t> bytes) const;

  const std::vector<PictureSource>& Pictures;
  const std::uint64_t MostPixels;
  PaintFolderWriter* const Folder;
  std::vector<std::string> Told;
  std::size_t Unread = 0;
};

}
