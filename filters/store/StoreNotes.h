// SPDX-License-Identifier: BSD-3-Clause
// The notes that lie beside a store: NAME.notes.json beside NAME.kds (filters/model/Notes.h has
// their form).
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
  std::vector<std::uint8_t> bytes; // as the file has them
  std::vector<Note> notes;         // what they say
};

std::filesystem::path NotesFileOf(const std::filesystem::path& store);
// Of a model in what was opened: its store, or a folder of stores.
std::filesystem::path NotesFileIn(
  const std::filesystem::path& storeOrFolder, const std::string& model);

// Reads at most maximumNotesBytes, and waits for no writer of a pipe. Errors: NotFound where there
// is no such file; those of ParseNotes; InvalidInput for what is no file; InputOutput.
Result<NotesText> ReadNotes(const std::filesystem::path& file);

// The file has the notes whole, or as it was before. Errors: LimitExceeded where they would be more
// than maximumNotesBytes; InputOutput.
Status WriteNotes(const std::filesystem::path& file, const std::vector<Note>& notes);

}
