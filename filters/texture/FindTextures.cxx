// SPDX-License-Identifier: BSD-3-Clause
#include "filters/texture/FindTextures.h"

#include "filters/meshio/ByteSource.h"
#include "filters/meshio/FileEnding.h"
#include "filters/meshio/ObjStatements.h"
#include "filters/texture/ObjMaterials.h"
#include "filters/texture/TexturedPly.h"

#include <algorithm>
#include <optional>
#include <string_view>

namespace kdstream
{
namespace
{

// Whether the word is anywhere in the file.
Result<bool> HasWord(ByteSource& source, std::string_view word)
{
  for (;;)
  {
    const Result<std::string_view> block = source.Peek(ByteSource::blockSize);
    KDSTREAM_TRY(block);
    if (block->find(word) != std::string_view::npos)
    {
      return true;
    }
    if (block->size() < word.size())
    {
      return false;
    }
    source.Consume(block->size() - (word.size() - 1)); // the next block may begin within it
  }
}

bool IsGrey(const Color& color)
{
  return color[0] == color[1] && color[0] == color[2];
}

// Colours of materials that are used, as far as is known.
class UsedColors
{
public:
  void Add(const ObjMaterial& material)
  {
    this->Several =
      this->Several || (this->First && *this->First != material.color) || !IsGrey(material.color);
    this->First = material.color;
  }
  // Whether they are more than one shade of grey.
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

// Whether faces use such colours, in an .obj whose vertices do not all have their own. What is
// wrong in it is left to its reader. Errors: InputOutput.
Result<bool> UsesColors(ObjStatements& statements, const std::vector<ObjMaterial>& materials)
{
  MaterialNames names;
  for (std::size_t i = 0; i < materials.size(); ++i)
  {
    names.Add(materials[i].name, static_cast<std::uint32_t>(i));
  }
  UsedColors colors;
  const ObjMaterial* used = nullptr;
  bool places = false, bare = false; // bare: a vertex has no colour
  statements.Restart();
  while (!bare || !colors.Count())
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
    if (statements.Keyword() == ObjKeyword::Place && !bare)
    {
      places = true;
      bare = !ParseObjPlace(text, false, place) || !place.colored;
    }
    else if (statements.Keyword() == ObjKeyword::Face && used)
    {
      colors.Add(*used);
    }
    else if (statements.Name() == "usemtl")
    {
      const std::optional<std::uint32_t> found = names.Find(TrimmedObjText(text));
      used = found && materials[*found].colored ? &materials[*found] : nullptr;
    }
  }
  return colors.Count() && (bare || !places);
}

Result<FoundTextures> FindInObj(const std::filesystem::path& file)
{
  Result<ByteSource> source = ByteSource::Open(file);
  KDSTREAM_TRY(source);
  const Result<bool> named = HasWord(*source, "mtllib");
  KDSTREAM_TRY(named);
  if (!*named)
  {
    return FoundTextures{};
  }
  source->Seek(0);
  ObjStatements statements(std::move(*source));
  ObjLibraries libraries(file);
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
  }
  ObjMaterials found = libraries.Take();
  const bool any = std::any_of(found.materials.begin(), found.materials.end(),
    [](const ObjMaterial& material) { return !material.picture.empty(); });
  if (any)
  {
    return FoundTextures{ true };
  }
  if (HasColors(found.materials))
  {
    const Result<bool> uses = UsesColors(statements, found.materials);
    KDSTREAM_TRY(uses);
    if (*uses)
    {
      return FoundTextures{ true, true };
    }
  }
  return FoundTextures{ false, false, std::move(found.warnings) };
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
    return FoundTextures{ header && HasPictures(*header) };
  }
  return ending == ".obj" ? FindInObj(file) : FoundTextures{};
}

Result<TexturedFile> ReadTextured(const std::filesystem::path& file, const Execution& execution)
{
  return FileEnding(file) == ".ply" ? ReadTexturedPly(file, execution)
                                    : ReadTexturedObj(file, execution);
}

}
