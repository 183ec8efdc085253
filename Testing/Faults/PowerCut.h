// SPDX-License-Identifier: BSD-3-Clause
// What a power cut leaves of a folder, at any moment of a program's work.
//
// The system only promises the bytes that a file had at its last fsync, and the names that a folder
// had at the folder's. Of everything later, each sector (512 bytes) may be there or not, in any
// order, and so may each new size, name, or change of a name. Bytes that were never written may be
// zeros, or what the disk had there before.
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
  // program ran (`inodes` too), completely on the disk.
  PowerCut(const std::filesystem::path& record, const std::filesystem::path& folder,
    const FileTree& before, const std::map<std::string, std::uint64_t>& inodes);

  // How many moments there are: a cut comes before the first action, after it, …, after the last.
  std::size_t Moments() const { return this->Actions.size() + 1; }
  // What is found in the folder if the power is cut after this number of actions. Seed 0: only what
  // was made durable; 1: everything; others: some of the rest.
  FileTree After(std::size_t actions, std::uint32_t seed) const;
  // The actions, a line each, for who looks for the cause.
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
