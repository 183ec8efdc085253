// SPDX-License-Identifier: BSD-3-Clause
// Hooks for the delivery of the original: quotas that limit who gets how much of it, and records of
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
  std::string subject, token; // of the client's token: its subject and its id, which may be "";
                              // both "" without a token
  std::string client;         // the client's address
  std::string model, digest;
  std::string original; // equal for models of one input: its digest, or where that is not known the
                        // model's
  std::uint32_t partition = 0;
  std::uint64_t bytes = 0;
};

// All functions may be called from any thread.
class PartitionLedger
{
public:
  using OnPartition = std::function<void(const PartitionRecord&)>;
  // Called with the reason why the quotas could not be kept. isNew: this is the first failure since
  // they could be kept.
  using OnFailure = std::function<void(const std::string& what, bool isNew)>;

  // quotas: null if there are none. The functions are called from any thread, and may be empty.
  PartitionLedger(std::shared_ptr<QuotaBook> quotas, OnPartition onPartition,
    std::function<void()> onRefusal, OnFailure onFailure = {});

  // Records a partition that is about to be sent to the client; in the record only client and token
  // need to be set. Returns nothing if the partition may be sent; else 403 if a share is used up,
  // 429 if requests come too fast, 503 if the quotas cannot be kept. Waits for a disk.
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
