// SPDX-License-Identifier: BSD-3-Clause
// Shared by the tests of kdstream-build and kdstream-store: a folder, meshes in it, and the
// programs.
#pragma once

#include "Testing/EndToEnd/Process.h"
#include "Testing/Fixtures/ReadMeshFile.h"
#include "filters/meshio/MeshReader.h"
#include "filters/meshio/MeshWriter.h"

#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <string>
#include <vector>

namespace kdstream::fixtures
{

class ProgramsTest : public ::testing::Test
{
protected:
  Outcome Build(std::vector<std::string> arguments)
  {
    return RunTool(this->Folder, "build", arguments);
  }
  Outcome Store(std::vector<std::string> arguments)
  {
    return RunTool(this->Folder, "store", arguments);
  }

  void Write(const std::string& name, const Mesh& mesh)
  {
    const Status status = WriteMesh(this->Folder / name, mesh);
    ASSERT_TRUE(status) << status.GetError().message;
  }
  void WriteText(const std::string& name, const std::string& text)
  {
    this->Folder.Write(name, text);
  }

  Mesh Read(const std::string& name) { return ReadMeshFile(this->Folder / name); }

  // Expects that a program has failed with exactly one line of errors, which begins with the
  // program and the subject: "kdstream-build: error: in.ply: ".
  void ExpectError(const Outcome& outcome, int exitCode, const std::string& begin)
  {
    EXPECT_EQ(outcome.exitCode, exitCode);
    EXPECT_EQ(outcome.err.rfind(begin, 0), 0U) << outcome.err;
    EXPECT_EQ(outcome.err.find('\n') + 1, outcome.err.size()) << outcome.err;
    EXPECT_EQ(outcome.out, "");
  }

  std::set<std::string> Files() const { return this->Folder.Names(); }

  TemporaryFolder Folder;
};

}
