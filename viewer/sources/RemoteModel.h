// SPDX-License-Identifier: BSD-3-Clause
// A model on a server, read as if it were a store: each read sends requests and waits for the
// answers.
#pragma once

#include "filters/store/PieceSource.h"
#include "viewer/client/ConnectServer.h"

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace kdstream
{

class RemoteModel final : public PieceSource
{
public:
  // Connects, and opens the model; if the server cannot be reached, opens the cached model. While
  // waiting (also in the functions below), the step "waiting" is reported every 20 ms. Errors:
  // those of ServerClient::Connect; NotFound for a model that the server does not have, naming the
  // models that it has; InputOutput if no answer arrives; Cancelled.
  static Result<std::shared_ptr<const RemoteModel>> Open(
    const ServerAddress& address, const Execution& execution);

  // Asks the server whether it still has this version of the model. If not, this object must not be
  // used any more. Errors: Cancelled.
  Result<bool> IsPresent(const Execution& execution) const;

  const ModelDescription& Info() const override { return this->Description; }
  // Further error: InputOutput if the connection is lost or stalls.
  Result<std::vector<Piece>> ReadPieces(
    std::span<const PieceId> ids, const Execution& execution = {}) const override;
  Result<std::vector<std::uint8_t>> Read(
    const protocol::BlobId& blob, const Execution& execution = {}) const override;
  Result<std::vector<Box>> ReadBoxes(const Execution& execution = {}) const override;

private:
  using Blobs = std::map<protocol::BlobId, std::vector<std::uint8_t>>;

  RemoteModel(std::unique_ptr<ModelSource> source, std::chrono::seconds timeout);
  Result<std::unique_lock<std::timed_mutex>> Lock(const Execution& execution) const;
  Result<ModelDescription> AskFor(const std::string& model, const Execution& execution) const;
  Result<Blobs> Fetch(std::span<const protocol::BlobId> wanted, const Execution& execution) const;
  Result<std::vector<ClientEvent>> NextEvents(const Execution& execution) const;

  mutable std::timed_mutex Mutex; // one read at a time
  std::unique_ptr<ModelSource> Source;
  std::chrono::seconds Timeout;
  ModelDescription Description;
  mutable std::uint32_t LastRequest = 0;
};

}
