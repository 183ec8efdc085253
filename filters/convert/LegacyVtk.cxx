// SPDX-License-Identifier: BSD-3-Clause
// Finds where a legacy .vtk file is damaged: see LegacyVtk.h. Steps:
// 1. the head: text or binary
// 2. each part: its head, then as many numbers as its head says.
#include "filters/convert/LegacyVtk.h"

#include "filters/meshio/ByteSource.h"
#include "filters/meshio/NumberText.h"
#include "filters/meshio/QuotedText.h"
#include "filters/meshio/TextWords.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

namespace kdstream
{
namespace
{

constexpr std::size_t longestWord = 4096;

// The bytes of a number in binary files; 0 for bits and for unknown types.
std::size_t SizeOfType(const std::string& type)
{
  constexpr struct
  {
    std::string_view name;
    std::size_t size;
  } sizes[] = { { "char", 1 }, { "unsigned_char", 1 }, { "signed_char", 1 }, { "short", 2 },
    { "unsigned_short", 2 }, { "int", 4 }, { "unsigned_int", 4 }, { "vtkidtype", 4 }, { "long", 8 },
    { "unsigned_long", 8 }, { "vtktypeint64", 8 }, { "vtktypeuint64", 8 }, { "float", 4 },
    { "double", 8 } };
  const auto* const found = std::find_if(
    std::begin(sizes), std::end(sizes), [&](const auto& each) { return each.name == type; });
  return found == std::end(sizes) ? 0 : found->size;
}

// Types with the same size on all systems and in all versions of the format.
bool IsSizeCertain(const std::string& type)
{
  return type.find("long") == std::string::npos && type != "vtkidtype";
}

// Parts that are an array of points or cells, with the number of components. In their heads, the
// type follows the name.
struct ArrayPart
{
  std::string_view keyword;
  std::uint64_t components;
};
constexpr ArrayPart arrayParts[] = { { "VECTORS", 3 }, { "NORMALS", 3 }, { "TENSORS", 9 },
  { "TENSORS6", 6 }, { "GLOBAL_IDS", 1 }, { "PEDIGREE_IDS", 1 }, { "EDGE_FLAGS", 1 } };

// VTK's other keywords, for grids and graphs. Their sizes do not matter here.
constexpr std::string_view otherKeywords[] = { "BLANKING", "EDGES", "VERTEX_DATA", "EDGE_DATA",
  "ROW_DATA", "CHILDREN" };

// If Fortran has written numbers without a blank in between, as in "1.0-2.0", the first of them, as
// a C++ stream reads it; empty for any other word.
std::string_view FirstOfGlued(std::string_view word)
{
  const auto pass = [&](std::size_t at, std::string_view set)
  { return std::min(word.find_first_not_of(set, at), word.size()); };
  constexpr std::string_view digits = "0123456789";
  const auto at = [&](std::size_t k, std::string_view set)
  { return k < word.size() && set.find(word[k]) != set.npos; };
  std::size_t end = pass(at(0, "+-") ? 1 : 0, digits);
  end = at(end, ".") ? pass(end + 1, digits) : end;
  if (at(end, "eE"))
  {
    end = pass(end + (at(end + 1, "+-") ? 2 : 1), digits);
  }
  return at(end, "+-.") ? word.substr(0, end) : std::string_view();
}

bool IsLetter(char c)
{
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

template <std::size_t count>
bool IsOneOf(std::string_view word, const std::string_view (&words)[count])
{
  return std::find(std::begin(words), std::end(words), word) != std::end(words);
}

class Scan
{
public:
  explicit Scan(ByteSource source)
    : Source(std::move(source))
  {
  }

  VtkDamage First()
  {
    constexpr std::string_view begin = "# vtk DataFile Versi"; // all that VTK asks for
    const Result<std::string_view> head = this->Source.Peek(begin.size());
    if (!head || !head->starts_with(begin))
    {
      return { "its first line does not begin with '# vtk DataFile Version'", true };
    }
    const Result<std::string_view> line = this->Source.Peek(longestWord);
    const std::size_t digit = line ? line->find_first_of("0123456789\n") : std::string_view::npos;
    this->HasVersion5 = digit < begin.size() + 16 && (*line)[digit] >= '5';
    this->SkipLine();
    this->SkipLine();
    const std::string kind = this->Keyword();
    this->IsBinary = kind == "BINARY";
    if (!this->IsBinary && kind != "ASCII")
    {
      return { "its third line says neither ASCII nor BINARY" };
    }
    this->SkipLine();
    this->HeadEnd = this->Source.Position();
    bool goesOn = true;
    while (goesOn)
    {
      this->LastPart = this->Part;
      goesOn = this->TakePart();
    }
    const bool isWhole = this->Ahead().empty() && this->Damage.part.empty();
    if (isWhole && this->Dataset.empty())
    {
      this->Part = "it";
      this->Damaged("has no DATASET: it contains no mesh", true);
    }
    this->Damage.hasOtherNumbers = this->HasOtherNumbers;
    this->Damage.forgiven = std::move(this->Forgiven);
    this->Order.leftOut = std::move(this->LeftOut);
    this->Damage.order = std::move(this->Order);
    this->Damage.lastPart =
      isWhole ? "its parts are complete up to the end of the file but contradict each other"
              : "something after " + (this->LastPart.empty() ? "its header" : this->LastPart) +
                  " cannot be read";
    return std::move(this->Damage);
  }

private:
  // --- Words

  // Goes to the next word without taking it; empty at the end.
  std::string_view Ahead()
  {
    for (;;)
    {
      const Result<std::string_view> ahead = this->Source.Peek(longestWord);
      if (!ahead || ahead->empty())
      {
        return {};
      }
      const auto* const begin = std::find_if_not(ahead->begin(), ahead->end(), IsBlank);
      this->Line += static_cast<std::uint64_t>(std::count(ahead->begin(), begin, '\n'));
      this->Source.Consume(static_cast<std::size_t>(begin - ahead->begin()));
      if (begin != ahead->end())
      {
        break;
      }
    }
    const Result<std::string_view> ahead = this->Source.Peek(longestWord);
    std::string_view rest = ahead ? ahead->substr(0, longestWord) : std::string_view();
    return TakeWord(rest);
  }

  std::string Word()
  {
    const std::string word(this->Ahead());
    this->Source.Consume(word.size());
    return word;
  }

  std::string Keyword()
  {
    std::string word = this->Word();
    std::transform(word.begin(), word.end(), word.begin(),
      [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
    return word;
  }

  // Skips to the next line.
  void SkipLine()
  {
    for (;;)
    {
      const Result<std::string_view> ahead = this->Source.Peek(1);
      if (!ahead || ahead->empty())
      {
        return;
      }
      const std::size_t end = ahead->find('\n');
      this->Source.Consume(end == ahead->npos ? ahead->size() : end + 1);
      if (end != ahead->npos)
      {
        ++this->Line;
        return;
      }
    }
  }

  // A block of METADATA ends with an empty line, or before DATASET.
  void SkipToEmptyLine()
  {
    constexpr std::string_view next = "DATASET ";
    for (bool isEnd = false; !isEnd;)
    {
      this->SkipLine();
      const Result<std::string_view> ahead = this->Source.Peek(next.size());
      isEnd = !ahead || ahead->empty() || ahead->starts_with('\n') || ahead->starts_with("\r\n") ||
              ahead->starts_with(next);
    }
  }

  std::string Here() const
  {
    return this->IsBinary ? "(byte " + std::to_string(this->Source.Position()) + ")"
                          : "(line " + std::to_string(this->Line) + ")";
  }

  // --- Damage. It ends the scan: all functions below return whether to continue.

  bool Damaged(const std::string& what, bool isCut = false)
  {
    this->Damage = { this->Part + " " + what, isCut };
    return false;
  }

  // Takes a count from the part's head.
  bool TakeCount(std::uint64_t& count)
  {
    const std::string word = this->Word();
    return ParseNumber(word, count) == NumberTextError::None ||
           this->Damaged("has " + (word.empty() ? "no number" : QuotedText(word)) +
                         " where a count is expected");
  }

  bool NotEnough(std::uint64_t there, std::uint64_t count, bool isCut = true)
  {
    const std::string_view next = this->IsBinary ? std::string_view() : this->Ahead();
    const std::string then =
      next.empty() ? "then the file ends"
                   : "then " + QuotedText(next) + " " + this->Here() + DecimalCommaHint(next);
    return this->Damaged(
      "has " + std::to_string(there) + " of its " + std::to_string(count) + " numbers, " + then,
      isCut);
  }

  // Takes the next number of a text. Numbers may be glued together, because VTK reads them, but not
  // in lists of cells: VTK crashes if numbers are missing there.
  bool TakeNumber(std::uint64_t index, std::uint64_t count, double& value, bool isOfCells = false)
  {
    std::string_view word = this->Ahead();
    if (word.empty())
    {
      return this->NotEnough(index, count);
    }
    if (ParseNumber(word, value) != NumberTextError::None)
    {
      const std::string_view first = isOfCells ? std::string_view() : FirstOfGlued(word);
      if (first.empty() || ParseNumber(first, value) != NumberTextError::None)
      {
        const bool isComma = !DecimalCommaHint(word).empty();
        return this->NotEnough(index, count, isOfCells || isComma || IsLetter(word[0]));
      }
      word = first;
    }
    if (!std::isfinite(value) && isOfCells)
    {
      return this->Damaged(
        "has " + QuotedText(word) + " " + this->Here() + ", which names no point", true);
    }
    this->HasOtherNumbers = this->HasOtherNumbers || !std::isfinite(value) ||
                            word.find_first_of("dD") != std::string_view::npos;
    this->Source.Consume(word.size());
    this->Taken = word;
    return true;
  }

  // Takes three numbers, which are text in binary files, too. areSides: they are numbers of points.
  bool TakeThree(bool areSides)
  {
    for (std::uint64_t i = 0; i < 3; ++i)
    {
      double value = 0;
      if (!this->TakeNumber(i, 3, value))
      {
        return false;
      }
      if (!std::isfinite(value) || (areSides && (value < 1 || value != std::floor(value))))
      {
        return this->Damaged("has " + QuotedText(this->Taken) + " " + this->Here() +
                               ", which is not a " + (areSides ? "number of points" : "length"),
          true);
      }
    }
    return true;
  }

  bool EndsBefore(std::uint64_t there, std::uint64_t count)
  {
    return this->Damaged("has " + std::to_string(there) + " of its " + std::to_string(count) +
                           " values, then the file ends",
      true);
  }

  // Reads an array of texts. In a text file, each is a line. In a binary file, the length precedes
  // each, in one to eight bytes; the first two bits say how many.
  bool TakeStrings(std::uint64_t count)
  {
    this->SkipLine();
    for (std::uint64_t i = 0; i < count; ++i)
    {
      const Result<std::string_view> ahead = this->Source.Peek(sizeof(std::uint64_t));
      const auto first = ahead && !ahead->empty() ? static_cast<unsigned char>(ahead->front()) : 0U;
      const std::size_t bytes = std::size_t{ 8 } >> (first >> 6U);
      if (!ahead || ahead->size() < (this->IsBinary ? bytes : 1))
      {
        return this->EndsBefore(i, count);
      }
      if (!this->IsBinary)
      {
        this->SkipLine();
        continue;
      }
      std::uint64_t size = first & 63U;
      for (std::size_t k = 1; k < bytes; ++k)
      {
        size = size << 8U | static_cast<unsigned char>((*ahead)[k]);
      }
      if (size > this->Source.Remaining() - bytes)
      {
        return this->EndsBefore(i, count);
      }
      this->Source.Seek(this->Source.Position() + bytes + size);
    }
    return true;
  }

  // Reads values of any type: for each, the number of the type, and a word.
  bool TakeVariants(std::uint64_t count)
  {
    for (std::uint64_t i = 0; i < count; ++i)
    {
      if (this->Word().empty() || this->Word().empty())
      {
        return this->EndsBefore(i, count);
      }
    }
    return true;
  }

  // Takes the numbers after a head; in a text file, they are words.
  bool TakeNumbers(
    std::uint64_t count, std::uint64_t components, const std::string& type, bool isOfCells = false)
  {
    const std::uint64_t all = components > 0 && count > ~std::uint64_t{ 0 } / components
                                ? ~std::uint64_t{ 0 }
                                : count * components;
    if (const std::string small = LowercaseText(type);
        small == "string" || small == "utf8_string" || small == "variant")
    {
      this->SizesAreSure = false;
      return small == "variant" ? this->TakeVariants(all) : this->TakeStrings(all);
    }
    const bool isBit = LowercaseText(type) == "bit";
    this->SizesAreSure = this->SizesAreSure && !isBit;
    const std::size_t bits = isBit ? 1 : 8 * SizeOfType(LowercaseText(type));
    if (bits == 0)
    {
      return this->Damaged("has numbers of the type " + QuotedText(type) + ", which is not known");
    }
    if (!this->IsBinary)
    {
      double value = 0;
      for (std::uint64_t i = 0; i < all; ++i)
      {
        if (!this->TakeNumber(i, all, value, isOfCells))
        {
          return false;
        }
      }
      return true;
    }
    this->SkipLine();
    if (!isBit && !IsSizeCertain(LowercaseText(type)))
    {
      return false; // the size of the type is not certain
    }
    const std::uint64_t room = 8 * this->Source.Remaining() / bits;
    if (all > room)
    {
      return this->NotEnough(room, all);
    }
    this->Source.Seek(this->Source.Position() + (all * bits + 7) / 8);
    return true;
  }

  // Reads how many tuples the following arrays have. all: the number of points in the file; 0:
  // unknown.
  bool TakeTuples(std::uint64_t all)
  {
    return this->TakeCount(this->Tuples) &&
           (all == 0 || this->Tuples == all ||
             this->Damaged("has values for " + std::to_string(this->Tuples) +
                           " points, but there are " + std::to_string(all)));
  }

  // More cells than the part counts are read; fewer are damage.
  bool HasCells(std::uint64_t cells, std::uint64_t found)
  {
    if (found < cells)
    {
      return this->Damaged(
        "declares " + std::to_string(cells) + " cells, but has " + std::to_string(found), true);
    }
    this->Cells = found;
    this->Forgiven.Count(Lapse::NotCounted, found - cells,
      this->Part + " counts " + std::to_string(cells) + (cells == 1 ? " cell" : " cells"));
    return true;
  }

  bool CellIsCut(std::uint64_t cell, std::uint64_t numbers)
  {
    return this->Damaged("has " + std::to_string(numbers) + " numbers and ends inside cell " +
                           std::to_string(cell) + " " + this->Here(),
      true);
  }

  // The same for a binary file, big endian: checks that the sizes of the cells fit the list.
  bool TakeBinaryCells(std::uint64_t cells, std::uint64_t numbers)
  {
    constexpr std::uint64_t size = 4;
    this->SkipLine();
    const std::uint64_t room = this->Source.Remaining() / size;
    if (numbers > room)
    {
      return this->NotEnough(room, numbers);
    }
    std::uint64_t cell = 0;
    for (std::uint64_t left = numbers; left > 0; ++cell)
    {
      const Result<std::string_view> bytes = this->Source.Peek(size);
      if (!bytes || bytes->size() < size)
      {
        return false;
      }
      std::uint64_t corners = 0;
      for (std::size_t i = 0; i < size; ++i)
      {
        corners = corners << 8U | static_cast<unsigned char>((*bytes)[i]);
      }
      if (corners >= left)
      {
        return this->CellIsCut(cell, numbers);
      }
      this->Source.Seek(this->Source.Position() + size * (1 + corners));
      left -= 1 + corners;
    }
    return this->HasCells(cells, cell);
  }

  // Takes a list of cells, as in files before version 5: for each cell its size, then its points.
  bool TakeCells(std::uint64_t cells, std::uint64_t numbers)
  {
    if (this->IsBinary)
    {
      return this->TakeBinaryCells(cells, numbers);
    }
    double value = 0;
    std::uint64_t cell = 0, taken = 0;
    for (; taken < numbers; ++cell)
    {
      if (!this->TakeNumber(taken++, numbers, value, true))
      {
        return false;
      }
      const double corners = value;
      for (double corner = 0; corner < corners; ++corner)
      {
        if (taken == numbers)
        {
          return this->CellIsCut(cell, numbers);
        }
        if (!this->TakeNumber(taken++, numbers, value, true))
        {
          return false;
        }
        if (value < 0 || value >= static_cast<double>(this->Points))
        {
          // VTK crashes on numbers too large for a point.
          constexpr double mostPoints = 2147483648.;
          return this->Damaged("has a cell " + std::to_string(cell) + " " + this->Here() +
                                 " that names point " + QuotedText(this->Taken) +
                                 ", but there are " + std::to_string(this->Points),
            !(std::abs(value) < mostPoints));
        }
      }
    }
    return this->HasCells(cells, cell);
  }

  // Whether the next line is "OFFSETS TYPE". Skips no blanks, because in a binary file the next
  // bytes may be numbers.
  bool HasOffsets()
  {
    const Result<std::string_view> ahead = this->Source.Peek(longestWord);
    const std::size_t end = ahead ? ahead->find('\n') : std::string_view::npos;
    return end != std::string_view::npos && LowercaseText(ahead->substr(end + 1, 8)) == "offsets ";
  }

  // Checks the version in the first line, by which VTK reads lists of cells.
  bool CheckVersion()
  {
    if (this->HasOffsets() == this->HasVersion5)
    {
      return true;
    }
    return this->Damaged(
      this->HasVersion5
        ? "is not followed by OFFSETS, which version 5 of the first line requires"
        : "is followed by OFFSETS, as in version 5, but the first line names an earlier version",
      true); // VTK crashes
  }

  // The same for version 5: where each cell begins, then the points of all cells.
  bool TakeOffsets(std::uint64_t offsets, std::uint64_t corners)
  {
    this->Cells = offsets > 0 ? offsets - 1 : 0;
    for (const auto& [keyword, count] :
      { std::pair{ "OFFSETS", offsets }, std::pair{ "CONNECTIVITY", corners } })
    {
      const std::string word = this->Keyword();
      if (word != keyword)
      {
        return this->Damaged("has " + (word.empty() ? "no" : QuotedText(word) + ", not") + " " +
                             keyword + " " + this->Here());
      }
      if (!this->TakeNumbers(count, 1, this->Word(), true))
      {
        return false;
      }
    }
    return true;
  }

  // Takes arrays of any size, each with its head.
  bool TakeField()
  {
    const std::string field = this->Part;
    std::uint64_t arrays = 0;
    this->Word();
    if (!this->TakeCount(arrays))
    {
      return false;
    }
    for (; arrays > 0; --arrays)
    {
      const std::string name = this->Word();
      if (name == "METADATA")
      {
        this->SkipToEmptyLine();
        ++arrays;
        continue;
      }
      if (name == "NULL_ARRAY")
      {
        continue;
      }
      this->Part = field + ", array " + QuotedText(name);
      std::uint64_t components = 0, tuples = 0;
      if (name.empty())
      {
        return this->Damaged("is not there");
      }
      if (!this->TakeCount(components) || !this->TakeCount(tuples) ||
          !this->TakeNumbers(tuples, components, this->Word()))
      {
        return false;
      }
    }
    return true;
  }

  bool TakeScalars()
  {
    this->Word();
    const std::string type = this->Word();
    std::uint64_t components = 1;
    if (ParseNumber(this->Ahead(), components) == NumberTextError::None)
    {
      this->Word();
    }
    if (LowercaseText(this->Ahead()) == "lookup_table")
    {
      this->Word();
      this->Word();
    }
    return this->TakeNumbers(this->Tuples, components, type);
  }

  bool TakeDataset(std::uint64_t begin)
  {
    constexpr std::string_view types[] = { "POLYDATA", "UNSTRUCTURED_GRID", "STRUCTURED_GRID",
      "STRUCTURED_POINTS", "RECTILINEAR_GRID" };
    constexpr std::string_view others[] = { "TABLE", "TREE", "MOLECULE", "DIRECTED_GRAPH",
      "UNDIRECTED_GRAPH", "MULTIBLOCK", "MULTIPIECE", "HIERARCHICAL_BOX", "OVERLAPPING_AMR",
      "NON_OVERLAPPING_AMR", "PARTITIONED", "PARTITIONED_COLLECTION", "STATISTICAL_MODEL",
      "HYPER_TREE_GRID", "CELL_GRID" };
    this->Dataset = this->Keyword();
    const bool isFirst = this->LastPart.empty();
    this->SkipLine();
    this->Order = isFirst ? VtkOrder{} : VtkOrder{ this->HeadEnd, begin, this->Source.Position() };
    if (IsOneOf(this->Dataset, others))
    {
      return this->Damaged(
        "is of the type " + QuotedText(this->Dataset) + ", which is not a mesh", true);
    }
    return IsOneOf(this->Dataset, types) ||
           this->Damaged(
             "is of the type " + QuotedText(this->Dataset) + ", which VTK does not have", true);
  }

  // Skips bytes after the last part of a binary file, if they certainly belong to no part and do
  // not begin a name. Returns whether it has skipped any.
  bool LeavesRest()
  {
    constexpr std::uint64_t most = 4096;
    const std::uint64_t rest = this->Source.Remaining(), at = this->Source.Position();
    const Result<std::string_view> ahead =
      this->Source.Peek(static_cast<std::size_t>(std::min(rest, most)));
    if (!this->IsBinary || !this->SizesAreSure || rest == 0 || rest > most || !ahead ||
        IsLetter(ahead->front()))
    {
      return false;
    }
    const bool areZeros = ahead->substr(0, rest).find_first_not_of('\0') == ahead->npos;
    this->Forgiven.Count(
      areZeros ? Lapse::PaddedEnd : Lapse::BytesAfterEnd, rest, "byte " + std::to_string(at));
    this->LeftOut.push_back({ at, at + rest });
    this->Source.Seek(at + rest);
    return true;
  }

  // Takes a keyword and its part; false at the end, too.
  bool TakePart()
  {
    this->Ahead();
    if (this->LeavesRest())
    {
      return false;
    }
    const std::string at = this->Here();
    const std::string keyword = this->Keyword();
    this->Part = (keyword.size() > 40 ? QuotedText(keyword) : keyword) + " " + at;
    constexpr std::string_view lines[] = { "DIMENSIONS", "ORIGIN", "SPACING", "ASPECT_RATIO" };
    constexpr std::string_view places[] = { "POINTS", "X_COORDINATES", "Y_COORDINATES",
      "Z_COORDINATES" };
    constexpr std::string_view cells[] = { "VERTICES", "LINES", "POLYGONS", "TRIANGLE_STRIPS",
      "CELLS" };
    const auto* const array = std::find_if(std::begin(arrayParts), std::end(arrayParts),
      [&](const ArrayPart& part) { return part.keyword == keyword; });
    std::uint64_t count = 0, more = 0;
    if (keyword.empty())
    {
      return false;
    }
    const bool isGeometry = IsOneOf(keyword, lines) || IsOneOf(keyword, places) ||
                            IsOneOf(keyword, cells) || keyword == "CELL_TYPES";
    if (isGeometry && this->IsAfterData)
    {
      return this->Damaged("is after POINT_DATA or CELL_DATA, which must come last", true);
    }
    if (isGeometry && !this->Geometry.insert(keyword).second)
    {
      return this->Damaged("is there a second time", true);
    }
    const bool isAfterArray = std::exchange(this->IsAfterArray, false);
    if (keyword == "DATASET")
    {
      return this->TakeDataset(this->Source.Position() - keyword.size());
    }
    if (IsOneOf(keyword, lines))
    {
      return this->TakeThree(keyword == "DIMENSIONS");
    }
    if (keyword == "METADATA")
    {
      const std::uint64_t begin = this->Source.Position() - keyword.size();
      this->SkipToEmptyLine();
      if (!isAfterArray)
      {
        this->LeftOut.push_back({ begin, this->Source.Position() });
      }
      return true;
    }
    this->IsAfterArray = !IsOneOf(keyword, cells) && keyword != "CELL_TYPES";
    if (IsOneOf(keyword, places))
    {
      const bool isPoints = keyword == "POINTS";
      if (!this->TakeCount(count))
      {
        return false;
      }
      this->Points = isPoints ? count : this->Points;
      return this->TakeNumbers(count, isPoints ? 3 : 1, this->Word());
    }
    if (IsOneOf(keyword, cells))
    {
      if (!this->Dataset.empty() && (keyword == "CELLS") == (this->Dataset == "POLYDATA"))
      {
        return this->Damaged("cannot be in a DATASET of the type " + QuotedText(this->Dataset));
      }
      return this->TakeCount(count) && this->TakeCount(more) && this->CheckVersion() &&
             (this->HasOffsets() ? this->TakeOffsets(count, more) : this->TakeCells(count, more));
    }
    if (keyword == "CELL_TYPES")
    {
      return this->TakeCount(count) &&
             (count >= this->Cells ||
               this->Damaged("has " + std::to_string(count) + (count == 1 ? " type" : " types") +
                               ", but there are " + std::to_string(this->Cells) + " cells",
                 true)) && // VTK reads beyond its memory
             this->TakeNumbers(count, 1, "int");
    }
    if (keyword == "POINT_DATA" || keyword == "CELL_DATA")
    {
      this->IsAfterData = true;
      return this->TakeTuples(keyword == "POINT_DATA" ? this->Points : 0);
    }
    if (keyword == "SCALARS")
    {
      return this->TakeScalars();
    }
    if (keyword == "FIELD")
    {
      return this->TakeField();
    }
    if (keyword == "COLOR_SCALARS" || keyword == "LOOKUP_TABLE")
    {
      this->Word();
      const bool isTable = keyword == "LOOKUP_TABLE";
      return this->TakeCount(count) &&
             this->TakeNumbers(isTable ? count : this->Tuples, isTable ? 4 : count, "char");
    }
    if (keyword == "TEXTURE_COORDINATES")
    {
      this->Word();
      return this->TakeCount(count) && this->TakeNumbers(this->Tuples, count, this->Word());
    }
    if (array != std::end(arrayParts))
    {
      this->Word();
      return this->TakeNumbers(this->Tuples, array->components, this->Word());
    }
    if (IsOneOf(keyword, otherKeywords))
    {
      return false; // no list of cells follows
    }
    this->Part = QuotedText(keyword) + " " + at;
    this->Damaged("is not the name of a part");
    this->Damage.unknownWord = LowercaseText(keyword);
    return false;
  }

  ByteSource Source;
  bool IsBinary = false, HasVersion5 = false;
  std::uint64_t Line = 1;
  std::uint64_t Points = 0, Tuples = 0; // points of the file; tuples of POINT_DATA or CELL_DATA
  std::uint64_t Cells = 0;              // of the last list of cells
  std::set<std::string> Geometry;       // parts that were read
  bool IsAfterData = false;
  std::string Part;       // as in "POINTS (line 5)"
  std::string_view Taken; // the last number of a text; valid until the next word
  VtkDamage Damage;
  std::string LastPart; // before Part; empty before the first
  std::string Dataset;  // its type, in capitals
  std::uint64_t HeadEnd = 0;
  VtkOrder Order;
  std::vector<std::array<std::uint64_t, 2>> LeftOut; // goes into Order
  bool IsAfterArray = false;                         // VTK allows METADATA after an array
  bool HasOtherNumbers = false;
  bool SizesAreSure = true; // of all parts so far
  Tolerance Forgiven;
};

}

VtkDamage FindVtkDamage(const std::filesystem::path& file)
{
  Result<ByteSource> source = ByteSource::Open(file);
  return source ? Scan(std::move(*source)).First() : VtkDamage{};
}

}
