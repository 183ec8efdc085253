// SPDX-License-Identifier: BSD-3-Clause
#include "server/session/NotesFiles.h"

#include "filters/store/StoreNotes.h"

#include <sys/stat.h>

#include <utility>

namespace kdstream
{
namespace
{

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

// All zeros if there is no file.
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

// Notes what is known of the file. Returns whether this has changed.
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
  const Stamp stamp = this->StampOf(path); // before reading: a write meanwhile counts as new
  if (stamp == Stamp{})
  {
    this->Remember(id, {});
    return NoNotes();
  }
  auto text = ReadNotes(path);
  if (!text)
  {
    const Error& error = text.GetError();
    if (error.code == ErrorCode::NotFound) // the file was just removed
    {
      this->Remember(id, {});
    }
    else if (this->Remember(id, { stamp, 0 }))
    {
      this->Tell(path, error.message + "; the model is served without notes");
    }
    return error.code == ErrorCode::InputOutput ? error : NoNotes();
  }
  this->Remember(id, { stamp, text->notes.size() });
  return std::make_shared<const std::vector<std::uint8_t>>(std::move(text->bytes));
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
