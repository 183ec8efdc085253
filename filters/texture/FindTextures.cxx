// SPDX-License-Identifier: BSD-3-Clause
#include "filters/texture/FindTextures.h"

#include "filters/meshio/ByteSource.h"
#include "filters/meshio/FileEnding.h"
#include "filters/meshio/ObjStatements.h"
#include "filters/texture/ObjMaterials.h"
#include "filters/texture/TexturedPly.h"

#include <algorithm>

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
  return any ? FoundTextures{ true, {} } : FoundTextures{ false, std::move(found.warnings) };
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
    return FoundTextures{ header && HasPictures(*header), {} };
  }
  return ending == ".obj" ? FindInObj(file) : FoundTextures{};
}

Result<TexturedFile> ReadTextured(const std::filesystem::path& file, const Execution& execution)
{
  return FileEnding(file) == ".ply" ? ReadTexturedPly(file, execution)
                                    : ReadTexturedObj(file, execution);
}

}
