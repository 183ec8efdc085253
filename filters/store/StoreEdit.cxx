// SPDX-License-Identifier: BSD-3-Clause
// Steps: 1. Copy the store beside it.  2. Replace the copy's row of metadata.  3. Rename the copy
// to the store.
#include "filters/store/StoreEdit.h"

#include "filters/core/SystemReason.h"
#include "filters/files/NewFile.h"
#include "filters/store/OpenFile.h"
#include "filters/store/Sqlite.h"
#include "filters/store/StoreHead.h"
#include "filters/store/StoreSchema.h"

#include <fcntl.h>
#include <sys/sendfile.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>

namespace kdstream
{
namespace
{

// Copies at most `bytes` from the current positions of both files; returns how many, or -1.
ssize_t CopySome(int from, int to, std::size_t bytes)
{
  // Shares blocks between both files if the file system can do that; some file systems do not
  // support the call at all.
  const ssize_t shared = ::copy_file_range(from, nullptr, to, nullptr, bytes, 0);
  const bool cannot =
    shared < 0 && (errno == EXDEV || errno == EINVAL || errno == ENOSYS || errno == EOPNOTSUPP);
  return cannot ? ::sendfile(to, from, nullptr, bytes) : shared;
}

Status CopyFile(int from, int to, std::uint64_t size, const Execution& execution)
{
  constexpr std::uint64_t atOnce = std::uint64_t{ 64 } << 20;
  for (std::uint64_t done = 0; done < size;)
  {
    const ssize_t copied =
      CopySome(from, to, static_cast<std::size_t>(std::min(atOnce, size - done)));
    if (copied < 0 && errno == EINTR)
    {
      continue;
    }
    if (copied < 0 && IsDiskFull(errno))
    {
      return SystemError("the disk is too full: editing makes a copy of the store, which needs " +
                           std::to_string(size) + " bytes",
        errno);
    }
    if (copied <= 0)
    {
      return copied == 0
               ? Error{ ErrorCode::InputOutput, "the store became shorter while it was copied" }
               : SystemError("cannot be copied", errno);
    }
    done += static_cast<std::uint64_t>(copied);
    KDSTREAM_TRY(execution.Report("copy", double(done) / double(size)));
  }
  return {};
}

void Change(const std::optional<std::string>& to, std::string& text)
{
  text = to.value_or(text);
}

// Values that are not given stay. If there is a new up direction but no view, the first view is
// from the front.
void ChangeHomeView(const StoreTexts& texts, ModelDescription& info)
{
  if (!texts.up && !texts.view)
  {
    return;
  }
  const HomeView before = info.homeView.value_or(HomeView{});
  const Vec3 up = texts.up.value_or(before.up);
  const bool turned = up != before.up;
  info.homeView = { up, texts.view.value_or(turned ? FrontOf(up) : before.view), false };
}

// The copy is discarded unless everything succeeds, so it needs no journal.
Status ReplaceMetadata(int copy, const std::string& json)
{
  KDSTREAM_TRY(CheckStoreHead(copy)); // somebody may have written to the store meanwhile
  const Result<Database> database = OpenForWriting(copy);
  KDSTREAM_TRY(database);
  Result<Statement> update = Statement::Prepare(
    database->get(), "UPDATE metadata SET value = ?, checksum = ? WHERE key = 'model'");
  KDSTREAM_TRY(update);
  update->Bind(1, json);
  update->Bind(2, MetadataChecksum("model", json));
  KDSTREAM_TRY(update->Step());
  return {};
}

bool IsStill(const struct stat& opened, const std::filesystem::path& store)
{
  struct stat now = {};
  return ::stat(store.c_str(), &now) == 0 && now.st_dev == opened.st_dev &&
         now.st_ino == opened.st_ino;
}

}

Result<ModelDescription> EditStore(
  const std::filesystem::path& store, const StoreTexts& texts, const Execution& execution)
{
  const OpenFile source(store);
  struct stat opened = {};
  if (source.descriptor < 0 || ::fstat(source.descriptor, &opened) != 0)
  {
    const int reason = errno;
    return reason == ENOENT || reason == ENOTDIR ? Error{ ErrorCode::NotFound, "no such file" }
                                                 : SystemError("cannot be opened", reason);
  }
  ModelDescription info;
  {
    const Result<std::shared_ptr<Store>> old = Store::Open(store);
    KDSTREAM_TRY(old);
    info = (*old)->Info();
  }
  const Result<int> version = CheckStoreHead(source.descriptor);
  KDSTREAM_TRY(version);
  if (HasRowsOfBlobs(*version))
  {
    return Error{ ErrorCode::Unsupported,
      "store version " + std::to_string(*version) +
        " can be read, but not changed: build the store again" };
  }
  Change(texts.title, info.title);
  Change(texts.credit, info.credit);
  Change(texts.license, info.license);
  Change(texts.unit, info.unit);
  Change(texts.description, info.description);
  ChangeHomeView(texts, info);
  const std::string json = WriteStoredModel(info);
  KDSTREAM_TRY(CheckMetadataSize(json));
  NewFile::RemoveLeftovers(store);
  Result<NewFile> copy = NewFile::Create(store);
  KDSTREAM_TRY(copy);
  KDSTREAM_TRY(CopyFile(
    source.descriptor, copy->Descriptor(), static_cast<std::uint64_t>(opened.st_size), execution));
  KDSTREAM_TRY(ReplaceMetadata(copy->Descriptor(), json));
  if (!IsStill(opened, store))
  {
    return Error{ ErrorCode::InputOutput, "was replaced while it was copied: nothing was changed" };
  }
  KDSTREAM_TRY(copy->Finish());
  return info;
}

}
