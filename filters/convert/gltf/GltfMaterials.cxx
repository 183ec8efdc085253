// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/gltf/GltfMaterials.h"

#include "filters/core/Texts.h"
#include "filters/meshio/QuotedText.h"
#include "filters/texture/FilesBeside.h"
#include "filters/texture/LostLooks.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

namespace kdstream
{
namespace
{

using Json = nlohmann::json;

constexpr std::size_t mostWarnings = 20;

// Reads what the JSON says about materials and pictures.
class MaterialReader
{
public:
  MaterialReader(
    const GltfDocument& document, const GltfBuffers& buffers, std::filesystem::path file)
    : Source(document)
    , Buffers(buffers)
    , File(std::move(file))
    , Files(this->File)
  {
  }

  PictureSource PictureOf(std::size_t number)
  {
    const Json& image = Member(this->Source.json, "images")[number];
    PictureSource source;
    source.name = "image " + std::to_string(number);
    const Json& uri = Member(image, "uri");
    if (uri.is_string())
    {
      this->Locate(uri.get<std::string>(), source);
      return source;
    }
    const Json& views = Member(this->Source.json, "bufferViews");
    const Json& view = Member(image, "bufferView");
    const std::size_t at = IndexIn(views, view);
    if (view.is_null())
    {
      source.wrong = "it has neither uri nor bufferView";
    }
    else if (at == CountOf(views))
    {
      source.wrong = "it " + NamesNone("bufferView", view, views);
    }
    else if (this->FirstLike(number) == number)
    {
      this->LocateView(at, views[at], source);
    }
    return source;
  }

  // number: of the material; for warnings.
  GltfMaterial MaterialOf(const Json& material, std::size_t number)
  {
    GltfMaterial read;
    const Json& pbr = Member(material, "pbrMetallicRoughness");
    const Json& core = Member(pbr, "baseColorTexture");
    // An older extension, which some programs still write for readers that do not know the core's
    // properties.
    const Json& glossy =
      Member(Member(material, "extensions"), "KHR_materials_pbrSpecularGlossiness");
    const bool isGlossy = core.is_null() && glossy.is_object();
    const Json& factor =
      isGlossy ? Member(glossy, "diffuseFactor") : Member(pbr, "baseColorFactor");
    const std::size_t factors = CountOf(factor);
    if (factors > 4)
    {
      this->Warn("material " + std::to_string(number) + " has a colour of " +
                 std::to_string(factors) + " numbers, not 4: it is not used");
    }
    for (std::size_t k = 0; k < factors && factors <= 4; ++k)
    {
      read.textured.factor[k] = std::clamp(NumberOf(factor[k], 1), 0.0, 1.0);
    }
    read.textured.color = read.textured.factor;
    const Json& mode = Member(material, "alphaMode");
    read.textured.opaque = !mode.is_string() || mode == "OPAQUE";
    if (const Json& texture = isGlossy ? Member(glossy, "diffuseTexture") : core;
        !texture.is_null())
    {
      this->ReadTexture(texture, number, read);
    }
    for (const char* const other : { "normalTexture", "occlusionTexture", "emissiveTexture" })
    {
      this->NoteOther(Member(material, other), other);
    }
    this->NoteOther(Member(pbr, "metallicRoughnessTexture"), "metallicRoughnessTexture");
    this->NoteExtensions(Member(material, "extensions"));
    this->NoteValues(material, number);
    return read;
  }

  // Returns the warnings about errors, and about properties that are left out.
  std::vector<std::string> TakeWarnings()
  {
    if (this->Wrong > mostWarnings)
    {
      this->Warnings.push_back(
        std::to_string(this->Wrong - mostWarnings) +
        " further materials name textures, images or samplers that do not exist");
    }
    std::string names;
    for (const std::string& other : this->Others)
    {
      names += (names.empty() ? "" : ", ") + other;
    }
    if (!names.empty())
    {
      this->Warnings.push_back("left out: textures of materials: " + names);
    }
    const std::vector<std::string> lost = this->Lost.Tell();
    this->Warnings.insert(this->Warnings.end(), lost.begin(), lost.end());
    return std::move(this->Warnings);
  }

private:
  // Whether a name is fit for a message.
  static bool IsWord(const std::string& name)
  {
    return name.size() <= 40 &&
           std::all_of(name.begin(), name.end(),
             [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); });
  }

