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

ViewTest::ViewTest()
{
  ::unsetenv("XDG_CACHE_HOME"); // nothing is kept unless a test asks for it
  ::unsetenv("HOME");
  ::unsetenv("DISPLAY"); // a window would wait for a user
  this->Server = std::move(*HttpServer::Start(this->Models, {}));
}

int ViewTest::Run(const std::string& arguments)
{
  const std::string command =
    "cd '" + this->Folder.Path.string() + "' && '" + program + "' " + arguments + " >out 2>err";
  const int status = std::system(command.c_str());
  this->Out = fixtures::ReadWhole(this->Folder / "out");
  this->Err = fixtures::ReadWhole(this->Folder / "err");
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}
