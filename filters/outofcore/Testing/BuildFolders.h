// SPDX-License-Identifier: BSD-3-Clause
// Shared by the tests of interrupted builds: a build folder, and a first phase to run in it.
#pragma once

#include "filters/outofcore/Testing/SpillTools.h"
#include "filters/outofcore/files/RecordFile.h"
#include "filters/outofcore/journal/BuildFolder.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <numeric>
#include <string_view>
#include <utility>
#include <vector>

namespace kdstream::testing
{

constexpr std::size_t numberCount = 1000;

inline std::vector<std::filesystem::path> EntriesOf(const std::filesystem::path& folder)
{
  std::vector<std::filesystem::path> entries;
  for (const std::filesystem::directory_entry& entry : std::filesystem::directory_iterator(folder))
  {
    entries.push_back(entry.path());
  }
  return entries;
}

// Runs a first phase, "numbers". It leaves a file of the numbers 1 … numberCount, and a closed file
// "nothing".
inline Status MakeNumbers(BuildFolder& folder)
{
  std::vector<std::uint64_t> numbers(numberCount);
  std::iota(numbers.begin(), numbers.end(), 1U);
  PhaseFile files[] = { { "numbers", {} }, { "nothing", {} } };
  Result<SpillFile> file = folder.Files().CreateFile("numbers", 0);
  KDSTREAM_TRY(file);
  RecordWriter<std::uint64_t> writer(*file, 0, 3000);
  for (const std::uint64_t number : numbers)
  {
    writer.Append(number);
  }
  KDSTREAM_TRY(writer.Finish());
  files[0].file = std::move(*file);
  BlobWriter blob;
  blob.Add(std::uint64_t{ numberCount });
  return folder.Finish("numbers", blob, files);
}

// Gives a test the path "build", in a folder that is removed after the test.
class BuildFolderTest : public ::testing::Test
{
protected:
  std::filesystem::path Path() const { return this->Parent.Path() / "build"; }
  BuildFolder Open(bool resume, std::string_view fingerprint = "same") const
  {
    return std::move(*BuildFolder::Open(this->Path(), fingerprint, resume));
  }
  std::size_t FinishedPhases(std::string_view fingerprint = "same") const
  {
    return this->Open(true, fingerprint).FinishedPhases();
  }

  SpillFolder Parent = MakeSpillFolder();
};

}
