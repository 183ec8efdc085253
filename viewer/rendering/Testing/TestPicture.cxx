// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/ErrorAt.h"
#include "viewer/rendering/Testing/RenderTools.h"

#include <vtkImageData.h>
#include <vtkPNGReader.h>

#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

namespace kdstream::test
{
namespace
{

// Each test has a folder of its own, which is removed afterwards.
class PictureTest : public ::testing::Test
{
protected:
  void SetUp() override
  {
    this->Folder = std::filesystem::temp_directory_path() /
                   ("kdstream-picture-" + std::to_string(std::random_device{}()));
    std::filesystem::create_directory(this->Folder);
  }
  void TearDown() override { std::filesystem::remove_all(this->Folder); }

  std::filesystem::path Folder;
};

// A stage whose upper half shows stone and whose lower half shows the background.
Stage HalfStage()
{
  Stage stage(WindowBackend::OsMesa, 61, 40);
  Surface plane;
  plane.points = { { -50, 0, 0 }, { 50, 0, 0 }, { 50, 50, 0 }, { -50, 50, 0 } };
  plane.sources.resize(4);
  plane.triangles = { { 0, 1, 2 }, { 0, 2, 3 } };
  EXPECT_TRUE(stage.scene->Update(plane, depths, { 0, 0, 0 }));
  EXPECT_TRUE(stage.scene->SetCamera({ { 0, 0, 4 }, { 0, 0, 0 }, { 0, 1, 0 }, 0.5 }));
  return stage;
}

TEST_F(PictureTest, StartsAtTheTop)
{
  const WindowPicture picture = HalfStage().Draw();
  ASSERT_EQ(picture.width, 61);
  ASSERT_EQ(picture.height, 40);
  ASSERT_EQ(picture.rgb.size(), 61u * 40u * 3u);
  EXPECT_GT(Brightness(PixelAt(picture, 30, 5)), 1.3 * Brightness(PixelAt(picture, 30, 35)));
}

TEST_F(PictureTest, IsTheSameInAPngFile)
{
  const Stage stage = HalfStage();
  const std::string file = this->Folder / "half.png";
  std::ofstream(file) << "what was there before";
  const Status status = WritePng(*stage.window, file);
  ASSERT_TRUE(status) << status.GetError().message;

  const vtkNew<vtkPNGReader> reader;
  ASSERT_EQ(reader->CanReadFile(file.c_str()), 3);
  reader->SetFileName(file.c_str());
  reader->Update();
  const vtkImageData* read = reader->GetOutput();
  const WindowPicture picture = stage.Draw();
  ASSERT_EQ(reader->GetOutput()->GetDimensions()[0], picture.width);
  ASSERT_EQ(reader->GetOutput()->GetDimensions()[1], picture.height);
  ASSERT_EQ(reader->GetOutput()->GetNumberOfScalarComponents(), 3);
  ASSERT_NE(read, nullptr);
  for (int y = 0; y < picture.height; ++y)
  {
    for (int x = 0; x < picture.width; ++x)
    {
      const auto* pixel = static_cast<const unsigned char*>(
        reader->GetOutput()->GetScalarPointer(x, picture.height - 1 - y, 0));
      const std::array<int, 3> expected{ pixel[0], pixel[1], pixel[2] };
      ASSERT_EQ(PixelAt(picture, x, y), expected) << x << ", " << y;
    }
  }
  // No other file was left.
  const auto files = std::filesystem::directory_iterator(this->Folder);
  EXPECT_EQ(std::distance(begin(files), end(files)), 1);
}

TEST_F(PictureTest, SaysWhyAFileCannotBeWritten)
{
  const Stage stage = HalfStage();
  const std::string nowhere = this->Folder / "missing" / "half.png";
  const Status missing = WritePng(*stage.window, nowhere);
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.GetError().code, ErrorCode::InputOutput);
  EXPECT_NE(missing.GetError().message.find(nowhere), std::string::npos);
  EXPECT_NE(missing.GetError().message.find("No such file or directory"), std::string::npos);

  const std::string folder = this->Folder / "folder.png";
  std::filesystem::create_directories(folder + "/inside");
  const Status taken = WritePng(*stage.window, folder);
  ASSERT_FALSE(taken);
  EXPECT_NE(taken.GetError().message.find(folder), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder + ".part"));
}

TEST_F(PictureTest, SaysThatADiskIsFull)
{
  const Stage stage = HalfStage();
  const std::string file = this->Folder / "half.png";
  // A limit for the size of files acts like a full disk.
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit little{ 10, before.rlim_max };
  setrlimit(RLIMIT_FSIZE, &little);
  const Status status = WritePng(*stage.window, file);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_TRUE(fixtures::FailsAt(status, ErrorCode::InputOutput, file));
  EXPECT_TRUE(std::filesystem::is_empty(this->Folder));
}

// If other users can write to the folder, they may have put a link there under a foreseeable name.
TEST_F(PictureTest, FollowsNoLinkBesideIt)
{
  std::ofstream(this->Folder / "victim") << "precious";
  std::filesystem::create_symlink("victim", this->Folder / "half.png.part");
  const Stage stage = HalfStage();
  ASSERT_TRUE(WritePng(*stage.window, this->Folder / "half.png"));
  std::ifstream victim(this->Folder / "victim");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(victim), {}), "precious");
  EXPECT_TRUE(std::filesystem::is_symlink(this->Folder / "half.png.part"));
}

}
}
