// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/ErrorAt.h"
#include "server/session/StoreCatalog.h"

#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/build/Builder.h"
#include "filters/model/ModelJson.h"
#include "filters/model/Notes.h"
#include "filters/protocol/ResourcePath.h"
#include "filters/store/Store.h"
#include "filters/store/Testing/StoreContent.h"
#include "server/http/Testing/ScarceMemory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

using namespace kdstream;
using namespace kdstream::protocol;
namespace fs = std::filesystem;

namespace
{

// A wavy sheet.
Mesh Sheet(std::uint32_t side)
{
  Mesh mesh;
  for (std::uint32_t i = 0; i < side; ++i)
  {
    for (std::uint32_t j = 0; j < side; ++j)
    {
      mesh.points.push_back({ i * 0.25, j * 0.125, std::floor(10 * std::sin(i * 0.1)) });
      if (i > 0 && j > 0)
      {
        const VertexId v = i * side + j;
        mesh.triangles.push_back({ v - side - 1, v - side, v });
        mesh.triangles.push_back({ v - side - 1, v, v - 1 });
      }
    }
  }
  return mesh;
}

class Folder : public testing::Test
{
protected:
  const fixtures::TemporaryFolder temporary;
  const fs::path folder = temporary / "stores";
  std::vector<std::string> reports;
  StoreCatalog catalog{ folder, [this](const fs::path& file, const std::string& what)
    { this->reports.push_back(file.filename().string() + ": " + what); } };

  void SetUp() override { fs::create_directories(this->folder); }

  ModelDescription Build(const std::string& name, std::uint32_t side, const std::string& title = "")
  {
    BuildOptions options;
    options.tree.verticesPerPartition = 200;
    options.title = title;
    auto report = BuildStore(Sheet(side), "sheet.ply", this->folder / name, options);
    EXPECT_TRUE(report) << report.GetError().message;
    return report->info;
  }

  // Flips a byte of the file where it contains these bytes.
  void Damage(const std::string& name, const std::vector<std::uint8_t>& bytes)
  {
    std::fstream file(this->folder / name, std::ios::in | std::ios::out | std::ios::binary);
    const std::string content{ std::istreambuf_iterator<char>(file), {} };
    const std::string part(bytes.begin(), bytes.begin() + std::min<long>(200, std::ssize(bytes)));
    const auto place = content.find(part);
    ASSERT_NE(place, std::string::npos);
    ASSERT_EQ(content.find(part, place + 1), std::string::npos);
    file.seekp(static_cast<std::streamoff>(place + part.size() / 2));
    file.put(static_cast<char>(content[place + part.size() / 2] ^ 1));
  }
};

}

TEST_F(Folder, AnEmptyFolderIsAnEmptyCatalogAndAMissingOneAnError)
{
  ASSERT_TRUE(this->catalog.Reload());
  EXPECT_TRUE(this->catalog.Models().empty());
  fs::remove_all(this->folder);
  for (int looks = 0; looks < 2; ++looks)
  {
    this->catalog.Look();
  }
  EXPECT_EQ(this->reports,
    std::vector<std::string>{
      "stores: there is no such folder; the earlier models are still served" })
    << "once";
  const auto status = this->catalog.Reload();
  ASSERT_FALSE(status);
  EXPECT_EQ(status.GetError().code, ErrorCode::NotFound);
}

TEST_F(Folder, TheListIsWrittenOnceForEachReadingOfTheFolder)
{
  const auto ids = [this]
  {
    const auto json = this->catalog.ListJson();
    const auto list = ParseModelList(std::string(json->begin(), json->end()));
    std::string all;
    for (const auto& model : *list)
    {
      all += model.id + " ";
    }
    return all;
  };
  EXPECT_EQ(ids(), "");
  this->Build("one.kds", 20);
  ASSERT_TRUE(this->catalog.Reload());
  EXPECT_EQ(ids(), "one ");
  EXPECT_EQ(this->catalog.ListJson(), this->catalog.ListJson()) << "the same bytes";
  this->Build("two.kds", 20);
  this->catalog.Look();
  EXPECT_EQ(ids(), "one two ");
  fs::remove(this->folder / "one.kds");
  this->catalog.Look();
  EXPECT_EQ(ids(), "two ");
}

