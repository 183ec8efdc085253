// SPDX-License-Identifier: BSD-3-Clause
// A temporary folder for one test.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <string_view>

#include <unistd.h>

namespace kdstream::fixtures
{

// On a RAM disk if the system has one: for tests that wait for the disk often.
inline std::filesystem::path FastTemporaryPath()
{
  return ::access("/dev/shm", W_OK) == 0 ? "/dev/shm" : std::filesystem::temp_directory_path();
}

// The folder is empty at first, and removed with the object.
class TemporaryFolder
{
public:
  explicit TemporaryFolder(
    const std::filesystem::path& parent = std::filesystem::temp_directory_path())
  {
    std::string name = (parent / "kdstream-test-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr)
    {
      ADD_FAILURE() << "no folder for temporary files: " << name;
      std::abort();
    }
    this->Path = name;
  }
  ~TemporaryFolder()
  {
    std::error_code ignored;
    std::filesystem::remove_all(this->Path, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::filesystem::path operator/(const std::filesystem::path& name) const
  {
    return this->Path / name;
  }
  // Writes a file of these bytes, and returns its path.
  std::filesystem::path Write(const std::filesystem::path& name, std::string_view bytes) const
  {
    const std::filesystem::path file = this->Path / name;
    std::ofstream stream(file, std::ios::binary);
    stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    EXPECT_TRUE(stream.flush()) << file;
    return file;
  }
  // The names of the files and folders in it.
  std::set<std::string> Names() const
  {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(this->Path))
    {
      names.insert(entry.path().filename().string());
    }
    return names;
  }

  std::filesystem::path Path;
};

// The bytes of a file; none if it cannot be read.
inline std::string ReadWhole(const std::filesystem::path& file)
{
  std::ifstream stream(file, std::ios::binary);
  return { std::istreambuf_iterator<char>(stream), {} };
}

}
