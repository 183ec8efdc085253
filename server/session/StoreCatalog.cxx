// SPDX-License-Identifier: BSD-3-Clause
#include "server/session/StoreCatalog.h"

#include "filters/core/CaughtError.h"
#include "filters/core/SystemReason.h"
#include "filters/protocol/ResourcePath.h"
#include "server/session/NotesFiles.h"
#include "server/session/PatientLoop.h"
#include "server/session/StoreModel.h"

#include <dirent.h>

#include <algorithm>
#include <cerrno>
#include <deque>
#include <system_error>
#include <utility>

namespace kdstream
{

// Calls the report function from one thread at a time. Models hold a pointer to this object.
class StoreCatalog::Reporter
{
public:
  explicit Reporter(Report report)
    : Function(std::move(report))
  {
  }
  void Tell(const std::filesystem::path& file, const std::string& what)
  {
    const std::lock_guard lock(this->Mutex);
    this->Function(file, what);
  }
  // Reports the error, unless it was the last one reported for this file.
  void TellOnce(const std::filesystem::path& file, const std::string& what)
  {
    const std::lock_guard lock(this->Mutex);
    auto& last = this->Last[file];
    if (last != what)
    {
      last = what;
      this->Function(file, what);
    }
  }
  // The file has no error now: a later error is reported again.
  void Forget(const std::filesystem::path& file)
  {
    const std::lock_guard lock(this->Mutex);
    this->Last.erase(file);
  }
  // Forgets all reports.
  void Forget()
  {
    const std::lock_guard lock(this->Mutex);
    this->Last.clear();
  }

private:
  std::mutex Mutex;
  Report Function;
  std::map<std::filesystem::path, std::string> Last;
};

namespace
{

// Looking whether a file has changed takes no time, unless its disk hangs.
constexpr std::chrono::seconds patienceWithLook{ 1 };
// The most replaced versions of one model; each keeps a file and a tree open.
constexpr std::size_t mostReplaced = 4;

// The file may be an unfinished copy. If it was a store before, it is awaited for less time,
// because clients meanwhile ask again and again.
constexpr std::chrono::seconds patienceWithNew{ 10 }, patienceWithChanged{ 3 };

bool WasWrittenJustNow(const std::filesystem::path& file, std::chrono::seconds patience)
{
  std::error_code error;
  const auto age =
    std::filesystem::file_time_type::clock::now() - std::filesystem::last_write_time(file, error);
  // The absolute value is compared, in case the clock was set back.
  return !error && std::chrono::abs(age) < patience;
}

// Whether the file was removed since the folder was read. A link that leads nowhere does not count
// as removed.
bool IsGone(const std::filesystem::path& file)
{
  std::error_code error;
  return std::filesystem::symlink_status(file, error).type() ==
         std::filesystem::file_type::not_found;
}

template <class ModelMap>
std::vector<std::shared_ptr<const ServedModel>> ListOf(const ModelMap& byId)
{
  std::vector<std::shared_ptr<const ServedModel>> models;
  models.reserve(byId.size());
  for (const auto& entry : byId)
  {
    if (!entry.second->IsDamaged())
    {
      models.push_back(entry.second);
    }
  }
  return models;
}

// Notes that something has ended, even if by an exception.
struct AtEnd
{
  std::atomic<bool>& ended;
  ~AtEnd() { this->ended = true; }
};

Error UnreadableFolder(int number)
{
  switch (number)
  {
    case ENOENT:
      return { ErrorCode::NotFound, "there is no such folder" };
    case ENOTDIR:
      return { ErrorCode::InputOutput,
        "is a file, not a folder: give the folder that contains it" };
    default:
      return SystemError("cannot be read", number);
  }
}

// The stores of a folder, by name. Uses readdir, because the iterator of std::filesystem ends the
// program if it has no memory.
Result<std::vector<std::filesystem::path>> FindStores(const std::filesystem::path& folder)
{
  const std::unique_ptr<DIR, int (*)(DIR*)> opened(::opendir(folder.c_str()), &::closedir);
  if (!opened)
  {
    return UnreadableFolder(errno);
  }
  std::vector<std::filesystem::path> files;
  errno = 0;
  for (const dirent* entry = ::readdir(opened.get()); entry; entry = ::readdir(opened.get()))
  {
    std::filesystem::path file = folder / entry->d_name;
    if (file.extension() == ".kds")
    {
      files.push_back(std::move(file));
    }
    errno = 0;
  }
  if (errno != 0)
  {
    return UnreadableFolder(errno);
  }
  std::sort(files.begin(), files.end());
  return files;
}

// The end of the message about a file that cannot be opened: what clients get instead. old: the
// model that was served by this name before, or null; it is marked as damaged if its file cannot be
// a store any more.
std::string WhatIsServed(const StoreModel* old, const Error& error)
{
  if (!old)
  {
    return "; this store is left out, the others are served";
  }
  if (old->CheckUnchanged())
  {
    return "; the earlier store is still served";
  }
  if (IsTransient(error))
  {
    return "; clients are asked to try again until the store is complete";
  }
  old->MarkDamaged();
  return "; clients get the error that it is damaged until the store is complete";
}

}

StoreCatalog::StoreCatalog(std::filesystem::path folder, Report report, std::chrono::seconds grace,
  std::size_t cacheBytes, std::size_t openStores)
  : Folder(std::move(folder))
  , Grace(grace)
  , Reports(std::make_shared<Reporter>(std::move(report)))
  , Cache(std::make_shared<BlobCache>(cacheBytes))
  , Stores(std::make_shared<OpenStores>(openStores))
  , Notes(std::make_shared<NotesFiles>(this->Folder,
      [reports = this->Reports](const std::filesystem::path& file, const std::string& what)
      { reports->Tell(file, what); }))
{
  this->Publish({});
}

StoreCatalog::~StoreCatalog() = default;

Status StoreCatalog::Reload()
{
  this->Reports->Forget();
  return this->Try(Patience::None);
}

void StoreCatalog::Look()
{
  if (const auto status = this->Try(Patience::WithNew); !status)
  {
    this->Reports->TellOnce(
      this->Folder, status.GetError().message + "; the earlier models are still served");
  }
}

// If this does not finish, it must be done again, which Again says.
Status StoreCatalog::Try(Patience patience)
{
  const std::lock_guard reloading(this->ReloadMutex);
  this->Again = true;
  try
  {
    return this->ReadFolder(patience);
  }
  catch (...) // mostly lack of memory
  {
    return CaughtError();
  }
}

struct StoreCatalog::Opening
{
  std::atomic<bool> ended{ false };
  bool isSame = false; // the same as the earlier model
  Result<std::shared_ptr<const StoreModel>> model = Error{ ErrorCode::InputOutput, "" };
  bool isGone = false, isNew = false;
};

// The stores of the folder whose names are valid ids, with the result of opening each. Shared by
// the threads that open them.
struct StoreCatalog::Files
{
  struct File
  {
    std::filesystem::path path;
    std::string id;
    std::shared_ptr<const StoreModel> old; // the earlier model; may be null
    std::shared_ptr<Opening> opening = std::make_shared<Opening>();
  };
  std::vector<File> files;
  std::shared_ptr<BlobCache> cache;
  std::shared_ptr<Reporter> reports;
  std::shared_ptr<NotesFiles> notes;
  std::shared_ptr<OpenStores> stores;