TEST_F(Folder, NotesLieBesideTheStoreAndMayChange)
{
  const auto counted = [this]
  {
    const auto json = this->catalog.ListJson();
    return ParseModelList(std::string(json->begin(), json->end()))->at(0).notes;
  };
  const auto put = [this](const std::string& text)
  {
    std::ofstream(this->folder / "new") << text;
    fs::rename(this->folder / "new", this->folder / "sheet.notes.json");
  };
  this->Build("sheet.kds", 20);
  ASSERT_TRUE(this->catalog.Reload());
  EXPECT_EQ(counted(), 0u);
  EXPECT_EQ(this->catalog.ReadNotes("sheet").GetError().code, ErrorCode::NotFound);

  const auto text = FormatNotes({ { "One", "", "model=sheet" }, { "Two", "", "model=sheet" } });
  put(text);
  this->catalog.Refresh();
  EXPECT_EQ(counted(), 2u);
  const auto notes = this->catalog.ReadNotes("sheet");
  ASSERT_TRUE(notes) << notes.GetError().message;
  EXPECT_EQ(std::string((*notes)->begin(), (*notes)->end()), text) << "as it is";
  EXPECT_TRUE(this->reports.empty());

  put(FormatNotes({ { "One", "", "model=sheet" } }));
  EXPECT_TRUE(this->catalog.ReadNotes("sheet")); // before the folder is looked at
  this->catalog.Refresh();
  EXPECT_EQ(counted(), 1u);

  for (const auto& [wrong, what] :
    std::vector<std::pair<std::string, std::string>>{ { "{}", "notes: \"type\" is missing" },
      { std::string(maximumNotesBytes + 1, ' '),
        "the notes are too large: at most 262144 bytes together" } })
  {
    this->reports.clear();
    put(wrong);
    for (int times = 0; times < 3; ++times)
    {
      this->catalog.Refresh();
      EXPECT_EQ(this->catalog.ReadNotes("sheet").GetError().code, ErrorCode::NotFound);
    }
    EXPECT_EQ(counted(), 0u);
    EXPECT_EQ(this->reports,
      std::vector{ "sheet.notes.json: " + what + "; the model is served without notes" })
      << "once for each change";
  }
  this->reports.clear();
  fs::remove(this->folder / "sheet.notes.json");
  this->catalog.Refresh();
  fs::create_directory(this->folder / "sheet.notes.json");
  this->catalog.Refresh();
  EXPECT_EQ(this->catalog.ReadNotes("sheet").GetError().code, ErrorCode::NotFound);
  EXPECT_EQ(
    this->reports, std::vector<std::string>{
                     "sheet.notes.json: is not a file; the model is served without notes" });
}

TEST_F(Folder, DescribesAndReadsAStore)
{
  const auto info = this->Build("sheet-1.kds", 60, "A sheet");
  ASSERT_TRUE(this->catalog.Reload());
  const auto model = this->catalog.Find("sheet-1");
  ASSERT_TRUE(model);
  EXPECT_EQ(this->catalog.Models().size(), 1u);
  EXPECT_FALSE(this->catalog.Find("sheet-1.kds"));
  EXPECT_TRUE(this->reports.empty());

  const auto& reported = model->Description();
  EXPECT_EQ(reported.digest, info.digest);
  EXPECT_EQ(reported.title, "A sheet");
  EXPECT_EQ(reported.vertices, 3600u);
  EXPECT_EQ(reported.partitions, info.partitions);
  EXPECT_EQ(reported.depths, info.depths);
  EXPECT_EQ(reported.box, info.box);
  EXPECT_EQ(reported.grid, info.grid);
  ASSERT_EQ(reported.levels.size(), info.levels.size());
  EXPECT_EQ(reported.levels[9].vertices, info.levels[9].vertices);
  EXPECT_EQ(reported.original.bytes, info.original.bytes);

  const auto store = Store::Open(this->folder / "sheet-1.kds");
  ASSERT_TRUE(store);
  for (const auto& id : (*store)->PieceIds())
  {
    const auto blob =
      id.resolution.IsOriginal()
        ? BlobId::Partition(id.node - (1u << info.depths.partition))
        : BlobId::LevelPiece(static_cast<std::uint8_t>(id.resolution.Depth()), id.node);
    const auto size = model->BlobSize(blob);
    const auto bytes = model->ReadBlob(blob);
    ASSERT_TRUE(bytes) << BlobName(blob);
    EXPECT_EQ(size.Value(), (*bytes)->size());
    EXPECT_EQ(model->BlobSize(blob).Value(), (*bytes)->size()) << "from the cache";
    EXPECT_EQ(*model->ReadBlob(blob), *bytes) << "read again";
    EXPECT_EQ(**bytes, *(*store)->Read(BlobOfPiece(id, (*store)->Info().depths)));
  }
  EXPECT_TRUE(model->ReadBlob(BlobId::TreePage(1)));
  const auto boxes = model->Boxes();
  ASSERT_TRUE(boxes);
  EXPECT_EQ((*boxes)[1], info.box);
}

