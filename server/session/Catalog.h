// SPDX-License-Identifier: BSD-3-Clause
// What a server serves, as the conversation and the routes see it: models, each with its
// description, the boxes of its tree, and its blobs. Step "serve" of the pipeline picture.
//
// Implemented by StoreCatalog for stores, and in memory in tests. Everything here may be called
// from any thread.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/model/ModelDescription.h"
#include "filters/protocol/BlobId.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace kdstream
{

using BlobBytes = std::shared_ptr<const std::vector<std::uint8_t>>;
BlobBytes BytesOfText(std::string_view text);

// One model, which never changes. Whoever holds the pointer can continue to read the model, even
// when the catalog has a newer build.
class ServedModel
{
public:
  virtual ~ServedModel() = default;

  virtual const ModelDescription& Description() const = 0;
  // The description as JSON, for clients of this access level; written once for each level.
  BlobBytes Json(ModelDetail detail = ModelDetail::Regions) const;
  // The hash of Json(). All calls must pass the same function; the hash is computed once.
  using Hash = std::string (*)(const std::vector<std::uint8_t>& json);
  std::string JsonHash(Hash hash) const;

  // Checks that the model can still be read as it is described. Errors: Changed if its store was
  // written to; InputOutput if this could not be determined.
  virtual Status CheckUnchanged() const { return {}; }
  // Does the same without a disk, if that is possible; else returns nothing. Never waits.
  virtual std::optional<bool> LooksUnchanged() const { return bool(this->CheckUnchanged()); }

  // The boxes of nodes 1 … 2^(P+1) - 1 in heap order, [0] unused; valid as long as the model.
  // Errors: Damaged; Changed; InputOutput and LimitExceeded if a later call may succeed.
  virtual Result<std::span<const Box>> Boxes() const = 0;

  // Reads a blob. Errors: NotFound if the model has no such blob; else those of Boxes. Like Boxes,
  // it may wait for a disk: do not call it on a thread on which others depend.
  virtual Result<BlobBytes> ReadBlob(const protocol::BlobId& blob) const = 0;

  // The blob, if it is in memory and may still be sent; else null. Never waits.
  virtual BlobBytes FindBlob(const protocol::BlobId& /*blob*/) const { return nullptr; }

  // The size of the blob in bytes; the blob is not read. Errors: those of ReadBlob.
  virtual Result<std::uint64_t> BlobSize(const protocol::BlobId& blob) const
  {
    const Result<BlobBytes> bytes = this->ReadBlob(blob);
    KDSTREAM_TRY(bytes);
    return (*bytes)->size();
  }

private:
  mutable std::mutex JsonMutex;
  mutable std::array<BlobBytes, 3> Written; // by ModelDetail
  mutable std::string WrittenHash;          // empty at first
};

// Statistics of a cache of blobs.
struct CacheUse
{
  std::uint64_t hits = 0, misses = 0; // blobs that were found, and that had to be read
  std::uint64_t bytes = 0;            // kept now
};

class Catalog
{
public:
  virtual ~Catalog() = default;

  // All models, sorted by id.
  virtual std::vector<std::shared_ptr<const ServedModel>> Models() const = 0;

  // The list of all models as JSON, sorted by id.
  virtual BlobBytes ListJson() const { return WriteList(this->Models()); }

  // The model with this id, or null.
  virtual std::shared_ptr<const ServedModel> Find(std::string_view id) const = 0;

  // The model with exactly this digest, or null. It may be the present model, or one that has been
  // replaced.
  virtual std::shared_ptr<const ServedModel> FindDigest(
    std::string_view id, std::string_view digest) const
  {
    auto model = this->Find(id);
    return model && model->Description().digest == digest ? model : nullptr;
  }

  // The notes on a model, as in their file (filters/model/Notes.h). May wait for a disk. Errors:
  // NotFound if there are none; InputOutput if they cannot be read now.
  virtual Result<BlobBytes> ReadNotes(const std::string& /*id*/) const
  {
    return Error{ ErrorCode::NotFound, "there are no notes" };
  }
  // How many notes the model has, as far as is known without a disk.
  virtual std::size_t CountNotes(std::string_view /*id*/) const { return 0; }

  // The use of the cache that the models share.
  virtual CacheUse Memory() const { return {}; }

  // The list of these models as JSON, after the server's own description.
  BlobBytes WriteList(const std::vector<std::shared_ptr<const ServedModel>>& models) const;

  // Sets what lists say about the server; otherwise they say nothing. Call this before anybody asks
  // for a list.
  void SetSite(SiteDescription site) { this->Site = std::move(site); }
  const SiteDescription& AboutSite() const { return this->Site; }
  // Sets where each model has a page (WithPages). Call this, too, before anybody asks for a list.
  void SetPages(std::string folder) { this->Pages = std::move(folder); }

private:
  SiteDescription Site;
  std::string Pages;
};

}
