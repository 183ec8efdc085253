// SPDX-License-Identifier: BSD-3-Clause
// Steps: 1. the JSON, of a .glb its first chunk; its buffers' files and its nodes are checked  2.
// images, textures, materials  3. the JSON without them, as a file in memory; its buffers by the
// numbers of open files, so that it does not matter where it lies.
#include "filters/convert/GltfScene.h"

#include "filters/convert/GltfAccessors.h"
#include "filters/convert/GltfBuffers.h"
#include "filters/convert/GltfDocument.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <utility>

namespace kdstream
{
namespace
{

using Json = nlohmann::json;

// Takes pictures out, and puts a material's number into its colour.
void StripPictures(Json& json)
{
  for (const char* const name : { "images", "textures", "samplers", "extensionsRequired" })
  {
    json.erase(name);
  }
  // VTK warns of those that we read.
  const auto used = json.find("extensionsUsed");
  for (const char* const ours : { "KHR_texture_transform", "EXT_texture_webp" })
  {
    if (used != json.end() && used->is_array())
    {
      used->erase(std::remove(used->begin(), used->end(), ours), used->end());
    }
  }
  const auto materials = json.find("materials");
  for (std::size_t i = 0; materials != json.end() && materials->is_array() && i < materials->size();
       ++i)
  {
    (*materials)[i] = { { "pbrMetallicRoughness", { { "baseColorFactor", { i, 0, 0, 1 } } } } };
  }
}

}

GltfScene::GltfScene(GltfScene&& other) noexcept
  : read(std::move(other.read))
  , named(std::move(other.named))
  , incomplete(std::move(other.incomplete))
  , Name(std::move(other.Name))
  , Folder(std::exchange(other.Folder, {}))
  , Descriptors(std::exchange(other.Descriptors, {}))
  , Copied(other.Copied)
{
}

// VTK's reader asks for the ending.
Status GltfScene::Link(int copy)
{
  std::error_code failed;
  std::string folder =
    (std::filesystem::temp_directory_path(failed) / "kdstream-scene-XXXXXX").string();
  if (failed || !::mkdtemp(folder.data()))
  {
    return Error{ ErrorCode::InputOutput, "cannot create a folder for temporary files" };
  }
  this->Folder = folder;
  this->Name = (this->Folder / "scene.gltf").string();
  std::filesystem::create_symlink("/proc/self/fd/" + std::to_string(copy), this->Name, failed);
  return failed ? Status(Error{ ErrorCode::InputOutput, failed.message(), folder }) : Status();
}

void GltfScene::HasRead()
{
  if (!this->Folder.empty())
  {
    std::error_code ignored;
    std::filesystem::remove_all(this->Folder, ignored);
    this->Folder.clear();
  }
}

GltfScene::~GltfScene()
{
  this->HasRead();
  for (const int descriptor : this->Descriptors)
  {
    ::close(descriptor);
  }
}

Result<GltfScene> GltfScene::Open(const std::filesystem::path& file)
{
  GltfScene scene;
  scene.Name = file.string();
  std::optional<GltfDocument> document = ReadGltfDocument(file);
  if (!document)
  {
    return scene;
  }
  Json& json = document->json;
  KDSTREAM_TRY(CheckGltfExtensions(json));
  KDSTREAM_TRY(CheckGltfBuffers(*document, file.parent_path()));
  KDSTREAM_TRY(CheckGltfAccessors(*document));
  KDSTREAM_TRY(CheckGltfMeshes(json));
  KDSTREAM_TRY(CheckGltfNodes(json));
  scene.incomplete = IncompleteGltfTriangles(json);
  scene.named = GltfBufferFiles(json, file.parent_path());
  if (Member(json, "images").is_null() && Member(json, "textures").is_null())
  {
    return scene;
  }
  scene.Copied = true;
  scene.read = ReadGltfMaterials(*document, file);
  for (const PictureSource& picture : scene.read.pictures)
  {
    if (!picture.file.empty() && picture.file != file)
    {
      scene.named.push_back(picture.file);
    }
  }
  StripPictures(json);
  const auto keep = [&](int descriptor)
  {
    if (descriptor >= 0)
    {
      scene.Descriptors.push_back(descriptor);
    }
    return std::to_string(descriptor);
  };
  Json& buffers = json["buffers"];
  for (std::size_t i = 0; buffers.is_array() && i < buffers.size(); ++i)
  {
    const Json uri = Member(buffers[i], "uri");
    const bool binary = !uri.is_string() && document->isGlb && i == 0;
    if (!buffers[i].is_object() || (!binary && !uri.is_string()) ||
        (uri.is_string() && uri.get<std::string>().rfind("data:", 0) == 0))
    {
      continue;
    }
    const std::filesystem::path bytes = binary ? file : file.parent_path() / uri.get<std::string>();
    buffers[i]["uri"] = "/proc/self/fd/" + keep(::open(bytes.c_str(), O_RDONLY | O_CLOEXEC));
    std::error_code failed;
    if (!binary)
    {
      continue;
    }
    buffers[i]["byteLength"] = std::filesystem::file_size(file, failed);
    for (Json& view : json["bufferViews"])
    {
      if (view.is_object() && IndexIn(buffers, Member(view, "buffer")) == 0)
      {
        view["byteOffset"] = NumberOf(Member(view, "byteOffset"), 0) + double(document->binary);
      }
    }
  }
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  const int copy = ::memfd_create("scene.gltf", MFD_CLOEXEC);
  keep(copy);
  std::size_t written = 0;
  while (copy >= 0 && written < text.size())
  {
    const ssize_t count = ::write(copy, text.data() + written, text.size() - written);
    if (count <= 0)
    {
      break;
    }
    written += static_cast<std::size_t>(count);
  }
  if (written < text.size())
  {
    return Error{ ErrorCode::InputOutput, "there is no memory for a copy of its JSON" };
  }
  KDSTREAM_TRY(scene.Link(copy));
  return scene;
}

}
