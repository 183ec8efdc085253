// SPDX-License-Identifier: BSD-3-Clause
// Shared by the tests of spilled meshes.
#pragma once

#include "filters/outofcore/files/RecordFile.h"
#include "filters/outofcore/files/SpillFile.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <vector>

namespace kdstream::testing
{

inline SpillFolder MakeSpillFolder()
{
  return std::move(*SpillFolder::Create(std::filesystem::temp_directory_path()));
}

template <class Record>
SpillFile Spilled(SpillFolder& folder, const std::vector<Record>& records)
{
  SpillFile file = std::move(*folder.CreateFile("test", records.size() * sizeof(Record)));
  EXPECT_TRUE(WriteRecords<Record>(file, 0, std::span<const Record>(records)));
  return file;
}

template <class Record>
std::vector<Record> ReadBack(const SpillFile& file)
{
  std::vector<Record> records(file.Size() / sizeof(Record));
  EXPECT_TRUE(ReadRecords<Record>(file, 0, std::span<Record>(records)));
  return records;
}

}