  void Open(const File& file, Patience patience) const;
};

// Opens one file. May wait for a disk.
void StoreCatalog::Files::Open(const File& file, Patience patience) const
{
  auto& found = *file.opening;
  const AtEnd end{ found.ended };
  found.isSame = file.old && file.old->IsFile(file.path);
  if (!found.isSame)
  {
    found.model = OpenStoreModel(
      file.path, file.id, this->cache,
      [to = this->reports, path = file.path](const std::string& what) { to->Tell(path, what); },
      this->stores);
  }
  if (found.isSame || found.model)
  {
    this->reports->Forget(file.path);
  }
  else
  {
    const Error& error = found.model.GetError();
    found.isGone = error.code == ErrorCode::NotFound && IsGone(file.path);
    found.isNew = patience == Patience::WithNew &&
                  WasWrittenJustNow(file.path, file.old ? patienceWithChanged : patienceWithNew);
    if (!found.isGone && !found.isNew)
    {
      this->reports->TellOnce(file.path, error.message + WhatIsServed(file.old.get(), error));
    }
  }
  // When the whole folder is read, notes that could not be read before are tried again. This counts
  // the notes for the list.
  const bool isServed = found.isSame || found.model || (file.old && !found.isGone);
  if (isServed && (patience == Patience::None || this->notes->HasChanged(file.id)))
  {
    (void)this->notes->Read(file.id);
  }
}

// Opens stores that may have changed. Files that a disk blocks are tried again next time.
void StoreCatalog::OpenAll(Files& files, Patience patience)
{
  auto shared = std::make_shared<Files>(files);
  std::erase_if(
    shared->files, [this](const Files::File& file) { return this->HeldByDisk.count(file.path); });
  ForEachPatiently(
    shared->files.size(), patienceWithDisk,
    [shared, patience](std::size_t i) { shared->Open(shared->files[i], patience); },
    [this, &shared](std::size_t i)
    {
      const auto& file = shared->files[i];
      const std::shared_ptr<const std::atomic<bool>> ended(file.opening, &file.opening->ended);
      this->HeldByDisk[file.path] = { ended, file.opening };
    });
}

bool StoreCatalog::IsHeld(const std::filesystem::path& file) const
{
  const auto held = this->HeldByDisk.find(file);
  return held != this->HeldByDisk.end() && !*held->second.ended;
}

Status StoreCatalog::ReadFolder(Patience patience)
{
  const auto paths = FindStores(this->Folder);
  KDSTREAM_TRY(paths); // the disk may be absent, or no descriptor left
  const auto before = this->Current();
  this->Reports->Forget(this->Folder);
  // Files that were only examined are opened again. If opening a file has ended in the meantime,
  // its result is used.
  std::erase_if(this->HeldByDisk,
    [](const auto& entry) { return *entry.second.ended && !entry.second.opening; });
  Files files{ {}, this->Cache, this->Reports, this->Notes, this->Stores };
  for (const auto& path : *paths)
  {
    auto id = path.stem().string();
    if (!IsModelId(id))
    {
      this->Reports->TellOnce(path, "a model's name must have " + std::string(modelIdRule) +
                                      "; this store is left out, the others are served");
      continue;
    }
    const auto found = before->byId.find(id);
    auto old = found == before->byId.end() ? nullptr : found->second;
    files.files.push_back({ path, std::move(id), std::move(old) });
  }
  this->OpenAll(files, patience);
  State state;
  for (const auto& file : files.files)
  {
    const auto held = this->HeldByDisk.find(file.path);
    if (held == this->HeldByDisk.end())
    {
      this->Add(state, file.path, file.id, file.old, file.opening.get());
    }
    else if (*held->second.ended)
    {
      this->Add(state, file.path, file.id, file.old, held->second.opening.get());
      state.passing = true; // the file may have changed since
      this->HeldByDisk.erase(held);
    }
    else
    {
      this->Add(state, file.path, file.id, file.old, nullptr);
    }
  }
  // Files whose examination has just ended will be opened next time.
  std::erase_if(this->HeldByDisk, [](const auto& entry) { return entry.second.ended->load(); });
  this->KeepReplaced(state, *before);
  const bool passing = state.passing;
  this->Publish(std::move(state));
  this->Again = passing;
  return {};
}

void StoreCatalog::Publish(State state)
{
  state.notes = this->Notes->Version();
  state.list = WriteList(ListOf(state.byId));
  const std::lock_guard lock(this->Mutex);
  this->Present = std::make_shared<const State>(std::move(state));
}

// Adds the model of `file`. If the file is unchanged or cannot be opened, this is the old model.
// found: the result of opening the file; null while its disk does not respond.
void StoreCatalog::Add(State& state, const std::filesystem::path& file, const std::string& id,
  const std::shared_ptr<const StoreModel>& old, const Opening* found) const
{
  if (found && found->model)
  {
    state.byId.emplace(id, *found->model);
    return;
  }
  if (found && !found->isSame)
  {
    if (found->isGone)
    {
      return;
    }
    state.passing = state.passing || IsTransient(found->model.GetError()) || found->isNew;
  }
  else if (!found)
  {
    state.passing = true;
    this->Reports->TellOnce(file, std::string("its disk does not respond") +
                                    (old ? "; the earlier store is served as far as it is in memory"
                                         : "; this store is left out, the others are served"));
  }
  if (old)
  {
    state.byId.emplace(id, old);
  }
}

// Keeps the models that were replaced by another digest, now or earlier, until their `grace` has
// passed.
void StoreCatalog::KeepReplaced(State& state, const State& before) const
{
  const auto now = Clock::now();
  state.replaced = before.replaced;
  for (const auto& [id, old] : before.byId)
  {
    const auto present = state.byId.find(id);
    if (present != state.byId.end() &&
        present->second->Description().digest != old->Description().digest)
    {
      old->StayOpen();
      state.replaced.push_back({ old, now + this->Grace });
    }
  }
  std::map<std::string, std::size_t> kept;
  std::vector<Replaced> latestFirst;
  for (auto each = state.replaced.rbegin(); each != state.replaced.rend(); ++each)
  {
    const auto& id = each->model->Description().id;
    if (now < each->until && state.byId.count(id) != 0 && ++kept[id] <= mostReplaced)
    {
      latestFirst.push_back(*each);
    }
  }
  state.replaced.assign(latestFirst.rbegin(), latestFirst.rend());
}

void StoreCatalog::Refresh()
{
  const auto present = this->Current();
  const auto now = Clock::now();
  const bool outlived = std::any_of(present->replaced.begin(), present->replaced.end(),
    [now](const Replaced& replaced) { return replaced.until <= now; });
  const bool otherNotes = present->notes != this->Notes->Version(); // the notes were read meanwhile
  if (this->Again || this->HasChanged(*present) || outlived || otherNotes)
  {
    this->Look();
  }
}

// Also detects a link that now leads to another file, which no watch of the folder reports.
bool StoreCatalog::HasChanged(const State& present)
{
  struct Looking
  {
    struct File
    {
      std::filesystem::path path;
      std::shared_ptr<const StoreModel> model;
      std::atomic<bool> ended{ false };
    };
    std::deque<File> files;
    std::shared_ptr<const NotesFiles> notes;
    std::atomic<bool> changed{ false };
  };
  const std::lock_guard reloading(this->ReloadMutex);
  const auto looking = std::make_shared<Looking>();
  looking->notes = this->Notes;
  for (const auto& [id, model] : present.byId)
  {
    if (auto path = this->FileOf(id); !this->IsHeld(path))
    {
      auto& file = looking->files.emplace_back();
      file.path = std::move(path);
      file.model = model;
    }
  }
  ForEachPatiently(
    looking->files.size(), patienceWithLook,
    [looking](std::size_t i)
    {
      auto& file = looking->files[i];
      const AtEnd end{ file.ended };
      if (!file.model->IsFile(file.path) ||
          looking->notes->HasChanged(file.model->Description().id))
      {
        looking->changed = true;
      }
    },
    [this, &looking](std::size_t i)
    {
      const auto& file = looking->files[i];
      this->HeldByDisk[file.path] = {
        std::shared_ptr<const std::atomic<bool>>(looking, &file.ended), nullptr
      };
    });
  return looking->changed;
}

std::filesystem::path StoreCatalog::FileOf(const std::string& id) const
{
  return this->Folder / (id + ".kds");
}

std::shared_ptr<const StoreCatalog::State> StoreCatalog::Current() const
{
  const std::lock_guard lock(this->Mutex);
  return this->Present;
}

std::vector<std::shared_ptr<const ServedModel>> StoreCatalog::Models() const
{
  return ListOf(this->Current()->byId);
}

BlobBytes StoreCatalog::ListJson() const
{
  return this->Current()->list;
}

Result<BlobBytes> StoreCatalog::ReadNotes(const std::string& id) const
{
  return this->Notes->Read(id);
}

std::size_t StoreCatalog::CountNotes(std::string_view id) const
{
  return this->Notes->Count(id);
}

std::shared_ptr<const ServedModel> StoreCatalog::Find(std::string_view id) const
{
  const auto present = this->Current();
  const auto found = present->byId.find(id);
  return found == present->byId.end() ? nullptr : found->second;
}

std::shared_ptr<const ServedModel> StoreCatalog::FindDigest(
  std::string_view id, std::string_view digest) const
{
  const auto present = this->Current();
  const auto found = present->byId.find(id);
  if (found != present->byId.end() && found->second->Description().digest == digest)
  {
    return found->second;
  }
  const auto now = Clock::now();
  for (const auto& replaced : present->replaced)
  {
    const auto& description = replaced.model->Description();
    if (now < replaced.until && description.id == id && description.digest == digest)
    {
      return replaced.model;
    }
  }
  return nullptr;
}

}
