// SPDX-License-Identifier: BSD-3-Clause
// Pieces of textured stores as VTK gets them: texture coordinates, pictures, and each triangle
// once.
#include "filters/codec/TextureTile.h"
#include "filters/store/Store.h"
#include "filters/texture/WritePicture.h"
#include "server/http/HttpServer.h"
#include "server/session/StoreCatalog.h"
#include "viewer/sources/Testing/Cxx/ModelSourceTools.h"

#include <vtkDataArray.h>
#include <vtkErrorCode.h>
#include <vtkImageData.h>
#include <vtkKdStreamSource.h>
#include <vtkKdTextureReader.h>
#include <vtkPointData.h>

#include <cmath>

namespace
{

using namespace kdstream;
using namespace kdstream::testing;
using fixtures::TemporaryFolder;

constexpr std::uint32_t width = 9, height = 5;

// The texture coordinate of a corner, computed from the position of its vertex. Every seventh
// triangle is beyond a seam.
TileCoordinate CornerAt(const Vec3& point, bool beyond)
{
  return { float(std::nearbyint(256 * (point[0] + 2)) / 256),
    float(std::nearbyint(256 * (point[1] + 1.5)) / 256) + (beyond ? 1 : 0) };
}

class SeamTextures : public PieceTextures
{
public:
  TextureDescription Describe() const override { return { "png" }; }
  Result<EncodedTexture> Make(Piece& piece) const override { return TextureOf(piece); }

protected:
  static EncodedTexture TextureOf(const Piece& piece)
  {
    Picture picture{ width, height, 1, {} };
    for (std::uint32_t i = 0; i < width * height; ++i)
    {
      picture.texels.push_back(static_cast<std::uint8_t>(i));
    }
    TextureTile tile{ width, height, TileImage::Png, EncodePicture(picture, PictureType::Png), {} };
    for (std::size_t t = 0; t < piece.triangles.size(); ++t)
    {
      auto& corners = tile.corners.emplace_back();
      for (std::size_t k = 0; k < 3; ++k)
      {
        corners[k] = CornerAt(piece.positions[piece.triangles[t][k]], t % 7 == 0);
      }
    }
    return EncodedTexture{ EncodeTextureTile(tile, piece.triangles), width * height };
  }
};

class SeamTexturesOfLevels : public SeamTextures
{
public:
  TextureDescription Describe() const override
  {
    TextureDescription description{ "png" };
    description.levels = true;
    return description;
  }
  Result<EncodedTexture> MakeOfLevel(const Piece& piece, const FinerPieces&) const override
  {
    return TextureOf(piece);
  }
};

class TestKdTextureReader : public ::testing::Test
{
protected:
  void Build(bool textured, bool levels = false)
  {
    BuildOptions options;
    options.tree.verticesPerPartition = 200;
    options.bits = 0;
    options.textures = levels     ? std::make_shared<SeamTexturesOfLevels>()
                       : textured ? std::make_shared<SeamTextures>()
                                  : nullptr;
    const auto built = BuildStore(this->Sphere, "sphere.ply", this->File, options);
    ASSERT_TRUE(built) << built.GetError().message;
    this->Reader->SetFileName(this->File.c_str());
  }
  std::string Refusal()
  {
    FilterObserver heard(this->Reader);
    this->Reader->Modified();
    this->Reader->Update();
    return heard.error;
  }

