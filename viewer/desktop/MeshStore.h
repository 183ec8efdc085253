// SPDX-License-Identifier: BSD-3-Clause
// Stores made from meshes for viewing: each is made once, and kept in the user's cache.
#pragma once

#include "filters/core/Result.h"
#include "filters/files/HeldFolder.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace kdstream
{

// Where the store of a mesh, in the mesh's current state, is kept or will be written.
struct MeshPlace
{
  std::shared_ptr<const HeldFolder> stores; // of all meshes
  std::shared_ptr<const HeldFolder> folder; // the store's folder, in `stores`
  std::string name;                         // of the store, in `folder`
  bool isThere = false;

  // The path for opening the file; valid as long as `folder` is held.
  std::filesystem::path File() const { return this->folder->Path() / this->name; }
  // The path of the store's folder, by its name in `stores`.
  std::filesystem::path InStores() const
  {
    return this->stores->Path() / this->folder->Name().filename();
  }
  // The path as messages show it.
  std::filesystem::path Called() const { return this->folder->Name() / this->name; }
};

// Returns the folder kdstream in XDG_CACHE_HOME, or in .cache of HOME. Errors: NotFound if neither
// is set.
Result<std::filesystem::path> UserCacheFolder();

// Whether the file is a store, judged by its first bytes; false if it cannot be read.
bool IsStore(const std::filesystem::path& file);

// Finds the place of this mesh's store in a cache. The cache is made if it does not exist; only
// this user and root may be able to write to it. Other users' files in it are not touched. Errors:
// NotFound if there is no such mesh; InputOutput if the cache, or something in it, cannot be used.
Result<MeshPlace> PlaceOfMesh(
  const std::filesystem::path& mesh, const std::filesystem::path& cache);

// Makes the store, by kdstream-build. report: called ten times a second with the progress ("levels
// 35 %, 42 s"), or with an empty text; if it returns false, the build stops, and nothing is left
// behind. warn: called with each warning of the build. Errors: Cancelled; those of the build,
// naming the file; NotFound if kdstream-build does not exist.
Status BuildStore(const std::filesystem::path& mesh, const MeshPlace& place,
  const std::function<bool(std::string_view progress)>& report,
  const std::function<void(std::string_view sentence)>& warn);

// Marks this store as used now. Removes the least recently used ones of the other stores until
// those have at most `mostBytes`.
void MakeRoomBeside(const MeshPlace& place, std::uint64_t mostBytes);

}
