// SPDX-License-Identifier: BSD-3-Clause
// The one rule of tolerance that the readers of all formats share: what of a damaged file is
// dropped or forgiven is counted by kind, and reported. doc/cli.md#tolerance tells users.
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

// What is forgiven. Refused whatever the options say, by the readers themselves: indices of places
// that do not exist, truncation, counts beyond the file.
enum class Lapse : std::uint8_t
{
  // Dropped:
  PointNotFinite,     // a point with a NaN or an infinity
  FaceOfDroppedPoint, // a face that names such a point
  FaceTooSmall,       // a face of fewer than three corners
  AttributeMissing,   // a face names a texture coordinate, normal or colour that does not exist: it
                      // is read without it

  // Read:
  BytesBehindEnd, // bytes after the end of what the file says it holds
  PaddedEnd,      // zeros after it, which fill up a block
  NotCounted,     // points or faces that the file holds and its header does not count
  ValuesNotNamed, // a line of a text with more values than its header names, which are not read
  ColumnsGuessed, // the first column of points as text may be a coordinate, a number or a time
  EndMissing,     // the word that ends a text is missing: it may have been cut there
  FieldNotKnown,  // a field of a scene that its format does not have, which is not read
  NodeLeftOut,    // a node of a scene that its format does not have, or that lies in a file that is
                  // not there, or whose sizes make no shape
};
inline constexpr std::size_t lapseKinds = 12;

// Counts of a file, and which of two readings were taken. Without memory to speak of.
class Tolerance
{
public:
  // Counts `number` further ones. first: where the first of them is ("vertex 17 (line 20)", "byte
  // 684"); that of the first call counts.
  void Count(Lapse kind, std::uint64_t number, std::string_view first = {});
  std::uint64_t Of(Lapse kind) const { return this->Numbers[static_cast<std::size_t>(kind)]; }
  bool Any() const;

  // A sentence about what can be read in two ways, and how it was read. --strict does not refuse
  // it.
  void Tell(std::string reading);

  // Adds what another part of the same file had.
  void Add(const Tolerance& other);
  // What was counted and reported after `before`, a former state of this.
  Tolerance Since(const Tolerance& before) const;

  // A sentence for each kind that was counted, then the readings: warnings without the file's name.
  std::vector<std::string> Warnings() const;
  // The same in few words, for a line's end: "3 points and 2 faces dropped"; empty if there is
  // nothing.
  std::string Summary() const;
  // What a build or conversion with --strict says. Errors: InvalidInput where it is strict, of the
  // first kind that was counted, with its place.
  Status Check(bool strict) const;

  // As lines of text, between processes and in files, and back. Lines that are something else are
  // passed over.
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
