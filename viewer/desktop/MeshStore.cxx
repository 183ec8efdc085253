// SPDX-License-Identifier: BSD-3-Clause
// Stores of meshes for viewing: see MeshStore.h.
//
// A mesh's store is FOLDER/stores/KEY/NAME.kds. KEY is a hash of the mesh's path, size and
// modification time and of the program's version, so a mesh that has been written again gets
// another store. The modification time of the folder KEY is the time when the store was last used.
#include "viewer/desktop/MeshStore.h"

#include "filters/core/SeededHash.h"
#include "filters/core/SystemReason.h"
#include "filters/files/Folders.h"
#include "filters/model/ModelDescription.h"
#include "filters/program/ChildProgram.h"
#include "kdstream/Version.h"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace kdstream
{
namespace
{

namespace fs = std::filesystem;

const std::string buildProgram = "kdstream-build";

Result<std::string> KeyOf(const fs::path& mesh)
{
  std::error_code failure;
  const fs::path absolute = fs::canonical(mesh, failure);
  const auto bytes = failure ? 0 : fs::file_size(absolute, failure);
  const auto time = failure ? fs::file_time_type{} : fs::last_write_time(absolute, failure);
  if (failure)
  {
    return Error{ ErrorCode::NotFound, "cannot be read: " + failure.message(), mesh.string() };
  }
  const std::string facts = absolute.string() + '\n' + std::to_string(bytes) + '\n' +
                            std::to_string(time.time_since_epoch().count()) + '\n' +
                            KDSTREAM_VERSION;
  std::array<char, 17> key;
  std::snprintf(key.data(), key.size(), "%016llx",
    static_cast<unsigned long long>(HashOfBytes(std::as_bytes(std::span(facts)), agreedSeed)));
  return std::string(key.data());
}

std::uint64_t BytesIn(const fs::path& folder)
{
  std::uint64_t sum = 0;
  const auto names = NamesIn(folder);
  for (const std::string& name : names ? *names : std::vector<std::string>())
  {
    std::error_code failed;
    const fs::directory_entry entry(folder / name, failed);
    if (failed || entry.is_symlink(failed))
    {
      continue;
    }
    const auto bytes = entry.is_directory(failed) ? BytesIn(entry.path()) : entry.file_size(failed);
    sum += failed ? 0 : bytes;
  }
  return sum;
}

// Deletes the least recently used stores until the others have at most mostBytes. `kept` is neither
// deleted nor counted.
void MakeRoom(const fs::path& stores, const fs::path& kept, std::uint64_t mostBytes)
{
  std::multimap<fs::file_time_type, fs::path> byUse;
  std::error_code ignored;
  const auto names = NamesIn(stores);
  for (const std::string& name : names ? *names : std::vector<std::string>())
  {
    const fs::path store = stores / name;
    if (store != kept)
    {
      byUse.emplace(fs::last_write_time(store, ignored), store);
    }
  }
  std::uint64_t sum = 0;
  for (auto newest = byUse.rbegin(); newest != byUse.rend(); ++newest)
  {
    sum += BytesIn(newest->second);
    if (sum > mostBytes)
    {
      fs::remove_all(newest->second, ignored);
    }
  }
}

// The build's messages: progress, warnings, and the error.
class BuildMessages
{
public:
  BuildMessages(const MeshPlace& place, const std::function<void(std::string_view)>& warn)
    : Place(place)
    , Warn(warn)
  {
  }

  void Add(const std::string& text)
  {
    for (const char c : text)
    {
      if (c == '\n')
      {
        this->Understand(std::exchange(this->Line, {}));
      }
      else
      {
        this->Line += c;
      }
    }
  }

  std::string progress, error;

private:
  void Understand(std::string line)
  {
    const std::string folder = this->Place.folder->Path().string();
    for (auto at = line.find(folder + '/'); at != std::string::npos; at = line.find(folder + '/'))
    {
      line.replace(at, folder.size(), this->Place.folder->Name().string());
    }
    static const std::string mark = buildProgram + ": ";
    if (line.rfind(mark, 0) == 0)
    {
      line.erase(0, mark.size());
    }
    if (line.rfind("error: ", 0) == 0)
    {
      this->error = line.substr(7);
    }
    else if (line.rfind("warning: ", 0) == 0)
    {
      this->Warn(line.substr(9));
    }
    else
    {
      this->progress = line;
    }
  }

  const MeshPlace& Place;
  const std::function<void(std::string_view)>& Warn;
  std::string Line;
};

Status Build(const fs::path& mesh, const MeshPlace& place,
  const std::function<bool(std::string_view)>& report,
  const std::function<void(std::string_view)>& warn)
{
  const fs::path program = ChildProgram::Beside(buildProgram);
  if (::access(program.c_str(), X_OK) != 0)
  {
    return Error{ ErrorCode::NotFound,
      buildProgram + " must make a store of it, but is not at " + program.string(), mesh.string() };
  }
  auto child =
    ChildProgram::Start(program, { "--output=" + place.File().string(),
                                   "--title=" + mesh.stem().string(), "--", mesh.string() });
  KDSTREAM_TRY(child);
  BuildMessages messages(place, warn);
  std::string text;
  for (bool more = true; more;)
  {
    if (!report(messages.progress))
    {
      return Error{ ErrorCode::Cancelled, "interrupted" };
    }
    more = child->Read(text);
    messages.Add(std::exchange(text, {}));
  }
  messages.Add("\n");
  const int ended = child->Wait();
  if (!report(""))
  {
    return Error{ ErrorCode::Cancelled, "interrupted" };
  }
  if (WIFEXITED(ended) && WEXITSTATUS(ended) == 0)
  {
    return {};
  }
  return Error{ ErrorCode::InvalidInput,
    messages.error.empty() ? mesh.string() + ": " + buildProgram + " failed" : messages.error };
}

}

Result<fs::path> UserCacheFolder()
{
  for (const auto& [name, below] : { std::pair{ "XDG_CACHE_HOME", "" }, { "HOME", ".cache" } })
  {
    const char* folder = std::getenv(name);
    if (folder && *folder == '/')
    {
      return fs::path(folder) / below / "kdstream";
    }
  }
  return Error{ ErrorCode::NotFound,
    "there is no cache folder: neither XDG_CACHE_HOME nor HOME is set; use --cache" };
}

bool IsStore(const fs::path& file)
{
  static constexpr std::string_view beginning = "SQLite format 3";
  std::array<char, beginning.size()> bytes{};
  std::ifstream(file, std::ios::binary).read(bytes.data(), bytes.size());
  return std::string_view(bytes.data(), bytes.size()) == beginning;
}

Result<MeshPlace> PlaceOfMesh(const fs::path& mesh, const fs::path& cache)
{
  const auto key = KeyOf(mesh);
  KDSTREAM_TRY(key);
  KDSTREAM_TRY(MakePrivateFolder(cache));
  if (::access(cache.c_str(), W_OK) != 0)
  {
    return SystemError("cannot be written", errno, cache.string());
  }
  const auto named = HeldFolder::Open(cache);
  KDSTREAM_TRY(named);
  auto stores = named->OwnBelow("stores");
  KDSTREAM_TRY(stores);
  auto folder = stores->OwnBelow(*key);
  KDSTREAM_TRY(folder);
  std::string name = ModelIdLike(mesh.stem().string()) + ".kds";
  const auto isThere = folder->HasOwnFile(name);
  KDSTREAM_TRY(isThere);
  return MeshPlace{ std::make_shared<const HeldFolder>(std::move(*stores)),
    std::make_shared<const HeldFolder>(std::move(*folder)), std::move(name), *isThere };
}

Status BuildStore(const fs::path& mesh, const MeshPlace& place,
  const std::function<bool(std::string_view)>& report,
  const std::function<void(std::string_view)>& warn)
{
  const Status built = Build(mesh, place, report, warn);
  if (!built)
  {
    RemoveTree(place.InStores());
  }
  return built;
}

void MakeRoomBeside(const MeshPlace& place, std::uint64_t mostBytes)
{
  std::error_code ignored;
  fs::last_write_time(place.folder->Path(), fs::file_time_type::clock::now(), ignored);
  MakeRoom(place.stores->Path(), place.InStores(), mostBytes);
}

}
