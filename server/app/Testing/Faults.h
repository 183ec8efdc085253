// SPDX-License-Identifier: BSD-3-Clause
// What the library of faults (FaultShim.cxx), which is loaded before all others of a program, does
// to it: told by a file that the program and its test have mapped.
#pragma once

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <string>

namespace kdstream
{

inline constexpr const char* faultsVariable = "KDSTREAM_FAULTS"; // the file's path

// Numbers of errno; 0: all is well.
struct Faults
{
  // As if the disk hung: of all threads but the main one, for as long as it is set.
  static constexpr int hangs = -1;

  std::atomic<int> reading{ 0 };   // of regular files: read, pread
  std::atomic<int> writing{ 0 };   // to regular files: write, pwrite
  std::atomic<int> opening{ 0 };   // of any file, to read
  std::atomic<int> accepting{ 0 }; // of connections
  std::atomic<int> tls{ 0 };       // SSL_new
  // What is asked of files and folders whose path has this word in it does not come back while
  // `hanging` is not 0: a disk, or another machine's, that does not answer.
  static constexpr const char* hangingWord = "hangs";
  std::atomic<int> hanging{ 0 };
  // Every so manieth allocation fails, of those of at least `leastBytes`; 0: none.
  std::atomic<std::uint64_t> allocation{ 0 };
  std::atomic<std::uint64_t> leastBytes{ 0 };
  // The system's time is so many seconds ahead of what it is.
  std::atomic<std::int64_t> ahead{ 0 };

  // How often any of them has struck.
  std::atomic<std::uint64_t> struck{ 0 };
  std::atomic<std::uint64_t> allocations{ 0 };

  void Clear()
  {
    this->reading = this->writing = this->opening = this->accepting = this->tls = 0;
    this->hanging = 0;
    this->allocation = 0;
    this->leastBytes = 0;
    this->ahead = 0;
  }
};

// The file, mapped; made if it is not there. Null where that fails.
inline Faults* MapFaults(const char* path, bool isNew)
{
  const int file = ::open(path, O_RDWR | O_CLOEXEC | (isNew ? O_CREAT : 0), 0600);
  if (file < 0)
  {
    return nullptr;
  }
  void* place = isNew && ::ftruncate(file, sizeof(Faults)) != 0
                  ? MAP_FAILED
                  : ::mmap(nullptr, sizeof(Faults), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  ::close(file);
  if (place == MAP_FAILED)
  {
    return nullptr;
  }
  return isNew ? new (place) Faults : static_cast<Faults*>(place);
}

}
