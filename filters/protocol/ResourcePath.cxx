// SPDX-License-Identifier: BSD-3-Clause
#include "filters/protocol/ResourcePath.h"

#include "filters/core/Texts.h"
#include "filters/model/ModelDescription.h"
#include "filters/protocol/TextParts.h"

namespace kdstream::protocol
{

namespace
{
constexpr std::string_view modelsPrefix = "/api/models/";
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
  const auto unknown = [path] {
    return Error{ ErrorCode::NotFound, "there is nothing at " + Quoted(path) };
  };
  if (path.substr(0, modelsPrefix.size()) != modelsPrefix)
  {
    return unknown();
  }
  const auto rest = path.substr(modelsPrefix.size());
  const auto idEnd = rest.find('/');
  if (idEnd == std::string_view::npos)
  {
    return unknown();
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
  const auto digestEnd = below.find('/');
  if (digestEnd == std::string_view::npos)
  {
    return unknown();
  }
  auto blob = ParseBlobName(below.substr(digestEnd + 1));
  if (!blob)
  {
    return blob.GetError().code == ErrorCode::NotFound ? unknown() : blob.GetError();
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
