// SPDX-License-Identifier: BSD-3-Clause
// Steps: 1. the JSON, of a .glb its first chunk  2. nodes: no cycles  3. images, textures,
// materials
// 4. the JSON without them, as a file in memory; its buffers by the numbers of open files,
// so that it does not matter where it lies.
#include "filters/convert/GltfMaterials.h"

#include "filters/meshio/FileEnding.h"
#include "filters/meshio/QuotedText.h"
#include "filters/texture/ObjMaterials.h"

#include <nlohmann/json.hpp>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <optional>
#include <utility>

namespace kdstream
{
namespace
{

using Json = nlohmann::json;

// A member, or null: also where the value is no object.
const Json& Member(const Json& value, const char* name)
{
  static const Json null;
  const auto found = value.is_object() ? value.find(name) : value.end();
  return value.is_object() && found != value.end() ? *found : null;
}

double NumberOf(const Json& value, double otherwise)
{
  return value.is_number() && std::isfinite(value.get<double>()) ? value.get<double>() : otherwise;
}

// A number of an element of an array; its size where it is none.
std::size_t IndexIn(const Json& array, const Json& index)
{
  const std::size_t size = array.is_array() ? array.size() : 0;
  return index.is_number_unsigned() ? std::min<std::size_t>(index.get<std::size_t>(), size) : size;
}

struct Document
{
  Json json;
  std::uint64_t binary = 0; // where a .glb's second chunk's bytes begin
  bool isGlb = false;
};

std::optional<Document> ReadDocument(const std::filesystem::path& file)
{
  std::ifstream text(file, std::ios::binary);
  Document document;
  document.isGlb = FileEnding(file) == ".glb";
  if (!document.isGlb)
  {
    document.json = Json::parse(text, nullptr, false);
    return document.json.is_object() ? std::optional(std::move(document)) : std::nullopt;
  }
  std::array<char, 20> head{};
  std::error_code failed;
  const std::uintmax_t bytes = std::filesystem::file_size(file, failed);
  std::uint32_t length = 0;
  if (failed || !text.read(head.data(), head.size()) || std::memcmp(head.data(), "glTF", 4) != 0)
  {
    return std::nullopt;
  }
  std::memcpy(&length, head.data() + 12, sizeof length);
  if (length > bytes - head.size())
  {
    return std::nullopt;
  }
  std::string json(length, ' ');
  text.read(json.data(), static_cast<std::streamsize>(length));
  document.json = Json::parse(json, nullptr, false);
  document.binary = head.size() + length + 8;
  return document.json.is_object() ? std::optional(std::move(document)) : std::nullopt;
}

// Each node at most once below the others: what is reached again while it is open is a cycle.
Status CheckNodes(const Json& json)
{
  const Json& nodes = Member(json, "nodes");
  const std::size_t count = nodes.is_array() ? nodes.size() : 0;
  std::vector<std::uint8_t> state(count); // 0 unknown, 1 open, 2 done
  for (std::size_t root = 0; root < count; ++root)
  {
    std::vector<std::pair<std::size_t, std::size_t>> path; // node, next child
    if (state[root] == 0)
    {
      path.push_back({ root, 0 });
      state[root] = 1;
    }
    while (!path.empty())
    {
      const std::size_t node = path.back().first;
      const Json& children = Member(nodes[node], "children");
      if (!children.is_array() || path.back().second == children.size())
      {
        state[node] = 2;
        path.pop_back();
        continue;
      }
      const std::size_t child = IndexIn(nodes, children[path.back().second++]);
      if (child < count && state[child] == 1)
      {
        return Error{ ErrorCode::InvalidInput,
          "node " + std::to_string(child) + " is its own descendant" };
      }
      if (child < count && state[child] == 0)
      {
        state[child] = 1;
        path.push_back({ child, 0 });
      }
    }
  }
  return {};
}

// What is behind "base64,"; nothing where that is no data.
std::vector<std::uint8_t> DataOf(const std::string& uri)
{
  static constexpr std::string_view digits =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const std::size_t comma = uri.find(";base64,");
  std::vector<std::uint8_t> bytes;
  std::uint32_t bits = 0;
  unsigned held = 0;
  for (std::size_t i = comma == std::string::npos ? uri.size() : comma + 8; i < uri.size(); ++i)
  {
    const std::size_t digit = digits.find(uri[i]);
    if (digit == std::string_view::npos)
    {
      break;
    }
    bits = (bits << 6U) | static_cast<std::uint32_t>(digit);
    held += 6;
    if (held >= 8)
    {
      held -= 8;
      bytes.push_back(static_cast<std::uint8_t>((bits >> held) & 255U));
    }
  }
  return bytes;
}

std::string Plain(const std::string& uri)
{
  std::string name;
  for (std::size_t i = 0; i < uri.size(); ++i)
  {
    const auto digit = [&](std::size_t at) {
      return at < uri.size() ? std::string_view("0123456789abcdef").find(char(uri[at] | 32)) : 16;
    };
    if (uri[i] == '%' && digit(i + 1) < 16 && digit(i + 2) < 16)
    {
      name += static_cast<char>(16 * digit(i + 1) + digit(i + 2));
      i += 2;
    }
    else
    {
      name += uri[i];
    }
  }
  return name;
}

// Of the JSON, what it says of pictures.
class MaterialReader
{
public:
  MaterialReader(const Document& document, std::filesystem::path file)
    : Source(document)
    , File(std::move(file))
  {
  }

