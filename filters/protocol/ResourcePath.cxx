// SPDX-License-Identifier: BSD-3-Clause
#include "filters/protocol/ResourcePath.h"

#include "filters/core/Texts.h"
#include "filters/model/ModelDescription.h"
#include "filters/protocol/TextParts.h"

#include <utility>

namespace kdstream::protocol
{

namespace
{
constexpr std::string_view modelsPrefix = "/api/models/";
constexpr std::string_view tilesFolder = "3dtiles/";

Error NothingAt(std::string_view path)
{
  return { ErrorCode::NotFound, "there is nothing at " + Quoted(path) };
}

// below: the part of the path after the folder of a model's tiles.
Result<ResourcePath> ParseTilePath(
  ResourcePath resource, std::string_view below, std::string_view path)
{
  resource.kind = ResourcePath::Kind::Tile;
  const auto versionEnd = below.find('/');
  const bool isRoot = versionEnd == std::string_view::npos;
  const auto tile = ParseTileName(isRoot ? below : below.substr(versionEnd + 1));
  if (!tile || tile->isRoot != isRoot)
  {
    return tile || tile.GetError().code == ErrorCode::NotFound ? NothingAt(path) : tile.GetError();
  }
  if (!isRoot && !IsDigest(below.substr(0, versionEnd)))
  {
    return Error{ ErrorCode::InvalidArgument,
      "not a version of a tileset: " + Quoted(below.substr(0, versionEnd)) };
  }
  resource.digest = isRoot ? std::string_view() : below.substr(0, versionEnd);
  resource.tile = *tile;
  return resource;
}

}

std::string ModelPath(std::string_view model)
{
  return std::string(modelsPrefix) + std::string(model) + "/model.json";
}

std::string NotesPath(std::string_view model)
{
  return std::string(modelsPrefix) + std::string(model) + "/notes.json";
}

std::string BlobPath(std::string_view model, std::string_view digest, const BlobId& blob)
{
  return std::string(modelsPrefix) + std::string(model) + "/" + std::string(digest) + "/" +
         BlobName(blob);
}

Result<ResourcePath> ParseResourcePath(std::string_view path)
{
  ResourcePath resource;
  if (path == modelListPath || path == "/api/models")
  {
    return resource;
  }
  if (path.substr(0, modelsPrefix.size()) != modelsPrefix)
  {
    return NothingAt(path);
  }
  const auto rest = path.substr(modelsPrefix.size());
  const auto idEnd = rest.find('/');
  if (idEnd == std::string_view::npos)
  {
    return NothingAt(path);
  }
  if (!IsModelId(rest.substr(0, idEnd)))
  {
    return Error{ ErrorCode::InvalidArgument, "not a model id: " + Quoted(rest.substr(0, idEnd)) };
  }
  resource.model = rest.substr(0, idEnd);

  const auto below = rest.substr(idEnd + 1);
  if (below == "model.json")
  {
    resource.kind = ResourcePath::Kind::Model;
    return resource;
  }
  if (below == "notes.json")
  {
    resource.kind = ResourcePath::Kind::Notes;
    return resource;
  }
  if (below.substr(0, tilesFolder.size()) == tilesFolder)
  {
    return ParseTilePath(std::move(resource), below.substr(tilesFolder.size()), path);
  }
  const auto digestEnd = below.find('/');
  if (digestEnd == std::string_view::npos)
  {
    return NothingAt(path);
  }
  auto blob = ParseBlobName(below.substr(digestEnd + 1));
  if (!blob)
  {
    return blob.GetError().code == ErrorCode::NotFound ? NothingAt(path) : blob.GetError();
  }
  if (!IsDigest(below.substr(0, digestEnd)))
  {
    return Error{ ErrorCode::InvalidArgument,
      "not a digest: " + Quoted(below.substr(0, digestEnd)) };
  }
  resource.kind = ResourcePath::Kind::Blob;
  resource.digest = below.substr(0, digestEnd);
  resource.blob = *blob;
  return resource;
}

}
