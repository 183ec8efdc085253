// SPDX-License-Identifier: BSD-3-Clause
// A folder for the files of one test, removed with everything in it.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

namespace kdstream::test
{

class ScratchFolder
{
public:
  ScratchFolder()
  {
    std::string name = (std::filesystem::temp_directory_path() / "kdstream-meshio-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr)
    {
      ADD_FAILURE() << "no folder for temporary files: " << name;
      std::abort();
    }
    this->Path = name;
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder()
  {
    std::error_code ignored;
    std::filesystem::remove_all(this->Path, ignored);
  }

  std::filesystem::path File(std::string_view name) const { return this->Path / name; }

  std::filesystem::path Write(std::string_view name, std::string_view bytes) const
  {
    const std::filesystem::path file = this->File(name);
    std::ofstream stream(file, std::ios::binary);
    stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    EXPECT_TRUE(stream.flush()) << file;
    return file;
  }

  static std::string Read(const std::filesystem::path& file)
  {
    std::ifstream stream(file, std::ios::binary);
    EXPECT_TRUE(stream) << file;
    return std::string(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  }

  std::size_t CountFiles() const
  {
    return static_cast<std::size_t>(std::distance(
      std::filesystem::directory_iterator(this->Path), std::filesystem::directory_iterator()));
  }

private:
  std::filesystem::path Path;
};

}
