// SPDX-License-Identifier: BSD-3-Clause
// Counts data of a damaged file that was dropped or repaired, and describes it: see Tolerance.h.
#include "filters/meshio/Tolerance.h"

#include <algorithm>
#include <charconv>

namespace kdstream
{
namespace
{

// The texts for one kind. A warning is the number and `one` or `many`; the summary takes `shortOne`
// or `shortMany`.
struct LapseText
{
  std::string_view key, one, many;
  std::string_view shortOne, shortMany;
};

constexpr std::array<LapseText, lapseKinds> texts{ {
  { "points_not_finite", "point is not finite and is dropped",
    "points are not finite and are dropped", "point dropped", "points dropped" },
  { "faces_of_dropped_points", "face is dropped with the points that are not finite",
    "faces are dropped with the points that are not finite", "face of it dropped",
    "faces of them dropped" },
  { "faces_too_small", "face has fewer than three corners and is dropped",
    "faces have fewer than three corners and are dropped", "face too small", "faces too small" },
  { "points_withheld", "point is marked as withheld and is dropped",
    "points are marked as withheld and are dropped", "point withheld", "points withheld" },
  { "faces_without_attribute",
    "face names a texture coordinate, normal or colour that does not exist: it is read without it",
    "faces name texture coordinates, normals or colours that do not exist: they are read without "
    "them",
    "face without attribute", "faces without attribute" },
  { "bytes_behind_end", "byte after the end is not read", "bytes after the end are not read",
    "byte after the end", "bytes after the end" },
  { "padding_bytes", "zero after the end is padding", "zeros after the end are padding",
    "byte of padding", "bytes of padding" },
  { "not_counted", "point or face is in the file but its header does not count it",
    "points or faces are in the file but its header does not count them", "not counted",
    "not counted" },
  { "lines_too_long", "line has more values than the header names: they are not read",
    "lines have more values than the header names: they are not read", "line too long",
    "lines too long" },
  { "columns_guessed", "reading of the columns was chosen among several",
    "files have columns that can be read in several ways: one way was chosen",
    "reading of columns guessed", "readings of columns guessed" },
  { "end_missing", "end of a part is missing: the part may be truncated",
    "ends of parts are missing: the parts may be truncated", "end missing", "ends missing" },
  { "fields_not_known", "field is unknown in the format and is left out",
    "fields are unknown in the format and are left out", "field not known", "fields not known" },
  { "nodes_left_out", "node cannot be read and is left out",
    "nodes cannot be read and are left out", "node left out", "nodes left out" },
} };

constexpr std::string_view forgivenMark = "forgiven ", readingMark = "reading ";

// Makes any text a single line.
std::string OneLine(std::string_view text)
{
  std::string line(text.substr(0, 1000));
  std::replace_if(
    line.begin(), line.end(), [](char c) { return c >= 0 && c < ' '; }, ' ');
  return line;
}

}

void Tolerance::Count(Lapse kind, std::uint64_t number, std::string_view first)
{
  const auto k = static_cast<std::size_t>(kind);
  if (number > 0 && this->Numbers[k] == 0)
  {
    this->Firsts[k] = OneLine(first);
  }
  this->Numbers[k] += number;
}

void Tolerance::Tell(const std::string& reading)
{
  std::string line = OneLine(reading);
  if (std::find(this->ReadingTexts.begin(), this->ReadingTexts.end(), line) ==
      this->ReadingTexts.end())
  {
    this->ReadingTexts.push_back(std::move(line));
  }
}

void Tolerance::Add(const Tolerance& other)
{
  for (std::size_t k = 0; k < lapseKinds; ++k)
  {
    this->Count(static_cast<Lapse>(k), other.Numbers[k], other.Firsts[k]);
  }
  for (const std::string& reading : other.ReadingTexts)
  {
    this->Tell(reading);
  }
}

Tolerance Tolerance::Since(const Tolerance& before) const
{
  Tolerance since;
  for (std::size_t k = 0; k < lapseKinds; ++k)
  {
    since.Count(static_cast<Lapse>(k), this->Numbers[k] - before.Numbers[k],
      before.Numbers[k] == 0 ? std::string_view(this->Firsts[k]) : std::string_view());
  }
  since.ReadingTexts.assign(
    this->ReadingTexts.begin() + static_cast<std::ptrdiff_t>(before.ReadingTexts.size()),
    this->ReadingTexts.end());
  return since;
}

std::vector<std::string> Tolerance::Warnings() const
{
  std::vector<std::string> warnings;
  for (std::size_t k = 0; k < lapseKinds; ++k)
  {
    const std::uint64_t number = this->Numbers[k];
    if (number > 0)
    {
      std::string sentence = std::to_string(number) + " ";
      sentence += number == 1 ? texts[k].one : texts[k].many;
      if (!this->Firsts[k].empty())
      {
        sentence += (number == 1 ? ": " : "; the first: ") + this->Firsts[k];
      }
      warnings.push_back(std::move(sentence));
    }
  }
  warnings.insert(warnings.end(), this->ReadingTexts.begin(), this->ReadingTexts.end());
  return warnings;
}

std::string Tolerance::Summary() const
{
  std::string summary;
  for (std::size_t k = 0; k < lapseKinds; ++k)
  {
    const std::uint64_t number = this->Numbers[k];
    if (number > 0)
    {
      summary += (summary.empty() ? "" : ", ") + std::to_string(number) + " ";
      summary += number == 1 ? texts[k].shortOne : texts[k].shortMany;
    }
  }
  return summary;
}

Status Tolerance::Check(bool strict) const
{
  for (std::size_t k = 0; k < lapseKinds; ++k)
  {
    if (strict && this->Numbers[k] > 0)
    {
      Tolerance one;
      one.Count(static_cast<Lapse>(k), this->Numbers[k], this->Firsts[k]);
      return BadInput(one.Warnings()[0] + ", which --strict does not allow", Remedy::InMessage);
    }
  }
  return {};
}

std::string Tolerance::ToLines() const
{
  std::string lines;
  for (std::size_t k = 0; k < lapseKinds; ++k)
  {
    if (this->Numbers[k] > 0)
    {
      lines += std::string(forgivenMark) + std::string(texts[k].key) + " " +
               std::to_string(this->Numbers[k]) + " " + this->Firsts[k] + "\n";
    }
  }
  for (const std::string& reading : this->ReadingTexts)
  {
    lines += std::string(readingMark) + reading + "\n";
  }
  return lines;
}

Tolerance Tolerance::FromLines(std::string_view lines)
{
  Tolerance tolerance;
  while (!lines.empty())
  {
    const std::size_t end = std::min(lines.find('\n'), lines.size());
    std::string_view line = lines.substr(0, end);
    lines.remove_prefix(std::min(end + 1, lines.size()));
    if (line.starts_with(readingMark))
    {
      tolerance.Tell(std::string(line.substr(readingMark.size())));
    }
    if (!line.starts_with(forgivenMark))
    {
      continue;
    }
    line.remove_prefix(forgivenMark.size());
    const std::string_view key = line.substr(0, line.find(' '));
    const auto* const text = std::find_if(
      texts.begin(), texts.end(), [&](const LapseText& each) { return each.key == key; });
    line.remove_prefix(std::min(key.size() + 1, line.size()));
    std::uint64_t number = 0;
    const std::from_chars_result parsed =
      std::from_chars(line.data(), line.data() + line.size(), number);
    if (text != texts.end() && parsed.ec == std::errc())
    {
      line.remove_prefix(static_cast<std::size_t>(parsed.ptr - line.data()));
      line.remove_prefix(line.starts_with(' ') ? 1 : 0);
      tolerance.Count(static_cast<Lapse>(text - texts.begin()), number, line);
    }
  }
  return tolerance;
}

std::string_view Tolerance::KeyOf(Lapse kind)
{
  return texts[static_cast<std::size_t>(kind)].key;
}

}
