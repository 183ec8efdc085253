// SPDX-License-Identifier: BSD-3-Clause
// The possible states of a folder after a power cut, at any moment of a program's work.
//
// The system only guarantees the bytes that a file had at its last fsync, and the names that a
// folder had at the folder's last fsync. Of everything later, each sector (512 bytes) may be there
// or not, in any order. The same applies to each new size, new name, or change of a name. Bytes
// that were never written may be zeros, or what the disk had there before.
#pragma once

#include "Testing/Faults/FaultyProgram.h"
#include "Testing/Faults/Recording.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

namespace kdstream::fixtures
{

class PowerCut
{
public:
  // Reads the record of the fault library. folder: the folder to examine, as it was before the
  // program ran (so is `inodes`); all of it was on the disk then.
  PowerCut(const std::filesystem::path& record, const std::filesystem::path& folder,
    const FileTree& before, const std::map<std::string, std::uint64_t>& inodes);

  // The number of moments: a cut comes before the first action, after it, …, or after the last.
  std::size_t Moments() const { return this->Actions.size() + 1; }
  // The content of the folder if the power is cut after this number of actions. Seed 0: only what
  // was made durable; 1: everything; any other seed: durable data and some of the rest.
  FileTree After(std::size_t actions, std::uint32_t seed) const;
  // Lists the actions, one in each line, to help find the cause of a failure.
  std::string Describe(std::size_t actions) const;

private:
  struct Action
  {
    FileRecord record;
    std::string path, path2, data;
  };
  std::filesystem::path Folder;
  FileTree Before;
  std::map<std::string, std::uint64_t> Inodes;
  std::vector<Action> Actions;
};

// The inodes of the files and folders of a tree, "" for the folder itself.
std::map<std::string, std::uint64_t> ReadInodes(const std::filesystem::path& folder);

}
