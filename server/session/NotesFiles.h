// SPDX-License-Identifier: BSD-3-Clause
// The notes beside the stores of a folder: NAME.notes.json beside NAME.kds. They may change while
// the stores do not. All functions may be called from any thread.
#pragma once

#include "filters/core/Result.h"
#include "server/session/Catalog.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <tuple>

namespace kdstream
{

class NotesFiles
{
public:
  // Called for an invalid file, once after each change of the file.
  using Report = std::function<void(const std::filesystem::path& file, const std::string& what)>;

  NotesFiles(std::filesystem::path folder, Report report);

  // The current content of the file, if ParseNotes accepts it. Waits for a disk; reads at most
  // maximumNotesBytes. Errors: NotFound if there is no file, or if its content is not accepted
  // (which is reported); InputOutput if the disk cannot read the file.
  Result<BlobBytes> Read(const std::string& id);

  // How many notes the model had when its file was last read. Never waits for a disk.
  std::size_t Count(std::string_view id) const;

  // Whether the file was replaced, changed or removed since it was last read. The file itself is
  // not read for this.
  bool HasChanged(const std::string& id) const;

  // A number that changes whenever a file is found to have changed or to be gone.
  std::uint64_t Version() const;

private:
  using Stamp = std::tuple<std::uint64_t, std::uint64_t, std::int64_t, std::int64_t>;
  struct Known
  {
    Stamp stamp;
    std::size_t count = 0;
    bool operator==(const Known&) const = default;
  };
  std::filesystem::path FileOf(std::string_view id) const;
  Stamp StampOf(const std::filesystem::path& file) const;
  bool Remember(const std::string& id, const Known& known);

  std::filesystem::path Folder;
  Report Tell;
  mutable std::mutex Mutex;
  std::map<std::string, Known, std::less<>> Files;
  std::uint64_t Changes = 0;
};

}
