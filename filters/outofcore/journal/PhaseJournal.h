// SPDX-License-Identifier: BSD-3-Clause
// The checkpoints of a build: which phases are finished. A small file, always replaced as a whole.
#pragma once

#include "filters/core/Result.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

// A file that a phase has left.
struct JournalFile
{
  // Closed: a file that the phase did not need, such as that of attributes if there are none.
  static constexpr std::uint64_t noNumber = ~std::uint64_t{ 0 };

  std::string name;                // as the phase calls it
  std::uint64_t number = noNumber; // its name in the folder
  std::uint64_t bytes = 0;         // exact size
  // How many phases were finished when the file was given up; 0 if it is still needed.
  std::uint64_t releasedAfter = 0;
  // When the file was last written, in nanoseconds. If the time or the size differs, it is no
  // longer the file that the phase left.
  std::int64_t changed = 0;
  std::uint64_t sum = 0; // the XXH3 of its bytes
  bool operator==(const JournalFile&) const = default;
};

struct JournalPhase
{
  std::string name;
  std::vector<std::byte> blob;
  std::vector<JournalFile> files;
  bool operator==(const JournalPhase&) const = default;
};

struct PhaseJournal
{
  std::string fingerprint;
  std::vector<JournalPhase> phases; // in the order in which they were finished
  bool operator==(const PhaseJournal&) const = default;
};

// The journal as bytes: a mark, the version of this layout, the size in bytes, the journal itself,
// and an XXH3 checksum over all before it.
std::vector<std::byte> EncodeJournal(const PhaseJournal& journal);

// Errors: Damaged if EncodeJournal of this version did not write the bytes.
Result<PhaseJournal> DecodeJournal(std::span<const std::byte> bytes);

// The size of a journal, from its first journalHeadBytes; 0 if these do not begin a journal. So no
// memory is allocated for another file of this name.
inline constexpr std::size_t journalHeadBytes = 20;
std::uint64_t ClaimedJournalBytes(std::span<const std::byte> head);

// The number of finished phases after which a build can continue: all their files exist as the
// journal says, or were given up when no later phase needed them. isThere(file): whether a file of
// this number, size, time and checksum exists; it is called more than once.
template <class IsThere>
std::size_t UsablePhases(const PhaseJournal& journal, const IsThere& isThere)
{
  std::size_t usable = journal.phases.size();
  for (std::size_t i = 0; i < usable; ++i)
  {
    for (const JournalFile& file : journal.phases[i].files)
    {
      const bool lost = file.releasedAfter > 0
                          ? file.releasedAfter > usable
                          : file.number != JournalFile::noNumber && !isThere(file);
      if (lost)
      {
        // That file is missing now. Earlier phases may have given up files that this phase would
        // need again; so check from the beginning.
        usable = i;
        i = static_cast<std::size_t>(-1);
        break;
      }
    }
  }
  return usable;
}

}
