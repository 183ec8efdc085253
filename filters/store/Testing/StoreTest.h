// SPDX-License-Identifier: BSD-3-Clause
// A folder for stores, for tests that write stores and read them back.
#pragma once

#include "filters/build/Builder.h"
#include "filters/store/Store.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <iterator>
#include <string>
#include <utility>

#include <unistd.h>

namespace kdstream::fixtures
{

// The folder is empty at first, and removed after the test.
class StoreTest : public ::testing::Test
{
protected:
  StoreTest()
    : Folder(std::filesystem::temp_directory_path() /
             ("kdstream-store-test-" + std::to_string(::getpid())))
  {
    std::filesystem::create_directories(this->Folder);
  }
  ~StoreTest() override { std::filesystem::remove_all(this->Folder); }

  std::filesystem::path File(const std::string& name = "model.kds") const
  {
    return this->Folder / name;
  }

  BuildReport Build(const Mesh& mesh, const BuildOptions& options, const Execution& execution = {})
  {
    Result<BuildReport> report = BuildStore(mesh, "mesh.ply", this->File(), options, execution);
    EXPECT_TRUE(report) << report.GetError().message;
    return std::move(*report);
  }

  std::size_t FilesInFolder() const
  {
    return static_cast<std::size_t>(std::distance(
      std::filesystem::directory_iterator(this->Folder), std::filesystem::directory_iterator()));
  }

  std::filesystem::path Folder;
};

}
