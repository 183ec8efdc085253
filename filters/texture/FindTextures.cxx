// SPDX-License-Identifier: BSD-3-Clause
#include "filters/texture/FindTextures.h"

#include "filters/core/Texts.h"
#include "filters/meshio/ByteSource.h"
#include "filters/meshio/FileEnding.h"
#include "filters/meshio/ObjStatements.h"
#include "filters/meshio/QuotedText.h"
#include "filters/texture/ObjMaterials.h"
#include "filters/texture/PictureTiles.h"
#include "filters/texture/TexturedPly.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string_view>

namespace kdstream
{
namespace
{

bool IsThere(const std::filesystem::path& file)
{
  // Pictures that consist of tiles (PictureTiles.h) have files of other names.
  std::error_code failed;
  return HasTiles(file.string()) || std::filesystem::is_regular_file(file, failed);
}

// Whether the word is anywhere in the file, in any case. word: in lower case.
Result<bool> HasWord(ByteSource& source, std::string_view word)
{
  const auto same = [](char c, char small)
  { return (c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c) == small; };
  for (;;)
  {
    const Result<std::string_view> block = source.Peek(ByteSource::blockSize);
    KDSTREAM_TRY(block);
    if (std::search(block->begin(), block->end(), word.begin(), word.end(), same) != block->end())
    {
      return true;
    }
    if (block->size() < word.size())
    {
      return false;
    }
    source.Consume(block->size() - (word.size() - 1)); // the word may cross the border of blocks
  }
}

bool IsGrey(const Color& color)
{
  return color[0] == color[1] && color[0] == color[2];
}

// The colours of materials in use, as far as they are known.
class UsedColors
{
public:
  void Add(const ObjMaterial& material)
  {
    this->Several =
      this->Several || (this->First && *this->First != material.color) || !IsGrey(material.color);
    this->First = material.color;
  }
  // Whether the colours count: they are more than one shade of grey.
  bool Count() const { return this->Several; }

private:
  std::optional<Color> First;
  bool Several = false;
};

bool HasColors(const std::vector<ObjMaterial>& materials)
{
  UsedColors colors;
  for (const ObjMaterial& material : materials)
  {
    if (material.colored)
    {
      colors.Add(material);
    }
  }
  return colors.Count();
}

MaterialNames NamesOfMaterials(const std::vector<ObjMaterial>& materials)
{
  MaterialNames names;
  for (std::size_t i = 0; i < materials.size(); ++i)
  {
    names.Add(materials[i].name, static_cast<std::uint32_t>(i));
  }
  return names;
}

// What is known of an .obj's textures. Reading stops as soon as this is certain.
struct TexturesOfObj
{
  bool textured = false; // a face uses an existing picture
  bool colors = false;   // faces use material colours that count
  bool bare = false;     // a vertex has no colour
  bool places = false;
};

// Errors in the file are left to its reader. pictures: for each material, whether its picture
// exists. Errors: InputOutput.
Result<TexturesOfObj> FindTexturesOfObj(ObjStatements& statements,
  const std::vector<ObjMaterial>& materials, const std::vector<bool>& pictures)
{
  const MaterialNames names = NamesOfMaterials(materials);
  UsedColors colors;
  TexturesOfObj textures;
  std::optional<std::uint32_t> used;
  const bool any = std::find(pictures.begin(), pictures.end(), true) != pictures.end();
  const bool lookForColors = HasColors(materials);
  statements.Restart();
  while (!textures.bare || (any && !textures.textured) || (lookForColors && !colors.Count()))
  {
    const Result<bool> more = statements.Next();
    if (!more && more.GetError().code == ErrorCode::InputOutput)
    {
      return more.GetError();
    }
    if (!more || !*more)
    {
      break;
    }
    const std::string_view text = statements.Rest();
    ObjPlace place;
    if (statements.Keyword() == ObjKeyword::Place && !textures.bare)
    {
      textures.places = true;
      textures.bare = !ParseObjPlace(text, false, place) || !place.colored;
    }
    else if (statements.Keyword() == ObjKeyword::Face && used)
    {
      textures.textured = textures.textured || pictures[*used];
      if (materials[*used].colored)
      {
        colors.Add(materials[*used]);
      }
    }
    else if (statements.Name() == "usemtl")
    {
      used = names.Find(Trimmed(text, blanksOfNames));
    }
    if (any && (textures.textured || textures.bare))
    {
      break; // the mesh is textured
    }
  }
  textures.colors = colors.Count();
  return textures;
}

// Adds a sentence for each missing picture, whose material's vertex colours are used instead.
void TellMissing(const std::vector<ObjMaterial>& materials, const std::vector<bool>& pictures,
  std::vector<std::string>& warnings)
{
  for (std::size_t i = 0; i < materials.size(); ++i)
  {
    if (!materials[i].picture.empty() && !pictures[i])
    {
      warnings.push_back("the picture " + QuotedText(materials[i].picture) + " (" +
                         materials[i].place + ") " + WhyMissing(materials[i].picture) +
                         ": vertex colours are used");
    }
  }
}

// The names in usemtl statements, each with the line where it occurs first.
class UsedMaterialNames
{
public:
  void Add(std::string_view name, std::uint64_t line)
  {
    constexpr std::size_t most = 1000;
    if (this->Lines.size() < most)
    {
      this->Lines.try_emplace(std::string(Trimmed(name, blanksOfNames)), line);
    }
  }

