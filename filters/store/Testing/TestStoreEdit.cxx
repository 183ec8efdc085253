// SPDX-License-Identifier: BSD-3-Clause
// EditStore: either the texts change and the content stays, or nothing changes at all.
#include "Testing/Fixtures/Meshes.h"
#include "filters/store/StoreEdit.h"
#include "filters/store/StoreSchema.h"
#include "filters/store/Testing/StoreTest.h"

#include <gtest/gtest.h>

#include <fstream>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

class StoreEditTest : public StoreTest
{
};

}

TEST_F(StoreEditTest, TextsAreChangedAndTheContentStays)
{
  BuildOptions options;
  options.tree.verticesPerPartition = 200;
  options.title = "Statu";
  options.credit = "somebody";
  const ModelDescription before = this->Build(Torus(96, 48), options).info;
  const auto open = *Store::Open(this->File()); // as a server would have it open
  const PieceId id{ Resolution::Original(), 32 };
  const auto piece = open->Read(BlobOfPiece(id, open->Info().depths));
  const auto edited = EditStore(this->File(), { "Statue", "", {}, std::string(9000, 'u') });
  ASSERT_TRUE(edited) << edited.GetError().message;
  EXPECT_EQ(*open->Read(BlobOfPiece(id, open->Info().depths)), *piece)
    << "a file that is open has changed";
  const auto store = *Store::Open(this->File());
  EXPECT_TRUE(store->Verify().empty());
  ModelDescription expected = before;
  expected.title = "Statue";
  expected.credit = "";
  expected.unit = std::string(9000, 'u');
  EXPECT_EQ(WriteStoredModel(store->Info()), WriteStoredModel(expected));
  EXPECT_EQ(WriteStoredModel(*edited), WriteStoredModel(expected));
  EXPECT_EQ(store->Info().digest, before.digest);
  // The inverse edit restores everything.
  ASSERT_TRUE(EditStore(this->File(), { "Statu", "somebody", {}, "" }));
  EXPECT_EQ(WriteStoredModel((*Store::Open(this->File()))->Info()), WriteStoredModel(before));
  EXPECT_EQ(this->FilesInFolder(), 1U);
}

TEST_F(StoreEditTest, UpAndFirstViewAreChangedAndNoLongerGuessed)
{
  this->Build(Torus(96, 48), {});
  const auto before = (*Store::Open(this->File()))->Info();
  ASSERT_TRUE(before.homeView && before.homeView->guessed);
  const auto edit = [&](const std::optional<Vec3>& up, const std::optional<Vec3>& view)
  {
    StoreTexts texts;
    texts.up = up;
    texts.view = view;
    const auto edited = EditStore(this->File(), texts);
    EXPECT_TRUE(edited);
    EXPECT_EQ(edited->digest, before.digest);
    EXPECT_EQ((*Store::Open(this->File()))->Info().homeView, edited->homeView);
    return *edited->homeView;
  };
  EXPECT_EQ(edit({}, Vec3{ 1, 0, 0 }), (HomeView{ before.homeView->up, { 1, 0, 0 }, false }));
  EXPECT_EQ(edit(before.homeView->up, {}).view, (Vec3{ 1, 0, 0 })) << "the same up: the view stays";
  EXPECT_EQ(edit(Vec3{ 0, 1, 0 }, {}), (HomeView{ { 0, 1, 0 }, { 0, 0, 1 }, false }));
  EXPECT_EQ(edit(Vec3{ 0, 0, -1 }, {}), (HomeView{ { 0, 0, -1 }, { 0, -1, 0 }, false }));
  ASSERT_TRUE(EditStore(this->File(), { "only a title", {}, {}, {} }));
  EXPECT_EQ((*Store::Open(this->File()))->Info().homeView->up, (Vec3{ 0, 0, -1 }));
}

TEST_F(StoreEditTest, AnEditThatFailsChangesNothing)
{
  this->Build(Torus(96, 48), {});
  const std::string whole = this->Bytes();
  Execution cancelled;
  cancelled.progress = [](std::string_view, double) { return false; };
  EXPECT_EQ(
    EditStore(this->File(), { "t", {}, {}, {} }, cancelled).GetError().code, ErrorCode::Cancelled);
  EXPECT_TRUE(this->Bytes() == whole);
  EXPECT_EQ(EditStore(this->File("no.kds"), {}).GetError().code, ErrorCode::NotFound);
  // Another build replaces the store while it is being copied.
  std::string other;
  Execution replacing;
  replacing.progress = [&](std::string_view, double)
  {
    BuildOptions options;
    options.title = "other";
    EXPECT_TRUE(BuildStore(Torus(20, 20), "x", this->File(), options));
    other = this->Bytes();
    return true;
  };
  const auto edited = EditStore(this->File(), { "t", {}, {}, {} }, replacing);
  ASSERT_FALSE(edited);
  EXPECT_NE(edited.GetError().message.find("was replaced"), std::string::npos);
  EXPECT_TRUE(this->Bytes() == other);
  std::ofstream(this->File("text.kds")) << "no store";
  EXPECT_FALSE(EditStore(this->File("text.kds"), { "t", {}, {}, {} }));
  EXPECT_EQ(this->FilesInFolder(), 2U) << "a temporary file is left";
}