// A texture of a few bytes for each partition.
class SmallTextures : public PieceTextures
{
public:
  TextureDescription Describe() const override { return { "webp", true }; }
  Result<EncodedTexture> Make(Piece& piece) const override
  {
    const auto node = static_cast<std::uint8_t>(piece.id.node);
    return EncodedTexture{ { 1, 2, node }, 100 };
  }
};

TEST_F(Folder, TexturesAreReadLikePartitions)
{
  BuildOptions options;
  options.tree.verticesPerPartition = 200;
  options.textures = std::make_shared<SmallTextures>();
  const auto report = BuildStore(Sheet(60), "sheet.ply", this->folder / "painted.kds", options);
  ASSERT_TRUE(report) << report.GetError().message;
  ASSERT_TRUE(this->catalog.Reload());
  const auto model = this->catalog.Find("painted");
  ASSERT_TRUE(model);
  const auto& reported = model->Description();
  ASSERT_TRUE(reported.textures);
  EXPECT_EQ(*reported.textures,
    (TextureDescription{ "webp", true, 3 * reported.partitions, 100 * reported.partitions }));
  for (std::uint32_t p = 0; p < reported.partitions; ++p)
  {
    EXPECT_EQ(model->BlobSize(BlobId::Texture(p)).Value(), 3u);
    const auto bytes = model->ReadBlob(BlobId::Texture(p));
    ASSERT_TRUE(bytes);
    EXPECT_EQ((*bytes)->back(), std::uint8_t(p + reported.partitions));
  }
  const auto missing = static_cast<std::uint32_t>(reported.partitions);
  EXPECT_EQ(model->ReadBlob(BlobId::Texture(missing)).GetError().code, ErrorCode::NotFound);
  // A permission for less detail does not list textures.
  EXPECT_FALSE(WithDetail(reported, ModelDetail::Levels).textures);
  // A plain model has no textures.
  this->Build("plain.kds", 20);
  ASSERT_TRUE(this->catalog.Reload());
  EXPECT_EQ(
    this->catalog.Find("plain")->ReadBlob(BlobId::Texture(0)).GetError().code, ErrorCode::NotFound);
}

// With as many attributes, and as long names, as a store can hold, clients must still accept the
// description.
TEST_F(Folder, ReportsEveryAttribute)
{
  Mesh mesh = Sheet(30);
  for (std::size_t i = 0; i < mostAttributes; ++i)
  {
    const std::string number = std::to_string(i);
    Attribute attribute;
    attribute.name = std::string(longestAttributeName - number.size(), '"') + number;
    attribute.type = static_cast<AttributeType>(i % 10);
    attribute.components = static_cast<std::uint8_t>(1 + i % 3);
    const bool points = i % 2 == 0;
    attribute.association = points ? AttributeAssociation::Point : AttributeAssociation::Cell;
    attribute.values.resize(
      attribute.TupleSize() * (points ? mesh.points.size() : mesh.triangles.size()));
    mesh.attributes.push_back(attribute);
  }
  const auto report = BuildStore(mesh, "sheet.ply", this->folder / "many.kds", {});
  ASSERT_TRUE(report) << report.GetError().message;
  ASSERT_TRUE(this->catalog.Reload());
  const auto model = this->catalog.Find("many");
  ASSERT_TRUE(model);
  const std::string json = WriteModel(model->Description());
  const auto reported = ParseModel(json);
  ASSERT_TRUE(reported) << reported.GetError().message;
  ASSERT_EQ(reported->attributes.size(), mostAttributes);
  for (std::size_t i = 0; i < mostAttributes; ++i)
  {
    const AttributeInfo& info = report->info.attributes[i];
    const auto& attribute = reported->attributes[i];
    EXPECT_EQ(attribute.name, info.name);
    EXPECT_EQ(attribute.type, info.type);
    EXPECT_EQ(attribute.association, info.association);
    EXPECT_EQ(attribute.components, info.components);
  }
}

