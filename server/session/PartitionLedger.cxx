// SPDX-License-Identifier: BSD-3-Clause
#include "server/session/PartitionLedger.h"

#include <utility>

namespace kdstream
{
namespace
{

// The numbers of partitions depend only on these values: not on precision, levels or texts. Welding
// and texture coordinates change the numbers.
std::string DivisionOf(const ModelDescription& model)
{
  return model.partitioner + " " + std::to_string(model.partitions) + " of " +
         std::to_string(model.vertices) + " " + std::to_string(model.triangles);
}

CountedModel CountedAs(const ModelDescription& model, const std::string& division)
{
  return { model.digest, model.inputDigest, division, model.partitions };
}

}

PartitionLedger::PartitionLedger(std::shared_ptr<QuotaBook> quotas, OnPartition onPartition,
  std::function<void()> onRefusal, OnFailure onFailure)
  : Quotas(std::move(quotas))
  , Tell(std::move(onPartition))
  , TellRefusal(std::move(onRefusal))
  , TellFailure(std::move(onFailure))
{
}

std::optional<Refusal> PartitionLedger::TakePartition(
  const ModelDescription& model, PartitionRecord record) const
{
  if (this->Quotas)
  {
    const auto division = DivisionOf(model);
    auto refusal = this->RefusalOf(this->Quotas->TakePartition(
      record.subject, CountedAs(model, division), record.partition, record.bytes));
    if (refusal)
    {
      return refusal;
    }
  }
  if (this->Tell)
  {
    record.model = model.id;
    record.digest = model.digest;
    record.original = model.inputDigest.empty() ? model.digest : model.inputDigest;
    this->Tell(record);
  }
  return std::nullopt;
}

std::optional<Refusal> PartitionLedger::TakeRegion(
  const ModelDescription& model, const std::string& subject) const
{
  const auto division = DivisionOf(model);
  return this->Quotas
           ? this->RefusalOf(this->Quotas->TakeRegion(subject, CountedAs(model, division)))
           : std::nullopt;
}

// If the quotas cannot be kept, nothing is sent.
std::optional<Refusal> PartitionLedger::RefusalOf(const QuotaBook::Taken& taken) const
{
  const bool failedBefore = this->Fails.exchange(!taken);
  if (!taken)
  {
    if (this->TellFailure)
    {
      const auto& error = taken.GetError();
      this->TellFailure(
        (error.file.empty() ? "" : error.file + ": ") + error.message, !failedBefore);
    }
    return Refusal{ 503, "the server cannot record its quotas: try again later" };
  }
  if (!*taken)
  {
    return std::nullopt;
  }
  if (this->TellRefusal)
  {
    this->TellRefusal();
  }
  const auto& refusal = **taken;
  const std::uint16_t status = refusal.isShare ? 403 : 429;
  return Refusal{ status, refusal.message, refusal.endsIn };
}

}
