// SPDX-License-Identifier: BSD-3-Clause
#include "filters/outofcore/journal/BuildFingerprint.h"

#include "filters/core/SystemReason.h"

#include <algorithm>
#include <cerrno>
#include <iterator>
#include <set>
#include <system_error>

#include <sys/stat.h>

namespace kdstream
{
namespace
{

namespace fs = std::filesystem;

using Parts = std::vector<std::string_view>;

std::string TextOfTime(const struct stat& state)
{
  return std::to_string(state.st_mtim.tv_sec) + "." + std::to_string(state.st_mtim.tv_nsec);
}

// The parts of a fingerprint; in the text each follows its length. Fewer if the text is not a
// fingerprint.
Parts PartsOf(std::string_view fingerprint)
{
  Parts parts;
  while (!fingerprint.empty())
  {
    std::size_t length = 0, digits = 0;
    for (; digits < fingerprint.size() && fingerprint[digits] >= '0' &&
           fingerprint[digits] <= '9' && length < fingerprint.size();
         ++digits)
    {
      length = 10 * length + static_cast<std::size_t>(fingerprint[digits] - '0');
    }
    if (digits + 2 + length > fingerprint.size())
    {
      break;
    }
    parts.push_back(fingerprint.substr(digits + 1, length));
    fingerprint.remove_prefix(digits + 2 + length);
  }
  return parts;
}

void AddPart(const std::string& part, std::string& fingerprint)
{
  fingerprint += std::to_string(part.size()) + ":" + part + "\n";
}

// The parts of a fingerprint before the options: the program; the path, size and time of the input;
// and, as one part, the files that the input names.
constexpr std::size_t pathOfInput = 1, partsOfInput = 3, namedFiles = 4, partsBeforeOptions = 5;

// For each file its path, and its size and time as "size time"; "none" if it does not exist.
std::string PartsOfNamed(const std::vector<fs::path>& files)
{
  std::string parts;
  for (const fs::path& file : files)
  {
    struct stat state = {};
    const bool there = stat(file.c_str(), &state) == 0;
    AddPart(CanonicalPath(file).string(), parts);
    AddPart(there ? std::to_string(state.st_size) + " " + TextOfTime(state) : "none", parts);
  }
  return parts;
}

// The first file that only one of the two builds names, or that has changed between them; empty if
// there is none.
std::string NamedOtherwise(const Parts& before, const Parts& after)
{
  using Files = std::set<std::pair<std::string_view, std::string_view>>; // paths and states
  const auto filesOf = [](std::string_view named)
  {
    const Parts parts = PartsOf(named);
    Files files;
    for (std::size_t i = 0; i + 1 < parts.size(); i += 2)
    {
      files.emplace(parts[i], parts[i + 1]);
    }
    return files;
  };
  const Files earlier = filesOf(before[namedFiles]), now = filesOf(after[namedFiles]);
  std::vector<Files::value_type> others;
  std::set_symmetric_difference(
    earlier.begin(), earlier.end(), now.begin(), now.end(), std::back_inserter(others));
  return others.empty() ? std::string() : std::string(others.front().first);
}

// Whether the same program made both. If so, they have the same options, maybe with different
// values.
bool OfOneProgram(const Parts& before, const Parts& after)
{
  return before.size() >= partsBeforeOptions && before.size() == after.size() &&
         before[0] == after[0];
}

bool OfOneInput(const Parts& before, const Parts& after)
{
  return std::equal(before.begin() + pathOfInput, before.begin() + pathOfInput + partsOfInput,
    after.begin() + pathOfInput);
}

// A value as in a message: "20", "none", "\"Statue of somebody\"".
std::string ValueText(std::string_view value)
{
  const bool plain = std::all_of(value.begin(), value.end(),
    [](char c) { return c > ' ' && c <= '~' && c != '"' && c != ',' && c != ';'; });
  return value.empty() ? "none" : plain ? std::string(value) : "\"" + std::string(value) + "\"";
}

// "--precision 20 (now 12), --title none (now \"Statue\")".
std::string DescribeOptions(const Parts& before, const Parts& after)
{
  std::string text;
  for (std::size_t i = partsBeforeOptions; i + 1 < before.size(); i += 2)
  {
    if (before[i] != after[i] || before[i + 1] != after[i + 1])
    {
      text += (text.empty() ? "" : ", ") + std::string(before[i]) + " " + ValueText(before[i + 1]) +
              " (now " + ValueText(after[i + 1]) + ")";
    }
  }
  return text;
}

}

fs::path CanonicalPath(const fs::path& path)
{
  std::error_code failed;
  fs::path canonical = fs::weakly_canonical(fs::absolute(path, failed), failed);
  return failed ? fs::absolute(path, failed) : canonical;
}

Result<std::string> FingerprintOf(const BuildIdentity& identity)
{
  struct stat input = {};
  if (stat(identity.input.c_str(), &input) != 0)
  {
    return SystemError("cannot be examined", errno, identity.input);
  }
  std::string fingerprint;
  const auto add = [&](const std::string& part) { AddPart(part, fingerprint); };
  add(identity.program);
  add(CanonicalPath(identity.input).string());
  add(std::to_string(input.st_size));
  add(TextOfTime(input));
  add(PartsOfNamed(identity.named));
  for (const auto& [name, value] : identity.options)
  {
    add(name);
    add(value);
  }
  return fingerprint;
}

Status CheckSameBuild(std::string_view earlier, std::string_view now)
{
  if (earlier == now)
  {
    return {};
  }
  const auto refused = [](ErrorCode code, const std::string& why)
  {
    return Error{ code, "--resume: the interrupted build " + why +
                          "; its files are kept: build without --resume to start over" };
  };
  const Parts before = PartsOf(earlier), after = PartsOf(now);
  if (!OfOneProgram(before, after))
  {
    return refused(ErrorCode::Unsupported, "was made by another version of this program");
  }
  if (!OfOneInput(before, after))
  {
    return refused(ErrorCode::InvalidArgument, "had another input, or its input has changed since");
  }
  if (const std::string file = NamedOtherwise(before, after); !file.empty())
  {
    return refused(ErrorCode::InvalidArgument,
      "had another file " + file + " (used by its input), or that file has changed since");
  }
  return refused(ErrorCode::InvalidArgument,
    "had other options, which --resume needs: " + DescribeOptions(before, after));
}

std::string DescribeOtherBuild(std::string_view earlier, std::string_view now)
{
  const Parts before = PartsOf(earlier), after = PartsOf(now);
  if (!OfOneProgram(before, after))
  {
    return "they were made by another version of this program";
  }
  const std::string needed = "to continue it with --resume, ";
  if (before[pathOfInput] != after[pathOfInput])
  {
    return needed + "their input " + std::string(before[pathOfInput]) + " is needed";
  }
  const std::string file = NamedOtherwise(before, after);
  return OfOneInput(before, after) && file.empty()
           ? needed + DescribeOptions(before, after) + " is needed"
           : (file.empty() ? "their input" : file) +
               " has changed since, so --resume cannot use them";
}

}
