// SPDX-License-Identifier: BSD-3-Clause
// The user's commands about notes in a window: see WindowController.h.
#include "filters/store/StoreNotes.h"
#include "viewer/desktop/MeshStore.h"
#include "viewer/desktop/OpenSource.h"
#include "viewer/desktop/window/WindowController.h"
#include "viewer/session/ViewLink.h"

#include <filesystem>

namespace kdstream
{
namespace
{

// The file for the notes: beside the store, if the source is a store or a folder of stores.
// Otherwise it is in the current folder, to be sent to the owner of the store.
std::filesystem::path NotesFile(const std::string& source, const std::string& model)
{
  std::error_code failure;
  const bool isHere =
    !NamesServer(source) && (std::filesystem::is_directory(source, failure) || IsStore(source));
  return isHere ? NotesFileIn(source, model) : NotesFileOf(model + ".kds");
}

}

void WindowController::Fulfil(const NotesWishes& wishes)
{
  NotesBook& book = this->Session.Notes();
  if (wishes.show)
  {
    this->ShowNote(*wishes.show);
  }
  if (wishes.list)
  {
    book.ShowList();
  }
  if (wishes.keep)
  {
    const auto& [index, title, text] = *wishes.keep;
    const Status kept = book.Keep(index, title, text, this->Link());
    this->Tell(kept ? "The note is not saved yet: use Save notes." : kept.GetError().message);
    if (kept)
    {
      this->Words.notes.EndEdit(book.Model());
      this->AskedToSave = false;
    }
  }
  if (wishes.move)
  {
    book.Move(wishes.move->first, wishes.move->second);
  }
  if (wishes.remove)
  {
    book.Remove(*wishes.remove);
  }
  if (wishes.save)
  {
    this->SaveNotes();
  }
  const bool changed = wishes.list || wishes.move || wishes.remove;
  this->FramesLeft = changed ? 2 : this->FramesLeft;
}

// Goes to the note's view, as a link would.
void WindowController::ShowNote(std::size_t index)
{
  const std::string text = this->Session.Notes().Show(index);
  const auto link = ParseViewLink(text);
  if (!link)
  {
    this->Tell("The view of this note is not valid: " + link.GetError().message);
    return;
  }
  this->Session.Do({ SessionStep::Kind::Link, {}, text });
  ViewSettings settings = this->Settings;
  settings.scene.colors = {};
  Perform({ SessionStep::Kind::Colors, {}, link->colors }, settings.scene);
  this->Apply(settings);
  this->FramesLeft = 2;
}

void WindowController::SaveNotes()
{
  NotesBook& book = this->Session.Notes();
  const std::filesystem::path file = NotesFile(this->Options.source, book.Model());
  const Status written = WriteNotes(file, book.Notes());
  if (!written)
  {
    this->Tell(file.string() + ": " + written.GetError().message);
    return;
  }
  book.Saved();
  this->Tell(
    "Wrote " + file.string() +
    (NamesServer(this->Options.source) ? ": put it beside " + book.Model() + ".kds on the server"
                                       : ""));
}

// While notes are unsaved, the first call does not end the program, but asks.
void WindowController::End()
{
  const bool isOutstanding = this->Session.Notes().HasUnsaved() || this->Words.notes.HasDraft();
  const bool asks = isOutstanding && !this->AskedToSave;
  this->AskedToSave = true;
  if (asks)
  {
    this->Tell("Some notes are not saved. Quit again to discard them.");
    return;
  }
  this->Ended = true;
}

}
