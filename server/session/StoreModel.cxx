// SPDX-License-Identifier: BSD-3-Clause
#include "server/session/StoreModel.h"

#include "filters/core/CaughtError.h"
#include "filters/model/ModelJson.h"
#include "filters/store/Store.h"
#include "filters/store/StoreFile.h"

#include <atomic>
#include <iterator>
#include <mutex>
#include <set>
#include <utility>

namespace kdstream
{

namespace
{

// The result of `read`; an exception, mostly lack of memory, becomes an error.
template <class Read>
auto Caught(const Read& read) -> decltype(read())
{
  try
  {
    return read();
  }
  catch (...)
  {
    return CaughtError();
  }
}

// A model whose store may be closed while nobody reads it. Its metadata and digest are remembered,
// so that the store is recognized when it is opened again.
class ModelOfStore : public StoreModel
{
public:
  ModelOfStore(std::filesystem::path file, const std::shared_ptr<Store>& store,
    ModelDescription description, std::shared_ptr<BlobCache> cache, DamageReport report,
    std::shared_ptr<OpenStores> stores)
    : File(std::move(file))
    , Stores(std::move(stores))
    , Described(std::move(description))
    , Cache(std::move(cache))
    , Number(this->Cache->AddModel())
    , Report(std::move(report))
    , LastState(store->State())
  {
    this->Stores->Keep(this, store);
  }
  ~ModelOfStore() override
  {
    this->Stores->Remove(this);
    this->Cache->RemoveModel(this->Number);
  }

  const ModelDescription& Description() const override { return this->Described; }

  Status CheckUnchanged() const override
  {
    if (this->IsDamaged())
    {
      return Error{ ErrorCode::Damaged, "the file is no longer a complete store" };
    }
    return Caught([this] { return this->CheckFile(); });
  }
  std::optional<bool> LooksUnchanged() const override
  {
    if (this->IsDamaged())
    {
      return false;
    }
    const auto store = this->FindOpen();
    return store ? store->LooksUnchanged() : std::nullopt;
  }
  bool IsFile(const std::filesystem::path& file) const override
  {
    if (const auto store = this->FindOpen())
    {
      return store->IsFile(file);
    }
    return this->CheckUnchanged() && FileState::Of(file) == this->State();
  }
  void StayOpen() const override
  {
    auto store = this->FindOpen();
    {
      const std::lock_guard lock(this->StateMutex);
      this->Kept = std::move(store);
    }
    this->Stores->Remove(this);
  }

  Result<std::span<const Box>> Boxes() const override
  {
    const std::lock_guard lock(this->TreeMutex);
    if (!this->Tree && this->Tree.GetError().code != ErrorCode::Damaged)
    {
      this->Tree = Caught(
        [this]() -> Result<std::vector<Box>>
        {
          const auto store = this->Opened();
          KDSTREAM_TRY(store);
          return (*store)->ReadBoxes();
        });
      if (!this->Tree)
      {
        this->ReportOfTree(this->Tree.GetError());
      }
    }
    KDSTREAM_TRY(this->Tree);
    return std::span<const Box>(*this->Tree);
  }

  Result<BlobBytes> ReadBlob(const protocol::BlobId& blob) const override
  {
    return Caught(
      [this, &blob]() -> Result<BlobBytes>
      {
        bool isRead = false; // and therefore checked
        auto bytes = this->Cache->Get(this->Number, blob,
          [&]
          {
            isRead = true;
            return this->ReadFromStore(blob);
          });
        if (bytes && !isRead)
        {
          KDSTREAM_TRY(this->Opened()); // from now on FindBlob finds it without the disk
          KDSTREAM_TRY(this->CheckFile());
        }
        return bytes;
      });
  }

  BlobBytes FindBlob(const protocol::BlobId& blob) const override
  {
    auto bytes = this->Cache->Find(this->Number, blob);
    return bytes && this->LooksUnchanged() == true ? bytes : nullptr;
  }

  Result<std::uint64_t> BlobSize(const protocol::BlobId& blob) const override
  {
    return Caught(
      [this, &blob]() -> Result<std::uint64_t>
      {
        if (const auto bytes = this->Cache->Find(this->Number, blob))
        {
          KDSTREAM_TRY(this->CheckFile());
          return bytes->size();
        }
        auto size = this->SizeInStore(blob);
        if (size)
        {
          KDSTREAM_TRY(CheckSize(blob, *size));
        }
        return size;
      });
  }

private:
  // The store, if it is open; else null.
  std::shared_ptr<Store> FindOpen() const
  {
    auto kept = this->FindKept();
    return kept ? kept : this->Stores->Find(this);
  }
  std::shared_ptr<Store> FindKept() const
  {
    const std::lock_guard lock(this->StateMutex);
    return this->Kept;
  }

  // Whether the file is unchanged. Opens the store only if the file's state does not show this.
  Status CheckFile() const
  {
    if (!this->FindOpen() && FileState::Of(this->File) == this->State())
    {
      return {};
    }
    const auto store = this->Opened();
    KDSTREAM_TRY(store);
    return (*store)->CheckUnchanged();
  }

  // The store, which is opened again if it was released. Errors: Changed if another file is there
  // now.
  Result<std::shared_ptr<Store>> Opened() const
  {
    if (auto store = this->FindOpen())
    {
      if (!this->FindKept())
      {
        this->Stores->Keep(this, store);
      }
      return store;
    }
    const Error replaced{ ErrorCode::Changed, "the file was replaced while it was closed" };
    if (!FileState::Of(this->File).SameContent(this->State()))
    {
      return replaced;
    }
    auto store = Store::Open(this->File);
    KDSTREAM_TRY(store);
    if (!(*store)->State().SameContent(this->State()) ||
        (*store)->Info().digest != this->Described.digest)
    {
      return replaced;
    }
    {
      const std::lock_guard lock(this->StateMutex);
      this->LastState = (*store)->State();
    }
    this->Stores->Keep(this, *store);
    return store;
  }

