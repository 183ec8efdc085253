// SPDX-License-Identifier: BSD-3-Clause
// Stores of meshes that somebody looks at: made once, and kept in the user's cache.
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

// Where the store of a mesh, as the mesh is now, is kept, or is to be.
struct MeshPlace
{
  std::shared_ptr<const HeldFolder> stores; // of all meshes
  std::shared_ptr<const HeldFolder> folder; // of this one, in `stores`
  std::string name;                         // of the store, in `folder`
  bool isThere = false;

  // As it is opened, as long as `folder` is held.
  std::filesystem::path File() const { return this->folder->Path() / this->name; }
  // The folder, by its name in `stores`.
  std::filesystem::path InStores() const
  {
    return this->stores->Path() / this->folder->Name().filename();
  }
  // As it is called in messages.
  std::filesystem::path Called() const { return this->folder->Name() / this->name; }
};

// kdstream in XDG_CACHE_HOME, or in .cache of HOME. Errors: NotFound where neither is set.
Result<std::filesystem::path> UserCacheFolder();

// Whether the file is a store, by how it begins; false where it cannot be read.
bool IsStore(const std::filesystem::path& file);

// The place of this mesh's store in a cache, which is made; one that only this user, and root, may
// write to. What others have put there is left alone. Errors: NotFound where the mesh is not there;
// InputOutput where the cache, or something in it, cannot be used.
Result<MeshPlace> PlaceOfMesh(
  const std::filesystem::path& mesh, const std::filesystem::path& cache);

// Makes the store, by kdstream-build.
// report: called ten times a second with how far that is ("levels 35 %, 42 s"), or with an empty
// text; false stops it, and nothing is left behind. warn: called with each sentence that the build
// warns of. Errors: Cancelled; those of the build, naming the file; NotFound where the program is
// not there.
Status BuildStore(const std::filesystem::path& mesh, const MeshPlace& place,
  const std::function<bool(std::string_view progress)>& report,
  const std::function<void(std::string_view sentence)>& warn);

// This one is used now. Of the others, those that were used longest ago go, until they have
// `mostBytes` at most.
void MakeRoomBeside(const MeshPlace& place, std::uint64_t mostBytes);

}