  PictureSource PictureOf(std::size_t number) const
  {
    const Json& image = Member(this->Source.json, "images")[number];
    PictureSource source;
    source.name = "image " + std::to_string(number);
    const Json& uri = Member(image, "uri");
    if (uri.is_string())
    {
      this->Locate(uri.get<std::string>(), source);
      source.name += source.file.empty() ? "" : " " + QuotedText(source.file.filename().string());
      return source;
    }
    const Json& views = Member(this->Source.json, "bufferViews");
    const std::size_t view = IndexIn(views, Member(image, "bufferView"));
    const Json& buffers = Member(this->Source.json, "buffers");
    if (!views.is_array() || view == views.size())
    {
      return source;
    }
    const std::size_t buffer = IndexIn(buffers, Member(views[view], "buffer"));
    if (!buffers.is_array() || buffer == buffers.size())
    {
      return source;
    }
    const Json& place = Member(buffers[buffer], "uri");
    if (place.is_string())
    {
      this->Locate(place.get<std::string>(), source);
    }
    else if (this->Source.isGlb && buffer == 0)
    {
      source.file = this->File;
      source.offset = this->Source.binary;
    }
    const auto size = static_cast<std::uint64_t>(
      std::clamp(NumberOf(Member(views[view], "byteLength"), 0), 0.0, 0x1p40));
    const auto offset = static_cast<std::uint64_t>(
      std::clamp(NumberOf(Member(views[view], "byteOffset"), 0), 0.0, 0x1p40));
    source.offset += offset;
    source.size = size;
    if (source.file.empty())
    {
      const std::size_t begin = std::min<std::size_t>(offset, source.bytes.size());
      const std::size_t end = begin + std::min<std::size_t>(size, source.bytes.size() - begin);
      source.bytes = { source.bytes.begin() + static_cast<std::ptrdiff_t>(begin),
        source.bytes.begin() + static_cast<std::ptrdiff_t>(end) };
    }
    return source;
  }

  GltfMaterial MaterialOf(const Json& material)
  {
    GltfMaterial read;
    const Json& pbr = Member(material, "pbrMetallicRoughness");
    const Json& factor = Member(pbr, "baseColorFactor");
    for (std::size_t k = 0; k < 4 && factor.is_array() && k < factor.size(); ++k)
    {
      read.paint.factor[k] = std::clamp(NumberOf(factor[k], 1), 0.0, 1.0);
    }
    read.paint.color = read.paint.factor;
    const Json& mode = Member(material, "alphaMode");
    read.paint.opaque = !mode.is_string() || mode == "OPAQUE";
    this->ReadTexture(Member(pbr, "baseColorTexture"), read);
    for (const char* const other : { "normalTexture", "occlusionTexture", "emissiveTexture" })
    {
      this->NoteOther(Member(material, other), other);
    }
    this->NoteOther(Member(pbr, "metallicRoughnessTexture"), "metallicRoughnessTexture");
    return read;
  }

  std::vector<std::string> others; // pictures that are not carried

private:
  void NoteOther(const Json& texture, const char* name)
  {
    if (texture.is_object() &&
        std::find(this->others.begin(), this->others.end(), name) == this->others.end())
    {
      this->others.emplace_back(name);
    }
  }

