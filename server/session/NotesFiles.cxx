// SPDX-License-Identifier: BSD-3-Clause
#include "server/session/NotesFiles.h"

#include "filters/core/SystemReason.h"
#include "filters/model/Notes.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

namespace kdstream
{

namespace
{

// An open file, closed at the end.
class OpenFile
{
public:
  // Not waiting: what has the name may be a pipe that nobody writes to.
  explicit OpenFile(const std::filesystem::path& file)
    : Number(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK))
  {
  }
  ~OpenFile()
  {
    if (this->Number >= 0)
    {
      ::close(this->Number);
    }
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  const int Number;
};

// At most maximumNotesBytes, and one more where there are more.
Result<std::vector<std::uint8_t>> ReadBytes(int file)
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

Error NoNotes()
{
  return { ErrorCode::NotFound, "there are no notes" };
}

}

NotesFiles::NotesFiles(std::filesystem::path folder, Report report)
  : Folder(std::move(folder))
  , Tell(std::move(report))
{
}

std::filesystem::path NotesFiles::FileOf(std::string_view id) const
{
  return this->Folder / (std::string(id) + ".notes.json");
}

// Zeros for no file.
NotesFiles::Stamp NotesFiles::StampOf(const std::filesystem::path& file) const
{
  struct stat found
  {
  };
  if (::stat(file.c_str(), &found) != 0)
  {
    return {};
  }
  return { found.st_ino, found.st_size, found.st_mtim.tv_sec, found.st_mtim.tv_nsec };
}

// Whether the file is another one.
bool NotesFiles::Remember(const std::string& id, const Known& known)
{
  const std::lock_guard lock(this->Mutex);
  const auto found = this->Files.find(id);
  const Known before = found == this->Files.end() ? Known{} : found->second;
  if (known == before)
  {
    return false;
  }
  ++this->Changes;
  if (known.stamp == Stamp{})
  {
    this->Files.erase(found);
  }
  else
  {
    this->Files[id] = known;
  }
  return known.stamp != before.stamp;
}

Result<BlobBytes> NotesFiles::Read(const std::string& id)
{
  const auto path = this->FileOf(id);
  const Stamp stamp = this->StampOf(path); // before it is read: what is written meanwhile is new
  if (stamp == Stamp{})
  {
    this->Remember(id, {});
    return NoNotes();
  }
  const auto refuse = [&](const std::string& what)
  {
    if (this->Remember(id, { stamp, 0 }))
    {
      this->Tell(path, what + "; the model is served without notes");
    }
  };
  const OpenFile file(path);
  struct stat found
  {
  };
  if (file.Number < 0 || ::fstat(file.Number, &found) != 0)
  {
    const auto error = SystemError("cannot be read", errno);
    refuse(error.message);
    return error;
  }
  if (!S_ISREG(found.st_mode))
  {
    refuse("is no file");
    return NoNotes();
  }
  auto bytes = ReadBytes(file.Number);
  if (!bytes)
  {
    refuse(bytes.GetError().message);
    return bytes.GetError();
  }
  const auto notes = ParseNotes({ reinterpret_cast<const char*>(bytes->data()), bytes->size() });
  if (!notes)
  {
    refuse(notes.GetError().message);
    return NoNotes();
  }
  this->Remember(id, { stamp, notes->size() });
  return std::make_shared<const std::vector<std::uint8_t>>(std::move(*bytes));
}

std::size_t NotesFiles::Count(std::string_view id) const
{
  const std::lock_guard lock(this->Mutex);
  const auto found = this->Files.find(id);
  return found == this->Files.end() ? 0 : found->second.count;
}

std::uint64_t NotesFiles::Version() const
{
  const std::lock_guard lock(this->Mutex);
  return this->Changes;
}

bool NotesFiles::HasChanged(const std::string& id) const
{
  const Stamp stamp = this->StampOf(this->FileOf(id));
  const std::lock_guard lock(this->Mutex);
  const auto found = this->Files.find(id);
  return found == this->Files.end() ? stamp != Stamp{} : found->second.stamp != stamp;
}

}