TEST_F(Folder, WhatAModelDoesNotHaveIsNotFound)
{
  const auto info = this->Build("sheet.kds", 60);
  ASSERT_TRUE(this->catalog.Reload());
  const auto model = this->catalog.Find("sheet");
  for (const auto blob : { BlobId::TreePage(2), BlobId::TreePage(1u << 11),
         BlobId::PartitionBoxes(2), BlobId::Partition(static_cast<std::uint32_t>(info.partitions)),
         BlobId::Partition((1u << 30) - 1), BlobId::LevelPiece(3, 2),
         BlobId::LevelPiece(static_cast<std::uint8_t>(info.depths.finest + 1), 1),
         BlobId::LevelPiece(30, (1u << 31) - 1) })
  {
    const auto bytes = model->ReadBlob(blob);
    ASSERT_FALSE(bytes) << BlobName(blob);
    EXPECT_EQ(model->BlobSize(blob).GetError().code, ErrorCode::NotFound) << BlobName(blob);
    EXPECT_EQ(bytes.GetError().code, ErrorCode::NotFound) << BlobName(blob);
  }
  EXPECT_TRUE(this->reports.empty());
}

TEST_F(Folder, WhatIsNotAStoreIsReportedAndLeftOut)
{
  this->Build("good.kds", 20);
  fs::copy(this->folder / "good.kds", this->folder / "bad name.kds");
  std::ofstream(this->folder / "broken.kds") << "nonsense";
  std::ofstream(this->folder / "empty.kds");
  std::ofstream(this->folder / "notes.txt") << "of no interest";
  fs::create_directories(this->folder / "folder.kds");
  ASSERT_TRUE(this->catalog.Reload());
  EXPECT_EQ(this->catalog.Models().size(), 1u);
  ASSERT_EQ(this->reports.size(), 4u);
  EXPECT_EQ(this->reports[0].substr(0, 13), "bad name.kds:");
  EXPECT_EQ(this->reports[1].substr(0, 11), "broken.kds:");
  EXPECT_EQ(this->reports[2].substr(0, 10), "empty.kds:");
  EXPECT_EQ(this->reports[3].substr(0, 11), "folder.kds:");
}

TEST_F(Folder, ADamagedBlobIsReportedOnceAndTheRestIsRead)
{
  this->Build("sheet.kds", 60);
  ASSERT_TRUE(this->catalog.Reload());
  const auto whole = *this->catalog.Find("sheet")->ReadBlob(BlobId::Partition(3));
  this->Damage("sheet.kds", *whole);
  ASSERT_TRUE(this->catalog.Reload());
  const auto model = this->catalog.Find("sheet");
  ASSERT_TRUE(model);
  for (int i = 0; i < 3; ++i)
  {
    const auto blob = model->ReadBlob(BlobId::Partition(3));
    ASSERT_FALSE(blob);
    EXPECT_EQ(blob.GetError().code, ErrorCode::Damaged);
  }
  EXPECT_TRUE(model->ReadBlob(BlobId::Partition(2)));
  EXPECT_TRUE(model->ReadBlob(BlobId::LevelPiece(5, 1)));
  EXPECT_TRUE(model->Boxes());
  ASSERT_EQ(this->reports.size(), 1u);
  EXPECT_NE(this->reports[0].find("sheet.kds: "), std::string::npos);
  EXPECT_NE(this->reports[0].find("partitions/3"), std::string::npos) << this->reports[0];
}

