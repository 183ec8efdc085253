// SPDX-License-Identifier: BSD-3-Clause
// An old store, whose levels do not have the numbers of vertices (as levels have now). It is shown
// like any other store, from this machine and from a server, but cannot be coloured by these
// numbers.
#include "Testing/Fixtures/Meshes.h"
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/build/Builder.h"
#include "filters/store/Testing/OldStore.h"
#include "server/http/HttpServer.h"
#include "server/session/StoreCatalog.h"
#include "viewer/client/LocalClient.h"
#include "viewer/client/ServerClient.h"
#include "viewer/client/Testing/SettledSession.h"
#include "viewer/session/appearance/Coloring.h"

#include <gtest/gtest.h>

using namespace kdstream;
using namespace kdstream::fixtures;
using kdstream::testing::Settle;

namespace
{

class TestOldStores : public ::testing::Test
{
protected:
  void SetUp() override
  {
    Mesh mesh = Torus(96, 48);
    Attribute intensity{ { "intensity", AttributeType::Float32, AttributeAssociation::Point, 1 },
      std::vector<std::uint8_t>(4 * mesh.points.size()) };
    for (std::size_t i = 0; i < mesh.points.size(); ++i)
    {
      intensity.Set(i, 0, mesh.points[i][0]);
    }
    this->Triangles = mesh.triangles.size();
    mesh.attributes.push_back(std::move(intensity));
    BuildOptions options;
    options.tree.verticesPerPartition = 200;
    const auto built = BuildStore(mesh, "torus.ply", this->Now(), options);
    ASSERT_TRUE(built) << built.GetError().message;
    ASSERT_EQ(built->info.scalars.size(), 1U);
    std::filesystem::create_directory(this->Folder / "old");
    WriteOldStore(this->Now(), this->Old());
  }

  std::filesystem::path Now() const { return this->Folder / "now.kds"; }
  std::filesystem::path Old() const { return this->Folder / "old" / "torus.kds"; }

  // Checks that preview, level, a region of the original, and all of the original are shown.
  void ExpectShown(ModelSource& source)
  {
    ASSERT_EQ(source.Models().size(), 1U);
    ViewerSession session;
    session.Resize({ 800, 600, 1 });
    session.SetModels(source.Models());
    const auto expect = [&](const char* what)
    {
      SCOPED_TRACE(what);
      ASSERT_TRUE(Settle(session, source));
      const ViewerScene scene = session.Scene();
      EXPECT_EQ(session.GetStatus().error, "");
      EXPECT_GT(session.GetStatus().triangles, 1000U);
      EXPECT_TRUE(scene.scalars.empty());
      const ColorChoice asked{ SurfaceColoring::Attribute, "intensity" };
      EXPECT_EQ(ColoringOf(asked, scene.scalars).kind, SurfaceColoring::Own);
    };
    ASSERT_TRUE(session.SelectModel(source.Models()[0].id));
    expect("preview");
    session.SetDetail(DetailMode::Level);
    session.EnterFullScreen();
    expect("level");
    for (const double time : { 1.0, 1.15 })
    {
      session.HandleTouches({ time, { { 1, 550.0, 300.0 } } });
      session.HandleTouches({ time + 0.05, {} });
    }
    expect("region");
    EXPECT_FALSE(session.RegionBoxes().empty()) << "the tap beside the hole hits";
    session.SetDetail(DetailMode::Full);
    expect("all");
    EXPECT_EQ(session.GetStatus().triangles, this->Triangles);
  }

  TemporaryFolder Folder;
  std::size_t Triangles = 0;
};

}

TEST_F(TestOldStores, AreWholeAndTheirOriginalHasItsArrays)
{
  const auto store = Store::Open(this->Old());
  ASSERT_TRUE(store) << store.GetError().message;
  EXPECT_TRUE((*store)->Info().scalars.empty());
  for (const PieceId id : (*store)->PieceIds())
  {
    const auto piece = (*store)->ReadPiece(id);
    ASSERT_TRUE(piece) << piece.GetError().message;
    EXPECT_EQ(piece->attributes.size(), id.resolution.IsOriginal() ? 1U : 0U);
  }
  for (const Error& error : (*store)->Verify())
  {
    ADD_FAILURE() << error.message;
  }
}

TEST_F(TestOldStores, AreShownFromThisMachine)
{
  const auto source = LocalClient::Open(this->Old());
  ASSERT_TRUE(source) << source.GetError().message;
  this->ExpectShown(**source);
}

TEST_F(TestOldStores, AreServed)
{
  StoreCatalog catalog(this->Folder / "old",
    [](const std::filesystem::path& file, const std::string& what)
    { ADD_FAILURE() << file << ": " << what; });
  ASSERT_TRUE(catalog.Reload());
  const auto server = HttpServer::Start(catalog, {});
  ASSERT_TRUE(server) << server.GetError().message;
  const auto client = ServerClient::Connect((*server)->Url());
  ASSERT_TRUE(client) << client.GetError().message;
  this->ExpectShown(**client);
}
