// SPDX-License-Identifier: BSD-3-Clause
// The messages of kdstream-store about files that it cannot read, and about geometric errors: in
// our words, not SQLite's.
#include "Testing/EndToEnd/Process.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/meshio/MeshWriter.h"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <fcntl.h>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

class StoreMessages : public testing::Test
{
protected:
  void SetUp() override
  {
    ASSERT_TRUE(WriteMesh(this->Folder / "torus.ply", Torus(40, 20)));
    const Outcome built =
      this->Run("kdstream-build", { "torus.ply", "-o", "torus.kds", "--unit", "mm", "--quiet" });
    ASSERT_EQ(built.exitCode, 0) << built.err;
  }

  Outcome Run(const std::string& program, const std::vector<std::string>& arguments)
  {
    return RunProgram(this->Folder, std::string(KDSTREAM_PROGRAMS) + "/" + program, arguments);
  }

  // Changes the database directly.
  void Sql(const std::string& statement)
  {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open((this->Folder / "torus.kds").c_str(), &database), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(database, statement.c_str(), nullptr, nullptr, nullptr), SQLITE_OK);
    sqlite3_close(database);
  }

  TemporaryFolder Folder;
};

}

TEST_F(StoreMessages, AFileThatIsNotAStoreIsReportedAsSuch)
{
  const Outcome mesh = this->Run("kdstream-store", { "info", "torus.ply" });
  EXPECT_EQ(mesh.exitCode, 1);
  EXPECT_EQ(mesh.err, "kdstream-store: error: torus.ply: not a KdStream store\n");
}

TEST_F(StoreMessages, AFileThatIsNotThereIsCalledThat)
{
  for (const std::string file : { "no.kds", "torus.ply/no.kds" })
  {
    const Outcome missing = this->Run("kdstream-store", { "info", file });
    EXPECT_EQ(missing.exitCode, 1);
    EXPECT_EQ(missing.err, "kdstream-store: error: " + file + ": no such file\n");
  }
}

TEST_F(StoreMessages, AStoreWithoutItsTablesIsDamaged)
{
  this->Sql("DROP TABLE content");
  const Outcome verified = this->Run("kdstream-store", { "verify", "torus.kds" });
  EXPECT_EQ(verified.exitCode, 1);
  EXPECT_NE(verified.err.find("its tables are not those of a store"), std::string::npos)
    << verified.err;
  EXPECT_EQ(verified.err.find("no such table"), std::string::npos) << verified.err;
}

TEST_F(StoreMessages, AStoreThatMayNotBeReadSaysWhy)
{
  const std::filesystem::path store = this->Folder / "torus.kds";
  std::filesystem::permissions(store, std::filesystem::perms::none);
  std::filesystem::permissions(this->Folder.Path, std::filesystem::perms::all);
  // Root may read everything, so the test runs as another user here.
  const bool root = ::geteuid() == 0;
  ASSERT_TRUE(!root || ::seteuid(65534) == 0);
  const std::filesystem::path program = std::filesystem::path(KDSTREAM_PROGRAMS) / "kdstream-store";
  const bool mayRun = ::faccessat(AT_FDCWD, program.c_str(), X_OK, AT_EACCESS) == 0;
  ASSERT_TRUE(!root || ::seteuid(0) == 0);
  if (!mayRun)
  {
    GTEST_SKIP() << "nobody else may run " << program;
  }
  const Outcome info = root ? RunProgram(this->Folder, "/usr/bin/setpriv",
                                { "--reuid=65534", program.string(), "info", "torus.kds" })
                            : this->Run("kdstream-store", { "info", "torus.kds" });
  EXPECT_EQ(info.exitCode, 1);
  EXPECT_EQ(info.err, "kdstream-store: error: torus.kds: cannot be opened: Permission denied\n");
}

TEST_F(StoreMessages, InfoReportsTheGeometricError)
{
  const Outcome info = this->Run("kdstream-store", { "info", "torus.kds" });
  ASSERT_EQ(info.exitCode, 0) << info.err;
  EXPECT_NE(info.out.find("distance of the original from the level, in mm"), std::string::npos)
    << info.out;
  EXPECT_NE(info.out.find("that 99 of 100 do not exceed"), std::string::npos) << info.out;
}
