// SPDX-License-Identifier: BSD-3-Clause
// Notes on a model: texts, each with its view, in the order of a tour. They are in a file beside
// the store (NAME.notes.json beside NAME.kds), and can be changed without changing the store.
//
// The file is an annotation list in IIIF style (W3C Web Annotation, IIIF Presentation 3):
//
//   { "@context": "http://iiif.io/api/presentation/3/context.json", "type": "AnnotationPage",
//     "items": [ { "type": "Annotation", "motivation": "commenting",
//       "label": { "en": [ "The crack" ] },
//       "body": { "type": "TextualBody", "format": "text/plain", "language": "en",
//                 "value": "It is from 1687." },
//       "target": { "type": "SpecificResource", "source": "model.json",
//         "selector": { "type": "FragmentSelector", "value": "model=dragon&view=AX9…" } } } ] }
#pragma once

#include "filters/core/Result.h"

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

// Texts are plain, even if they look like markup.
struct Note
{
  std::string title;      // 1 to longestTitle characters
  std::string text;       // at most longestText characters
  std::string link;       // the view as in a link (viewer/session/ViewLink.h); not checked here
  std::string language{}; // of title and text, such as "de" or "zh-Hant"; empty: not known
  bool operator==(const Note&) const = default;

  static constexpr std::size_t longestTitle = 200;
  static constexpr std::size_t longestText = 4000;
  static constexpr std::size_t longestLink = 2048;   // bytes
  static constexpr std::size_t longestLanguage = 35; // bytes
};

inline constexpr std::size_t maximumNotesBytes = std::size_t{ 256 } << 10;
inline constexpr std::size_t mostNotes = 100;

// Unknown members are skipped. If a label has several languages, that of the text is used, or the
// first. Memory: about 24 bytes a byte of text. Errors: LimitExceeded for a text of more than
// maximumNotesBytes; InvalidInput, with the number of the note (from 1) and what is wrong with it.
Result<std::vector<Note>> ParseNotes(std::string_view text);

// Writes a text from which ParseNotes reads the same notes. REQUIRES: each note satisfies the
// limits of Note. All together may still be more than maximumNotesBytes.
std::string FormatNotes(const std::vector<Note>& notes);

}
