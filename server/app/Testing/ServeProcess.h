// SPDX-License-Identifier: BSD-3-Clause
// kdstream-serve as a process, and a folder of small stores for it: what its tests share.
#pragma once

#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/build/Builder.h"

#include <gtest/gtest.h>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace kdstream
{

namespace fs = std::filesystem;

inline std::string program;
inline constexpr const char* openToAll = "kdstream-serve: open to all: ";

// A running kdstream-serve.
class Process
{
public:
  explicit Process(std::vector<std::string> arguments, std::string executable = program,
    std::optional<rlimit> descriptors = {})
  {
    std::array<int, 2> out{}, error{};
    EXPECT_EQ(::pipe(out.data()), 0);
    EXPECT_EQ(::pipe(error.data()), 0);
    arguments.insert(arguments.begin(), executable);
    std::vector<char*> list;
    for (auto& argument : arguments)
    {
      list.push_back(argument.data());
    }
    list.push_back(nullptr);
    this->Id = ::fork();
    if (this->Id == 0)
    {
      ::dup2(out[1], STDOUT_FILENO);
      ::dup2(error[1], STDERR_FILENO);
      for (const int end : { out[0], out[1], error[0], error[1] })
      {
        ::close(end);
      }
      if (descriptors)
      {
        ::setrlimit(RLIMIT_NOFILE, &*descriptors);
      }
      ::execv(executable.c_str(), list.data());
      ::_exit(127);
    }
    ::close(out[1]);
    ::close(error[1]);
    this->Out = out[0];
    this->Err = error[0];
  }
  ~Process()
  {
    if (this->Id > 0)
    {
      this->Signal(SIGKILL);
      this->Wait();
    }
    ::close(this->Out);
    ::close(this->Err);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void Signal(int signal) const { ::kill(this->Id, signal); }
  // The exit code, or minus the signal that ended it.
  int Wait()
  {
    int status = 0;
    ::waitpid(this->Id, &status, 0);
    this->Id = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }
  static std::string ReadLine(int file)
  {
    std::string line;
    for (char c = 0; ::read(file, &c, 1) == 1 && c != '\n';)
    {
      line += c;
    }
    return line;
  }
  std::string OutLine() const { return ReadLine(this->Out); }
  // The next one but that it is open to all.
  std::string ErrorLine() const
  {
    auto line = ReadLine(this->Err);
    return line.rfind(openToAll, 0) == 0 ? ReadLine(this->Err) : line;
  }
  std::string AnyErrorLine() const { return ReadLine(this->Err); }

  // Waits for the line; the port in it.
  std::uint16_t Port(const std::string& scheme = "http") const
  {
    return PortIn(this->OutLine(), "listening on " + scheme + "://127.0.0.1:");
  }
  // The same of the line that tells where the metrics are.
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

  pid_t Id = -1;
  int Out = -1, Err = -1;
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
