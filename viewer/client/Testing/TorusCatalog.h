// SPDX-License-Identifier: BSD-3-Clause
// What a real server serves in tests of viewers: one torus, in memory.
#pragma once

#include "server/session/Catalog.h"
#include "viewer/session/Testing/MemoryServer.h"

#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace kdstream::testing
{

inline MemoryServer& ServedTorus()
{
  static MemoryServer torus(MakeTorus(120, 60), 128, 2);
  return torus;
}

class TorusModel : public ServedModel
{
public:
  const ModelDescription& Description() const override
  {
    return this->described ? *this->described : ServedTorus().Description();
  }
  Result<std::span<const Box>> Boxes() const override
  {
    return std::span<const Box>(ServedTorus().Tree());
  }
  Result<BlobBytes> ReadBlob(const protocol::BlobId& blob) const override
  {
    {
      const std::lock_guard lock(this->Mutex);
      this->Read.push_back(protocol::BlobName(blob));
    }
    if (this->damaged == blob)
    {
      return Error{ ErrorCode::Damaged, "its checksum is wrong" };
    }
    if (!ServedTorus().Has(blob))
    {
      return Error{ ErrorCode::NotFound, "no such blob" };
    }
    return std::make_shared<const std::vector<std::uint8_t>>(ServedTorus().Blob(blob));
  }
  std::optional<protocol::BlobId> damaged;
  std::optional<ModelDescription> described; // instead of the torus's own

  // The names of the blobs that were read since the last call, in order.
  std::vector<std::string> TakeRead() const
  {
    const std::lock_guard lock(this->Mutex);
    return std::exchange(this->Read, {});
  }

private:
  mutable std::mutex Mutex;
  mutable std::vector<std::string> Read;
};

class TorusCatalog : public Catalog
{
public:
  std::vector<std::shared_ptr<const ServedModel>> Models() const override
  {
    return { this->model };
  }
  std::shared_ptr<const ServedModel> Find(std::string_view id) const override
  {
    return id == "torus" ? this->model : nullptr;
  }
  std::shared_ptr<TorusModel> model = std::make_shared<TorusModel>();
};

}
