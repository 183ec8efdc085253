// SPDX-License-Identifier: BSD-3-Clause
// What the tests of kdstream-serve share: the program as a process, and a folder of small stores.
#pragma once

#include "Testing/Fixtures/RunningProgram.h"
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/build/Builder.h"

#include <gtest/gtest.h>

#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace kdstream
{

namespace fs = std::filesystem;

inline const std::string program = KDSTREAM_PROGRAMS "/kdstream-serve";
inline constexpr const char* openToAll = "kdstream-serve: without --tokens, everybody ";

// A running kdstream-serve.
class Process : public fixtures::RunningProgram
{
public:
  explicit Process(std::vector<std::string> arguments, const std::string& executable = program,
    std::optional<rlimit> descriptors = {})
    : RunningProgram(executable, std::move(arguments), descriptors)
  {
  }

  // The next line on stderr, skipping the warning that the server is open to all.
  std::string ErrorLine() const
  {
    auto line = this->AnyErrorLine();
    return line.rfind(openToAll, 0) == 0 ? this->AnyErrorLine() : line;
  }

  // Waits for the line that gives the server's address, and returns the port in it.
  std::uint16_t Port(const std::string& scheme = "http") const
  {
    return PortIn(this->OutLine(), "listening on " + scheme + "://127.0.0.1:");
  }
  // Waits for the line that gives the address of the metrics, and returns the port in it.
  std::uint16_t AdminPort() const
  {
    return PortIn(this->ErrorLine(), "kdstream-serve: metrics on http://127.0.0.1:");
  }

private:
  static std::uint16_t PortIn(const std::string& line, const std::string& start)
  {
    EXPECT_EQ(line.substr(0, start.size()), start);
    return line.size() > start.size()
             ? static_cast<std::uint16_t>(std::stoi(line.substr(start.size())))
             : std::uint16_t{ 0 };
  }
};

class Serve : public testing::Test
{
protected:
  const fixtures::TemporaryFolder temporary;
  const fs::path folder = this->temporary.Path, stores = this->folder / "stores";

  void SetUp() override { fs::create_directories(this->stores); }

  void Build(const std::string& name, double height = 1) const
  {
    Mesh mesh;
    mesh.points = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, height } };
    mesh.triangles = { { 0, 1, 2 }, { 0, 2, 3 } };
    EXPECT_TRUE(BuildStore(mesh, "mesh.ply", this->stores / name, {}));
  }
};

}
