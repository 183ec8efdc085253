// SPDX-License-Identifier: BSD-3-Clause
#include "filters/outofcore/journal/BuildFingerprint.h"

#include "filters/core/SystemReason.h"

#include <algorithm>
#include <cerrno>
#include <system_error>

#include <sys/stat.h>

namespace kdstream
{
namespace
{

namespace fs = std::filesystem;

using Parts = std::vector<std::string_view>;

// The parts of a fingerprint, each after its length; fewer where it is none.
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

// The parts of a fingerprint before the options: the program; path, size and time of the input.
constexpr std::size_t partsOfProgram = 1, pathOfInput = 1, partsBeforeOptions = 4;

// Whether the same program has made both, which then have the same options, with values.
bool OfOneProgram(const Parts& before, const Parts& after)
{
  return before.size() >= partsBeforeOptions && before.size() == after.size() &&
         before[0] == after[0];
}

bool OfOneInput(const Parts& before, const Parts& after)
{
  return std::equal(before.begin() + partsOfProgram, before.begin() + partsBeforeOptions,
    after.begin() + partsOfProgram);
}

// "20", "none", "\"Statue of somebody\"".
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
  const auto add = [&](const std::string& part)
  { fingerprint += std::to_string(part.size()) + ":" + part + "\n"; };
  add(identity.program);
  add(CanonicalPath(identity.input).string());
  add(std::to_string(input.st_size));
  add(std::to_string(input.st_mtim.tv_sec) + "." + std::to_string(input.st_mtim.tv_nsec));
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
    return Error{ code,
      "--resume: the interrupted build " + why +
        "; its files are left as they are: build without --resume to start over" };
  };
  const Parts before = PartsOf(earlier), after = PartsOf(now);
  if (!OfOneProgram(before, after))
  {
    return refused(ErrorCode::Unsupported, "was by another version of this program");
  }
  if (!OfOneInput(before, after))
  {
    return refused(
      ErrorCode::InvalidArgument, "had another input, or this one has been changed since");
  }
  return refused(ErrorCode::InvalidArgument,
    "had other options, which are needed to go on with it: " + DescribeOptions(before, after));
}

std::string DescribeOtherBuild(std::string_view earlier, std::string_view now)
{
  const Parts before = PartsOf(earlier), after = PartsOf(now);
  if (!OfOneProgram(before, after))
  {
    return "they are of another version of this program";
  }
  const std::string needed = "to go on with them by --resume, ";
  if (before[pathOfInput] != after[pathOfInput])
  {
    return needed + "their input " + std::string(before[pathOfInput]) + " is needed";
  }
  return OfOneInput(before, after)
           ? needed + DescribeOptions(before, after) + " is needed"
           : "their input has been changed since, so that --resume cannot go on with them";
}

}
