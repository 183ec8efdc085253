// SPDX-License-Identifier: BSD-3-Clause
#include "filters/app/OutputFolders.h"

#include "filters/core/SystemReason.h"
#include "filters/files/Folders.h"
#include "filters/program/Program.h"

#include <algorithm>
#include <utility>

namespace kdstream
{

Result<std::filesystem::path> CheckOutputAndFolders(
  const std::string& file, const std::string& input)
{
  CatchInterrupts();
  const auto check = [&]() -> Result<std::filesystem::path>
  {
    const Result<OutputFolders> folders = OutputFolders::Make(file);
    KDSTREAM_TRY(folders);
    return CheckOutput(file, OutputKind::File, { input });
  };
  Result<std::filesystem::path> output = check();
  ReleaseInterrupts();
  if (Interrupted())
  {
    return Error{ ErrorCode::Cancelled, "cancelled" };
  }
  return output;
}

Result<OutputFolders> OutputFolders::Make(const std::filesystem::path& file)
{
  namespace fs = std::filesystem;
  std::error_code status;
  std::vector<fs::path> missing; // each is the parent folder of the one before
  fs::path folder = file.parent_path();
  for (; !folder.empty() && !fs::exists(folder, status); folder = folder.parent_path())
  {
    missing.push_back(folder);
  }
  if (!folder.empty() && !fs::is_directory(folder, status))
  {
    return Error{ ErrorCode::InputOutput,
      "cannot be created in " + folder.string() + ", which is a file, not a folder" };
  }
  OutputFolders folders;
  for (auto next = missing.rbegin(); next != missing.rend(); ++next)
  {
    // create_directory may find that the folder exists: "a/b/" has the parent "a/b", and "." exists
    // as soon as its parent does. The name is stored before the folder is made, because afterwards
    // there may be no memory.
    folders.Made.push_back(*next);
    if (fs::create_directory(*next, status))
    {
      KDSTREAM_TRY(SyncFolder(next->has_parent_path() ? next->parent_path() : "."));
      continue;
    }
    folders.Made.pop_back();
    if (status)
    {
      return SystemError("cannot create the folder " + next->string(), status.value());
    }
  }
  return folders;
}

OutputFolders::OutputFolders(OutputFolders&& other) noexcept
  : Made(std::exchange(other.Made, {}))
{
}

OutputFolders& OutputFolders::operator=(OutputFolders&& other) noexcept
{
  std::swap(this->Made, other.Made);
  return *this;
}

OutputFolders::~OutputFolders()
{
  std::error_code ignored; // a folder that is not empty stays
  std::for_each(this->Made.rbegin(), this->Made.rend(),
    [&](const std::filesystem::path& folder) { std::filesystem::remove(folder, ignored); });
}

}
