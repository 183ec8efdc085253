// SPDX-License-Identifier: BSD-3-Clause
// The stores of a folder as a catalog: every NAME.kds is the model NAME, and NAME.notes.json, if it
// exists, has the notes on that model.
#pragma once

#include "server/session/BlobCache.h"
#include "server/session/Catalog.h"

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace kdstream
{

class NotesFiles;
class OpenStores;
class StoreModel;

class StoreCatalog : public Catalog
{
public:
  // Called with errors of files: a store that is left out, invalid notes (once for each change), a
  // damaged blob (once for each blob), a disk that cannot read (once, until it can again), a folder
  // that Look cannot read. Called from any thread, but not from two at the same time.
  using Report = std::function<void(const std::filesystem::path& file, const std::string& what)>;

  static constexpr std::chrono::seconds defaultGrace{ 3600 };
  static constexpr std::size_t defaultOpenStores = 64;
  static constexpr std::chrono::seconds patienceWithDisk{ 5 };

  // A replaced model is still found by its digest for the time `grace`, so that two servers behind
  // a proxy can change to a new build at different times. All models share a BlobCache of
  // `cacheBytes`. openStores: how many stores stay open at a time.
  StoreCatalog(std::filesystem::path folder, Report report,
    std::chrono::seconds grace = defaultGrace, std::size_t cacheBytes = BlobCache::defaultBytes,
    std::size_t openStores = defaultOpenStores);
  ~StoreCatalog() override;

  // Reads the folder (without its subfolders). Call this at the start, and whenever the folder may
  // have changed. Models whose stores have not changed stay; only the stores read last are kept
  // open (OpenStores).
  // - Stores that cannot be opened, and names that are not model ids, are reported. If the name had
  //   a model before, that model stays.
  // - A model whose file was removed is not found any more. A model whose file was overwritten in
  //   place, and is not a store any more, is found but not listed; it reports that it is damaged.
  //   Pointers to earlier models stay valid.
  // - A store that takes longer than patienceWithDisk is left to a thread of its own, and is listed
  //   when that thread is done: a disk that hangs on one store does not hide the others.
  //
  // Errors: NotFound or InputOutput if the folder cannot be read, LimitExceeded if memory runs out;
  // the models stay as they were, and Refresh tries again. Memory: the descriptions, and 48 bytes
  // for each node of each tree of which regions were requested.
  Status Reload();

  // Does what Reload does, when stores may have been added or removed; but nothing is reported
  // again.
  void Look();

  // Call this now and then. It removes replaced models after `grace`. It does what Reload does if a
  // store was overwritten, if its name leads to another file, if its notes have changed, or if a
  // store or the folder could not be opened. Nothing is reported twice. Throws only for lack of
  // memory.
  void Refresh();

  std::vector<std::shared_ptr<const ServedModel>> Models() const override;
  BlobBytes ListJson() const override; // written once for each reading of the folder
  std::shared_ptr<const ServedModel> Find(std::string_view id) const override;
  std::shared_ptr<const ServedModel> FindDigest(
    std::string_view id, std::string_view digest) const override;
  Result<BlobBytes> ReadNotes(const std::string& id) const override;
  std::size_t CountNotes(std::string_view id) const override;
  CacheUse Memory() const override { return this->Cache->Use(); }

private:
  class Reporter;
  using Clock = std::chrono::steady_clock;
  struct Replaced
  {
    std::shared_ptr<const StoreModel> model;
    Clock::time_point until;
  };
  // The models that are served at one time.
  struct State
  {
    std::map<std::string, std::shared_ptr<const StoreModel>, std::less<>> byId;
    std::vector<Replaced> replaced; // the oldest first
    bool passing = false;           // something failed that may soon succeed
    std::uint64_t notes = 0;        // the version of the notes whose numbers are in the list
    BlobBytes list;
  };
  // The result of opening a file, and whether opening has ended.
  struct Opening;
  struct Held
  {
    std::shared_ptr<const std::atomic<bool>> ended;
    std::shared_ptr<const Opening> opening; // null: the file was only examined
  };
  std::shared_ptr<const State> Current() const;
  std::filesystem::path FileOf(const std::string& id) const;
  void Publish(State state);
  enum class Patience
  {
    None,
    // A recently written file that is not a store is not reported yet, because it may become one.
    WithNew
  };
  Status Try(Patience patience);
  Status ReadFolder(Patience patience);
  struct Files;
  void OpenAll(Files& files, Patience patience);
  void Add(State& state, const std::filesystem::path& file, const std::string& id,
    const std::shared_ptr<const StoreModel>& old, const Opening* found) const;
  bool HasChanged(const State& present);
  bool IsHeld(const std::filesystem::path& file) const;
  void KeepReplaced(State& state, const State& before) const;

  std::filesystem::path Folder;
  std::chrono::seconds Grace;
  std::shared_ptr<Reporter> Reports;
  std::shared_ptr<BlobCache> Cache;
  std::shared_ptr<OpenStores> Stores;
  std::shared_ptr<NotesFiles> Notes;
  std::mutex ReloadMutex;                           // one reload at a time; also for HeldByDisk
  std::map<std::filesystem::path, Held> HeldByDisk; // files whose disk did not respond in time
  std::atomic<bool> Again{ false };                 // the folder is to be read again soon
  mutable std::mutex Mutex;
  std::shared_ptr<const State> Present;
};

}