  // Adds a sentence for each of the first names that no library has.
  void TellUnknown(const std::vector<ObjMaterial>& materials, std::vector<std::string>& warnings)
  {
    constexpr std::size_t most = 10;
    const MaterialNames names = NamesOfMaterials(materials);
    std::map<std::uint64_t, std::string> unknown;
    for (const auto& [name, line] : this->Lines)
    {
      if (!names.Find(name))
      {
        unknown.emplace(line, name);
      }
    }
    for (const auto& [line, name] : unknown)
    {
      if (warnings.size() < most)
      {
        warnings.push_back("line " + std::to_string(line) + ": the material " + QuotedText(name) +
                           " is in no material library: it is drawn white");
      }
    }
  }

private:
  std::map<std::string, std::uint64_t> Lines;
};

Result<FoundTextures> FindInObj(const std::filesystem::path& file)
{
  Result<ByteSource> source = ByteSource::Open(file);
  KDSTREAM_TRY(source);
  Result<bool> named = HasWord(*source, "mtllib");
  KDSTREAM_TRY(named);
  if (!*named)
  {
    std::error_code failed;
    source->Seek(0);
    named = std::filesystem::is_regular_file(
              std::filesystem::path(file).replace_extension(".mtl"), failed)
              ? HasWord(*source, "usemtl")
              : Result<bool>(false);
    KDSTREAM_TRY(named);
  }
  if (!*named)
  {
    return FoundTextures{};
  }
  source->Seek(0);
  ObjStatements statements(std::move(*source));
  ObjLibraries libraries(file);
  UsedMaterialNames used;
  for (;;)
  {
    const Result<bool> more = statements.Next();
    if (!more && more.GetError().code == ErrorCode::InputOutput)
    {
      return more.GetError();
    }
    if (!more || !*more)
    {
      break;
    }
    if (statements.Name() == "mtllib")
    {
      libraries.Add(statements.Rest(), statements.GetLines().Number());
    }
    else if (statements.Name() == "usemtl")
    {
      used.Add(statements.Rest(), statements.GetLines().Number());
    }
  }
  libraries.AddOwn();
  ObjMaterials found = libraries.Take();
  FilesBeside files(file);
  std::vector<bool> pictures; // for each material: its picture exists
  bool any = false;
  for (const ObjMaterial& material : found.materials)
  {
    any = any || !material.picture.empty();
    pictures.push_back(!material.picture.empty() && IsThere(files.Find(material.picture)));
  }
  if (!any && !HasColors(found.materials))
  {
    if (found.warnings.empty())
    {
      used.TellUnknown(found.materials, found.warnings);
    }
    return FoundTextures{ false, false, std::move(found.warnings), true };
  }
  const Result<TexturesOfObj> textures = FindTexturesOfObj(statements, found.materials, pictures);
  KDSTREAM_TRY(textures);
  const bool ownColors = textures->places && !textures->bare;
  if (any && !(ownColors && !textures->textured))
  {
    return FoundTextures{ true };
  }
  if (!any && textures->colors && !ownColors)
  {
    return FoundTextures{ true, true };
  }
  TellMissing(found.materials, pictures, found.warnings);
  return FoundTextures{ false, false, std::move(found.warnings), !any && !textures->colors };
}

// In a .ply, pictures that do not exist are ignored if vertices have colours.
FoundTextures FindInPly(const std::filesystem::path& file, const PlyHeader& header)
{
  if (!HasPictures(header))
  {
    return {};
  }
  FilesBeside files(file);
  FoundTextures found{ true };
  for (const std::string& name : header.textureFiles)
  {
    if (IsThere(files.Find(name)))
    {
      return { true };
    }
    found.warnings.push_back("the picture " + QuotedText(name) + " (TextureFile) " +
                             WhyMissing(name) + ": vertex colours are used");
  }
  found.any = !HasColorsOfVertices(header);
  found.warnings.resize(found.any ? 0 : found.warnings.size());
  return found;
}

}

Result<FoundTextures> FindTextures(const std::filesystem::path& file)
{
  const std::string ending = FileEnding(file);
  if (ending == ".ply")
  {
    Result<ByteSource> source = ByteSource::Open(file);
    KDSTREAM_TRY(source);
    const Result<PlyHeader> header = ReadPlyHeader(*source);
    return header ? FindInPly(file, *header) : FoundTextures{};
  }
  return ending == ".obj" ? FindInObj(file) : FoundTextures{};
}

Result<TexturedFile> ReadTextured(const std::filesystem::path& file, const Execution& execution)
{
  return FileEnding(file) == ".ply" ? ReadTexturedPly(file, execution)
                                    : ReadTexturedObj(file, execution);
}

}
