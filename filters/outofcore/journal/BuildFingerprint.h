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
  // Files that the input refers to and that shape the store, too. As for the input, path, size and
  // time count, and also whether they exist.
  std::vector<std::filesystem::path> named{};
};
// Errors: InputOutput where the input cannot be examined.
Result<std::string> FingerprintOf(const BuildIdentity& identity);

// Checks that a build with the fingerprint `now` may resume one with the fingerprint `earlier`.
// Errors: InvalidArgument if the options or the input differ, or if the input, or a file that it
// refers to, has changed since; the message names them. Unsupported if another program or version
// made the earlier build.
Status CheckSameBuild(std::string_view earlier, std::string_view now);

// What `now` would have to change to continue the earlier build, as the end of a sentence about the
// files that are left: "to continue it with --resume, --title none (now \"Statue\") is needed".
// REQUIRES: the fingerprints differ.
std::string DescribeOtherBuild(std::string_view earlier, std::string_view now);

// One path for a file, however it is written.
std::filesystem::path CanonicalPath(const std::filesystem::path& path);

}
