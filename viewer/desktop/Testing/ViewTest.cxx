// SPDX-License-Identifier: BSD-3-Clause
// Runs kdstream-view for its tests: see ViewTest.h.
#include "viewer/desktop/Testing/ViewTest.h"

#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <iterator>
#include <utility>

namespace
{

const std::string program = KDSTREAM_PROGRAMS "/kdstream-view";

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
  ::unsetenv("XDG_CACHE_HOME"); // nothing is kept unless a test asks for it
  ::unsetenv("HOME");
  ::unsetenv("DISPLAY"); // a window would wait for a user
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
