// SPDX-License-Identifier: BSD-3-Clause
// Models whose stores are released while nobody reads them. They are opened again; if another file
// is there by then, this is noticed.
#include "Testing/Fixtures/Meshes.h"
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/build/Builder.h"
#include "filters/store/Sqlite.h"
#include "filters/store/Store.h"
#include "server/session/StoreCatalog.h"
#include "server/session/StoreModel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <iterator>
#include <thread>

using namespace kdstream;
using protocol::BlobId;
namespace fs = std::filesystem;

namespace
{

// Three stores, two of which may be open.
class SomeOpenStores : public testing::Test
{
protected:
  static constexpr std::size_t count = 3;
  const fixtures::TemporaryFolder folder;
  const std::shared_ptr<OpenStores> open = std::make_shared<OpenStores>(2);
  const std::shared_ptr<BlobCache> cache = std::make_shared<BlobCache>(0);
  std::vector<std::shared_ptr<const StoreModel>> models;

  void SetUp() override
  {
    for (std::size_t i = 0; i < count; ++i)
    {
      this->Build(this->File(i), 20 + static_cast<std::uint32_t>(i));
      this->models.push_back(this->Open(i));
    }
  }

  fs::path File(std::size_t i) const { return this->folder / (std::to_string(i) + ".kds"); }

  void Build(const fs::path& file, std::uint32_t around, const std::string& title = "") const
  {
    BuildOptions options;
    options.title = title;
    const auto report = BuildStore(fixtures::Torus(around, 10), "torus.ply", file, options);
    ASSERT_TRUE(report) << report.GetError().message;
  }

  std::shared_ptr<const StoreModel> Open(std::size_t i, std::shared_ptr<BlobCache> blobs = {}) const
  {
    auto model = OpenStoreModel(
      this->File(i), "model-" + std::to_string(i), blobs ? std::move(blobs) : this->cache,
      [](const std::string&) {}, this->open);
    EXPECT_TRUE(model) << model.GetError().message;
    return *model;
  }

  bool IsOpen(std::size_t i) const { return this->open->Find(this->models[i].get()) != nullptr; }

  static Result<BlobBytes> Read(const StoreModel& model)
  {
    return model.ReadBlob(BlobId::Partition(0));
  }
};

std::size_t OpenDescriptors()
{
  return static_cast<std::size_t>(
    std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator()));
}

}

TEST_F(SomeOpenStores, ThoseThatWereReadLastAreOpen)
{
  EXPECT_FALSE(this->IsOpen(0));
  EXPECT_TRUE(this->IsOpen(1) && this->IsOpen(2));
  EXPECT_TRUE(this->models[0]->CheckUnchanged());
  EXPECT_TRUE(this->models[0]->IsFile(this->File(0)));
  EXPECT_EQ(this->models[0]->LooksUnchanged(), std::nullopt) << "not without a disk";
  EXPECT_FALSE(this->IsOpen(0)) << "to ask whether it is there opens nothing";
  ASSERT_TRUE(Read(*this->models[1]));
  ASSERT_TRUE(Read(*this->models[0]));
  EXPECT_TRUE(this->IsOpen(0) && this->IsOpen(1));
  EXPECT_FALSE(this->IsOpen(2));
  EXPECT_EQ(this->models[0]->LooksUnchanged(), std::optional(true));
  for (const auto& model : this->models)
  {
    const auto alone = Store::Open(this->File(static_cast<std::size_t>(
      std::find(this->models.begin(), this->models.end(), model) - this->models.begin())));
    ASSERT_TRUE(alone);
    EXPECT_EQ(**Read(*model),
      *(*alone)->Read(BlobOfPiece({ Resolution::Original(), 1 }, (*alone)->Info().depths)));
    EXPECT_TRUE(model->Boxes());
    EXPECT_TRUE(model->BlobSize(BlobId::TreePage(1)));
  }
}

TEST_F(SomeOpenStores, ABlobInMemoryIsSentOfAStoreThatWasLetGo)
{
  const auto blobs = std::make_shared<BlobCache>(std::size_t{ 1 } << 20);
  const auto model = this->Open(0, blobs);
  const auto bytes = Read(*model);
  ASSERT_TRUE(bytes);
  EXPECT_EQ(model->FindBlob(BlobId::Partition(0)), *bytes);
  ASSERT_TRUE(Read(*this->models[1]) && Read(*this->models[2]));
  EXPECT_EQ(model->FindBlob(BlobId::Partition(0)), nullptr) << "that takes a disk";
  EXPECT_EQ(*Read(*model), *bytes);
  EXPECT_EQ(model->FindBlob(BlobId::Partition(0)), *bytes) << "it is open again";
  // If another file has replaced it, it is not sent.
  ASSERT_TRUE(Read(*this->models[1]) && Read(*this->models[2]));
  this->Build(this->File(0), 33);
  EXPECT_EQ(Read(*model).GetError().code, ErrorCode::Changed);
  EXPECT_EQ(model->FindBlob(BlobId::Partition(0)), nullptr);
}

TEST_F(SomeOpenStores, AFileThatWasReplacedWhileItWasReadIsNoticed)
{
  this->Build(this->File(0), 33);
  EXPECT_EQ(this->models[0]->CheckUnchanged().GetError().code, ErrorCode::Changed);
  EXPECT_EQ(Read(*this->models[0]).GetError().code, ErrorCode::Changed);
  EXPECT_EQ(this->models[0]->BlobSize(BlobId::Partition(0)).GetError().code, ErrorCode::Changed);
  EXPECT_FALSE(this->models[0]->IsFile(this->File(0)));
  EXPECT_FALSE(this->IsOpen(0));
  // A file that is absent for a while is the same one when it comes back.
  ASSERT_TRUE(Read(*this->models[1]));
  EXPECT_FALSE(this->IsOpen(0));
  fs::rename(this->File(2), this->folder / "away");
  ASSERT_TRUE(Read(*this->models[2])) << "it is open";
  const auto first = this->Open(0);
  ASSERT_TRUE(Read(*this->models[1]));
  ASSERT_FALSE(this->IsOpen(2));
  EXPECT_EQ(Read(*this->models[2]).GetError().code, ErrorCode::Changed);
  fs::rename(this->folder / "away", this->File(2));
  EXPECT_TRUE(this->models[2]->CheckUnchanged());
  EXPECT_TRUE(Read(*this->models[2]));
  EXPECT_TRUE(this->models[2]->IsFile(this->File(2)));
}