  void Locate(const std::string& uri, PictureSource& source) const
  {
    if (uri.rfind("data:", 0) == 0)
    {
      source.bytes = DataOf(uri);
    }
    else
    {
      source.file = FileBeside(this->File, Plain(uri));
    }
  }

  void ReadTexture(const Json& info, GltfMaterial& read) const
  {
    const Json& textures = Member(this->Source.json, "textures");
    const std::size_t number = IndexIn(textures, Member(info, "index"));
    if (!textures.is_array() || number == textures.size())
    {
      return;
    }
    const Json& texture = textures[number];
    const Json& webp = Member(Member(texture, "extensions"), "EXT_texture_webp");
    const Json& source = webp.is_object() ? Member(webp, "source") : Member(texture, "source");
    const Json& images = Member(this->Source.json, "images");
    const std::size_t image = IndexIn(images, source);
    if (!images.is_array() || image == images.size())
    {
      return;
    }
    read.paint.picture = static_cast<std::uint32_t>(image);
    const Json& samplers = Member(this->Source.json, "samplers");
    const std::size_t sampler = IndexIn(samplers, Member(texture, "sampler"));
    if (samplers.is_array() && sampler < samplers.size())
    {
      read.paint.wrapU = WrapOf(Member(samplers[sampler], "wrapS"));
      read.paint.wrapV = WrapOf(Member(samplers[sampler], "wrapT"));
    }
    read.coordinates =
      static_cast<int>(std::clamp(NumberOf(Member(info, "texCoord"), 0), 0.0, 99.0));
    this->ReadTransform(Member(Member(info, "extensions"), "KHR_texture_transform"), read);
  }

  static TextureWrap WrapOf(const Json& value)
  {
    constexpr double clampToEdge = 33071, mirroredRepeat = 33648; // as glTF names them
    const double number = NumberOf(value, 0);
    return number == clampToEdge      ? TextureWrap::Clamp
           : number == mirroredRepeat ? TextureWrap::Mirror
                                      : TextureWrap::Repeat;
  }

  static void ReadTransform(const Json& transform, GltfMaterial& read)
  {
    if (!transform.is_object())
    {
      return;
    }
    const auto at = [&](const char* name, std::size_t k, double otherwise)
    {
      const Json& values = Member(transform, name);
      return values.is_array() && k < values.size() ? NumberOf(values[k], otherwise) : otherwise;
    };
    const double angle = NumberOf(Member(transform, "rotation"), 0);
    const double c = std::cos(angle), s = std::sin(angle);
    const double x = at("scale", 0, 1), y = at("scale", 1, 1);
    read.paint.transform = { { c * x, s * y, at("offset", 0, 0) },
      { -s * x, c * y, at("offset", 1, 0) } };
    read.coordinates = static_cast<int>(
      std::clamp(NumberOf(Member(transform, "texCoord"), read.coordinates), 0.0, 99.0));
  }

  const Document& Source;
  std::filesystem::path File;
};

// Takes pictures out, and puts a material's number into its colour.
void StripPictures(Json& json)
{
  for (const char* const name : { "images", "textures", "samplers", "extensionsRequired" })
  {
    json.erase(name);
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
  : materials(std::move(other.materials))
  , pictures(std::move(other.pictures))
  , warnings(std::move(other.warnings))
  , Name(std::move(other.Name))
  , Folder(std::exchange(other.Folder, {}))
  , Descriptors(std::exchange(other.Descriptors, {}))
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
  std::optional<Document> document = ReadDocument(file);
  if (!document)
  {
    return scene;
  }
  Json& json = document->json;
  KDSTREAM_TRY(CheckNodes(json));
  const Json& images = Member(json, "images");
  const Json& materials = Member(json, "materials");
  if (!images.is_array() || images.empty() || !materials.is_array())
  {
    return scene;
  }
  MaterialReader reader(*document, file);
  for (std::size_t i = 0; i < images.size(); ++i)
  {
    scene.pictures.push_back(reader.PictureOf(i));
  }
  for (const Json& material : materials)
  {
    scene.materials.push_back(reader.MaterialOf(material));
  }
  for (const std::string& other : reader.others)
  {
    scene.warnings.push_back((scene.warnings.empty() ? "" : scene.warnings.back() + ", ") + other);
  }
  if (!scene.warnings.empty())
  {
    scene.warnings = { "pictures of materials that are not carried: " + scene.warnings.back() };
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
