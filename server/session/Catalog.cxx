// SPDX-License-Identifier: BSD-3-Clause
#include "server/session/Catalog.h"

#include "filters/model/ModelJson.h"

namespace kdstream
{

namespace
{

BlobBytes JsonBytes(const std::string& text)
{
  return std::make_shared<const std::vector<std::uint8_t>>(text.begin(), text.end());
}

}

BlobBytes ServedModel::Json(ModelDetail detail) const
{
  if (detail != ModelDetail::Regions)
  {
    auto told = this->Description();
    told.detail = detail;
    return JsonBytes(WriteModel(told));
  }
  const std::lock_guard lock(this->JsonMutex);
  if (!this->Written)
  {
    this->Written = JsonBytes(WriteModel(this->Description()));
  }
  return this->Written;
}

BlobBytes Catalog::WriteList(const std::vector<std::shared_ptr<const ServedModel>>& models)
{
  std::vector<ModelSummary> summaries;
  summaries.reserve(models.size());
  for (const auto& model : models)
  {
    summaries.push_back(Summarize(model->Description()));
  }
  return JsonBytes(WriteModelList(summaries));
}

}
