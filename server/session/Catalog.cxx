// SPDX-License-Identifier: BSD-3-Clause
#include "server/session/Catalog.h"

#include "filters/model/ModelJson.h"

namespace kdstream
{

BlobBytes ServedModel::Json() const
{
  const std::lock_guard lock(this->JsonMutex);
  if (!this->Written)
  {
    const auto text = WriteModel(this->Description());
    this->Written = std::make_shared<const std::vector<std::uint8_t>>(text.begin(), text.end());
  }
  return this->Written;
}

}
