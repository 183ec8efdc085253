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

// A file of a phase, and the name by which later phases request it. The file is closed if the phase
// leaves nothing under this name. It may be a file that an earlier phase left.
struct PhaseFile
{
  std::string name;
  SpillFile file;
};
// A killed build that can be resumed.
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
// Once the files are on the disk, the journal (PhaseJournal.h) is replaced by a write and a rename.
// So after a kill or a power cut all phases that were finished before are there, with or without
// the current one. Folder and lock are removed when this object and all its files are destroyed,
// also after errors (doc/cli.md#resume), unless Keep is set.
class BuildFolder
{
public:
  // What Open found of an earlier build.
  enum class Found
  {
    Nothing,  // no journal: no build, or one that was killed during its first phase
    Damaged,  // the journal cannot be read, or is of another version
    SameBuild // some of its phases may be usable
  };

  // The folder for builds of `store`: a hidden folder in temporaryFolder, or beside the store if
  // temporaryFolder is empty. The folder's name contains a hash of the store's absolute path, so
  // builds of different stores have different folders.
  static std::filesystem::path PathFor(
    const std::filesystem::path& store, const std::filesystem::path& temporaryFolder);

  // Makes the folder, or opens an existing one. Without `resume` all its content is removed; with
  // `resume`, only files that the journal does not name. A phase counts as not finished if one of
  // its files is missing, or has another size, checksum or time; then all phases after it do not
  // count either. A damaged journal counts as no journal. Each file is read once for this check.
  // hook: for tests. Errors: InputOutput if the folder cannot be made or is not this user's;
  // LimitExceeded if another process is building in it (a lock on PATH.lock, which the system
  // releases when the process ends). With `resume` also the errors of CheckSameBuild; nothing is
  // changed then.
  static Result<BuildFolder> Open(const std::filesystem::path& path, std::string_view fingerprint,
    bool resume, FileHook hook = {});

  // Where a build with the same fingerprint could continue with `resume`. Nothing if no phase is
  // finished, or if a build is running there. Changes nothing; checks only the sizes and times of
  // the files.
  static std::optional<LeftBuild> LeftIn(const std::filesystem::path& path);

  BuildFolder(BuildFolder&&) noexcept = default;
  BuildFolder& operator=(BuildFolder&&) = delete;
  ~BuildFolder();

  // The folder for new files. Each file is removed with its owner, unless Finish keeps it.
  SpillFolder& Files() { return this->Folder; }

  bool Finished(std::string_view phase) const;
  std::size_t FinishedPhases() const { return this->Journal.phases.size(); }
  // The last finished phase. REQUIRES: FinishedPhases() > 0.
  const std::string& LastPhase() const { return this->Journal.phases.back().name; }
  Found WhatWasFound() const { return this->Earlier; }
  // Whether some finished phases no longer count, because their files are missing or damaged.
  bool HasLostPhases() const { return this->Lost; }

  // Finishes a phase, which leaves `files`; from now on they are closed and read-only. `givenUp`
  // names files of this and earlier phases that no later phase needs; they are removed. (An empty
  // file name means all files of the phase.) Either both happen or neither, wherever the process is
  // killed. Waits until the files are on the disk. Errors: InputOutput; then the phase is not
  // finished. REQUIRES: !Finished(phase); the names of the files differ; `files` come from Files().
  Status Finish(std::string_view phase, const BlobWriter& blob, std::span<PhaseFile> files = {},
    std::initializer_list<PhaseFileName> givenUp = {});

  // The values that a phase left. REQUIRES: Finished(phase).
  BlobReader BlobOf(std::string_view phase) const;
  // Opens a file that a phase left, for reading; may be called any number of times. The file is
  // closed if the phase left it closed. Errors: InputOutput; NotFound if the phase did not leave a
  // file of this name, or if it was given up.
  Result<SpillFile> TakeFile(std::string_view phase, std::string_view file) const;

  // Whether the files of finished phases stay when this object is destroyed, so that a later build
  // can resume. Default: no.
  void Keep(bool keep);

private:
  explicit BuildFolder(SpillFolder folder)
    : Folder(std::move(folder))
    , JournalPath(this->Folder.Path() / journalName)
  {
  }

  std::filesystem::path PathOf(std::uint64_t number) const;
  Status TakeUp(std::string_view fingerprint, bool resume);
  // Whether the file exists with the size and time that the journal says.
  bool IsThere(const JournalFile& file) const;
  // The same, and whether its checksum is right too.
  bool IsWhole(const JournalFile& file) const;
  void RemoveUnnamed();
  Result<PhaseJournal> ReadJournal() const;
  // Marks the files as given up. Returns those that can be removed, because no other entry needs
  // them.
  static std::vector<JournalFile> GiveUp(
    PhaseJournal& journal, std::initializer_list<PhaseFileName> files);
  Status WriteJournal(const PhaseJournal& journal);
  const JournalPhase* Find(std::string_view phase) const;
  Result<SpillFile> OpenKept(
    const std::filesystem::path& path, std::string_view purpose, const JournalFile& file) const;

  static constexpr const char* journalName = "journal";

  SpillFolder Folder;
  std::filesystem::path JournalPath; // made early, because the destructor must not allocate
  PhaseJournal Journal;
  Found Earlier = Found::Nothing;
  bool Lost = false;
};

}