// The description in the store has no id at its beginning, but a build at its end.
TEST_F(Folder, WhatIsReportedIsWhatTheStoreKeeps)
{
  this->Build("sheet.kds", 40, "A \"sheet\"");
  ASSERT_TRUE(this->catalog.Reload());
  const auto json = this->catalog.Find("sheet")->Json(ModelDetail::Regions);
  const std::string reported(json->begin(), json->end()), begin = "{\"id\":\"sheet\",";
  const std::string kept = fixtures::Metadata(this->folder / "sheet.kds");
  ASSERT_EQ(reported.substr(0, begin.size()), begin);
  EXPECT_EQ(kept.substr(0, kept.find(",\"build\":{")) + "}", "{" + reported.substr(begin.size()));
}

// Each request for a tile needs the hash, and the description may be as large as 1 MiB.
TEST_F(Folder, ADescriptionIsHashedOnce)
{
  this->Build("sheet.kds", 40, "A sheet");
  ASSERT_TRUE(this->catalog.Reload());
  const auto model = this->catalog.Find("sheet");
  static int calls = 0;
  const auto hash = [](const std::vector<std::uint8_t>& json)
  { return std::to_string(++calls) + " of " + std::to_string(json.size()); };
  const std::string first = model->JsonHash(hash);
  EXPECT_EQ(first, "1 of " + std::to_string(model->Json()->size()));
  EXPECT_EQ(model->JsonHash(hash), first);
}

// A blob without bytes is damaged even if its checksum is correct.
TEST_F(Folder, ABlobOfNoBytesIsDamaged)
{
  this->Build("sheet.kds", 40);
  {
    fixtures::StoreContent content(this->folder / "sheet.kds");
    content.Replace("partitions/0", {});
    content.Write();
  }
  ASSERT_TRUE(this->catalog.Reload());
  const auto model = this->catalog.Find("sheet");
  ASSERT_TRUE(model);
  const auto blob = model->ReadBlob(BlobId::Partition(0));
  EXPECT_TRUE(fixtures::FailsAt(blob, ErrorCode::Damaged, "partitions/0"));
  const auto size = model->BlobSize(BlobId::Partition(0));
  ASSERT_FALSE(size);
  EXPECT_EQ(size.GetError().code, ErrorCode::Damaged);
  EXPECT_TRUE(model->ReadBlob(BlobId::Partition(1)));
}

// Fuzz targets start from these stores. A new version of the store format needs new ones
// (WriteSmallStores).
TEST_F(Folder, TheSmallStoresThatAreKeptAreWhole)
{
  std::size_t stores = 0;
  for (const auto& entry : fs::directory_iterator(KDSTREAM_SMALL_STORES))
  {
    const auto store = Store::Open(entry.path());
    ASSERT_TRUE(store) << entry.path() << store.GetError().message;
    EXPECT_TRUE((*store)->Verify().empty()) << entry.path();
    ++stores;
  }
  EXPECT_EQ(stores, 10u);
}

TEST_F(Folder, DamagedBoxesAreReportedAndForbidRegionsOnly)
{
  this->Build("sheet.kds", 60);
  ASSERT_TRUE(this->catalog.Reload());
  const BlobId boxes = BlobId::PartitionBoxes(1);
  const auto whole = *this->catalog.Find("sheet")->ReadBlob(boxes);
  this->Damage("sheet.kds", *whole);
  ASSERT_TRUE(this->catalog.Reload());
  const auto model = this->catalog.Find("sheet");
  ASSERT_TRUE(model);
  EXPECT_FALSE(model->Boxes());
  EXPECT_FALSE(model->ReadBlob(boxes));
  EXPECT_TRUE(model->ReadBlob(BlobId::TreePage(1)));
  EXPECT_TRUE(model->ReadBlob(BlobId::Partition(2)));
  ASSERT_FALSE(this->reports.empty());
  EXPECT_NE(this->reports[0].find("boxes/1"), std::string::npos) << this->reports[0];
}

