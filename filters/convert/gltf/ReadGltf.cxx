// SPDX-License-Identifier: BSD-3-Clause
// Reads glTF 2: the scene of a file, joined into one mesh (JoinScenes.h).
#include "filters/convert/ForeignMesh.h"
#include "filters/convert/gltf/JoinScenes.h"

namespace kdstream
{

Result<ForeignMesh> ReadGltf(
  const std::filesystem::path& file, const TextureOptions& textures, const Execution& execution)
{
  KDSTREAM_TRY(execution.Report("read", 0));
  const auto source = GltfSource::Open(file);
  KDSTREAM_TRY(source);
  GltfSource& scene = **source;
  std::vector<std::filesystem::path> named = scene.Named();
  JoinedScenes joined(textures, JoinedScenes::Parts::OfOneFile);
  Status read = joined.Count(scene);
  joined.Begin();
  read = read ? joined.Append(scene, execution) : read;
  if (!read)
  {
    return scene.Explained(read.GetError());
  }
  Result<ForeignMesh> mesh = joined.Finish(scene.SceneNotes(), scene.MaterialNotes(), execution);
  KDSTREAM_TRY(mesh);
  const std::vector<std::string> notes = scene.OtherNotes();
  mesh->warnings.insert(mesh->warnings.end(), notes.begin(), notes.end());
  mesh->named = std::move(named);
  return mesh;
}

}
