// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/ForeignMesh.h"

#include "filters/core/Attribute.h"
#include "filters/meshio/ByteSource.h"
#include "filters/meshio/ContentFormat.h"
#include "filters/meshio/DroppedPoints.h"
#include "filters/meshio/FileEnding.h"
#include "filters/meshio/MeshReader.h"
#include "filters/meshio/ObjReader.h"
#include "filters/meshio/ShownColors.h"
#include "filters/texture/FindTextures.h"

#include <algorithm>

namespace kdstream
{
namespace
{

const std::string notCarried = "left out: ";

// Reads formats that kdstream-build reads itself.
Result<ForeignMesh> ReadInChunks(const std::filesystem::path& file, const Execution& execution)
{
  Result<std::unique_ptr<MeshReader>> reader = MeshReader::Open(file, execution);
  KDSTREAM_TRY(reader);
  ForeignMesh result;
  Mesh& mesh = result.mesh;
  MeshReader& input = **reader;
  mesh.scalarType = input.Info().scalarType;
  KDSTREAM_TRY(input.ReadRest(mesh, execution));
  for (const std::string& name : input.Info().ignoredAttributes)
  {
    result.warnings.push_back(notCarried + name);
  }
  result.tolerance = input.Info().tolerance;
  return result;
}

// Bakes the textures of a mesh.
Result<ForeignMesh> Bake(
  TexturedFile read, const TextureOptions& textures, const Execution& execution)
{
  Result<BakeReport> report = BakeAndKeepTextures(read.textured, textures, execution);
  KDSTREAM_TRY(report);
  ForeignMesh result{ std::move(read.textured.mesh), std::move(read.warnings) };
  result.tolerance = std::move(read.tolerance);
  result.named = std::move(read.libraries);
  for (const PictureSource& picture : read.textured.pictures)
  {
    result.named.push_back(picture.file);
  }
  result.warnings.insert(result.warnings.end(), report->warnings.begin(), report->warnings.end());
  if (!read.textured.pictures.empty())
  {
    result.baked = std::move(*report);
  }
  return result;
}

// Formats that kdstream-build reads itself, except files with textures.
Result<ForeignMesh> ReadOwn(
  const std::filesystem::path& file, const TextureOptions& textures, const Execution& execution)
{
  const Result<FoundTextures> found =
    textures.bake ? FindTextures(file) : Result<FoundTextures>(FoundTextures{});
  KDSTREAM_TRY(found);
  if (!found->any)
  {
    Result<ForeignMesh> read = ReadInChunks(file, execution);
    if (read)
    {
      // Removes the warning if no textures are wanted, or nothing is lost.
      std::erase_if(read->warnings, [&](const std::string& warning)
        { return (!textures.bake || found->isPlain) && warning == notCarried + objMaterialsName; });
      read->warnings.insert(read->warnings.begin(), found->warnings.begin(), found->warnings.end());
    }
    return read;
  }
  Result<TexturedFile> read = ReadTextured(file, execution);
  KDSTREAM_TRY(read);
  return Bake(std::move(*read), textures, execution);
}

#ifndef KDSTREAM_HAS_PCL
Result<ForeignMesh> ReadPcdWithoutPcl(const std::filesystem::path&, const Execution&)
{
  return Error{ ErrorCode::Unsupported,
    "reading .pcd files needs PCL, but kdstream-convert was built without it: install PCL (Debian: "
    "libpcl-dev) and build kdstream-convert again",
    {}, {}, Remedy::InMessage };
}
#endif

#ifndef KDSTREAM_HAS_COIN
Result<ForeignMesh> ReadVrmlWithoutCoin(const std::filesystem::path&, const Execution&)
{
  return Error{ ErrorCode::Unsupported,
    "reading .wrl files needs Coin, but kdstream-convert was built without it: install Coin "
    "(Debian: libcoin-dev) and build kdstream-convert again",
    {}, {}, Remedy::InMessage };
}
#endif

using ReadFormat = Result<ForeignMesh> (*)(const std::filesystem::path&, const Execution&);

ReadFormat FormatOf(const std::string& ending)
{
  static constexpr struct
  {
    const char* ending;
    ReadFormat read;
  } formats[] = {
    { ".stl", ReadInChunks }, { ".off", ReadInChunks }, { ".vtp", ReadVtp }, { ".vtk", ReadVtk },
#ifdef KDSTREAM_HAS_COIN
    { ".wrl", ReadVrml }, { ".wrz", ReadVrml },
#else
    { ".wrl", ReadVrmlWithoutCoin }, { ".wrz", ReadVrmlWithoutCoin },
#endif
    { ".las", ReadLas }, { ".laz", ReadLas },
#ifdef KDSTREAM_HAS_PCL
    { ".pcd", ReadPcd }
#else
    { ".pcd", ReadPcdWithoutPcl }
#endif
  };
  const auto found = std::find_if(std::begin(formats), std::end(formats),
    [&](const auto& format) { return format.ending == ending; });
  return found == std::end(formats) ? nullptr : found->read;
}

// Drops arrays that a stored mesh cannot have, with a warning.
void DropUnfitAttributes(ForeignMesh& result)
{
  std::vector<Attribute> kept;
  for (Attribute& attribute : result.mesh.attributes)
  {
    const bool second = std::any_of(kept.begin(), kept.end(),
      [&](const Attribute& other)
      { return other.name == attribute.name && other.association == attribute.association; });
    if (IsAttributeName(attribute.name) && !second && kept.size() < mostAttributes)
    {
      kept.push_back(std::move(attribute));
    }
    else
    {
      result.warnings.push_back(second ? "a second array \"" + attribute.name + "\" is dropped"
                                       : "an array is dropped: its name cannot be stored");
    }
  }
  result.mesh.attributes = std::move(kept);
}

}

Result<ForeignMesh> ReadForeignMesh(const std::filesystem::path& file,
  const TextureOptions& textures, const Execution& execution, const std::string& columns)
{
  const std::string ending = FileEnding(file);
  const bool xyz = IsPointText(ending);
  const bool own = ending == ".ply" || ending == ".obj";
  const bool gltf = ending == ".glb" || ending == ".gltf", tileset = ending == ".json";
  const ReadFormat read = FormatOf(ending);
  // Only for the error message if the file is missing, or is a folder.
  Result<ByteSource> source = ByteSource::Open(file);
  KDSTREAM_TRY(source);
  if (source->Size() == 0)
  {
    return BadInput("is empty", Remedy::CopyAgain);
  }
  if (!read && !own && !gltf && !tileset && !xyz)
  {
    return Error{ ErrorCode::Unsupported, UnknownEndingHint(*source, ending), {}, {},
      Remedy::InMessage };
  }
  Result<ForeignMesh> result = OfInput(own       ? ReadOwn(file, textures, execution)
                                       : gltf    ? ReadGltf(file, textures, execution)
                                       : tileset ? ReadTileset(file, textures, execution)
                                       : xyz     ? ReadXyz(file, columns, execution)
                                                 : read(file, execution));
  const Result<std::string_view> begin = source->Peek(contentFormatBytes);
  const bool isUnpacked = ending.starts_with(".wr") && begin && FormatOfContent(*begin) == ".gz";
  const std::string hint = isUnpacked ? std::string() : OtherFormatHint(*source, ending);
  if (!result)
  {
    return hint.empty() || result.GetError().code != ErrorCode::InvalidInput
             ? result
             : BadInput(hint, Remedy::InMessage);
  }
  if (ending == ".pcd" || ending == ".vtk" || ending == ".vtp")
  {
    KDSTREAM_TRY(CheckByteOrder(result->mesh.points, result->mesh.scalarType));
  }
  // For formats whose readers return points that are not finite.
  const Result<std::vector<bool>> finite = DropNotFinite(result->mesh, {}, result->tolerance);
  KDSTREAM_TRY(finite);
  if (result->mesh.points.empty() && !hint.empty())
  {
    return BadInput(hint, Remedy::InMessage);
  }
  if (result->mesh.points.empty())
  {
    std::string message = "holds no points";
    std::vector<std::string> why = result->warnings;
    const std::vector<std::string> reported = result->tolerance.Warnings();
    why.insert(why.end(), reported.begin(), reported.end());
    for (const std::string& warning : why)
    {
      message += "; " + warning;
    }
    return OfInput(Error{ ErrorCode::InvalidInput, message });
  }
  DropUnfitAttributes(*result);
  AddShownColors(result->mesh, result->tolerance);
  return result;
}

}
