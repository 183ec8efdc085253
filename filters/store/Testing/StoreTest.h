// SPDX-License-Identifier: BSD-3-Clause
// A folder for stores, for tests that write stores and read them back.
#pragma once

#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/build/Builder.h"
#include "filters/store/Store.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <utility>

namespace kdstream::fixtures
{

// The folder is empty at first, and removed after the test.
class StoreTest : public ::testing::Test
{
protected:
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

  std::string Bytes(const std::string& name = "model.kds") const
  {
    return ReadWhole(this->File(name));
  }

  std::size_t FilesInFolder() const { return this->Temporary.Names().size(); }

  const TemporaryFolder Temporary;
  const std::filesystem::path Folder = this->Temporary.Path;
};

}
