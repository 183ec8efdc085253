// SPDX-License-Identifier: BSD-3-Clause
#include "server/session/StoreModel.h"

#include "filters/model/ModelJson.h"
#include "filters/store/Store.h"

#include <mutex>
#include <set>
#include <utility>

namespace kdstream
{

namespace
{

class StoreModel : public ServedModel
{
public:
  StoreModel(std::shared_ptr<Store> store, ModelDescription description, DamageReport report)
    : Source(std::move(store))
    , Told(std::move(description))
    , Report(std::move(report))
    , Tree(this->Source->ReadTree())
  {
    if (!this->Tree)
    {
      this->Report(this->Tree.GetError().message);
    }
  }

  const ModelDescription& Description() const override { return this->Told; }

  Result<std::span<const Box>> Boxes() const override
  {
    KDSTREAM_TRY(this->Tree);
    return std::span<const Box>(*this->Tree);
  }

  Result<BlobBytes> ReadBlob(const protocol::BlobId& blob) const override
  {
    auto bytes = this->Read(blob);
    if (bytes)
    {
      return std::make_shared<const std::vector<std::uint8_t>>(std::move(*bytes));
    }
    if (bytes.GetError().code != ErrorCode::NotFound)
    {
      const std::lock_guard lock(this->Mutex);
      if (this->Reported.insert(blob).second)
      {
        this->Report(bytes.GetError().message);
      }
    }
    return bytes.GetError();
  }

private:
  Result<std::vector<std::uint8_t>> Read(const protocol::BlobId& blob) const
  {
    switch (blob.kind)
    {
      case protocol::BlobKind::Tree:
        return this->Source->ReadTreePageBlob(blob.number);
      case protocol::BlobKind::Level:
        return this->Source->ReadPieceBlob({ Resolution::Level(blob.level), blob.number });
      case protocol::BlobKind::Partition:
        if (blob.number < this->Told.partitions)
        {
          return this->Source->ReadPieceBlob(
            { Resolution::Original(), NodeOfPartition(blob.number, this->Source->Info().depths) });
        }
    }
    return Error{ ErrorCode::NotFound, "the model has no " + protocol::BlobName(blob) };
  }

  std::shared_ptr<Store> Source;
  ModelDescription Told;
  DamageReport Report;
  Result<std::vector<Box>> Tree;
  mutable std::mutex Mutex;
  mutable std::set<protocol::BlobId> Reported;
};

}

Result<std::shared_ptr<const ServedModel>> OpenStoreModel(
  const std::filesystem::path& file, const std::string& id, DamageReport report)
{
  auto store = Store::Open(file);
  KDSTREAM_TRY(store);
  // A description that clients would reject is rejected here, where the operator sees it.
  ModelDescription told = (*store)->Info();
  told.id = id;
  auto description = ParseModel(WriteModel(told));
  KDSTREAM_TRY(description);
  return std::shared_ptr<const ServedModel>(
    std::make_shared<StoreModel>(std::move(*store), std::move(*description), std::move(report)));
}

}