TEST_F(Folder, AReloadKeepsWhatHasNotChangedAndWhatCannotBeReplaced)
{
  this->Build("same.kds", 30);
  this->Build("sheet.kds", 60);
  ASSERT_TRUE(this->catalog.Reload());
  const auto same = this->catalog.Find("same"), sheet = this->catalog.Find("sheet");
  std::ofstream(this->folder / "broken") << "nonsense";
  fs::rename(this->folder / "broken", this->folder / "sheet.kds");
  for (int i = 1; i <= 2; ++i)
  {
    ASSERT_TRUE(this->catalog.Reload());
    EXPECT_EQ(this->catalog.Find("same"), same) << "opened again";
    EXPECT_EQ(this->catalog.Find("sheet"), sheet) << "given up";
    ASSERT_EQ(this->reports.size(), static_cast<std::size_t>(i));
    EXPECT_EQ(
      this->reports.back(), "sheet.kds: not a KdStream store; the earlier store is still served");
    this->catalog.Refresh();
    EXPECT_EQ(this->reports.size(), static_cast<std::size_t>(i)) << "told twice";
  }
  EXPECT_TRUE(sheet->ReadBlob(BlobId::Partition(0)));
}

// A store that vanishes while the folder is read counts as removed; nothing more is reported.
TEST_F(Folder, AStoreThatGoesWhileTheFolderIsReadIsGone)
{
  std::ofstream(this->folder / "first.kds") << "nonsense";
  this->Build("going.kds", 30);
  fs::create_symlink(this->folder / "nowhere", this->folder / "leading.kds");
  StoreCatalog watched(this->folder,
    [this](const fs::path& file, const std::string& what)
    {
      this->reports.push_back(file.filename().string() + ": " + what);
      fs::remove(this->folder / "going.kds");
    });
  const std::vector<std::string> reported{
    "first.kds: not a KdStream store; this store is left out, the others are served",
    "leading.kds: no such file; this store is left out, the others are served"
  };
  ASSERT_TRUE(watched.Reload());
  EXPECT_EQ(this->reports, reported);
  EXPECT_FALSE(watched.Find("going"));
  // The same for a store that is already served.
  fs::remove(this->folder / "first.kds");
  this->Build("going.kds", 30);
  ASSERT_TRUE(watched.Reload());
  EXPECT_TRUE(watched.Find("going"));
  this->Build("going.kds", 30); // it was removed when the link was reported
  std::ofstream(this->folder / "first.kds") << "nonsense";
  this->reports.clear();
  ASSERT_TRUE(watched.Reload());
  EXPECT_EQ(this->reports, reported);
  EXPECT_FALSE(watched.Find("going"));
}

TEST_F(Folder, AnOverwrittenStoreIsOpenedAgain)
{
  this->Build("sheet.kds", 60);
  const auto other = this->Build("other", 40);
  ASSERT_TRUE(this->catalog.Reload());
  const auto old = this->catalog.Find("sheet");
  this->catalog.Refresh();
  EXPECT_EQ(this->catalog.Find("sheet"), old);
  {
    std::ifstream in(this->folder / "other", std::ios::binary);
    std::ofstream out(this->folder / "sheet.kds", std::ios::binary);
    out << in.rdbuf();
  }
  EXPECT_EQ(old->CheckUnchanged().GetError().code, ErrorCode::Changed);
  EXPECT_EQ(old->ReadBlob(BlobId::Partition(0)).GetError().code, ErrorCode::Changed);
  EXPECT_TRUE(this->reports.empty()) << "that is no damage";
  this->catalog.Refresh();
  const auto found = this->catalog.Find("sheet");
  ASSERT_TRUE(found);
  EXPECT_EQ(found->Description().digest, other.digest);
  EXPECT_TRUE(found->CheckUnchanged());
}

// The folder that is served does not change at all.
TEST_F(Folder, AStoreThatALinkLeadsToIsSeenWhenItIsReplaced)
{
  const auto elsewhere = this->temporary / "elsewhere.kds", next = this->temporary / "next.kds";
  this->Build("one", 60);
  fs::rename(this->folder / "one", elsewhere);
  fs::create_symlink(elsewhere, this->folder / "sheet.kds");
  ASSERT_TRUE(this->catalog.Reload());
  const auto old = this->catalog.Find("sheet");
  ASSERT_TRUE(old);
  const auto other = this->Build("other", 40);
  fs::rename(this->folder / "other", next);
  this->catalog.Refresh();
  EXPECT_EQ(this->catalog.Find("sheet"), old);
  fs::rename(next, elsewhere);
  this->catalog.Refresh();
  EXPECT_EQ(this->catalog.Find("sheet")->Description().digest, other.digest);
  EXPECT_EQ(this->catalog.FindDigest("sheet", old->Description().digest), old) << "in its grace";
}

