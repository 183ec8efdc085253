// SPDX-License-Identifier: BSD-3-Clause
#include "server/session/Permission.h"

#include <string>
#include <utility>
#include <variant>

namespace kdstream
{

namespace
{

using protocol::BlobId;
using protocol::BlobKind;

// The least detail that the token must allow for a blob.
ModelDetail DetailOf(const ModelDescription& model, const BlobId& blob)
{
  const unsigned preview = PreviewLevel(model);
  switch (blob.kind)
  {
    case BlobKind::Level:
    case BlobKind::LevelTexture:
      return blob.level <= preview ? ModelDetail::Preview : ModelDetail::Levels;
    case BlobKind::Tree: // even the first page describes pieces of finer levels
      return ModelDetail::Levels;
    case BlobKind::Partition:
    case BlobKind::Texture:
    case BlobKind::Boxes:
      break;
  }
  return ModelDetail::Regions;
}

}

Permission::Permission(std::shared_ptr<const TokenGuard> guard, std::shared_ptr<const Pass> pass,
  std::shared_ptr<const PartitionLedger> ledger, std::string client)
  : Guard(std::move(guard))
  , Held(std::move(pass))
  , Ledger(std::move(ledger))
  , Client(std::move(client))
{
}

ModelDetail Permission::Detail() const
{
  return this->Guard ? this->Held->claims.detail : ModelDetail::Regions;
}

bool Permission::AllowsAllModels() const
{
  return !this->Guard || this->Held->claims.allModels;
}

Permission::Refused Permission::TakePartition(
  const ModelDescription& model, std::uint32_t partition, std::uint64_t bytes) const
{
  if (!this->Ledger)
  {
    return std::nullopt;
  }
  PartitionRecord record;
  record.client = this->Client;
  record.partition = partition;
  record.bytes = bytes;
  if (this->Held)
  {
    record.subject = this->Held->claims.subject;
    record.token = this->Held->claims.id;
  }
  return this->Ledger->TakePartition(model, std::move(record));
}

Permission::Refused Permission::TakeRegion(const ModelDescription& model) const
{
  return this->Ledger ? this->Ledger->TakeRegion(
                          model, this->Held ? this->Held->claims.subject : std::string())
                      : std::nullopt;
}

Permission::Refused Permission::RefuseAll() const
{
  const auto valid = this->Guard ? this->Guard->Check(*this->Held) : Status{};
  return valid ? std::nullopt : Refused({ 401, valid.GetError().message });
}

Permission::Refused Permission::RefuseModel(std::string_view model) const
{
  if (!this->Guard || this->Held->claims.AllowsModel(model))
  {
    return std::nullopt;
  }
  return Refusal{ 403, "the token is not for the model " + std::string(model) };
}

Permission::Refused Permission::RefuseBlob(const ModelDescription& model, const BlobId& blob) const
{
  if (!this->Guard)
  {
    return std::nullopt;
  }
  if (auto refused = this->RefuseModel(model.id))
  {
    return refused;
  }
  const auto& claims = this->Held->claims;
  if (DetailOf(model, blob) <= claims.detail)
  {
    return std::nullopt;
  }
  return Refusal{ 403,
    claims.detail == ModelDetail::Preview
      ? "the token only allows the preview of " + model.id + ""
      : "the token only allows the levels of " + model.id + ", not its original" };
}

Permission::Refused Permission::RefuseRequest(
  const ModelDescription& model, const protocol::ClientMessage& message) const
{
  if (!this->Guard)
  {
    return std::nullopt;
  }
  const auto* const asked = std::get_if<protocol::BlobsRequest>(&message.body);
  if (!asked) // a region
  {
    return this->RefuseBlob(model, BlobId::Partition(0));
  }
  for (const BlobId& blob : asked->blobs)
  {
    if (auto refused = this->RefuseBlob(model, blob))
    {
      return refused;
    }
  }
  return std::nullopt;
}

}
