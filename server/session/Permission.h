// SPDX-License-Identifier: BSD-3-Clause
// What one client may have by its token: the same by GET and by stream. Step "serve" of the
// pipeline picture.
//
//   preview   the description of a model, the level of its preview and coarser ones
//   levels    all levels, and the pages of the tree
//   regions   the original too, and the boxes of its partitions
//
// The description says nothing about finer data than the token allows (WithDetail).
//
// All functions may be called from any thread.
#pragma once

#include "filters/model/ModelDescription.h"
#include "filters/protocol/ControlMessage.h"
#include "server/access/TokenGuard.h"
#include "server/session/PartitionLedger.h"
#include "server/session/Refusal.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace kdstream
{

class Permission
{
public:
  using Refused = std::optional<Refusal>; // empty: allowed

  // Allows everything: the server has no tokens, and keeps no ledger.
  Permission() = default;
  // The permission of the token of `pass`, as long as the guard accepts it; if both are null,
  // everything is allowed. What `client` (its address) gets of the original is recorded in the
  // ledger, if there is one.
  Permission(std::shared_ptr<const TokenGuard> guard, std::shared_ptr<const Pass> pass,
    std::shared_ptr<const PartitionLedger> ledger = {}, std::string client = {});

  // 401 if the token is no longer valid.
  Refused RefuseAll() const;
  // 403 if the token is for other models. The refusal does not reveal whether this model exists.
  Refused RefuseModel(std::string_view model) const;
  // 403 if the token does not allow this part of the model.
  Refused RefuseBlob(const ModelDescription& model, const protocol::BlobId& blob) const;
  // Does the same for everything that a message asks for. REQUIRES: the message does not open a
  // model.
  Refused RefuseRequest(
    const ModelDescription& model, const protocol::ClientMessage& message) const;

  // How much the token allows of the models that it is for.
  ModelDetail Detail() const;
  bool AllowsAllModels() const;

  // Whether TakePartition must be called before the blob is sent.
  bool IsCounted(const protocol::BlobId& blob) const
  {
    return this->Ledger && protocol::IsOfOriginal(blob);
  }
  // Records that the client gets a partition, or its texture; both together count once. 403 or 429
  // beyond a quota; 503 if the quotas cannot be kept. Waits for a disk.
  Refused TakePartition(
    const ModelDescription& model, std::uint32_t partition, std::uint64_t bytes) const;
  Refused TakeRegion(const ModelDescription& model) const;

private:
  std::shared_ptr<const TokenGuard> Guard; // null: everything is allowed
  std::shared_ptr<const Pass> Held;
  std::shared_ptr<const PartitionLedger> Ledger; // null: nothing is counted
  std::string Client;
};

}