// A new name or permission shows that something has happened to the file. To find out whether its
// content has changed, the file must be read, which callers that never wait leave to others.
TEST_F(Folder, WhatTakesADiskIsNotReportedWithoutOne)
{
  this->Build("sheet.kds", 60);
  ASSERT_TRUE(this->catalog.Reload());
  const auto model = this->catalog.Find("sheet");
  const auto blob = *model->ReadBlob(BlobId::Partition(0));
  EXPECT_EQ(model->FindBlob(BlobId::Partition(0)), blob);
  EXPECT_EQ(model->LooksUnchanged(), std::optional(true));
  fs::create_hard_link(this->folder / "sheet.kds", this->temporary / "again");
  EXPECT_EQ(model->LooksUnchanged(), std::nullopt);
  EXPECT_FALSE(model->FindBlob(BlobId::Partition(0)));
  EXPECT_EQ(*model->ReadBlob(BlobId::Partition(0)), blob);
  EXPECT_EQ(model->LooksUnchanged(), std::optional(true));
  EXPECT_EQ(model->FindBlob(BlobId::Partition(0)), blob);
  fs::resize_file(this->folder / "sheet.kds", 4096);
  EXPECT_EQ(model->LooksUnchanged(), std::optional(false));
  EXPECT_FALSE(model->FindBlob(BlobId::Partition(0)));
}

TEST_F(Folder, AFolderThatIsGoneForAMomentIsReadAgain)
{
  this->Build("sheet.kds", 20);
  ASSERT_TRUE(this->catalog.Reload());
  const auto away = fs::path(this->folder) += "-away";
  fs::rename(this->folder, away);
  EXPECT_FALSE(this->catalog.Reload());
  EXPECT_TRUE(this->catalog.Find("sheet"));
  fs::rename(away, this->folder);
  this->Build("other.kds", 20);
  this->catalog.Refresh();
  EXPECT_TRUE(this->catalog.Find("other"));
}

// Each allocation of a reload fails in its turn. A store is added and removed by a link, because
// changing the store itself would require waiting.
TEST_F(Folder, WantOfMemoryAtAReloadChangesNothingAndPasses)
{
  this->Build("same.kds", 30);
  const auto more = this->temporary / "more", link = this->temporary / "link";
  fs::create_directory(more);
  fs::create_hard_link(this->folder / "same.kds", more / "same.kds");
  this->Build("new", 20);
  fs::rename(this->folder / "new", more / "new.kds");
  const auto lead = [&](const fs::path& target)
  {
    fs::create_directory_symlink(target, this->temporary / "next");
    fs::rename(this->temporary / "next", link);
  };
  lead(this->folder);
  StoreCatalog linked(link, [](const fs::path&, const std::string&) {});
  ASSERT_TRUE(linked.Reload());
  const auto same = linked.Find("same");
  bool failed = true;
  for (long tried = 0; failed; ++tried)
  {
    lead(more);
    Status status;
    {
      const ScarceMemory scarce(tried, ScarceMemory::Where::Everywhere);
      status = linked.Reload();
      failed = scarce.HasFailed();
    }
    EXPECT_TRUE(status || status.GetError().code == ErrorCode::LimitExceeded) << tried;
    EXPECT_EQ(linked.Find("same"), same) << tried;
    linked.Refresh(); // there is memory again
    EXPECT_TRUE(linked.Find("new")) << tried;
    lead(this->folder);
    ASSERT_TRUE(linked.Reload());
    EXPECT_FALSE(linked.Find("new"));
  }
  EXPECT_TRUE(same->ReadBlob(BlobId::Partition(0)));
}

