// SPDX-License-Identifier: BSD-3-Clause
// Notes on the model in Dear ImGui: a tour of the notes, and fields for an author to edit them.
#pragma once

#include "viewer/desktop/window/NotesBook.h"

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace kdstream
{

// What the user asked for in one frame.
struct NotesWishes
{
  struct Written
  {
    std::optional<std::size_t> index; // nothing: a new note, on the current view
    std::string title, text;
  };
  std::optional<std::size_t> show, remove;
  std::optional<std::pair<std::size_t, int>> move; // moves a note by one place
  std::optional<Written> keep;
  bool list = false, save = false;
};

class NotesPanel
{
public:
  bool isOpen = false;

  // width: of the window, pixels. ratio: pixels per point.
  NotesWishes Draw(const NotesBook& book, int width, double ratio);
  // Discards the text in this model's fields.
  void EndEdit(const std::string& model) { this->Drafts.erase(model); }
  // Whether there is text in the fields of any model that would be lost.
  bool HasDraft() const;

private:
  void DrawShown(const NotesBook& book, NotesWishes& wishes) const;
  void DrawList(const NotesBook& book, NotesWishes& wishes);
  // The text for one model is kept while other models are viewed.
  struct Fields
  {
    std::optional<std::size_t> index;
    std::string title, text;
    std::string oldTitle{}, oldText{};
    bool isNew = true; // the fields have not had the keyboard focus yet
  };
  void DrawFields(Fields& fields, const std::string& model, NotesWishes& wishes);
  void Edit(const std::string& model, std::optional<std::size_t> index, const Note& note);

  std::map<std::string, Fields> Drafts; // by model
  double Ratio = 1;
};

}