  // Notes the textures of all extensions, except the one that is used for the colour.
  void NoteExtensions(const Json& extensions)
  {
    for (const auto& [extension, members] : extensions.items())
    {
      for (const auto& [name, value] : members.items())
      {
        if (name.ends_with("Texture") && name != "diffuseTexture" && IsWord(name))
        {
          this->NoteOther(value, name);
        }
      }
    }
  }

  // Metalness counts only if the file gives it. The default would be 1, but programs that do not
  // support metalness do not mean this value.
  void NoteValues(const Json& material, std::size_t number)
  {
    const Json& pbr = Member(material, "pbrMetallicRoughness");
    const Json& name = Member(material, "name");
    const std::string named =
      name.is_string() ? QuotedText(name.get<std::string>()) : std::to_string(number);
    const bool metal = NumberOf(Member(pbr, "metallicFactor"), 0) > 0;
    const Json& light = Member(material, "emissiveFactor");
    const bool emits = std::any_of(
      light.begin(), light.end(), [](const Json& value) { return NumberOf(value, 0) > 0; });
    const Json& glass = Member(Member(material, "extensions"), "KHR_materials_transmission");
    for (const auto& [look, is] : { std::pair{ LostLook::Metalness, metal },
           { LostLook::Roughness, metal && NumberOf(Member(pbr, "roughnessFactor"), 1) < 1 },
           { LostLook::Emission, emits && !Member(material, "emissiveTexture").is_object() },
           { LostLook::Transparency, NumberOf(Member(glass, "transmissionFactor"), 0) > 0 } })
    {
      if (is)
      {
        this->Lost.Add(look, named);
      }
    }
  }

  void NoteOther(const Json& texture, const std::string& name)
  {
    if (texture.is_object() && this->Others.size() < mostWarnings &&
        std::find(this->Others.begin(), this->Others.end(), name) == this->Others.end())
    {
      this->Others.emplace_back(name);
    }
  }

  void Warn(const std::string& sentence)
  {
    const bool reported =
      std::find(this->Warnings.begin(), this->Warnings.end(), sentence) != this->Warnings.end();
    if (!reported && ++this->Wrong <= mostWarnings)
    {
      this->Warnings.push_back(sentence);
    }
  }

  void Locate(const std::string& uri, PictureSource& source)
  {
    if (uri.rfind("data:", 0) == 0)
    {
      std::optional<std::vector<std::uint8_t>> data = DataOf(uri);
      source.wrong = data ? "" : "its data URI is not base64";
      source.bytes = data ? std::move(*data) : std::vector<std::uint8_t>();
    }
    else if (uri.find("://") != std::string::npos)
    {
      source.wrong = "it is at " + QuotedText(uri) + ", and nothing is downloaded";
    }
    else
    {
      source = PictureBeside(
        this->Files.Find(PercentDecoded(uri).value_or(uri)), uri, source.name + " ", "");
    }
  }

  void LocateView(std::size_t number, const Json& view, PictureSource& source)
  {
    const std::string named = "its bufferView " + std::to_string(number);
    const Json& buffers = Member(this->Source.json, "buffers");
    const std::size_t buffer = IndexIn(buffers, Member(view, "buffer"));
    if (buffer == CountOf(buffers))
    {
      source.wrong = named + " " + NamesNone("buffer", Member(view, "buffer"), buffers);
      return;
    }
    const Json& place = Member(buffers[buffer], "uri");
    if (this->IsInData(view))
    {
      const Result<GltfBytes> bytes = this->Buffers.BytesOf(view);
      // Without a limit, many views could decode the same bytes again and again.
      this->BytesTaken += bytes ? bytes->size() : 0;
      if (!bytes || this->BytesTaken > this->Buffers.Size())
      {
        source.wrong =
          named +
          (bytes ? " shares bytes with other images: together they are larger than the file allows"
                 : " " + bytes.GetError().message);
        return;
      }
      source.bytes.assign(bytes->begin(), bytes->end());
      return;
    }
    if (place.is_string())
    {
      this->Locate(place.get<std::string>(), source);
    }
    else if (this->Source.binary > 0 && buffer == 0)
    {
      source.file = this->File;
      source.offset = this->Source.binary;
    }
    const auto bytesOf = [&](const char* name) {
      return static_cast<std::uint64_t>(std::clamp(NumberOf(Member(view, name), 0), 0.0, 0x1p40));
    };
    source.offset += bytesOf("byteOffset");
    source.size = bytesOf("byteLength");
    std::error_code failed;
    const std::uint64_t all =
      source.file.empty() ? 0 : std::filesystem::file_size(source.file, failed);
    if (source.wrong.empty() && !failed && source.offset + source.size > all)
    {
      source.wrong = named + " reaches beyond the end of its buffer";
    }
  }

