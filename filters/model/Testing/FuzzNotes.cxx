// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer's entry point for files of notes: accepted notes are within their limits, and survive
// being written and read again.
#include "filters/core/Texts.h"
#include "filters/model/Notes.h"

#include <cstdint>
#include <cstdlib>

using namespace kdstream;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const auto notes = ParseNotes({ reinterpret_cast<const char*>(data), size });
  if (!notes)
  {
    return 0;
  }
  bool good = notes->size() <= mostNotes;
  for (const Note& note : *notes)
  {
    good = good && IsUtf8(note.title) && IsUtf8(note.text) && IsUtf8(note.link) &&
           !note.title.empty() && note.link.size() <= Note::longestLink;
  }
  const auto text = FormatNotes(*notes);
  const auto back = ParseNotes(text);
  // Written again, with indentation, they may take too many bytes.
  good = good && (back ? *back == *notes : text.size() > maximumNotesBytes);
  if (!good)
  {
    std::abort();
  }
  return 0;
}