TEST_F(Folder, AReplacedModelIsFoundByItsDigestForAWhile)
{
  StoreCatalog hasty(this->folder, [](const fs::path&, const std::string&) {}, {});
  const auto first = this->Build("sheet.kds", 60).digest;
  ASSERT_TRUE(this->catalog.Reload() && hasty.Reload());
  const auto second = this->Build("sheet.kds", 40).digest;
  ASSERT_TRUE(this->catalog.Reload() && hasty.Reload());
  EXPECT_EQ(this->catalog.FindDigest("sheet", second), this->catalog.Find("sheet"));
  const auto replaced = this->catalog.FindDigest("sheet", first);
  ASSERT_TRUE(replaced);
  EXPECT_TRUE(replaced->ReadBlob(BlobId::Partition(0)));
  EXPECT_FALSE(this->catalog.FindDigest("other", first));
  EXPECT_FALSE(this->catalog.FindDigest("sheet", "0"));
  EXPECT_FALSE(hasty.FindDigest("sheet", first)) << "without a grace";
  for (const std::uint32_t side : { 20, 25, 30, 35 })
  {
    this->Build("sheet.kds", side);
    ASSERT_TRUE(this->catalog.Reload());
  }
  EXPECT_FALSE(this->catalog.FindDigest("sheet", first)) << "the oldest of too many";
  EXPECT_TRUE(this->catalog.FindDigest("sheet", second));
  fs::remove(this->folder / "sheet.kds");
  ASSERT_TRUE(this->catalog.Reload());
  EXPECT_FALSE(this->catalog.FindDigest("sheet", second)) << "what is removed is gone at once";
}

TEST_F(Folder, ReloadingSeesNewStoresAndKeepsTheOldForWhoHoldsThem)
{
  this->Build("sheet.kds", 60);
  ASSERT_TRUE(this->catalog.Reload());
  const auto old = this->catalog.Find("sheet");
  const auto before = *old->ReadBlob(BlobId::Partition(0));
  this->Build("sheet.kds", 40); // another file under the name
  this->Build("other.kds", 20);
  EXPECT_EQ(this->catalog.Find("sheet"), old);
  ASSERT_TRUE(this->catalog.Reload());
  EXPECT_EQ(this->catalog.Models().size(), 2u);
  EXPECT_NE(this->catalog.Find("sheet")->Description().digest, old->Description().digest);
  const auto after = old->ReadBlob(BlobId::Partition(0));
  ASSERT_TRUE(after);
  EXPECT_EQ(**after, *before);
  fs::remove(this->folder / "sheet.kds");
  ASSERT_TRUE(this->catalog.Reload());
  EXPECT_FALSE(this->catalog.Find("sheet"));
}

TEST_F(Folder, AStoreThatIsCutOffInPlaceIsNotCalledServed)
{
  this->Build("a.kds", 20);
  ASSERT_TRUE(this->catalog.Reload());
  fs::resize_file(this->folder / "a.kds", fs::file_size(this->folder / "a.kds") / 2);
  ASSERT_TRUE(this->catalog.Reload());
  ASSERT_EQ(this->reports.size(), 1u);
  EXPECT_NE(
    this->reports[0].find("; clients get the error that it is damaged until the store is complete"),
    std::string::npos)
    << this->reports[0];
  const auto status = this->catalog.Find("a")->CheckUnchanged();
  ASSERT_FALSE(status);
  EXPECT_EQ(status.GetError().code, ErrorCode::Damaged);
  EXPECT_TRUE(this->catalog.Models().empty()) << "nor is it listed";
  const auto list = this->catalog.ListJson();
  EXPECT_TRUE(ParseModelList(std::string(list->begin(), list->end()))->empty());
  this->Build("a.kds", 20);
  ASSERT_TRUE(this->catalog.Reload());
  EXPECT_TRUE(this->catalog.Find("a")->CheckUnchanged());
  EXPECT_EQ(this->catalog.Models().size(), 1u);
}

// While the file may still be being written, the server waits, for a few seconds.
TEST_F(Folder, AStoreThatWasCutOffAMomentAgoIsWaitedForThenDamaged)
{
  this->Build("a.kds", 20);
  ASSERT_TRUE(this->catalog.Reload());
  const auto file = this->folder / "a.kds";
  fs::resize_file(file, fs::file_size(file) / 2);
  this->catalog.Look();
  EXPECT_EQ(this->catalog.Find("a")->CheckUnchanged().GetError().code, ErrorCode::Changed);
  EXPECT_TRUE(this->reports.empty());
  fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::seconds(4));
  this->catalog.Refresh();
  EXPECT_EQ(this->catalog.Find("a")->CheckUnchanged().GetError().code, ErrorCode::Damaged);
  EXPECT_EQ(this->reports.size(), 1u);
}