// Another store of the same size is written into the same file, with the same file times.
TEST_F(SomeOpenStores, AFileThatWasOverwrittenWhileItWasReadIsNoticed)
{
  const fs::path other = this->folder / "other";
  this->Build(other, 21);
  const auto size = std::max(fs::file_size(other), fs::file_size(this->File(0)));
  fs::resize_file(this->File(0), size);
  fs::resize_file(other, size);
  const auto model = this->Open(0);
  ASSERT_TRUE(Read(*this->models[1]) && Read(*this->models[2]));
  const auto written = fs::last_write_time(this->File(0));
  {
    std::ifstream in(other, std::ios::binary);
    std::ofstream out(this->File(0), std::ios::binary);
    out << in.rdbuf();
  }
  fs::last_write_time(this->File(0), written);
  EXPECT_EQ(Read(*model).GetError().code, ErrorCode::Changed);
  EXPECT_EQ(model->CheckUnchanged().GetError().code, ErrorCode::Changed);
}

// For clients that still read a model whose file has been replaced.
TEST_F(SomeOpenStores, WhatStaysOpenIsReadThoughItsNameLeadsElsewhere)
{
  ASSERT_TRUE(this->IsOpen(2));
  const auto before = Read(*this->models[2]);
  ASSERT_TRUE(before);
  this->Build(this->File(2), 33);
  this->models[2]->StayOpen();
  ASSERT_TRUE(Read(*this->models[1]));
  const auto first = this->Open(0);
  EXPECT_EQ(**Read(*this->models[2]), **before);
  EXPECT_TRUE(this->IsOpen(1)) << "it takes nobody's place";
}

TEST_F(SomeOpenStores, AnyNumberOfThreadsReadMoreThanMayBeOpen)
{
  std::vector<std::vector<std::uint8_t>> bytes;
  for (const auto& model : this->models)
  {
    bytes.push_back(**Read(*model));
  }
  std::atomic<unsigned> wrong{ 0 };
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < 6; ++t)
  {
    threads.emplace_back(
      [&, t]
      {
        for (std::size_t i = 0; i < 60; ++i)
        {
          const std::size_t which = (i + t) % count;
          const auto read = Read(*this->models[which]);
          wrong += !read || **read != bytes[which] || !this->models[which]->CheckUnchanged();
        }
      });
  }
  for (std::thread& thread : threads)
  {
    thread.join();
  }
  EXPECT_EQ(wrong, 0u);
  EXPECT_EQ(this->IsOpen(0) + this->IsOpen(1) + this->IsOpen(2), 2);
}

TEST_F(SomeOpenStores, AFolderOfManyTakesFewDescriptors)
{
  const fs::path many = this->folder / "many";
  fs::create_directory(many);
  for (std::size_t i = 0; i < 2 * StoreCatalog::defaultOpenStores; ++i)
  {
    fs::copy_file(this->File(0), many / (std::to_string(i) + ".kds"));
  }
  const std::size_t before = OpenDescriptors();
  StoreCatalog catalog(many, [](const fs::path&, const std::string&) {});
  ASSERT_TRUE(catalog.Reload());
  EXPECT_EQ(catalog.Models().size(), 2 * StoreCatalog::defaultOpenStores);
  EXPECT_LE(OpenDescriptors(), before + StoreCatalog::defaultOpenStores);
  for (const auto& model : catalog.Models())
  {
    EXPECT_TRUE(model->ReadBlob(BlobId::Partition(0)));
  }
  EXPECT_LE(OpenDescriptors(), before + StoreCatalog::defaultOpenStores);
  const auto list = catalog.ListJson();
  catalog.Refresh();
  EXPECT_EQ(catalog.ListJson(), list) << "nothing has changed";
}

TEST_F(SomeOpenStores, AStrangersStoreKeepsNoOtherFromBeingServed)
{
  const fs::path stores = this->folder / "stores";
  fs::create_directory(stores);
  fs::copy_file(this->File(0), stores / "a-view.kds");
  fs::copy_file(this->File(0), stores / "b-good.kds");
  {
    const auto database = OpenForWriting(stores / "a-view.kds");
    ASSERT_TRUE(database);
    ASSERT_TRUE(Execute(database->get(),
      "DROP TABLE metadata; CREATE VIEW metadata AS SELECT 'model' AS key, (WITH RECURSIVE c(x) AS "
      "(SELECT 1 UNION ALL SELECT x + 1 FROM c) SELECT count(*) FROM c) AS value, 0 AS checksum"));
  }
  std::vector<std::string> reported;
  StoreCatalog catalog(stores, [&reported](const fs::path& file, const std::string& what)
    { reported.push_back(file.filename().string() + ": " + what); });
  ASSERT_TRUE(catalog.Reload());
  EXPECT_EQ(catalog.Models().size(), 1u);
  EXPECT_TRUE(catalog.Find("b-good"));
  EXPECT_EQ(reported,
    std::vector<std::string>{ "a-view.kds: not a KdStream store: it has a view "
                              "'metadata'; this store is left out, the others are served" });
}