  FileState State() const
  {
    const std::lock_guard lock(this->StateMutex);
    return this->LastState;
  }

  // Checks the size of a blob, because clients refuse blobs of other sizes.
  static Status CheckSize(const protocol::BlobId& blob, std::uint64_t bytes)
  {
    return bytes != 0 && bytes <= protocol::maximumBlobBytes
             ? Status{}
             : Error{ ErrorCode::Damaged, protocol::BlobName(blob) + ": " + std::to_string(bytes) +
                                            " bytes cannot be a blob" };
  }

  Result<std::uint64_t> SizeInStore(const protocol::BlobId& blob) const
  {
    const auto store = this->Opened();
    KDSTREAM_TRY(store);
    return (*store)->Size(blob);
  }

  void ReportOfBlob(const protocol::BlobId& blob, const Error& error) const
  {
    if (error.code == ErrorCode::Damaged)
    {
      const std::lock_guard lock(this->Mutex);
      if (this->Reported.insert(blob).second)
      {
        this->Report(error.message);
      }
    }
    this->ReportPassing(error);
  }

  void ReportOfTree(const Error& error) const
  {
    if (error.code == ErrorCode::Damaged)
    {
      this->Report(error.message);
    }
    this->ReportPassing(error);
  }

  // Reports a temporary error once, until something can be read again.
  void ReportPassing(const Error& error) const
  {
    const bool passes =
      error.code == ErrorCode::InputOutput || error.code == ErrorCode::LimitExceeded;
    if (passes && !this->Fails.exchange(true))
    {
      this->Report(error.message);
    }
  }

  Result<BlobBytes> ReadFromStore(const protocol::BlobId& blob) const
  {
    auto read = Caught(
      [&]() -> Result<BlobBytes>
      {
        const auto store = this->Opened();
        KDSTREAM_TRY(store);
        auto bytes = (*store)->Read(blob);
        KDSTREAM_TRY(bytes);
        KDSTREAM_TRY(CheckSize(blob, bytes->size()));
        return std::make_shared<const std::vector<std::uint8_t>>(std::move(*bytes));
      });
    if (read)
    {
      this->Fails = false;
    }
    else
    {
      this->ReportOfBlob(blob, read.GetError());
    }
    return read;
  }

  const std::filesystem::path File;
  const std::shared_ptr<OpenStores> Stores;
  ModelDescription Described;
  std::shared_ptr<BlobCache> Cache;
  BlobCache::Model Number;
  DamageReport Report;
  mutable std::mutex StateMutex;
  mutable FileState LastState;         // state of the file when it was last opened
  mutable std::shared_ptr<Store> Kept; // the store that another file has replaced; else null
  mutable std::mutex TreeMutex;
  // The result of the last reading; at first an error. Once the tree has been read, it is never
  // moved.
  mutable Result<std::vector<Box>> Tree = Error{ ErrorCode::InputOutput, "has not been read yet" };
  mutable std::mutex Mutex;
  mutable std::set<protocol::BlobId> Reported;
  mutable std::atomic<bool> Fails{ false }; // for a temporary reason
};

}

std::shared_ptr<Store> OpenStores::Find(const StoreModel* model)
{
  const std::lock_guard lock(this->Mutex);
  const auto place = this->Places.find(model);
  if (place == this->Places.end())
  {
    return nullptr;
  }
  return place->second->store;
}

void OpenStores::Keep(const StoreModel* model, std::shared_ptr<Store> store)
{
  std::list<Entry> added, gone; // closed after the mutex is released
  added.push_back({ model, std::move(store) });
  const std::lock_guard lock(this->Mutex);
  const auto [place, isNew] = this->Places.try_emplace(model, added.begin());
  if (!isNew) // another thread has opened it, too
  {
    gone.splice(gone.begin(), this->Recent, place->second);
    place->second = added.begin();
  }
  this->Recent.splice(this->Recent.begin(), added);
  while (this->Recent.size() > this->Most)
  {
    this->Places.erase(this->Recent.back().model);
    gone.splice(gone.begin(), this->Recent, std::prev(this->Recent.end()));
  }
}

void OpenStores::Remove(const StoreModel* model)
{
  std::list<Entry> gone;
  const std::lock_guard lock(this->Mutex);
  const auto place = this->Places.find(model);
  if (place != this->Places.end())
  {
    gone.splice(gone.begin(), this->Recent, place->second);
    this->Places.erase(place);
  }
}

Result<std::shared_ptr<const StoreModel>> OpenStoreModel(const std::filesystem::path& file,
  const std::string& id, std::shared_ptr<BlobCache> cache, DamageReport report,
  std::shared_ptr<OpenStores> stores)
{
  return Caught(
    [&]() -> Result<std::shared_ptr<const StoreModel>>
    {
      auto store = Store::Open(file);
      KDSTREAM_TRY(store);
      // A description that clients would reject is rejected here, where the operator sees it.
      ModelDescription reported = (*store)->Info();
      reported.id = id;
      KDSTREAM_TRY(CheckServed(reported));
      return std::shared_ptr<const StoreModel>(
        std::make_shared<const ModelOfStore>(file, *store, std::move(reported), std::move(cache),
          std::move(report), stores ? std::move(stores) : std::make_shared<OpenStores>(1)));
    });
}

}
