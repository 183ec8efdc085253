// SPDX-License-Identifier: BSD-3-Clause
// A server's catalog of one model in memory, for recordings.
#pragma once

#include "server/session/Catalog.h"
#include "viewer/session/Testing/MemoryServer.h"

#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace kdstream::testing
{

// A torus with colours and normals.
inline Mesh ColoredTorus()
{
  Mesh mesh = MakeTorus(420, 210);
  AddVertexColors(mesh);
  return mesh;
}

class MemoryModel : public ServedModel
{
public:
  MemoryModel(const Mesh& mesh, std::string id)
    : Server(mesh, 400, 2)
    , Facts(this->Server.Description())
  {
    this->Facts.id = std::move(id);
    // Without attributes, levels are chosen by the shape only. A model with colours would be shown
    // in the finest level at once.
    this->Facts.attributes.clear();
  }
  const ModelDescription& Description() const override { return this->Facts; }
  Result<std::span<const Box>> Boxes() const override
  {
    return std::span<const Box>(this->Server.Tree());
  }
  Result<BlobBytes> ReadBlob(const protocol::BlobId& blob) const override
  {
    if (!this->Server.Has(blob))
    {
      return Error{ ErrorCode::NotFound, "no such blob" };
    }
    return std::make_shared<const std::vector<std::uint8_t>>(this->Server.Blob(blob));
  }

private:
  mutable MemoryServer Server;
  ModelDescription Facts;
};

class MemoryCatalog : public Catalog
{
public:
  MemoryCatalog(const Mesh& mesh, std::string id)
    : Only(std::make_shared<MemoryModel>(mesh, std::move(id)))
  {
  }
  std::vector<std::shared_ptr<const ServedModel>> Models() const override { return { this->Only }; }
  std::shared_ptr<const ServedModel> Find(std::string_view id) const override
  {
    return id == this->Only->Description().id ? this->Only : nullptr;
  }

private:
  std::shared_ptr<const ServedModel> Only;
};

}
