// SPDX-License-Identifier: BSD-3-Clause
// Runs kdstream-view for its tests: see ViewTest.h. The program is the tests' first argument.
#include "viewer/desktop/Testing/ViewTest.h"

#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <iterator>
#include <utility>

namespace
{

std::string program; // kdstream-view

}

namespace kdstream::testing
{

std::string ReadText(const std::filesystem::path& file)
{
  std::ifstream input(file, std::ios::binary);
  return { std::istreambuf_iterator<char>(input), {} };
}

ViewTest::ViewTest()
{
  std::string name = (std::filesystem::temp_directory_path() / "kdstream-view-XXXXXX").string();
  this->Folder = ::mkdtemp(name.data());
  this->Server = std::move(*HttpServer::Start(this->Models, {}));
}

ViewTest::~ViewTest()
{
  std::filesystem::remove_all(this->Folder);
}

int ViewTest::Run(const std::string& arguments)
{
  const std::string command =
    "cd '" + this->Folder.string() + "' && '" + program + "' " + arguments + " >out 2>err";
  const int status = std::system(command.c_str());
  this->Out = ReadText(this->Folder / "out");
  this->Err = ReadText(this->Folder / "err");
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}

int main(int argc, char** argv)
{
  ::testing::InitGoogleTest(&argc, argv);
  program = argc > 1 ? argv[1] : "kdstream-view";
  ::unsetenv("XDG_CACHE_HOME"); // nothing is kept but where a test says
  ::unsetenv("HOME");
  ::unsetenv("DISPLAY"); // a window would wait for somebody
  return RUN_ALL_TESTS();
}
