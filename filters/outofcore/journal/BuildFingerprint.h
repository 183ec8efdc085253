// SPDX-License-Identifier: BSD-3-Clause
// What the files of an interrupted build are of use to: the same build, by doc/cli.md#resume.
#pragma once

#include "filters/core/Result.h"

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace kdstream
{

// What a build is made from. Builds of equal fingerprints make the same files.
struct BuildIdentity
{
  std::string program;         // with its version
  std::filesystem::path input; // its absolute path, size and time of change count
  // All that the store or the files of any phase depend on: names as the user knows them, values.
  std::vector<std::pair<std::string, std::string>> options;
  // Files that the input names and that shape the store, too: as of the input path, size and time
  // count, and also whether they are there.
  std::vector<std::filesystem::path> named{};
};
// Errors: InputOutput where the input cannot be examined.
Result<std::string> FingerprintOf(const BuildIdentity& identity);

// Whether the build of one fingerprint may go on with what that of an earlier one has left. Errors:
// InvalidArgument where the earlier one had other options, which are named, another input, or the
// same before it was changed, or one of the files that it names, which is told; Unsupported where
// it was by another program or version.
Status CheckSameBuild(std::string_view earlier, std::string_view now);

// The same for a build that does not want to go on with it, as the end of a sentence about the
// files that are left: "to continue it with --resume, --title none (now \"Statue\") is needed".
// REQUIRES: the fingerprints differ.
std::string DescribeOtherBuild(std::string_view earlier, std::string_view now);

// One path for a file, however it is written.
std::filesystem::path CanonicalPath(const std::filesystem::path& path);

}
