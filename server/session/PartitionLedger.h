// SPDX-License-Identifier: BSD-3-Clause
// The hooks for delivery of the original: quotas that limit who gets how much of it, and records of
// who got what.
#pragma once

#include "filters/model/ModelDescription.h"
#include "server/access/QuotaBook.h"
#include "server/session/Refusal.h"

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace kdstream
{

// A partition that a client gets.
struct PartitionRecord
{
  std::string subject, token; // of its token, the id of which may be ""; both "" without one
  std::string client;         // address
  std::string model, digest;
  std::string original; // equal for models of one input: its digest, or where that is not known the
                        // model's
  std::uint32_t partition = 0;
  std::uint64_t bytes = 0;
};

// All functions from any thread.
class PartitionLedger
{
public:
  using OnPartition = std::function<void(const PartitionRecord&)>;
  // Called with the reason why the quotas could not be kept; isNew: the first time since they
  // could.
  using OnFailure = std::function<void(const std::string& what, bool isNew)>;

  // quotas: null for none. The functions are called from any thread; may be empty.
  PartitionLedger(std::shared_ptr<QuotaBook> quotas, OnPartition onPartition,
    std::function<void()> onRefusal, OnFailure onFailure = {});

  // Enters what is about to be sent to the client; of the record only client and token need to be
  // set. Nothing if it may be sent; else 403 for a share that is used up, 429 for too fast
  // requests, 503 if the quotas cannot be kept. Waits for a disk.
  std::optional<Refusal> TakePartition(const ModelDescription& model, PartitionRecord record) const;
  std::optional<Refusal> TakeRegion(
    const ModelDescription& model, const std::string& subject) const;

private:
  std::optional<Refusal> RefusalOf(const QuotaBook::Taken& taken) const;

  std::shared_ptr<QuotaBook> Quotas;
  OnPartition Tell;
  std::function<void()> TellRefusal;
  OnFailure TellFailure;
  mutable std::atomic<bool> Fails{ false }; // whether the quotas failed at the last request
};

}
