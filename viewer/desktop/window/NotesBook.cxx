// SPDX-License-Identifier: BSD-3-Clause
#include "viewer/desktop/window/NotesBook.h"

#include "filters/core/Texts.h"

#include <algorithm>
#include <utility>

namespace kdstream
{
namespace
{

Status CheckLength(const std::string& what, const std::string& text, std::size_t most)
{
  if (CountCharacters(text) > most)
  {
    return Error{ ErrorCode::LimitExceeded,
      what + " may have at most " + std::to_string(most) + " characters" };
  }
  return {};
}

}

void NotesBook::Open(const std::string& model, std::vector<Note> notes)
{
  const auto written = this->Written.find(model);
  this->Id = model;
  this->All = written == this->Written.end() ? std::move(notes) : written->second;
  this->At.reset();
}

void NotesBook::Close()
{
  this->Id.clear();
  this->All.clear();
  this->At.reset();
}

std::string NotesBook::Show(std::size_t index)
{
  this->At = index;
  std::string link = "model=" + this->Id;
  const std::string& parts = this->All[index].link;
  for (std::size_t begin = 0; begin < parts.size();)
  {
    const std::size_t end = std::min(parts.find('&', begin), parts.size());
    const std::string part = parts.substr(begin, end - begin);
    if (!part.empty() && !part.starts_with("model="))
    {
      link += "&" + part;
    }
    begin = end + 1;
  }
  return link;
}

Status NotesBook::Keep(
  std::optional<std::size_t> index, std::string title, std::string text, const std::string& link)
{
  Note note = index ? this->All[*index] : Note{ "", "", link };
  note.title = Trimmed(RepairUtf8(title), " \t\r\n");
  note.text = RepairUtf8(text);
  if (note.title.empty())
  {
    return Error{ ErrorCode::InvalidArgument, "a note needs a title" };
  }
  KDSTREAM_TRY(CheckLength("a title", note.title, Note::longestTitle));
  KDSTREAM_TRY(CheckLength("a note", note.text, Note::longestText));
  if (note.link.size() > Note::longestLink)
  {
    return Error{ ErrorCode::LimitExceeded,
      "this view has too many distances for a note: remove some" };
  }
  if (!index && this->All.size() >= mostNotes)
  {
    return Error{ ErrorCode::LimitExceeded,
      "a model can have at most " + std::to_string(mostNotes) + " notes" };
  }
  std::vector<Note> notes = this->All;
  notes.insert(notes.end(), index ? 0 : 1, {});
  notes[index.value_or(notes.size() - 1)] = std::move(note);
  this->Change(std::move(notes));
  return {};
}

void NotesBook::Move(std::size_t index, int step)
{
  const std::size_t to = index + static_cast<std::size_t>(step); // wraps around below 0
  if (to < this->All.size())
  {
    std::vector<Note> notes = this->All;
    std::swap(notes[index], notes[to]);
    this->Change(std::move(notes));
  }
}

void NotesBook::Remove(std::size_t index)
{
  std::vector<Note> notes = this->All;
  notes.erase(notes.begin() + static_cast<std::ptrdiff_t>(index));
  this->Change(std::move(notes));
}

void NotesBook::Change(std::vector<Note> notes)
{
  this->All = std::move(notes);
  this->Written[this->Id] = this->All;
  this->At.reset();
}

}
