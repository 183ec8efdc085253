// SPDX-License-Identifier: BSD-3-Clause
// How tolerant the readers of all formats are. Data that is dropped or repaired because a file is
// damaged is counted by kind, and reported. For users: doc/cli.md#tolerance.
#pragma once

#include "filters/core/Result.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

// What is tolerated. Whatever the options say, the readers refuse indices of elements that do not
// exist, truncated files, and counts that the file is too short for.
enum class Lapse : std::uint8_t
{
  // Dropped:
  PointNotFinite,     // a point with a NaN or an infinity
  FaceOfDroppedPoint, // a face that names such a point
  FaceTooSmall,       // a face of fewer than three corners
  PointWithheld,      // a point that the file itself marks as not to be used
  AttributeMissing,   // a texture coordinate, normal or colour that a face names but that does not
                      // exist: the face is read without it

  // Read:
  BytesAfterEnd,  // bytes after the end of the data that the file declares
  PaddedEnd,      // zeros after the end, which fill up a block
  NotCounted,     // points or faces in the file that its header does not count
  ValuesNotNamed, // a line with more values than the text's header names: they are not read
  ColumnsGuessed, // points as text: what the first columns are was guessed
  EndMissing,     // the word that ends a text is missing: the file may be truncated
  FieldNotKnown,  // a field of a scene that the format does not have: it is not read
  NodeLeftOut,    // a node of a scene that the format does not have, that lies in a missing file,
                  // or whose sizes make no shape
};
inline constexpr std::size_t lapseKinds = 13;

// Counts what was tolerated in a file, and notes how ambiguous data was read. Needs almost no
// memory.
class Tolerance
{
public:
  // Counts `number` more cases. first: where the first of them is ("vertex 17 (line 20)", "byte
  // 684"); kept only from the first call for each kind.
  void Count(Lapse kind, std::uint64_t number, std::string_view first = {});
  std::uint64_t Of(Lapse kind) const { return this->Numbers[static_cast<std::size_t>(kind)]; }

  // Adds a sentence that says what was ambiguous and how it was read. A sentence is kept only once.
  // --strict does not refuse these.
  void Tell(const std::string& reading);

  // Adds the counts of another part of the same file.
  void Add(const Tolerance& other);
  // The difference between this and `before`, an earlier state of it.
  Tolerance Since(const Tolerance& before) const;

  // One sentence for each kind that was counted, then the sentences of Tell: warnings, without the
  // file's name.
  std::vector<std::string> Warnings() const;
  // A short summary for the end of a line: "3 points and 2 faces dropped"; empty if there is
  // nothing.
  std::string Summary() const;
  // For builds and conversions with --strict. Errors: InvalidInput if `strict` is set and something
  // was counted; the message names the first kind and its place.
  Status Check(bool strict) const;

  // Converts to lines of text, for files and other processes, and back. Other lines are skipped.
  std::string ToLines() const;
  static Tolerance FromLines(std::string_view lines);

  // The key of a kind in statistics: "points_not_finite".
  static std::string_view KeyOf(Lapse kind);

private:
  std::array<std::uint64_t, lapseKinds> Numbers{};
  std::array<std::string, lapseKinds> Firsts;
  std::vector<std::string> ReadingTexts;
};

}
