// SPDX-License-Identifier: BSD-3-Clause
// One store as a served model.
#pragma once

#include "server/session/BlobCache.h"
#include "server/session/Catalog.h"

#include <atomic>
#include <filesystem>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>

namespace kdstream
{

class Store;
class StoreModel;

// Called once for each damaged blob, and when blobs can no longer be read for a temporary reason
// (the disk, memory). From any thread.
using DamageReport = std::function<void(const std::string& what)>;

// Keeps open the stores that were read last, so thousands of models need only a few descriptors.
// All models share one object of this class. All functions may be called from any thread.
class OpenStores
{
public:
  explicit OpenStores(std::size_t most)
    : Most(most)
  {
  }

  // The store of `model`, if it is open; else null.
  std::shared_ptr<Store> Find(const StoreModel* model);
  // Keeps the store open, and releases the stores that were read longest ago. Code that is reading
  // one of those can still use it.
  void Keep(const StoreModel* model, std::shared_ptr<Store> store);
  void Remove(const StoreModel* model);

private:
  struct Entry
  {
    const StoreModel* model;
    std::shared_ptr<Store> store;
  };
  const std::size_t Most;
  std::mutex Mutex;
  std::list<Entry> Recent; // the latest first
  std::unordered_map<const StoreModel*, std::list<Entry>::iterator> Places;
};

class StoreModel : public ServedModel
{
public:
  // Whether `file` is still exactly the store that this model reads, unchanged.
  virtual bool IsFile(const std::filesystem::path& file) const = 0;

  // Another file has taken the name of this model's file: if this file is open, it stays open.
  virtual void StayOpen() const = 0;

  // Marks a file that was written to, and that is neither a store any more nor being written. From
  // now on CheckUnchanged returns Damaged, so that clients do not ask again.
  void MarkDamaged() const { this->Damaged = true; }
  bool IsDamaged() const { return this->Damaged; }

private:
  mutable std::atomic<bool> Damaged{ false };
};

// Opens the store `file` as the model `id`, whose blobs are kept in `cache`. The tree is read when
// it is needed. If it is damaged, that is reported, and only regions are refused; if it cannot be
// read for another reason, later requests try again. stores: null keeps the store open. A released
// store is opened again by its path; if another file is there by then, reads fail with Changed.
// Errors: those of Store::Open; InvalidInput if the store's metadata cannot be sent to clients;
// LimitExceeded for lack of memory. Does not throw.
Result<std::shared_ptr<const StoreModel>> OpenStoreModel(const std::filesystem::path& file,
  const std::string& id, std::shared_ptr<BlobCache> cache, DamageReport report,
  std::shared_ptr<OpenStores> stores = nullptr);

}
