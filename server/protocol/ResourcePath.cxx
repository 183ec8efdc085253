#include "server/protocol/ResourcePath.h"

#include "server/protocol/TextParts.h"

#include <algorithm>

namespace kdstream::protocol
{

namespace
{

constexpr std::string_view modelsPrefix = "/api/models/";

bool IsIdCharacter(char c)
{
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' ||
         c == '_' || c == '-';
}

bool IsHexDigit(char c)
{
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
}

}

bool IsModelId(std::string_view id)
{
  return !id.empty() && id.size() <= 128 && id != "." && id != ".." &&
         std::all_of(id.begin(), id.end(), IsIdCharacter);
}

bool IsDigest(std::string_view digest)
{
  return digest.size() == 32 && std::all_of(digest.begin(), digest.end(), IsHexDigit);
}

std::string ModelPath(std::string_view model)
{
  return std::string(modelsPrefix) + std::string(model) + "/model.json";
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
  const Error unknown{ ErrorCode::NotFound, "there is nothing at " + Quoted(path) };
  if (path.substr(0, modelsPrefix.size()) != modelsPrefix)
  {
    return unknown;
  }
  const auto rest = path.substr(modelsPrefix.size());
  const auto idEnd = rest.find('/');
  if (idEnd == std::string_view::npos)
  {
    return unknown;
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
  const auto digestEnd = below.find('/');
  if (digestEnd == std::string_view::npos)
  {
    return unknown;
  }
  auto blob = ParseBlobName(below.substr(digestEnd + 1));
  if (!blob)
  {
    return blob.GetError().code == ErrorCode::NotFound ? unknown : blob.GetError();
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
