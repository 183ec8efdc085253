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

// Told of a damaged blob, once for each; and when blobs begin not to be read, for a reason that may
// pass (the disk, memory). Called from any thread.
using DamageReport = std::function<void(const std::string& what)>;

// The stores that were read last, which stay open, so that thousands of models need only a few
// descriptors. Models share it. All functions may be called from any thread.
class OpenStores
{
public:
  explicit OpenStores(std::size_t most)
    : Most(most)
  {
  }

  // The store of `model`, if it is open; else null.
  std::shared_ptr<Store> Find(const StoreModel* model);
  // Keeps it open, and lets go of those that were read longest ago. Whoever reads one of them still
  // has it.
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
  // Whether `file` is still the very store that this model reads, unchanged.
  virtual bool IsFile(const std::filesystem::path& file) const = 0;

  // Its file, if it is open, stays open: another one has taken its name.
  virtual void StayOpen() const = 0;

  // Its file was written to and is not a store any more, nor is it being written: from now on
  // CheckUnchanged says Damaged, of which clients need not ask again.
  void MarkDamaged() const { this->Damaged = true; }
  bool IsDamaged() const { return this->Damaged; }

private:
  mutable std::atomic<bool> Damaged{ false };
};

// Opens the store `file` as the model `id`, whose blobs are kept in `cache`. Its tree is read when
// it is asked for: if it is damaged that is reported, and only regions are refused; where it cannot
// be read for another reason, it is tried again. stores: null keeps it open. A store that was let
// go is opened again by its path; where another file is there by then, reading says Changed.
// Errors: those of Store::Open; InvalidInput where its metadata cannot be told to a client;
// LimitExceeded for want of memory. Throws nothing.
Result<std::shared_ptr<const StoreModel>> OpenStoreModel(const std::filesystem::path& file,
  const std::string& id, std::shared_ptr<BlobCache> cache, DamageReport report,
  std::shared_ptr<OpenStores> stores = nullptr);

}
