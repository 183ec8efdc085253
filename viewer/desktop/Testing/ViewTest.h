// SPDX-License-Identifier: BSD-3-Clause
// Shared by the tests that run kdstream-view: a folder to run it in, a server with a torus, and its
// output.
#pragma once

#include "Testing/Fixtures/TemporaryFolder.h"
#include "server/http/HttpServer.h"
#include "viewer/client/Testing/TorusCatalog.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

namespace kdstream::testing
{

class ViewTest : public ::testing::Test
{
protected:
  ViewTest();

  // Runs kdstream-view with this server's URL in the test's folder. Returns the exit code.
  int View(const std::string& options) { return this->Run(this->Server->Url() + " " + options); }
  int Run(const std::string& arguments);
  void Write(const std::string& name, const std::string& text) { this->Folder.Write(name, text); }
  bool IsPicture(const std::string& name)
  {
    return fixtures::ReadWhole(this->Folder / name).substr(1, 3) == "PNG";
  }

  const fixtures::TemporaryFolder Folder;
  TorusCatalog Models;
  std::unique_ptr<HttpServer> Server;
  std::string Out, Err;
};

}
