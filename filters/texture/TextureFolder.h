// SPDX-License-Identifier: BSD-3-Clause
// A folder with the decoded pictures of a textured mesh, and its materials. Through it,
// kdstream-convert passes them to the build, which holds no picture in memory. Between steps "read"
// and "encode" of the pipeline picture.
//
// `paint` is an index: the materials, and the sizes of the pictures. `picture-N` has the RGBA
// texels of picture N, in squares of 64 × 64, row by row of squares. Squares at the right and lower
// edge are filled up with zeros. Both programs have the same version, and the folder is removed
// with the build's temporary files.
#pragma once

#include "filters/texture/PictureTexels.h"
#include "filters/texture/TexelSource.h"
#include "filters/texture/TileCharts.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace kdstream
{

// The texels in a picture's file.
class MappedPicture
{
public:
  // Errors: InputOutput. REQUIRES: the file has this size.
  static Result<MappedPicture> Open(
    const std::filesystem::path& file, std::size_t width, std::size_t height);
  MappedPicture(MappedPicture&& other) noexcept
    : Layout(std::exchange(other.Layout, {}))
    , Bytes(std::exchange(other.Bytes, 0))
  {
  }
  MappedPicture(const MappedPicture&) = delete;
  MappedPicture& operator=(const MappedPicture&) = delete;
  MappedPicture& operator=(MappedPicture&&) = delete;
  ~MappedPicture();

  const TexelLayout& Texels() const { return this->Layout; }

private:
  MappedPicture() = default;

  TexelLayout Layout;
  std::size_t Bytes = 0;
};

class TextureFolderWriter
{
public:
  // Makes the folder, for this number of pictures. Errors: InputOutput.
  static Result<TextureFolderWriter> Create(
    const std::filesystem::path& folder, std::size_t pictures);

  // Decodes a picture into its file, row by row (DecodePictureRows). Extra memory: 256 bytes for
  // each column of the picture. The result maps the file, which the system keeps in memory as far
  // as memory is free. Errors: InputOutput if the file cannot be written; else those of decoding,
  // and the picture is then not added. Several threads may add different pictures at the same time.
  Result<MappedPicture> AddPicture(
    std::uint32_t number, std::span<const std::uint8_t> bytes, std::uint64_t mostPixels);
  // Adds a picture beyond the number that Create was given, from RGBA texels. Returns its number.
  // Errors: InputOutput.
  Result<std::uint32_t> AddTexels(const Picture& picture);
  // Pictures that were not added count as unreadable. May be called again. Errors: InputOutput.
  Status Finish(const std::vector<TexturedMaterial>& materials);

private:
  TextureFolderWriter(std::filesystem::path folder, std::size_t pictures)
    : Folder(std::move(folder))
    , Sizes(pictures)
  {
  }

  std::filesystem::path Folder;
  std::vector<std::array<std::uint32_t, 2>> Sizes; // of each picture; 0 if there is none
};

// Reads a folder of this kind. A read takes 16 KiB, whatever the picture's size; the system's cache
// serves repeated reads.
class TextureFolder : public TexelSource
{
public:
  // Errors: NotFound; InvalidInput for another folder; InputOutput.
  static Result<std::shared_ptr<const TextureFolder>> Open(const std::filesystem::path& folder);
  ~TextureFolder() override;

  const TextureSet& Content() const { return this->Textures; }
  std::array<std::uint32_t, 2> SizeOf(std::uint32_t picture) const override
  {
    return this->Sizes[picture];
  }
  Status Read(std::uint32_t picture, const TexelBox& box, std::uint8_t* rgba) const override;

private:
  TextureFolder() = default;
  Status OpenPicture(const std::filesystem::path& file, std::array<std::uint32_t, 2> size);
  Status ReadFrom(
    int descriptor, std::uint32_t picture, const TexelBox& box, std::uint8_t* rgba) const;

  std::filesystem::path Folder;
  TextureSet Textures;
  std::vector<std::array<std::uint32_t, 2>> Sizes;
  std::vector<int> Descriptors; // -1: no texels, or opened for each read
};

}