  void ReadTexture(const Json& info, std::size_t material, GltfMaterial& read)
  {
    const Json& textures = Member(this->Source.json, "textures");
    const std::size_t number = IndexIn(textures, Member(info, "index"));
    if (number == CountOf(textures))
    {
      this->Warn("material " + std::to_string(material) + " " +
                 NamesNone("texture", Member(info, "index"), textures) + ": its colour is used");
      return;
    }
    const Json& texture = textures[number];
    const std::string named = "texture " + std::to_string(number);
    const Json& webp = Member(Member(texture, "extensions"), "EXT_texture_webp");
    const Json& source = webp.is_object() ? Member(webp, "source") : Member(texture, "source");
    const Json& images = Member(this->Source.json, "images");
    const std::size_t image = IndexIn(images, source);
    if (image == CountOf(images))
    {
      const bool other = Member(texture, "extensions").contains("KHR_texture_basisu");
      this->Warn(named + " " +
                 (other && source.is_null() ? "has its image only as KTX 2, which is not read"
                                            : NamesNone("image", source, images)) +
                 ": the material's colour is used");
      return;
    }
    read.textured.picture = static_cast<std::uint32_t>(this->FirstLike(image));
    const Json& samplers = Member(this->Source.json, "samplers");
    const Json& sampler = Member(texture, "sampler");
    if (const std::size_t at = IndexIn(samplers, sampler); at < CountOf(samplers))
    {
      read.textured.wrapU = WrapOf(Member(samplers[at], "wrapS"));
      read.textured.wrapV = WrapOf(Member(samplers[at], "wrapT"));
    }
    else if (!sampler.is_null())
    {
      this->Warn(
        named + " " + NamesNone("sampler", sampler, samplers) + ": its picture is repeated");
    }
    read.coordinates =
      static_cast<int>(std::clamp(NumberOf(Member(info, "texCoord"), 0), 0.0, 99.0));
    this->ReadTransform(Member(Member(info, "extensions"), "KHR_texture_transform"), read);
  }

  // The first image with the same view in a data URI; else the image itself.
  std::size_t FirstLike(std::size_t image)
  {
    const Json& views = Member(this->Source.json, "bufferViews");
    const Json& json = Member(this->Source.json, "images")[image];
    const std::size_t view = IndexIn(views, Member(json, "bufferView"));
    return view < CountOf(views) && !Member(json, "uri").is_string() && this->IsInData(views[view])
             ? this->ImageOfView.try_emplace(view, image).first->second
             : image;
  }

  bool IsInData(const Json& view) const
  {
    const Json& buffers = Member(this->Source.json, "buffers");
    const std::size_t buffer = IndexIn(buffers, Member(view, "buffer"));
    const Json& uri = buffer < CountOf(buffers) ? Member(buffers[buffer], "uri") : view;
    return uri.is_string() && uri.get_ref<const std::string&>().starts_with("data:");
  }

  static TextureWrap WrapOf(const Json& value)
  {
    constexpr double clampToEdge = 33071, mirroredRepeat = 33648; // glTF's numbers for these modes
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
    read.textured.transform = { { c * x, s * y, at("offset", 0, 0) },
      { -s * x, c * y, at("offset", 1, 0) } };
    read.coordinates = static_cast<int>(
      std::clamp(NumberOf(Member(transform, "texCoord"), read.coordinates), 0.0, 99.0));
  }

  const GltfDocument& Source;
  const GltfBuffers& Buffers;
  std::filesystem::path File;
  FilesBeside Files;
  std::map<std::size_t, std::size_t> ImageOfView; // the first image that uses the view
  std::uint64_t BytesTaken = 0;                   // decoded from data URIs
  std::vector<std::string> Warnings, Others;      // Others: pictures that are not carried
  LostLooks Lost;
  std::size_t Wrong = 0;
};

}

GltfMaterials ReadGltfMaterials(
  const GltfDocument& document, const GltfBuffers& buffers, const std::filesystem::path& file)
{
  GltfMaterials read;
  MaterialReader reader(document, buffers, file);
  for (std::size_t i = 0; i < CountOf(Member(document.json, "images")); ++i)
  {
    read.pictures.push_back(reader.PictureOf(i));
  }
  const Json& materials = Member(document.json, "materials");
  for (std::size_t i = 0; i < CountOf(materials); ++i)
  {
    read.materials.push_back(reader.MaterialOf(materials[i], i));
  }
  read.warnings = reader.TakeWarnings();
  return read;
}

}
