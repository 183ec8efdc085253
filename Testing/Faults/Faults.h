// SPDX-License-Identifier: BSD-3-Clause
// Controls the fault library (FaultShim.cxx), which is loaded before all other libraries of a
// program. The control is a file that both the program and its test have mapped.
#pragma once

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <utility>

namespace kdstream
{

inline constexpr const char* faultsVariable = "KDSTREAM_FAULTS"; // the path of the control file
// Used without a control file, to repeat one failure (also in a debugger):
// "KIND,CALL,once|on,ERRNO".
inline constexpr const char* faultVariable = "KDSTREAM_FAULT";
// The path of a file in which the program's operations on files are recorded: Recording.h.
inline constexpr const char* recordVariable = "KDSTREAM_RECORD";
// "READ,WRITE": two descriptors. If they are given, main runs in a child process for each byte
// received. The way in which the child ended (waitpid's status) is sent back.
inline constexpr const char* runsVariable = "KDSTREAM_RUNS";

// Calls of one kind: which of them fail.
struct Fault
{
  std::atomic<std::uint64_t> calls{ 0 }; // number of calls so far
  std::atomic<int> reason{ 0 };          // the errno of calls that fail; 0: none fails
  // Calls are numbered from 1. The calls from first to last fail, or only every 'every'-th of
  // these.
  std::atomic<std::uint64_t> first{ 1 }, last{ ~std::uint64_t{ 0 } }, every{ 1 };

  void operator=(int why) { this->Fail(why, 1, ~std::uint64_t{ 0 }); } // from now on
  void FailEvery(std::uint64_t so, int why)
  {
    this->Fail(why, 1, ~std::uint64_t{ 0 });
    this->every = so;
  }
  void Fail(int why, std::uint64_t begin, std::uint64_t end)
  {
    this->reason = 0;
    this->calls = 0;
    this->first = begin;
    this->last = end;
    this->every = 1;
    this->reason = why;
  }
};

struct Faults
{
  Fault reading;   // of regular files: read, pread; fread is left out
  Fault writing;   // to regular files except stdout and stderr: write, pwrite, copy_file_range
  Fault opening;   // any file or folder, for reading
  Fault creating;  // or opening for writing; folders, too
  Fault looking;   // stat and similar calls
  Fault syncing;   // fsync, fdatasync
  Fault sizing;    // ftruncate, fallocate
  Fault renaming;  // rename, link
  Fault removing;  // unlink, rmdir
  Fault owning;    // fchmod, fchown, flock
  Fault mapping;   // mmap
  Fault starting;  // of threads
  Fault accepting; // of connections
  Fault tls;       // SSL_new
  Fault allocation;
  // While `hanging` is not 0, calls on files and folders whose path contains this word do not
  // return, as if a disk, or another machine's disk, did not answer.
  static constexpr const char* hangingWord = "hangs";
  std::atomic<int> hanging{ 0 };
  std::atomic<std::uint64_t> leastBytes{ 0 }; // only allocations of at least this size fail
  // The process sees a system time that is this number of seconds ahead.
  std::atomic<std::int64_t> ahead{ 0 };

  // How often a fault of any kind has occurred.
  std::atomic<std::uint64_t> struck{ 0 };

  void Clear();
};

// All kinds, by the names that tests give them.
inline constexpr std::array<std::pair<const char*, Fault Faults::*>, 15> faultKinds{ {
  { "allocation", &Faults::allocation },
  { "reading", &Faults::reading },
  { "writing", &Faults::writing },
  { "opening", &Faults::opening },
  { "creating", &Faults::creating },
  { "looking", &Faults::looking },
  { "syncing", &Faults::syncing },
  { "sizing", &Faults::sizing },
  { "renaming", &Faults::renaming },
  { "removing", &Faults::removing },
  { "owning", &Faults::owning },
  { "mapping", &Faults::mapping },
  { "starting", &Faults::starting },
  { "accepting", &Faults::accepting },
  { "tls", &Faults::tls },
} };

inline void Faults::Clear()
{
  for (const auto& [name, kind] : faultKinds)
  {
    (this->*kind) = 0;
  }
  this->hanging = 0;
  this->leastBytes = 0;
  this->ahead = 0;
}

// Maps the control file; creates it if it does not exist. Null if this fails.
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
