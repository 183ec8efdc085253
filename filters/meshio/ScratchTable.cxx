// SPDX-License-Identifier: BSD-3-Clause
// A table of records on disk, in a file without a name: see ScratchTable.h.
#include "filters/meshio/ScratchTable.h"

#include "filters/core/SystemReason.h"
#include "filters/files/Folders.h"

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstdlib>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

namespace kdstream
{

ScratchFile::ScratchFile(std::filesystem::path folder, std::size_t recordSize)
  : Folder(std::move(folder))
  , RecordSize(recordSize)
  , RecordsPerBlock(blockSize / recordSize)
  , Slots(slotCount)
{
  assert(recordSize > 0 && recordSize <= blockSize);
}

ScratchFile::~ScratchFile()
{
  if (this->Descriptor >= 0)
  {
    close(this->Descriptor);
  }
}

Error ScratchFile::Failure(const char* what) const
{
  return Error{ ErrorCode::InputOutput,
    "a temporary file in " + this->Folder.string() + " cannot be " + what + ": " +
      SystemReason(errno) + " (" + std::to_string(this->Blocks * blockSize) + " bytes are in it)",
    this->Folder.string() };
}

// Makes the file. Called only when a block must leave memory: small tables need no file.
Status ScratchFile::Open()
{
  if (this->Folder.empty())
  {
    std::error_code status;
    this->Folder = std::filesystem::temp_directory_path(status);
  }
  this->Descriptor = OpenNameless(this->Folder);
  return this->Descriptor >= 0 ? Status() : this->Failure("made");
}

Status ScratchFile::Write(const Slot& slot)
{
  if (this->Descriptor < 0)
  {
    KDSTREAM_TRY(this->Open());
  }
  for (std::size_t done = 0; done < blockSize;)
  {
    const ssize_t put = pwrite(this->Descriptor, slot.bytes.get() + done, blockSize - done,
      static_cast<off_t>(slot.block * blockSize + done));
    if (put < 0 && errno != EINTR)
    {
      return this->Failure("written");
    }
    done += put < 0 ? 0 : static_cast<std::size_t>(put);
  }
  this->Blocks = std::max(this->Blocks, slot.block + 1);
  return {};
}

// Writes the slot's block if it has changed, and reads the wanted block.
Status ScratchFile::Load(Slot& slot, std::uint64_t block)
{
  if (slot.changed)
  {
    KDSTREAM_TRY(this->Write(slot));
    slot.changed = false;
  }
  if (!slot.bytes)
  {
    slot.bytes = std::make_unique<char[]>(blockSize);
  }
  std::size_t done = 0;
  while (block < this->Blocks && done < blockSize)
  {
    const ssize_t got = pread(this->Descriptor, slot.bytes.get() + done, blockSize - done,
      static_cast<off_t>(block * blockSize + done));
    if (got < 0 && errno != EINTR)
    {
      return this->Failure("read");
    }
    if (got == 0)
    {
      break;
    }
    done += got < 0 ? 0 : static_cast<std::size_t>(got);
  }
  std::memset(slot.bytes.get() + done, 0, blockSize - done);
  slot.block = block;
  return {};
}

}
