// SPDX-License-Identifier: BSD-3-Clause
// Opens what the command line names as a source of models: see OpenSource.h.
#include "viewer/desktop/OpenSource.h"

#include "viewer/client/ConnectServer.h"
#include "viewer/client/LocalClient.h"
#include "viewer/client/ServerUrl.h"
#include "viewer/desktop/MeshStore.h"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>

namespace kdstream
{
namespace
{

template <class Client>
Result<std::unique_ptr<ModelSource>> AsSource(Result<std::unique_ptr<Client>> client)
{
  KDSTREAM_TRY(client);
  return std::unique_ptr<ModelSource>(std::move(*client));
}

// The folder for fetched blobs and built stores: the one that the options name, or the user's.
Result<std::filesystem::path> CacheFolder(const ViewOptions& options)
{
  return options.cache.empty()
           ? UserCacheFolder()
           : Result<std::filesystem::path>(std::filesystem::path(options.cache));
}

// Returns null, after a warning, if there is no folder or it cannot be used. Then everything is
// requested from the server each time.
std::shared_ptr<DiskCache> OpenCache(
  const ViewOptions& options, const std::function<void(std::string_view sentence)>& warn)
{
  const auto folder = CacheFolder(options);
  const auto onTrouble = [warn](const Error& why)
  {
    warn("the cache: " + (why.file.empty() ? "" : why.file + " ") + why.message +
         "; data received from now on is not cached");
  };
  auto cache = folder ? DiskCache::Open(*folder, options.cacheBytes, onTrouble)
                      : Result<std::shared_ptr<DiskCache>>(folder.GetError());
  if (!cache)
  {
    const Error& error = cache.GetError();
    warn((error.file.empty() ? "" : error.file + ": ") + error.message +
         "; data from the server is not cached");
    return nullptr;
  }
  return *cache;
}

// Views without a window often measure a server. They use a cache only if the options name one.
bool UsesCache(const ViewOptions& options)
{
  return options.OpensWindow() || !options.cache.empty();
}

Result<std::unique_ptr<ModelSource>> OpenServer(
  const ViewOptions& options, const std::function<void(std::string_view sentence)>& warn)
{
  const auto url = ParseServerUrl(options.source);
  KDSTREAM_TRY(url);
  if (!options.authorities.empty() && !url->isSecure)
  {
    return Error{ ErrorCode::InvalidArgument,
      "--ca needs an https server: others have no certificate" };
  }
  auto connected = ConnectServer(options.source, options.token, options.authorities,
    UsesCache(options) ? OpenCache(options, warn) : nullptr);
  KDSTREAM_TRY(connected);
  if (connected->unreached)
  {
    warn(options.source + ": " + connected->unreached->message + "; only cached data is shown");
  }
  return std::move(connected->source);
}

// A temporary folder, which is removed after one view.
class BriefFolder
{
public:
  BriefFolder()
  {
    std::error_code failure;
    std::string name = (std::filesystem::temp_directory_path(failure) / "kdstream-XXXXXX").string();
    this->Path = ::mkdtemp(name.data()) ? name : "";
  }
  ~BriefFolder()
  {
    std::error_code ignored;
    std::filesystem::remove_all(this->Path, ignored);
  }
  BriefFolder(const BriefFolder&) = delete;
  BriefFolder& operator=(const BriefFolder&) = delete;

  std::filesystem::path Path; // empty: no folder could be made
};

// If the cached store cannot be used, a warning is given, and the store is built again. If the
// cache itself cannot be used, the store is built in a temporary folder, only for this view.
Result<std::unique_ptr<ModelSource>> OpenMesh(const std::filesystem::path& mesh,
  const ViewOptions& options, const std::function<bool(std::string_view progress)>& report,
  const std::function<void(std::string_view sentence)>& warn)
{
  const auto warnOf = [&](const Error& error, const char* consequence)
  { warn((error.file.empty() ? "" : error.file + ": ") + error.message + consequence); };
  const auto open = [&](const MeshPlace& place)
  { return At(place.Called().string(), AsSource(LocalClient::Open(place.File(), place.folder))); };
  const auto buildAndOpen = [&](const MeshPlace& place) -> Result<std::unique_ptr<ModelSource>>
  {
    KDSTREAM_TRY(BuildStore(mesh, place, report, warn));
    MakeRoomBeside(place, options.cacheBytes);
    return open(place);
  };
  const auto cache = CacheFolder(options);
  const auto place = cache ? PlaceOfMesh(mesh, *cache) : Result<MeshPlace>(cache.GetError());
  if (place && place->isThere)
  {
    auto kept = open(*place);
    if (kept)
    {
      MakeRoomBeside(*place, options.cacheBytes);
      return kept;
    }
    warnOf(OfFile(place->Called().string(), std::move(kept)).GetError(),
      "; the store is made from the mesh again");
  }
  if (place)
  {
    return buildAndOpen(*place);
  }
  const BriefFolder brief;
  const auto briefPlace =
    brief.Path.empty() ? Result<MeshPlace>(place.GetError()) : PlaceOfMesh(mesh, brief.Path);
  KDSTREAM_TRY(briefPlace);
  warnOf(place.GetError(), "; the store made from the mesh is not cached");
  return buildAndOpen(*briefPlace); // the open file outlives its name
}

}

bool NamesServer(const std::string& source)
{
  std::error_code failure;
  return source.find("://") != std::string::npos && !std::filesystem::exists(source, failure);
}

Result<std::unique_ptr<ModelSource>> OpenSource(const ViewOptions& options,
  const std::function<bool(std::string_view progress)>& report,
  const std::function<void(std::string_view sentence)>& warn)
{
  if (NamesServer(options.source))
  {
    return At(options.source, OpenServer(options, warn));
  }
  const std::filesystem::path file = options.source;
  std::error_code failure;
  if (!std::filesystem::exists(file, failure))
  {
    return Error{ ErrorCode::NotFound,
      options.source + ": there is no such file, and a server's address must be http://HOST:PORT "
                       "or https://HOST:PORT" };
  }
  if (!std::filesystem::is_directory(file, failure) &&
      !std::filesystem::is_regular_file(file, failure)) // reading a pipe could block for ever
  {
    return Error{ ErrorCode::NotFound, options.source + ": is neither a file nor a folder" };
  }
  if (std::filesystem::is_directory(file, failure) || IsStore(file))
  {
    return At(options.source, AsSource(LocalClient::Open(file)));
  }
  return OpenMesh(file, options, report, warn);
}

}
