// SPDX-License-Identifier: BSD-3-Clause
#include "server/session/Catalog.h"

#include "filters/model/ListedPages.h"
#include "filters/model/ModelJson.h"

namespace kdstream
{

BlobBytes BytesOfText(std::string_view text)
{
  return std::make_shared<const std::vector<std::uint8_t>>(text.begin(), text.end());
}

BlobBytes ServedModel::Json(ModelDetail detail) const
{
  const std::lock_guard lock(this->JsonMutex);
  auto& written = this->Written.at(static_cast<std::size_t>(detail));
  if (!written)
  {
    written = BytesOfText(WriteModel(WithDetail(this->Description(), detail)));
  }
  return written;
}

std::string ServedModel::JsonHash(Hash hash) const
{
  const BlobBytes json = this->Json();
  const std::lock_guard lock(this->JsonMutex);
  if (this->WrittenHash.empty())
  {
    this->WrittenHash = hash(*json);
  }
  return this->WrittenHash;
}

BlobBytes Catalog::WriteList(const std::vector<std::shared_ptr<const ServedModel>>& models) const
{
  std::vector<ModelSummary> summaries;
  summaries.reserve(models.size());
  for (const auto& model : models)
  {
    auto& summary = summaries.emplace_back(Summarize(model->Description()));
    summary.notes = this->CountNotes(summary.id);
  }
  return BytesOfText(WithPages(WriteModelList(summaries, this->Site), this->Pages));
}

}
