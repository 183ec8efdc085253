// SPDX-License-Identifier: BSD-3-Clause
// A folder of spill files that outlives a killed build. The next build of the same store continues
// after the last finished phase (doc/design.md#whole-or-not-there, doc/cli.md#resume).
#pragma once

#include "filters/core/Result.h"
#include "filters/outofcore/files/Blob.h"
#include "filters/outofcore/files/SpillFile.h"
#include "filters/outofcore/journal/PhaseJournal.h"

#include <cstddef>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace kdstream
{

// A file of a phase, with the name by which it is asked for. It is closed if the phase leaves
// nothing under this name; it may also be a file that an earlier phase left.
struct PhaseFile
{
  std::string name;
  SpillFile file;
};
// A killed build that could be resumed.
struct LeftBuild
{
  std::string fingerprint, lastPhase;
};
struct PhaseFileName
{
  std::string_view phase, file;
};

// A build is a list of phases that always come in the same order. Each phase makes files in Files()
// and keeps some of them, and a few values, with Finish. Later phases read them by TakeFile and
// BlobOf:
//
//   if (!folder.Finished("tree"))
//   {
//     … files from folder.Files() …
//     PhaseFile files[] = { { "records", std::move(records) } };
//     status = folder.Finish("tree", blob, files);
//   }
//   BlobReader blob = folder.BlobOf("tree");
//   Result<SpillFile> records = folder.TakeFile("tree", "records");
//
// When the files are on the disk, the journal (PhaseJournal.h) is replaced by a write and a rename.
// So after a kill or a power cut the phases finished before are there, with or without the current
// one. Folder and lock are removed when this object and all its files are destroyed, after errors
// too (doc/cli.md#resume), unless Keep is set.
class BuildFolder
{
public:
  // What Open found of an earlier build.
  enum class Found
  {
    Nothing,  // no journal: none, or one that was killed before its first phase was finished
    Damaged,  // a journal that cannot be read, or is of another version
    SameBuild // some of its phases may be usable
  };

  // The folder for builds of `store`: a hidden folder in temporaryFolder, or, if that is empty,
  // beside the store. Its name has a hash of the store's absolute path, so builds of different
  // stores have different folders.
  static std::filesystem::path PathFor(
    const std::filesystem::path& store, const std::filesystem::path& temporaryFolder);

  // Makes the folder, or opens an existing one. Without `resume` all its content is removed; with
  // it, everything that the journal does not name. A phase counts as not finished if one of its
  // files is missing, or has another size, sum or time; so do all phases after it. A damaged
  // journal counts as no journal. Each file is read once for this check. hook: for tests. Errors:
  // InputOutput if the folder cannot be made or is not this user's; LimitExceeded if another
  // process is building in it (a lock on PATH.lock, which the system releases when the process
  // ends). With `resume` also those of CheckSameBuild; nothing is changed then.
  static Result<BuildFolder> Open(const std::filesystem::path& path, std::string_view fingerprint,
    bool resume, FileHook hook = {});

  // From where a build of the same fingerprint could continue with `resume`. Nothing if no phase is
  // finished, or if a build is running there. Changes nothing; checks only the files' sizes and
  // times.
  static std::optional<LeftBuild> LeftIn(const std::filesystem::path& path);

  BuildFolder(BuildFolder&&) noexcept = default;
  BuildFolder& operator=(BuildFolder&&) = delete;
  ~BuildFolder();

  // Where files are made. They go with their owners until a phase is finished with them.
  SpillFolder& Files() { return this->Folder; }

  bool Finished(std::string_view phase) const;
  std::size_t FinishedPhases() const { return this->Journal.phases.size(); }
  // The last of them. REQUIRES: FinishedPhases() > 0.
  const std::string& LastPhase() const { return this->Journal.phases.back().name; }
  Found WhatWasFound() const { return this->Earlier; }
  // Whether phases that were finished do not count any more, because their files are missing or
  // damaged.
  bool HasLostPhases() const { return this->Lost; }

  // Finishes a phase: it leaves these files, which are closed and read-only from now on. `givenUp`
  // names files of this and earlier phases that no later phase needs (an empty file name means all
  // of a phase); they are removed. Both happen or neither, wherever the process is killed. Waits
  // for the disk. Errors: InputOutput; then the phase is not finished. REQUIRES: !Finished(phase);
  // names of files differ; `files` come from Files().
  Status Finish(std::string_view phase, const BlobWriter& blob, std::span<PhaseFile> files = {},
    std::initializer_list<PhaseFileName> givenUp = {});

  // The values that a phase left. REQUIRES: Finished(phase).
  BlobReader BlobOf(std::string_view phase) const;
  // A file that a phase left, for reading, any number of times; closed if the phase left it closed.
  // Errors: InputOutput; NotFound for a name that the phase did not leave, or that was given up.
  Result<SpillFile> TakeFile(std::string_view phase, std::string_view file) const;

  // Whether the files of finished phases stay when this object is destroyed, for a later build with
  // `resume`. Default: no.
  void Keep(bool keep);

private:
  explicit BuildFolder(SpillFolder folder)
    : Folder(std::move(folder))
    , JournalPath(this->Folder.Path() / journalName)
  {
  }

  std::filesystem::path PathOf(std::uint64_t number) const;
  Status TakeUp(std::string_view fingerprint, bool resume);
  // Whether the file of a phase is there, by its size and time.
  bool IsThere(const JournalFile& file) const;
  // Also compares its checksum.
  bool IsWhole(const JournalFile& file) const;
  void RemoveUnnamed();
  Result<PhaseJournal> ReadJournal() const;
  // Marks the files as given up; their numbers and sizes, but those that another entry still needs.
  static std::vector<JournalFile> GiveUp(
    PhaseJournal& journal, std::initializer_list<PhaseFileName> files);
  Status WriteJournal(const PhaseJournal& journal);
  const JournalPhase* Find(std::string_view phase) const;
  Result<SpillFile> OpenKept(
    const std::filesystem::path& path, std::string_view purpose, const JournalFile& file) const;

  static constexpr const char* journalName = "journal";

  SpillFolder Folder;
  std::filesystem::path JournalPath; // made early, because the destructor must not need memory
  PhaseJournal Journal;
  Found Earlier = Found::Nothing;
  bool Lost = false;
};

}
