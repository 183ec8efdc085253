// SPDX-License-Identifier: BSD-3-Clause
// One store as a served model.
#pragma once

#include "server/session/BlobCache.h"
#include "server/session/Catalog.h"

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

namespace kdstream
{

// Told of a damaged blob, once for each; and when blobs begin not to be read, for a reason that may
// pass (the disk, memory). Called from any thread.
using DamageReport = std::function<void(const std::string& what)>;

class StoreModel : public ServedModel
{
public:
  // Whether `file` is still the very store that this model reads, unchanged.
  virtual bool IsFile(const std::filesystem::path& file) const = 0;

  // Its file was written to and is no store any more, nor is it being written: from now on
  // CheckUnchanged says Damaged, of which clients need not ask again.
  void MarkDamaged() const { this->Damaged = true; }
  bool IsDamaged() const { return this->Damaged; }

private:
  mutable std::atomic<bool> Damaged{ false };
};

// Opens the store `file` as the model `id`, whose blobs are kept in `cache`. If its tree is damaged
// that is reported, and only regions are refused; where it cannot be read for another reason, it is
// tried again when it is asked for. Errors: those of Store::Open; InvalidInput where its metadata
// cannot be told to a client; LimitExceeded for want of memory. Throws nothing.
Result<std::shared_ptr<const StoreModel>> OpenStoreModel(const std::filesystem::path& file,
  const std::string& id, std::shared_ptr<BlobCache> cache, DamageReport report);

}
