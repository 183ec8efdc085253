// SPDX-License-Identifier: BSD-3-Clause
// For tests of code that uses a Catalog: models made up in memory, from a seed.
#pragma once

#include "filters/core/tree/KdTree.h"
#include "server/session/Catalog.h"

#include <atomic>
#include <map>
#include <new>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <utility>

namespace kdstream
{

class MemoryModel : public ServedModel
{
public:
  // A model of random points with 2^partitionDepth partitions. Each partition's blob has
  // `blobBytes` bytes, plus or minus a half. The other blobs, including those of its texture, are
  // small.
  MemoryModel(std::string id, std::uint64_t seed, unsigned partitionDepth, std::size_t blobBytes)
    : Random(seed)
  {
    KdTreeOptions options;
    options.partitions = 1u << partitionDepth;
    std::vector<Vec3> points(std::size_t{ 20 } << partitionDepth);
    std::uniform_real_distribution<double> coordinate(-10, 10);
    for (auto& point : points)
    {
      point = { coordinate(this->Random), coordinate(this->Random), coordinate(this->Random) / 8 };
    }
    const auto tree = BuildKdTree(points, options);
    this->Tree = tree->boxes;
    this->Depths = tree->depths;
    this->Describe(std::move(id), points.size());
    this->MakeBlobs(blobBytes);
  }

  const ModelDescription& Description() const override { return this->Reported; }
  Status CheckUnchanged() const override
  {
    return this->fails == ErrorCode::Changed ? Error{ *this->fails, "changed" } : Status{};
  }
  std::optional<bool> LooksUnchanged() const override
  {
    return this->unclear ? std::nullopt : std::optional(bool(this->CheckUnchanged()));
  }
  Result<std::span<const Box>> Boxes() const override
  {
    this->AwaitDisk();
    if (this->throws)
    {
      throw std::bad_alloc();
    }
    if (this->treeDamaged)
    {
      return Error{ ErrorCode::Damaged, "tree/1: wrong checksum" };
    }
    return std::span<const Box>(this->Tree);
  }
  Result<BlobBytes> ReadBlob(const protocol::BlobId& blob) const override
  {
    ++this->reads;
    this->AwaitDisk();
    if (this->throws)
    {
      throw std::bad_alloc();
    }
    if (this->fails)
    {
      return Error{ *this->fails, protocol::BlobName(blob) + ": secret place" };
    }
    const auto found = this->blobs.find(blob);
    if (found == this->blobs.end())
    {
      return Error{ ErrorCode::NotFound, "no such blob" };
    }
    if (this->damaged.count(blob) != 0)
    {
      return Error{ ErrorCode::Damaged, protocol::BlobName(blob) + ": secret place" };
    }
    return found->second;
  }

  Result<std::uint64_t> BlobSize(const protocol::BlobId& blob) const override
  {
    const auto bytes = this->ReadBlob(blob);
    this->reads -= 1;
    KDSTREAM_TRY(bytes);
    return (*bytes)->size();
  }

  BlobBytes FindBlob(const protocol::BlobId& blob) const override
  {
    const auto found = this->inMemory ? this->blobs.find(blob) : this->blobs.end();
    return found == this->blobs.end() ? nullptr : found->second;
  }

  std::map<protocol::BlobId, BlobBytes> blobs;
  bool inMemory = false; // whether FindBlob finds all blobs
  bool unclear = false;  // only a disk can tell whether the model has changed
  // While this is set, readers of blobs or of the tree wait.
  std::atomic<bool> diskHangs{ false };
  mutable std::atomic<int> hanging{ 0 };
  std::set<protocol::BlobId> damaged;
  bool treeDamaged = false;
  std::optional<ErrorCode> fails;    // the error of reading any blob
  std::atomic<bool> throws{ false }; // lack of memory
  mutable std::atomic<std::size_t> reads{ 0 };

  ModelDescription& Retell() { return this->Reported; } // call this before it is served
  const TreeDepths& GetDepths() const { return this->Depths; }
  std::span<const Box> TrueBoxes() const { return this->Tree; }

private:
  void AwaitDisk() const
  {
    ++this->hanging;
    this->diskHangs.wait(true);
    --this->hanging;
  }
  void Describe(std::string id, std::uint64_t vertices)
  {
    this->Reported.id = std::move(id);
    for (int i = 0; i < 32; ++i)
    {
      this->Reported.digest += "0123456789abcdef"[this->Random() % 16];
    }
    this->Reported.vertices = vertices;
    this->Reported.triangles = 2 * vertices;
    this->Reported.partitions = std::uint64_t{ 1 } << this->Depths.partition;
    this->Reported.depths = this->Depths;
    this->Reported.box = this->Tree[1];
    this->Reported.title = "made up";
    this->Reported.levels.resize(this->Depths.finest + 1u);
    this->Reported.textures.emplace();
  }

  std::uint64_t Put(const protocol::BlobId& id, std::size_t size)
  {
    std::vector<std::uint8_t> bytes(size);
    for (auto& byte : bytes)
    {
      byte = static_cast<std::uint8_t>(this->Random());
    }
    this->blobs[id] = std::make_shared<const std::vector<std::uint8_t>>(std::move(bytes));
    return size;
  }

  void MakeBlobs(std::size_t blobBytes)
  {
    this->Put(protocol::BlobId::TreePage(1), 500);
    for (std::uint8_t level = 0; level <= this->Depths.finest; ++level)
    {
      const auto depth = PieceDepth(Resolution::Level(level), this->Depths);
      auto& reported = this->Reported.levels[level];
      reported.pieces = std::uint64_t{ 1 } << depth;
      for (std::uint32_t node = 1u << depth; node < 2u << depth; ++node)
      {
        reported.bytes += this->Put(protocol::BlobId::LevelPiece(level, node), 100 + level);
      }
    }
    this->Reported.original.pieces = this->Reported.partitions;
    for (std::uint32_t p = 0; p < this->Reported.partitions; ++p)
    {
      this->Reported.original.bytes += this->Put(
        protocol::BlobId::Partition(p), blobBytes / 2 + this->Random() % (blobBytes + 1) + 1);
    }
    for (std::uint32_t p = 0; p < this->Reported.partitions; ++p)
    {
      this->Reported.textures->bytes += this->Put(protocol::BlobId::Texture(p), 50 + p % 7);
    }
  }

  std::mt19937_64 Random;
  std::vector<Box> Tree;
  TreeDepths Depths;
  ModelDescription Reported;
};

class MemoryCatalog : public Catalog
{
public:
  std::shared_ptr<MemoryModel> Add(
    const std::string& id, std::uint64_t seed, unsigned partitionDepth, std::size_t blobBytes)
  {
    auto model = std::make_shared<MemoryModel>(id, seed, partitionDepth, blobBytes);
    this->models[id] = model;
    return model;
  }

  std::vector<std::shared_ptr<const ServedModel>> Models() const override
  {
    std::vector<std::shared_ptr<const ServedModel>> all;
    for (const auto& entry : this->models)
    {
      all.push_back(entry.second);
    }
    return all;
  }
  std::shared_ptr<const ServedModel> Find(std::string_view id) const override
  {
    const auto found = this->models.find(id);
    return found == this->models.end() ? nullptr : found->second;
  }

  Result<BlobBytes> ReadNotes(const std::string& id) const override
  {
    const auto found = this->notes.find(id);
    return found == this->notes.end() ? Catalog::ReadNotes(id) : found->second;
  }

  std::map<std::string, std::shared_ptr<MemoryModel>, std::less<>> models;
  std::map<std::string, Result<BlobBytes>, std::less<>> notes;
};

}
