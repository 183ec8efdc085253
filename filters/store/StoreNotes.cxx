// SPDX-License-Identifier: BSD-3-Clause
#include "filters/store/StoreNotes.h"

#include "filters/core/SystemReason.h"
#include "filters/files/NewFile.h"
#include "filters/files/WriteWhole.h"
#include "filters/store/OpenFile.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <utility>

namespace kdstream
{
namespace
{

// Reads at most maximumNotesBytes + 1, so that a longer file is noticed.
Result<std::vector<std::uint8_t>> ReadNotesBytes(int file)
{
  std::vector<std::uint8_t> bytes(maximumNotesBytes + 1);
  std::size_t end = 0;
  while (end < bytes.size())
  {
    const auto got = ::read(file, bytes.data() + end, bytes.size() - end);
    if (got < 0 && errno != EINTR)
    {
      return SystemError("cannot be read", errno);
    }
    if (got == 0)
    {
      break;
    }
    end += got > 0 ? static_cast<std::size_t>(got) : 0;
  }
  bytes.resize(end);
  return bytes;
}

}

std::filesystem::path NotesFileOf(const std::filesystem::path& store)
{
  return store.parent_path() / (store.stem().string() + ".notes.json");
}

std::filesystem::path NotesFileIn(
  const std::filesystem::path& storeOrFolder, const std::string& model)
{
  std::error_code failure;
  return NotesFileOf(std::filesystem::is_directory(storeOrFolder, failure)
                       ? storeOrFolder / (model + ".kds")
                       : storeOrFolder);
}

Result<NotesText> ReadNotes(const std::filesystem::path& path)
{
  const OpenFile file(path, O_NONBLOCK); // a pipe may have this name, and nobody may write to it
  struct stat found
  {
  };
  if (file.descriptor < 0 && errno == ENOENT)
  {
    return Error{ ErrorCode::NotFound, "there are no notes" };
  }
  if (file.descriptor < 0 || ::fstat(file.descriptor, &found) != 0)
  {
    return SystemError("cannot be read", errno);
  }
  if (!S_ISREG(found.st_mode))
  {
    return Error{ ErrorCode::InvalidInput, "is not a file" };
  }
  auto bytes = ReadNotesBytes(file.descriptor);
  KDSTREAM_TRY(bytes);
  auto notes = ParseNotes({ reinterpret_cast<const char*>(bytes->data()), bytes->size() });
  KDSTREAM_TRY(notes);
  return NotesText{ std::move(*bytes), std::move(*notes) };
}

Status WriteNotes(const std::filesystem::path& file, const std::vector<Note>& notes)
{
  const std::string text = FormatNotes(notes);
  if (text.size() > maximumNotesBytes)
  {
    return Error{ ErrorCode::LimitExceeded,
      "these notes are too long to be served: " + std::to_string(text.size()) + " bytes, at most " +
        std::to_string(maximumNotesBytes) };
  }
  NewFile::RemoveLeftovers(file);
  return WriteWhole(file, text);
}

}
