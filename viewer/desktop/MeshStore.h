// SPDX-License-Identifier: BSD-3-Clause
// Stores of meshes that somebody looks at: made once, and kept in the user's cache.
#pragma once

#include "filters/core/Result.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string_view>

namespace kdstream
{

struct MeshStores
{
  std::filesystem::path folder;
  // What is kept there at most, bytes, beside the store that is asked for; those that were asked
  // for longest ago go first.
  std::uint64_t mostBytes = 0;
};

// kdstream in XDG_CACHE_HOME, or in .cache of HOME. Errors: NotFound where neither is set.
Result<std::filesystem::path> UserCacheFolder();

// Whether the file is a store, by how it begins; false where it cannot be read.
bool IsStore(const std::filesystem::path& file);

// The store of this mesh as it is now, which kdstream-build makes where there is none yet.
// report: called ten times a second with how far that is ("levels 35 %, 42 s"), or with an empty
// text; false stops it, and nothing is left behind. warn: called with each sentence that the build
// warns of. Errors: Cancelled; those of the build, naming the file; NotFound where the program or
// the mesh is not there; InputOutput for the cache.
Result<std::filesystem::path> StoreOfMesh(const std::filesystem::path& mesh,
  const MeshStores& stores, const std::function<bool(std::string_view progress)>& report,
  const std::function<void(std::string_view sentence)>& warn);

}
