// SPDX-License-Identifier: BSD-3-Clause
// The file of notes beside a store: NAME.notes.json beside NAME.kds (the format:
// filters/model/Notes.h).
#pragma once

#include "filters/core/Result.h"
#include "filters/model/Notes.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace kdstream
{

struct NotesText
{
  std::vector<std::uint8_t> bytes; // as in the file
  std::vector<Note> notes;         // the parsed notes
};

std::filesystem::path NotesFileOf(const std::filesystem::path& store);
// The file of notes of a model. The path that was opened is either its store or a folder of stores.
std::filesystem::path NotesFileIn(
  const std::filesystem::path& storeOrFolder, const std::string& model);

// Reads at most maximumNotesBytes, and does not wait if the file is a pipe. Errors: NotFound if
// there is no such file; those of ParseNotes; InvalidInput if it is not a regular file;
// InputOutput.
Result<NotesText> ReadNotes(const std::filesystem::path& file);

// Writes the notes. Whatever happens, the file has either all of them or its old content. Errors:
// LimitExceeded for more than maximumNotesBytes; InputOutput.
Status WriteNotes(const std::filesystem::path& file, const std::vector<Note>& notes);

}
