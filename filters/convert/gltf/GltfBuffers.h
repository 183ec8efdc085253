// SPDX-License-Identifier: BSD-3-Clause
// The bytes of a glTF file: its buffers, wherever they are, and the buffers' views. Compressed
// views are decompressed.
#pragma once

#include "filters/convert/gltf/GltfDocument.h"
#include "filters/core/Result.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace kdstream
{

using GltfBytes = std::span<const std::uint8_t>;

class FilesBeside;

class GltfBuffers
{
public:
  // Finds every buffer of `document`, which comes from `file`: in the .glb, in a data URI, or in a
  // file in or below the file's folder (FilesBeside). Files are mapped, not read. A buffer that is
  // missing, or shorter than it claims, is an error only when it is needed. The document must
  // outlive the buffers.
  static GltfBuffers Open(const GltfDocument& document, const std::filesystem::path& file);

  struct View
  {
    GltfBytes bytes;
    std::uint64_t stride = 0; // between elements; 0: without gaps
  };
  // Returns one of the document's bufferViews. A compressed view is decompressed once, to at most
  // 64 times its size, and stays in memory. REQUIRES: a view of this number exists. Errors:
  // InvalidInput, continuing the sentence "bufferView 7 …"; Unsupported if KdStream was built
  // without libmeshoptimizer-dev.
  Result<View> ViewOf(std::size_t number);

  // The bytes as the file has them. Errors: as ViewOf. REQUIRES: the bufferView exists.
  Result<GltfBytes> BytesOf(const nlohmann::json& view) const;

  // Why ViewOf failed, if the buffer is missing or shorter than it claims: InvalidInput naming the
  // file or the buffer; InputOutput.
  const std::optional<Error>& Missing() const { return this->Missed; }
  // The numbers of all missing or short buffers, even if nothing needs them.
  std::vector<std::size_t> WrongOnes() const;
  // How many bytes all readable buffers have together.
  std::uint64_t Size() const { return this->BytesInAll; }

  // The files in which the buffers are, except the document's own.
  std::vector<std::filesystem::path> Files() const;

private:
  struct Buffer
  {
    GltfBytes bytes;
    bool isThere = false;
    std::optional<Error> wrong{};
  };
  class Mapping;

  GltfBuffers() = default;
  Result<GltfBytes> Map(const std::filesystem::path& file);
  Status Find(std::size_t number, const std::filesystem::path& file, FilesBeside& files);

  const GltfDocument* Document = nullptr;
  std::vector<Buffer> Buffers;
  std::map<std::filesystem::path, std::shared_ptr<Mapping>> Mappings;
  std::vector<std::vector<std::uint8_t>> Decoded;                // of data URIs
  std::map<std::size_t, std::vector<std::uint8_t>> Decompressed; // by the number of the view
  std::vector<std::filesystem::path> Named;
  std::optional<Error> Missed;
  std::uint64_t BytesInAll = 0, BytesDecompressed = 0; // all buffers; compressed views so far
};

}
