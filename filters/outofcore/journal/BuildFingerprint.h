// SPDX-License-Identifier: BSD-3-Clause
// Which build may use the files of an interrupted one: only the same build, see doc/cli.md#resume.
#pragma once

#include "filters/core/Result.h"

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace kdstream
{

// What a build is made from. Builds with equal fingerprints make the same files.
struct BuildIdentity
{
  std::string program;         // with its version
  std::filesystem::path input; // its absolute path, size and time matter
  // All options that the store or the files of any phase depend on: names as the user knows them,
  // and values.
  std::vector<std::pair<std::string, std::string>> options;
  // Files that the input refers to, and that affect the store too. Path, size and time matter as
  // for the input, and also whether the file exists.
  std::vector<std::filesystem::path> named{};
};
// Errors: InputOutput if the input cannot be examined.
Result<std::string> FingerprintOf(const BuildIdentity& identity);

// Checks that a build with the fingerprint `now` may resume one with the fingerprint `earlier`.
// Errors: InvalidArgument if the options or the input differ, or if the input, or a file that it
// refers to, has changed since; the message names them. Unsupported if another program or version
// made the earlier build.
Status CheckSameBuild(std::string_view earlier, std::string_view now);

// What would have to change in `now` to continue the earlier build, as the end of a sentence about
// the files that are left: "to continue it with --resume, --title none (now \"Statue\") is needed".
// REQUIRES: the fingerprints differ.
std::string DescribeOtherBuild(std::string_view earlier, std::string_view now);

// The canonical path of a file: the same, however the path is written.
std::filesystem::path CanonicalPath(const std::filesystem::path& path);

}
