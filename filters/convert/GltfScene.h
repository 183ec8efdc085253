// SPDX-License-Identifier: BSD-3-Clause
// A glTF scene for VTK's reader, without what paints it: we read that, since the reader decodes
// whatever pictures a file claims.
#pragma once

#include "filters/convert/GltfMaterials.h"
#include "filters/core/Result.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace kdstream
{

class GltfScene
{
public:
  // Reads the JSON of a .gltf or .glb. Where it has images or textures, makes a copy of it without
  // them, in memory, whose materials have their number as the red of their base colour: so parts of
  // the scene tell their material. What names no picture becomes a warning, or is `wrong` of a
  // picture. All that is wrong otherwise is left to the reader. Peak memory: some times the JSON.
  // Errors: those of CheckGltfExtensions, CheckGltfBuffers, CheckGltfAccessors, CheckGltfMeshes and
  // CheckGltfNodes; InputOutput.
  static Result<GltfScene> Open(const std::filesystem::path& file);

  GltfScene(GltfScene&& other) noexcept;
  GltfScene(const GltfScene&) = delete;
  GltfScene& operator=(const GltfScene&) = delete;
  GltfScene& operator=(GltfScene&&) = delete;
  ~GltfScene();

  // What VTK is to read while this lives: the file itself or the copy.
  const std::string& Readable() const { return this->Name; }
  // To be called when its JSON is read: what names the copy is removed, so that nothing is left
  // should a reader crash.
  void HasRead();
  // Whether it is the copy: then its materials count, else those that VTK tells.
  bool IsCopy() const { return this->Copied; }
  bool HasPictures() const { return !this->read.pictures.empty(); }

  GltfMaterials read;                       // of a copy
  std::vector<std::filesystem::path> named; // files of buffers and images
  std::optional<std::string> incomplete;    // IncompleteGltfTriangles

private:
  GltfScene() = default;

  Status Link(int copy);

  std::string Name;
  std::filesystem::path Folder; // of a link to the copy; empty: none
  std::vector<int> Descriptors; // of the copy, and of the files that its buffers are in
  bool Copied = false;
};

}
