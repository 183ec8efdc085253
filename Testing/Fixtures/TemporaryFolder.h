// SPDX-License-Identifier: BSD-3-Clause
// A temporary folder for one test.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdlib.h>
#include <string>

namespace kdstream::fixtures
{

// The folder is empty at first, and removed with the object.
class TemporaryFolder
{
public:
  TemporaryFolder()
  {
    std::string name = (std::filesystem::temp_directory_path() / "kdstream-test-XXXXXX").string();
    this->Path = ::mkdtemp(name.data());
  }
  ~TemporaryFolder() { std::filesystem::remove_all(this->Path); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return this->Path / name; }
  std::filesystem::path Path;
};

inline std::string ReadWhole(const std::filesystem::path& file)
{
  std::ifstream stream(file, std::ios::binary);
  return { std::istreambuf_iterator<char>(stream), {} };
}

}
