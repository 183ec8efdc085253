// SPDX-License-Identifier: BSD-3-Clause
// Reads a mesh's pictures, one after the other, into memory, or into the folder for the tiles of a
// build. Part of step "read" of the pipeline picture.
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

// A decoded picture, in memory or in a file.
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
  // folder: where decoded pictures go; null: into memory. Keeps references to the arguments.
  PictureReader(const std::vector<PictureSource>& pictures, std::uint64_t mostPixels,
    TextureFolderWriter* folder)
    : Pictures(pictures)
    , MostPixels(mostPixels)
    , Folder(folder)
  {
  }

  // Decodes pictures into the folder, several at a time, before Read asks for them; only pictures
  // that are decoded by rows. Read decodes all others, and all pictures that go into memory, one at
  // a time to limit the memory. share: of step "textures", for its progress. Errors: Cancelled.
  Status ReadAhead(
    const std::vector<std::uint32_t>& numbers, double share, const Execution& execution);
  // Returns nothing, and adds a warning, if the picture cannot be read. Errors: InputOutput of the
  // folder.
  Result<std::optional<ReadablePicture>> Read(std::uint32_t number);
  // The warnings so far: up to twenty pictures that could not be read, and how many others; and
  // pictures whose content does not fit their names.
  std::vector<std::string> Warnings() const;

private:
  struct Outcome
  {
    Result<ReadablePicture> picture = Error{};
    bool missing = false; // the file is missing
    bool wasRead = false; // the file's bytes were read
    PictureType type = PictureType::Unknown;
  };

  // Returns nothing if the picture must be decoded by rows, but this is not possible.
  std::optional<Outcome> Load(std::uint32_t number, bool byRows) const;
  Result<ReadablePicture> Decode(std::uint32_t number, std::span<const std::uint8_t> bytes) const;

  const std::vector<PictureSource>& Pictures;
  const std::uint64_t MostPixels;
  TextureFolderWriter* const Folder;
  std::vector<std::optional<Outcome>> Ahead; // for each picture; removed by Read
  std::vector<std::string> Reported;
  std::size_t Unread = 0;
};

}
