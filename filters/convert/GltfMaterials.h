// SPDX-License-Identifier: BSD-3-Clause
// What paints a glTF scene: read by us, since VTK's reader decodes whatever pictures a file claims.
#pragma once

#include "filters/core/Result.h"
#include "filters/texture/TexturedMesh.h"

#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace kdstream
{

// A material and which of a vertex' texture coordinates its picture has.
struct GltfMaterial
{
  TexturedMaterial paint;
  int coordinates = 0; // TEXCOORD_…
};

class GltfScene
{
public:
  // Reads the JSON of a .gltf or .glb. Where it has pictures, makes a copy of it without them, in
  // memory, whose materials have their number as the red of their base colour: so parts of the
  // scene tell their material. All that is wrong otherwise is left to the reader. Peak memory: some
  // times the JSON. Errors: InvalidInput for nodes that are their own descendants.
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
  // Whether it is the copy: then `materials` count, else those that VTK tells.
  bool HasPictures() const { return !this->pictures.empty(); }

  std::vector<GltfMaterial> materials;
  std::vector<PictureSource> pictures;
  std::vector<std::string> warnings; // what materials have that is not carried

private:
  GltfScene() = default;

  Status Link(int copy);

  std::string Name;
  std::filesystem::path Folder; // of a link to the copy; empty: none
  std::vector<int> Descriptors; // of the copy, and of the files that its buffers are in
};

}
