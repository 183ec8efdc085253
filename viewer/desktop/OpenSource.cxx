// SPDX-License-Identifier: BSD-3-Clause
// What the command line names, as a source of models.
#include "viewer/desktop/OpenSource.h"

#include "viewer/client/LocalClient.h"
#include "viewer/client/ServerClient.h"
#include "viewer/desktop/MeshStore.h"

#include <filesystem>
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
    return At(options.source, AsSource(ServerClient::Connect(options.source)));
  }
  const std::filesystem::path file = options.source;
  std::error_code failure;
  if (!std::filesystem::exists(file, failure))
  {
    return Error{ ErrorCode::NotFound,
      options.source + ": there is no such file, and the address of a server is http://HOST:PORT" };
  }
  if (std::filesystem::is_directory(file, failure) || IsStore(file))
  {
    return At(options.source, AsSource(LocalClient::Open(file)));
  }
  MeshStores stores{ options.cache, options.cacheBytes };
  if (options.cache.empty())
  {
    const auto folder = UserCacheFolder();
    KDSTREAM_TRY(folder);
    stores.folder = *folder;
  }
  const auto store = StoreOfMesh(file, stores, report, warn);
  KDSTREAM_TRY(store);
  return At(store->string(), AsSource(LocalClient::Open(*store)));
}

}
