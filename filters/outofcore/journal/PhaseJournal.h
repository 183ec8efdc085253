// SPDX-License-Identifier: BSD-3-Clause
// A build's checkpoints: which phases are finished. A small file, replaced as a whole.
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
  // Closed: a file that the phase did not need, as that of attributes if there are none.
  static constexpr std::uint64_t noNumber = ~std::uint64_t{ 0 };

  std::string name;                // as the phase calls it
  std::uint64_t number = noNumber; // its name in the folder
  std::uint64_t bytes = 0;         // exactly
  // How many phases were finished when the file was given up; 0: it is still needed.
  std::uint64_t releasedAfter = 0;
  // When the file was last written, in nanoseconds. If the time or the size differs, it is not the
  // file that the phase has left.
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

// Errors: Damaged for whatever EncodeJournal did not write, also by another version.
Result<PhaseJournal> DecodeJournal(std::span<const std::byte> bytes);

// The size of a journal, from its first journalHeadBytes; 0 if these are not a journal's, so that
// no memory is taken for another file of this name.
inline constexpr std::size_t journalHeadBytes = 20;
std::uint64_t ClaimedJournalBytes(std::span<const std::byte> head);

// The number of finished phases from which a build can continue: their files exist as the journal
// says, or were given up when no later phase needed them. isThere(file): whether a file of that
// number, size, time and sum exists; called more than once.
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
        // Phases before this one may have given up files that it needs again.
        usable = i;
        i = static_cast<std::size_t>(-1);
        break;
      }
    }
  }
  return usable;
}

}