  const Mesh Sphere = fixtures::DisplacedSphere(4);
  TemporaryFolder Folder;
  const std::filesystem::path File = this->Folder / "model.kds";
  vtkNew<vtkKdTextureReader> Reader;
};

TEST_F(TestKdTextureReader, PartitionsHaveCoordinatesAndPictures)
{
  this->Build(true);
  this->Reader->UpdateInformation();
  ASSERT_EQ(this->Reader->GetNumberOfModelPartitions(), 8);
  vtkIdType triangles = 0, points = 0;
  for (vtkIdType p = 0; p < this->Reader->GetNumberOfModelPartitions(); ++p)
  {
    this->Reader->SetPartition(p);
    this->Reader->Update();
    vtkPolyData* const surface = this->Reader->GetOutput();
    triangles += surface->GetNumberOfPolys();
    points += surface->GetNumberOfPoints();
    vtkDataArray* const places = surface->GetPointData()->GetTCoords();
    ASSERT_TRUE(places);
    ASSERT_EQ(places->GetNumberOfTuples(), surface->GetNumberOfPoints());
    for (vtkIdType i = 0; i < surface->GetNumberOfPoints(); ++i)
    {
      Vec3 point;
      surface->GetPoint(i, point.data());
      const double u = places->GetComponent(i, 0), v = places->GetComponent(i, 1);
      const TileCoordinate here = CornerAt(point, false), beyond = CornerAt(point, true);
      ASSERT_NEAR(u, here[0] / width, 1e-6);
      ASSERT_TRUE(std::abs(1 - v - double(here[1]) / height) < 1e-6 ||
                  std::abs(1 - v - double(beyond[1]) / height) < 1e-6);
    }
    vtkImageData* const picture = this->Reader->GetPicture();
    ASSERT_EQ(picture->GetDimensions()[0], int(width));
    ASSERT_EQ(picture->GetDimensions()[1], int(height));
    ASSERT_EQ(picture->GetNumberOfScalarComponents(), 3);
    ASSERT_EQ(picture->GetScalarComponentAsDouble(2, 0, 0, 1), (height - 1) * width + 2);
    ASSERT_EQ(picture->GetScalarComponentAsDouble(3, height - 1, 0, 2), 3);
  }
  EXPECT_EQ(triangles, vtkIdType(this->Sphere.triangles.size()));
  EXPECT_GT(points, vtkIdType(this->Sphere.points.size())) << "they are split at seams";
}

TEST_F(TestKdTextureReader, PiecesOfLevelsHaveThemToo)
{
  this->Build(true, true);
  const auto store = Store::Open(this->File);
  ASSERT_TRUE(store);
  const ModelDescription& model = (*store)->Info();
  for (int level = 0; level < int(model.levels.size()); ++level)
  {
    SCOPED_TRACE(level);
    const ResolutionDescription& reported = model.levels[std::size_t(level)];
    this->Reader->SetLevel(level);
    this->Reader->SetPartition(0);
    this->Reader->UpdateInformation();
    ASSERT_EQ(this->Reader->GetNumberOfModelPartitions(), vtkIdType(reported.pieces));
    vtkIdType triangles = 0;
    for (vtkIdType piece = 0; piece < vtkIdType(reported.pieces); ++piece)
    {
      this->Reader->SetPartition(piece);
      this->Reader->Update();
      vtkPolyData* const surface = this->Reader->GetOutput();
      triangles += surface->GetNumberOfPolys();
      vtkDataArray* const places = surface->GetPointData()->GetTCoords();
      ASSERT_TRUE(places);
      ASSERT_EQ(places->GetNumberOfTuples(), surface->GetNumberOfPoints());
      ASSERT_EQ(this->Reader->GetPicture()->GetDimensions()[0], int(width));
    }
    EXPECT_EQ(triangles, vtkIdType(reported.triangles)) << "each once";
  }
  this->Reader->SetPartition(1000);
  EXPECT_NE(this->Refusal().find("there is no piece 1000 of level "), std::string::npos);
  this->Reader->SetLevel(30);
  this->Reader->SetPartition(0);
  EXPECT_NE(
    this->Refusal().find("there is no piece 0 of level 30: there are 0"), std::string::npos);
  this->Build(true);
  this->Reader->SetLevel(0);
  EXPECT_NE(this->Refusal().find("only the original has textures"), std::string::npos);
  this->Reader->SetLevel(-1);
  EXPECT_EQ(this->Refusal(), "");
}

TEST_F(TestKdTextureReader, CanReadTexturedStores)
{
  this->Build(true);
  EXPECT_EQ(this->Reader->CanReadFile(this->File.c_str()), 1);
  this->Build(false);
  EXPECT_EQ(this->Reader->CanReadFile(this->File.c_str()), 0);
  EXPECT_EQ(this->Reader->CanReadFile("/nonexistent.kds"), 0);
}

TEST_F(TestKdTextureReader, AServersModelIsReadOverItsSource)
{
  this->Build(true);
  StoreCatalog models(this->Folder.Path, [](const std::filesystem::path&, const std::string&) {});
  ASSERT_TRUE(models.Reload());
  HttpServerOptions options;
  options.drainTimeout = std::chrono::milliseconds(100);
  const auto server = HttpServer::Start(models, options);
  ASSERT_TRUE(server) << server.GetError().message;
  vtkNew<vtkKdStreamSource> source;
  vtkNew<vtkKdTextureReader> streamed;
  streamed->SetModelSource(source);
  {
    FilterObserver heard(streamed);
    streamed->Update();
    EXPECT_NE(heard.error.find("no Url is set"), std::string::npos) << heard.error;
  }
  source->SetUrl("http://127.0.0.1:" + std::to_string((*server)->Port()));
  for (const vtkIdType partition : { 0, 5 })
  {
    this->Reader->SetPartition(partition);
    this->Reader->Update();
    streamed->SetPartition(partition);
    streamed->Update();
    EXPECT_EQ(Describe(*streamed->GetOutput()), Describe(*this->Reader->GetOutput()));
    for (const int pixel : { 0, 13, int(width * height) - 1 })
    {
      EXPECT_EQ(
        streamed->GetPicture()->GetScalarComponentAsDouble(pixel % width, pixel / width, 0, 0),
        this->Reader->GetPicture()->GetScalarComponentAsDouble(pixel % width, pixel / width, 0, 0));
    }
  }
  // What an abort stopped is read by the next Update.
  for (const bool informationAlone : { false, true })
  {
    streamed->SetPartition(informationAlone ? 7 : 6);
    {
      FilterObserver heard(streamed);
      heard.abortAt = 0;
      informationAlone ? streamed->UpdateInformation() : streamed->Update();
      EXPECT_EQ(heard.error, "");
      EXPECT_EQ(streamed->GetOutput()->GetNumberOfPoints() > 0, informationAlone);
    }
    const vtkMTimeType before = streamed->GetOutput()->GetMTime();
    streamed->Update();
    EXPECT_GT(streamed->GetOutput()->GetNumberOfPoints(), 0);
    EXPECT_GT(streamed->GetOutput()->GetMTime(), before);
  }
}

TEST_F(TestKdTextureReader, SaysWhatIsNotThere)
{
  EXPECT_NE(this->Refusal().find("no FileName is set"), std::string::npos);
  EXPECT_EQ(this->Reader->GetErrorCode(), vtkErrorCode::NoFileNameError);
  this->Build(false);
  EXPECT_NE(this->Refusal().find("the model has no textures"), std::string::npos);
  EXPECT_EQ(this->Reader->GetErrorCode(), vtkErrorCode::UnrecognizedFileTypeError);
  this->Build(true);
  this->Reader->SetPartition(1000);
  EXPECT_NE(this->Refusal().find("there is no partition 1000: the model has "), std::string::npos);
  EXPECT_EQ(this->Reader->GetErrorCode(), vtkErrorCode::UnknownError);
  this->Reader->SetPartition(1);
  EXPECT_EQ(this->Refusal(), "");
  EXPECT_EQ(this->Reader->GetErrorCode(), vtkErrorCode::NoError);
}

}
