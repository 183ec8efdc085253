// SPDX-License-Identifier: BSD-3-Clause
#include "server/session/StoreModel.h"

#include "filters/core/CaughtError.h"
#include "filters/model/ModelJson.h"
#include "filters/store/Store.h"

#include <atomic>
#include <mutex>
#include <set>
#include <utility>

namespace kdstream
{

static_assert(Store::largestBlobBytes == protocol::maximumBlobBytes);

namespace
{

// What `read` returns; an exception, for want of memory mostly, becomes an error.
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

class ModelOfStore : public StoreModel
{
public:
  ModelOfStore(std::shared_ptr<Store> store, ModelDescription description,
    std::shared_ptr<BlobCache> cache, DamageReport report)
    : Source(std::move(store))
    , Told(std::move(description))
    , Cache(std::move(cache))
    , Number(this->Cache->AddModel())
    , Report(std::move(report))
  {
  }
  ~ModelOfStore() override { this->Cache->RemoveModel(this->Number); }

  const ModelDescription& Description() const override { return this->Told; }

  Status CheckUnchanged() const override
  {
    if (this->IsDamaged())
    {
      return Error{ ErrorCode::Damaged, "the file is no whole store any more" };
    }
    return Caught([this] { return this->Source->CheckUnchanged(); });
  }
  std::optional<bool> LooksUnchanged() const override
  {
    return this->IsDamaged() ? false : this->Source->LooksUnchanged();
  }
  bool IsFile(const std::filesystem::path& file) const override
  {
    return this->Source->IsFile(file);
  }

  Result<std::span<const Box>> Boxes() const override
  {
    const std::lock_guard lock(this->TreeMutex);
    if (!this->Tree && this->Tree.GetError().code != ErrorCode::Damaged)
    {
      this->Tree = Caught([this] { return this->Source->ReadBoxes(); });
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
        bool isRead = false; // and so checked
        auto bytes = this->Cache->Get(this->Number, blob,
          [&]
          {
            isRead = true;
            return this->ReadFromStore(blob);
          });
        if (bytes && !isRead)
        {
          KDSTREAM_TRY(this->Source->CheckUnchanged());
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
          KDSTREAM_TRY(this->Source->CheckUnchanged());
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
  // No client takes another size.
  static Status CheckSize(const protocol::BlobId& blob, std::uint64_t bytes)
  {
    return bytes != 0 && bytes <= protocol::maximumBlobBytes
             ? Status{}
             : Error{ ErrorCode::Damaged,
                 protocol::BlobName(blob) + ": " + std::to_string(bytes) + " bytes are no blob" };
  }

  Result<std::uint64_t> SizeInStore(const protocol::BlobId& blob) const
  {
    switch (blob.kind)
    {
      case protocol::BlobKind::Tree:
        return this->Source->TreePageBlobSize(blob.number);
      case protocol::BlobKind::Boxes:
        return this->Source->BoxesBlobSize(blob.number);
      case protocol::BlobKind::Texture:
        return this->Source->TextureBlobSize(blob.number);
      default:
        return this->OfPiece(blob, [this](PieceId id) { return this->Source->PieceBlobSize(id); });
    }
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

  // What may pass is told once until something can be read again.
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
        auto bytes =
          blob.kind == protocol::BlobKind::Tree    ? this->Source->ReadTreePageBlob(blob.number)
          : blob.kind == protocol::BlobKind::Boxes ? this->Source->ReadBoxesBlob(blob.number)
          : blob.kind == protocol::BlobKind::Texture
            ? this->Source->ReadTextureBlob(blob.number)
            : this->OfPiece(blob, [this](PieceId id) { return this->Source->ReadPieceBlob(id); });
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

  // What `read` says of the piece that the blob is.
  template <class Read>
  auto OfPiece(const protocol::BlobId& blob, const Read& read) const -> decltype(read(PieceId{}))
  {
    if (blob.kind == protocol::BlobKind::Level)
    {
      return read({ Resolution::Level(blob.level), blob.number });
    }
    if (blob.number < this->Told.partitions)
    {
      return read({ Resolution::Original(), NodeOfPartition(blob.number, this->Told.depths) });
    }
    return Error{ ErrorCode::NotFound, "the model has no " + protocol::BlobName(blob) };
  }

  std::shared_ptr<Store> Source;
  ModelDescription Told;
  std::shared_ptr<BlobCache> Cache;
  BlobCache::Model Number;
  DamageReport Report;
  mutable std::mutex TreeMutex;
  // As it was read last; not yet at first. Once it has been read it stays in its place.
  mutable Result<std::vector<Box>> Tree = Error{ ErrorCode::InputOutput, "not yet read" };
  mutable std::mutex Mutex;
  mutable std::set<protocol::BlobId> Reported;
  mutable std::atomic<bool> Fails{ false }; // for a reason that may pass
};

}

Result<std::shared_ptr<const StoreModel>> OpenStoreModel(const std::filesystem::path& file,
  const std::string& id, std::shared_ptr<BlobCache> cache, DamageReport report)
{
  return Caught(
    [&]() -> Result<std::shared_ptr<const StoreModel>>
    {
      auto store = Store::Open(file);
      KDSTREAM_TRY(store);
      // A description that clients would reject is rejected here, where the operator sees it.
      ModelDescription told = (*store)->Info();
      told.id = id;
      auto description = ParseModel(WriteModel(told));
      KDSTREAM_TRY(description);
      // For quotas; clients are not told.
      description->inputDigest = (*store)->Info().inputDigest;
      description->partitioner = (*store)->Info().partitioner;
      auto model = std::make_shared<ModelOfStore>(
        std::move(*store), std::move(*description), std::move(cache), std::move(report));
      (void)model->Boxes();
      return std::shared_ptr<const StoreModel>(std::move(model));
    });
}

}
