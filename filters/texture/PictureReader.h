// SPDX-License-Identifier: BSD-3-Clause
// Reads a mesh's pictures, one after the other, into memory, or into the folder of a build's tiles.
// Part of step "read" of the pipeline picture.
#pragma once

#include "filters/core/Execution.h"
#include "filters/texture/PictureTexels.h"
#include "filters/texture/TextureFolder.h"
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
  PictureReader(const std::vector<PictureSource>& pictures, std::uint64_t mostPixels,
    TextureFolderWriter* folder)
    : Pictures(pictures)
    , MostPixels(mostPixels)
    , Folder(folder)
  {
  }

  // Decodes pictures into the folder before Read asks for them, several at a time; only those that
  // are decoded by rows. Read decodes all others, and all that go into memory, one at a time to
  // limit the memory. share: of step "textures", for its progress. Errors: Cancelled.
  Status ReadAhead(
    const std::vector<std::uint32_t>& numbers, double share, const Execution& execution);
  // Nothing, and a warning, where it cannot be read. Errors: InputOutput of the folder.
  Result<std::optional<ReadablePicture>> Read(std::uint32_t number);
  // The warnings so far: up to twenty pictures that could not be read, and the number of others;
  // and pictures whose content differs from their names.
  std::vector<std::string> Warnings() const;

private:
  struct Outcome
  {
    Result<ReadablePicture> picture = Error{};
    bool missing = false; // the file
    bool wasRead = false; // its bytes were
    PictureType type = PictureType::Unknown;
  };

  // Nothing if the picture must be decoded by rows but cannot be.
  std::optional<Outcome> Load(std::uint32_t number, bool byRows) const;
  Result<ReadablePicture> Decode(std::uint32_t number, std::span<const std::uint8_t> bytes) const;

  const std::vector<PictureSource>& Pictures;
  const std::uint64_t MostPixels;
  TextureFolderWriter* const Folder;
  std::vector<std::optional<Outcome>> Ahead; // of each picture; removed when it was read
  std::vector<std::string> Reported;
  std::size_t Unread = 0;
};

}
