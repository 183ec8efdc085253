// SPDX-License-Identifier: BSD-3-Clause
// The notes on the model that is viewed: which note is shown, and what an author writes. No
// widgets, no files.
#pragma once

#include "filters/core/Result.h"
#include "filters/model/Notes.h"

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace kdstream
{

// Unsaved notes on a model are kept while other models are viewed.
class NotesBook
{
public:
  // Takes the model's notes, unless there are unsaved changes to them; those are kept instead.
  void Open(const std::string& model, std::vector<Note> notes);
  // No model is viewed any more.
  void Close();

  const std::string& Model() const { return this->Id; }
  const std::vector<Note>& Notes() const { return this->All; }
  // The note that is shown; nothing if the list of notes is shown.
  std::optional<std::size_t> Shown() const { return this->At; }
  bool IsUnsaved() const { return this->Written.contains(this->Id); }
  // Whether any model has unsaved notes.
  bool HasUnsaved() const { return !this->Written.empty(); }

  void ShowList() { this->At.reset(); }
  // Shows the note, and returns the link to the note's view. The link is applied to this model,
  // whatever model the note names. REQUIRES: index < Notes().size().
  std::string Show(std::size_t index);

  // Replaces the note `index`, keeping its view and language; without `index`, appends a note.
  // Blanks around the title are removed. Errors: InvalidArgument for a note without a title;
  // LimitExceeded for texts longer than Note allows, and for more than mostNotes.
  Status Keep(
    std::optional<std::size_t> index, std::string title, std::string text, const std::string& link);
  // Moves the note by one place: step -1 or 1. A note at the end of the list does not move past it.
  void Move(std::size_t index, int step);
  void Remove(std::size_t index);
  void Saved() { this->Written.erase(this->Id); }

private:
  void Change(std::vector<Note> notes);

  std::string Id;
  std::vector<Note> All;
  std::optional<std::size_t> At;
  std::map<std::string, std::vector<Note>> Written; // by model
};

}
