// SPDX-License-Identifier: BSD-3-Clause
// What one client may have by its token: the same by GET and by stream. Step "serve" of the
// README's picture.
//
//   preview   the description of a model, the level of its preview and coarser ones, and the pages
//             of its tree that tell of nothing finer
//   levels    all levels, and all pages of the tree
//   regions   the original too, and the boxes of its partitions
//
// All functions from any thread.
#pragma once

#include "filters/model/ModelDescription.h"
#include "server/access/TokenGuard.h"
#include "server/protocol/ControlMessage.h"
#include "server/session/Refusal.h"

#include <memory>
#include <optional>
#include <string_view>

namespace kdstream
{

class Permission
{
public:
  using Refused = std::optional<Refusal>; // nothing where it may

  // For everything: the server has no tokens.
  Permission() = default;
  // For what the token of `pass` allows, for as long as the guard takes it.
  Permission(std::shared_ptr<const TokenGuard> guard, std::shared_ptr<const Pass> pass);

  // 401 where the token is valid no more.
  Refused RefuseAll() const;
  // 403 where it is for other models. Says nothing of whether there is such a model.
  Refused RefuseModel(std::string_view model) const;
  // 403 where it does not allow as much of the model.
  Refused RefuseBlob(const ModelDescription& model, const protocol::BlobId& blob) const;
  // The same for all that a message asks for. REQUIRES: it is no open.
  Refused RefuseRequest(
    const ModelDescription& model, const protocol::ClientMessage& message) const;

  // How much of the models that it is for.
  ModelDetail Detail() const;

private:
  std::shared_ptr<const TokenGuard> Guard; // null: for everything
  std::shared_ptr<const Pass> Held;
};

}
