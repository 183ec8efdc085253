// SPDX-License-Identifier: BSD-3-Clause
// Reads point clouds that are text. Steps:
// 1. split each line into words, and find out what commas mean
// 2. read the numbers
// 3. find out what the columns mean
// 4. make points and attributes.
#include "filters/convert/ForeignMesh.h"
#include "filters/convert/PointAttributes.h"
#include "filters/convert/XyzColumns.h"
#include "filters/core/Texts.h"
#include "filters/meshio/NumberText.h"
#include "filters/meshio/QuotedText.h"
#include "filters/meshio/ShownColors.h"
#include "filters/meshio/TextLines.h"
#include "filters/meshio/TextWords.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

namespace kdstream
{
namespace
{

constexpr std::string_view separators = " \t,;\r\v\f", separatorsButCommas = " \t;\r\v\f";
constexpr std::uint64_t linesPerReport = 1 << 16;

bool IsDigit(char c)
{
  return c >= '0' && c <= '9';
}

bool IsCount(const std::vector<std::string_view>& words)
{
  return words.size() == 1 && std::all_of(words[0].begin(), words[0].end(), IsDigit);
}

// What commas mean; the first line that has some decides.
enum class Commas
{
  Unknown,
  Separators,
  Decimal,
  Unclear // ambiguous
};

// Whether a number has separators of thousands, "1,234.5" or "1.234,5": three digits between comma
// and point.
bool HasThousands(std::string_view word)
{
  const std::size_t comma = word.find(','), point = word.find('.');
  const std::size_t first = std::min(comma, point), last = std::max(comma, point);
  return last != std::string_view::npos && last == first + 4 && first >= 1 && first <= 4 &&
         std::all_of(word.begin() + static_cast<std::ptrdiff_t>(first) + 1,
           word.begin() + static_cast<std::ptrdiff_t>(last), IsDigit);
}

// Finds out what commas mean. words: of a line, split only at blanks and semicolons.
Commas CommasOf(const std::vector<std::string_view>& words)
{
  std::size_t inner = 0, points = 0, both = 0, thousands = 0;
  bool several = false;
  for (std::string_view word : words)
  {
    word.remove_suffix(word.ends_with(',') ? 1 : 0);
    const auto commas = std::count(word.begin(), word.end(), ',');
    several = several || commas > 1 || word.starts_with(',');
    inner += commas > 0 ? 1 : 0;
    const bool point = word.find('.') != std::string_view::npos;
    points += point ? 1 : 0;
    both += point && commas > 0 ? 1 : 0;
    thousands += HasThousands(word) ? 1 : 0;
  }
  if (words.size() < 3 || several || inner == 0)
  {
    return Commas::Separators;
  }
  return points == 0 ? Commas::Decimal : both == thousands ? Commas::Unclear : Commas::Separators;
}

// Whether the text is a colour "#c86432", with or without an opacity.
bool IsHexColor(std::string_view text)
{
  const std::string_view word = text.substr(0, text.find_first_of(separators));
  return (word.size() == 7 || word.size() == 9) &&
         word.find_first_not_of("0123456789abcdefABCDEF", 1) == word.npos;
}

// Whether a number has blanks between thousands: "1 234 567" or "-1 010.5".
bool HasBlankThousands(std::string_view cell)
{
  cell.remove_prefix(cell.starts_with('-') ? 1 : 0);
  std::size_t digits = 0, groups = 0;
  for (; digits < cell.size() && IsDigit(cell[digits]); ++digits)
  {
  }
  const bool isFirst = digits >= 1 && digits <= 3;
  cell.remove_prefix(digits);
  const auto isGroup = [&]
  {
    return cell.size() >= 4 && cell[0] == ' ' && IsDigit(cell[1]) && IsDigit(cell[2]) &&
           IsDigit(cell[3]);
  };
  for (; isGroup(); ++groups)
  {
    cell.remove_prefix(4);
  }
  return isFirst && groups > 0 && (cell.empty() || cell[0] == '.' || cell[0] == ',');
}

class XyzReader
{
public:
  XyzReader(TextLines lines, std::optional<XyzLayout> layout, std::size_t columns)
    : Lines(std::move(lines))
    , Layout(std::move(layout))
    , NamedColumns(columns)
  {
  }

  Result<ForeignMesh> Read(const Execution& execution)
  {
    for (;;)
    {
      const Result<bool> more = this->Lines.Next();
      KDSTREAM_TRY(more);
      if (!*more)
      {
        break;
      }
      KDSTREAM_TRY(this->AddLine());
      if (this->Lines.Number() % linesPerReport == 0)
      {
        KDSTREAM_TRY(execution.Report("read", this->Lines.Fraction()));
      }
    }
    return this->Finish();
  }

private:
  Status AddLine()
  {
    std::string_view line = this->Lines.Line();
    const std::size_t begin = line.find_first_not_of(separators);
    if (begin == std::string_view::npos)
    {
      return {};
    }
    if (line[begin] == '#' || line.substr(begin, 2) == "//")
    {
      this->SplitNames(line.substr(std::min(line.find_first_not_of("#/ \t", begin), line.size())));
      this->TakeNames();
      return {};
    }
    for (std::size_t at = line.find('#'); at != std::string_view::npos; at = line.find('#', at + 1))
    {
      if (at > 0 && IsBlank(line[at - 1]))
      {
        if (this->HexColorLine == 0 && IsHexColor(line.substr(at)))
        {
          this->HexColorLine = this->Lines.Number();
        }
        line = line.substr(0, at);
        break;
      }
    }
    if (this->Lines.Number() == 1 && LowercaseText(line.substr(0, 4)) == "sep=")
    {
      return {}; // spreadsheets name their separator in this way
    }
    if (!this->Columns && this->IsNames(line))
    {
      return {};
    }
    KDSTREAM_TRY(this->SplitLine(line));
    if (this->Words.empty())
    {
      return {};
    }
    const Result<bool> counts = this->IsNextCount();
    KDSTREAM_TRY(counts);
    if (*counts)
    {
      return {};
    }
    if (!this->Columns)
    {
      KDSTREAM_TRY(this->SetColumns());
    }
    if (this->Words.size() != this->ColumnCount)
    {
      this->SplitCells(this->ColumnCount);
    }
    if (this->Words.size() != this->ColumnCount)
    {
      return this->Lines.Wrong("has " + std::to_string(this->Words.size()) +
                               " columns; those before have " + std::to_string(this->ColumnCount));
    }
    return this->AddPoint();
  }

  // Takes a line that gives the number of points after it, as before each scan of a .pts.
  Result<bool> IsNextCount()
  {
    std::uint64_t count = 0;
    if (!IsCount(this->Words) || ParseNumber(this->Words[0], count) != NumberTextError::None)
    {
      return false;
    }
    if (this->CountLine > 0 && this->CountLine + 1 == this->Lines.Number() &&
        this->Out.mesh.points.empty() && this->Counted > 0)
    {
      return BadInput("lines " + std::to_string(this->CountLine) + " and " +
                        std::to_string(this->Lines.Number()) +
                        " count columns and rows, as Leica's .ptx does, which is not read: export "
                        "the scan as .pts or .xyz",
        Remedy::InMessage);
    }
    KDSTREAM_TRY(this->EndCount());
    this->CountLine = this->Lines.Number();
    this->Counted = count;
    this->SinceCount = 0;
    return true;
  }

  // Checks that there were as many points as the last count says. Errors: InvalidInput for fewer.
  Status EndCount()
  {
    if (this->CountLine == 0)
    {
      return {};
    }
    if (this->SinceCount < this->Counted)
    {
      return BadInput("truncated: line " + std::to_string(this->CountLine) + " declares " +
                        std::to_string(this->Counted) + " points, but the file has " +
                        std::to_string(this->SinceCount),
        Remedy::CopyAgain);
    }
    this->Out.tolerance.Count(Lapse::NotCounted, this->SinceCount - this->Counted,
      "line " + std::to_string(this->CountLine) + " counts " + std::to_string(this->Counted) +
        (this->Counted == 1 ? " point" : " points"));
    return {};
  }

  // Takes a line before the points that has names, of the columns or of something else.
  bool IsNames(std::string_view line)
  {
    this->SplitNames(line);
    if (AreXyzNames(this->Words))
    {
      this->NameAxes = AxesOfNames(this->Words);
      this->TakeNames();
      this->NamesAlone = this->NamesInFile == this->Lines.Number();
      return true;
    }
    const bool areNames = this->Words.size() > 1 && AreOtherNames(this->Words);
    if (areNames && (!this->OtherNames || this->Words.size() >= 3))
    {
      this->CountRemark(this->OtherNames);
      this->OtherNames = this->Lines.Number();
      this->NameAxes = AxesOfNames(this->Words);
      this->OtherWords.assign(this->Words.begin(), this->Words.end());
      return true;
    }
    if (!this->IsRemark(line))
    {
      return false;
    }
    this->CountRemark(this->Lines.Number());
    return true;
  }

  // Whether a line is a remark that programs write before points ("Date: 2026-01-01"). It begins
  // with a letter, or with % ! ; or *, and has fewer than three words with digits. The header of a
  // height grid ("ncols") does not count.
  bool IsRemark(std::string_view line)
  {
    constexpr std::uint64_t most = 64;
    SplitWords(line, separators, this->Words);
    const auto hasDigit = [](std::string_view word)
    { return std::any_of(word.begin(), word.end(), IsDigit); };
    const std::string first = this->Words.empty() ? "" : LowercaseText(this->Words[0]);
    double number = 0; // nan counts as a number
    return !this->Layout && this->Remarks < most && !first.empty() && first != "ncols" &&
           ParseNumber(first, number) == NumberTextError::NotANumber &&
           ((first[0] >= 'a' && first[0] <= 'z') ||
             std::string_view("%!;*").find(first[0]) != std::string_view::npos) &&
           std::count_if(this->Words.begin(), this->Words.end(), hasDigit) < 3;
  }

  // line: the number of the line; 0 if there is none.
  void CountRemark(std::uint64_t line)
  {
    if (line > 0)
    {
      this->FirstRemark = this->Remarks == 0 ? line : std::min(line, this->FirstRemark);
      ++this->Remarks;
    }
  }

  // Splits at commas, semicolons and tabs (names may then contain blanks and quotes). If this does
  // not give names of columns, also splits at blanks.
  void SplitNames(std::string_view line)
  {
    this->Words.clear();
    constexpr std::string_view blanks = " \r\v\f";
    bool quoted = false;
    for (std::size_t begin = 0, at = 0; at <= line.size(); ++at)
    {
      const char c = at < line.size() ? line[at] : ';';
      quoted = quoted != (c == '"');
      if (at < line.size() && (quoted || (c != ',' && c != ';' && c != '\t')))
      {
        continue;
      }
      const std::string_view name = Trimmed(line.substr(begin, at - begin), blanks);
      if (!name.empty())
      {
        this->Words.push_back(name);
      }
      begin = at + 1;
    }
    if (!AreXyzNames(this->Words))
    {
      SplitWords(line, separators, this->Words);
    }
  }

  // Takes the names of the columns, which some programs write before the points.
  void TakeNames()
  {
    if (this->Columns || this->Layout || !AreXyzNames(this->Words))
    {
      return;
    }
    this->PartNames.clear();
    if (Result<XyzLayout> layout = LayoutOfNamesInFile(this->Words, this->PartNames))
    {
      this->Layout = std::move(*layout);
      this->NamedColumns = this->Words.size();
      this->NamesInFile = this->Lines.Number();
      this->Degrees = DegreesOf(this->Words);
    }
  }

  Status SplitLine(std::string_view line)
  {
    this->Cells = line;
    if (line.find('"') != std::string_view::npos)
    {
      this->Unquoted = line;
      std::replace(this->Unquoted.begin(), this->Unquoted.end(), '"', ' ');
      line = this->Unquoted;
    }
    if (line.find(',') == std::string_view::npos)
    {
      this->PointSeen = this->PointSeen || line.find('.') != std::string_view::npos;
      if (this->Comma == Commas::Decimal && line.find('.') != std::string_view::npos)
      {
        return this->Lines.Wrong("has a decimal point, where lines before have decimal commas: it "
                                 "can be read in two ways");
      }
      SplitWords(line, separators, this->Words);
      return {};
    }
    if (this->Comma == Commas::Unknown)
    {
      SplitWords(line, separatorsButCommas, this->Words);
      this->Comma = CommasOf(this->Words);
      this->CommaLine = this->Lines.Number();
      this->AlsoDecimal = this->Words.size() == 1;
    }
    if (this->Comma == Commas::Separators)
    {
      this->PointSeen = this->PointSeen || line.find('.') != std::string_view::npos;
      SplitWords(line, separators, this->Words);
      return {};
    }
    if (this->Comma == Commas::Unclear || line.find('.') != std::string_view::npos ||
        this->PointSeen)
    {
      return this->Lines.Wrong("has commas and decimal points, which can be read in two ways: "
                               "write numbers as 1234.5, with blanks between them",
        Remedy::InMessage);
    }
    this->Text = line;
    SplitWords(this->Text, separatorsButCommas, this->Words);
    for (std::string_view& word : this->Words)
    {
      word.remove_suffix(word.ends_with(',') ? 1 : 0);
    }
    std::erase(this->Words, std::string_view()); // empty words: from a comma between blanks
    std::replace(this->Text.begin(), this->Text.end(), ',', '.');
    return {};
  }

  // Splits only at commas, semicolons or tabs, if the line then has the right number of columns. A
  // cell may then contain several words and, in quotes, even a separator. An empty cell becomes
  // "nan".
  void SplitCells(std::size_t columns)
  {
    this->CellText = this->Cells;
    if (this->Comma == Commas::Decimal)
    {
      std::replace(this->CellText.begin(), this->CellText.end(), ',', '.');
    }
    for (const char separator : { ',', ';', '\t' })
    {
      std::vector<std::string_view> cells = CellsOf(this->CellText, separator, columns);
      if (cells.size() == columns)
      {
        this->Words = std::move(cells);
        return;
      }
    }
  }

  // Returns at most `most` + 1 cells.
  static std::vector<std::string_view> CellsOf(
    std::string_view line, char separator, std::size_t most)
  {
    constexpr std::string_view blanks = " \t\r\v\f";
    std::vector<std::string_view> cells;
    bool quoted = false;
    for (std::size_t begin = 0, at = 0; at <= line.size() && cells.size() <= most; ++at)
    {
      quoted = at < line.size() && quoted != (line[at] == '"');
      if (at == line.size() || (!quoted && line[at] == separator))
      {
        const std::string_view cell =
          Trimmed(Trimmed(Trimmed(line.substr(begin, at - begin), blanks), "\""), blanks);
        cells.push_back(cell.empty() ? "nan" : cell);
        begin = at + 1;
      }
    }
    return cells;
  }

  Status SetColumns()
  {
    if (this->Layout && this->Words.size() != this->NamedColumns)
    {
      this->SplitCells(this->NamedColumns);
    }
    this->ColumnCount = this->Words.size();
    for (const char separator : { ';', '\t' })
    {
      const std::vector<std::string_view> cells = CellsOf(this->Cells, separator, mostXyzColumns);
      const auto found = std::find_if(cells.begin(), cells.end(), HasBlankThousands);
      const auto empty = std::count(cells.begin(), cells.end(), std::string_view("nan"));
      if (std::ssize(cells) - empty >= 3 && found != cells.end())
      {
        return this->Lines.Wrong(
          "has blanks in the number " + QuotedText(*found) + ": write numbers without them",
          Remedy::InMessage);
      }
    }
    if (this->Words[0].size() == 5 &&
        this->Words[0].find_first_not_of("nNcCoOlLsS") == this->Words[0].npos)
    {
      return BadInput("is a grid of heights (Esri's ASCII grid), not points: convert it with "
                      "gdal_translate -of XYZ",
        Remedy::InMessage);
    }
    if (this->Layout && this->NamesInFile > 0 && this->NamedColumns != this->ColumnCount)
    {
      if (this->NamesAlone && this->Comma == Commas::Separators && !this->PointSeen &&
          this->ColumnCount == 2 * this->NamedColumns)
      {
        return this->Lines.Wrong(
          "has " + std::to_string(this->ColumnCount) + " columns, and line " +
            std::to_string(this->NamesInFile) + " names " + std::to_string(this->NamedColumns) +
            ": decimal commas cannot be distinguished from commas between columns; "
            "write 1.5 for 1,5, or semicolons between columns",
          Remedy::InMessage);
      }
      this->Layout = std::nullopt; // the line is a remark, or has other names
      this->OtherNames = this->NamesAlone ? this->NamesInFile : this->OtherNames;
    }
    if (this->Layout && this->NamedColumns != this->ColumnCount)
    {
      return this->Lines.Wrong(
        "has " + std::to_string(this->ColumnCount) + " columns, and --columns names " +
          std::to_string(this->NamedColumns) + ": name each of them, and those to leave out -",
        Remedy::InMessage);
    }
    if (this->ColumnCount < 3 || this->ColumnCount > mostXyzColumns)
    {
      return this->Lines.Wrong("has " + std::to_string(this->ColumnCount) +
                               (this->ColumnCount == 1 ? " column" : " columns") +
                               "; points have at least 3 (x y z), and at most " +
                               std::to_string(mostXyzColumns) +
                               ", with blanks, commas, semicolons or tabs between them");
    }
    this->Columns.emplace(this->ColumnCount - 3);
    if (this->Layout)
    {
      this->FindLeftOut(*this->Layout);
      return {};
    }
    if (this->ColumnCount > 3)
    {
      this->Shifted.emplace(this->ColumnCount - 4, 4);
    }
    if (this->ColumnCount > 5)
    {
      this->AfterColors.emplace(this->ColumnCount - 6, 6);
    }
    this->IsShiftedUsual =
      this->Shifted && this->Shifted->IsCountUsual() && !this->Columns->IsCountUsual();
    if (this->ColumnCount > 4)
    {
      XyzColumns after(this->ColumnCount - 5, 5);
      if (after.IsCountUsual())
      {
        this->InRows.emplace(std::move(after));
      }
    }
    return {};
  }

  // A value for --columns that helps if an unnamed column holds words, before or after the
  // coordinates; empty if none would help.
  std::string ColumnsWithout(std::size_t column) const
  {
    std::size_t count = this->ColumnCount;
    for (const char separator : { '\t', ';', ',' })
    {
      const bool isThere = this->Cells.find(separator) != std::string_view::npos;
      count = isThere ? CellsOf(this->Cells, separator, mostXyzColumns).size() : count;
    }
    const bool isFirst = column == 0;
    if (this->Layout || count < 4 || (column > 0 && column < 3))
    {
      return {};
    }
    std::string names = isFirst ? "- x y z" : "x y z";
    for (std::size_t k = isFirst ? 4 : 3; k < count; ++k)
    {
      names += " -";
    }
    return names;
  }

  // Marks the columns that are ignored, which may have any words.
  void FindLeftOut(const XyzLayout& layout)
  {
    this->LeftOut.assign(this->ColumnCount, true);
    this->HasNumbers.assign(this->ColumnCount, false);
    for (const std::size_t place : layout.coordinates)
    {
      this->LeftOut[place] = false;
    }
    for (const XyzLayout::Block& block : layout.blocks)
    {
      for (const std::size_t column : block.columns)
      {
        this->LeftOut[column] = false;
      }
    }
  }

  // Leaves out a column that the file names, if it holds words and has had no number so far.
  bool LeaveOutWords(std::size_t column)
  {
    if (!this->Layout || this->NamesInFile == 0 || this->HasNumbers[column])
    {
      return false;
    }
    const auto isOfWords = [&](const XyzLayout::Block& block)
    { return block.kind == XyzLayout::Kind::Number && block.columns[0] == column; };
    std::vector<XyzLayout::Block>& numbers = this->Layout->blocks;
    const auto found = std::find_if(numbers.begin(), numbers.end(), isOfWords);
    if (found == numbers.end())
    {
      return false;
    }
    this->WordColumns += (this->WordColumns.empty() ? "" : ", ") + QuotedText(found->name);
    numbers.erase(found);
    this->LeftOut[column] = true;
    return true;
  }

  Status AddPoint()
  {
    ++this->SinceCount;
    const std::array<std::size_t, 3> places =
      this->Layout ? this->Layout->coordinates : std::array<std::size_t, 3>{ 0, 1, 2 };
    Vec3 point{};
    std::array<float, mostXyzColumns> rest{};
    std::size_t extra = 0;
    for (std::size_t i = 0; i < this->ColumnCount; ++i)
    {
      const std::string_view word = this->Words[i];
      if (i < this->LeftOut.size() && this->LeftOut[i])
      {
        ++extra;
        continue;
      }
      const auto place =
        static_cast<std::size_t>(std::find(places.begin(), places.end(), i) - places.begin());
      const NumberTextError error =
        place < 3 ? ParseNumber(word, point[place]) : ParseNumber(word, rest[extra++]);
      const bool isNumber = error == NumberTextError::None;
      if (place == 3 && error == NumberTextError::NotANumber && this->LeaveOutWords(i))
      {
        continue;
      }
      if (place == 3 && isNumber && i < this->HasNumbers.size())
      {
        this->HasNumbers[i] = this->HasNumbers[i] || std::isfinite(double(rest[extra - 1]));
      }
      if (!isNumber)
      {
        const std::string names = this->ColumnsWithout(i);
        return this->Lines.Wrong(
          QuotedText(word) + " (column " + std::to_string(i + 1) + ")" +
          (error == NumberTextError::NotANumber ? " is not a number" : " is too large a number") +
          (names.empty() ? "" : "; --columns \"" + names + "\" leaves out what is called -"));
      }
    }
    if (this->Shifted)
    {
      this->First.Add(point[0]);
      if (!this->First.MayBeOther())
      {
        this->Shifted.reset();
        std::vector<double>().swap(this->Fourth);
      }
    }
    if (this->InRows)
    {
      this->Raster.Add(point[0], point[1]);
      if (!this->Raster.MayBe())
      {
        this->InRows.reset();
        std::vector<std::array<double, 2>>().swap(this->Later);
      }
    }
    if (!std::all_of(point.begin(), point.end(), [](double v) { return std::isfinite(v); }))
    {
      this->Out.tolerance.Count(
        Lapse::PointNotFinite, 1, "line " + std::to_string(this->Lines.Number()));
      return {};
    }
    if (this->Out.mesh.points.size() >= noVertex - 1)
    {
      return Error{ ErrorCode::LimitExceeded, "more than 4294967294 points" };
    }
    this->Out.mesh.points.push_back(point);
    for (const std::size_t place : places)
    {
      this->Precision.Add(this->Words[place]);
    }
    this->Extra.insert(this->Extra.end(), rest.begin(), rest.begin() + std::ptrdiff_t(extra));
    this->Columns->Add(rest.data());
    this->AddAfterColors(point, rest.data());
    if (this->InRows)
    {
      std::array<double, 2> later{};
      ParseNumber(this->Words[3], later[0]);
      ParseNumber(this->Words[4], later[1]);
      this->Later.push_back(later);
      this->InRows->Add(rest.data() + 2);
      for (std::size_t k = 2; k < 5; ++k)
      {
        this->InRowsPrecision.Add(this->Words[k]);
      }
    }
    if (this->Shifted)
    {
      double fourth = 0;
      ParseNumber(this->Words[3], fourth);
      this->Fourth.push_back(fourth);
      this->Shifted->Add(rest.data() + 1);
      for (std::size_t k = 0; k < 3; ++k)
      {
        this->ShiftedPrecision.Add(this->Words[k + 1]);
      }
    }
    return {};
  }

  // Adds a point as if the columns began with a colour. This reading stays possible as long as the
  // first three columns are bytes.
  void AddAfterColors(const Vec3& point, const float* rest)
  {
    if (!this->AfterColors)
    {
      return;
    }
    Vec3 place{};
    for (std::size_t k = 0; k < 3; ++k)
    {
      ParseNumber(this->Words[k + 3], place[k]);
    }
    const auto isByte = [](double v) { return v >= 0 && v <= 255 && v == std::floor(v); };
    if (!std::all_of(point.begin(), point.end(), isByte) ||
        !std::all_of(place.begin(), place.end(), [](double v) { return std::isfinite(v); }))
    {
      this->AfterColors.reset();
      std::vector<Vec3>().swap(this->Places);
      return;
    }
    this->Places.push_back(place);
    this->AfterColors->Add(rest + 3);
    for (std::size_t k = 0; k < 3; ++k)
    {
      this->PlacesPrecision.Add(this->Words[k + 3]);
    }
  }

  Result<ForeignMesh> Finish()
  {
    Mesh& mesh = this->Out.mesh;
    KDSTREAM_TRY(this->EndCount());
    this->Out.tolerance.Count(Lapse::PaddedEnd, this->Lines.Padding());
    if (this->SinceCount == 0 && this->OtherNames + this->Remarks > 0)
    {
      return this->Lines.Wrong("none of its lines is a point", Remedy::Rename);
    }
    if (mesh.points.empty())
    {
      return std::move(this->Out);
    }
    std::vector<std::string> readings;
    this->TellCommas(readings);
    this->TellNames(readings);
    Result<XyzLayout> layout =
      this->Layout ? Result<XyzLayout>(*this->Layout) : this->ChooseLayout(readings);
    KDSTREAM_TRY(layout);
    this->NameNumbers(*layout);
    KDSTREAM_TRY(this->CheckNames(*layout));
    mesh.scalarType = this->Precision.FloatsSuffice() ? ScalarType::Float32 : ScalarType::Float64;
    for (const XyzLayout::Block& block : layout->blocks)
    {
      this->AddBlock(block, layout->coordinates, readings);
    }
    for (std::string& reading : readings)
    {
      this->Out.tolerance.Tell(reading);
    }
    return std::move(this->Out);
  }

  // Guesses, from the values, what the first column is, and what the columns after the coordinates
  // are.
  Result<XyzLayout> ChooseLayout(std::vector<std::string>& readings)
  {
    using Meaning = XyzFirstColumn::Meaning;
    std::vector<std::string> plainReadings, shiftedReadings;
    XyzLayout plain = this->Columns->Guess(plainReadings);
    if (this->MayBeginWithColors(plain))
    {
      XyzLayout colored = this->AfterColors->Guess(shiftedReadings);
      std::erase_if(
        colored.blocks, [](const XyzLayout::Block& block) { return block.columns[0] < 3; });
      colored.blocks.insert(colored.blocks.begin(), { XyzLayout::Kind::Colors, { 0, 1, 2 } });
      const std::string colors = "the first three are whole numbers from 0 to 255";
      if (CountDifferent(this->Out.mesh.points) < CountDifferent(this->Places))
      {
        this->TellOther("the columns are read as \"" + NamesOfLayout(colored) + "\", not \"" +
                        NamesOfLayout(plain) + "\": " + colors +
                        ", some of them alike (--columns decides)");
        this->PutPlacesFirst();
        readings.insert(readings.end(), shiftedReadings.begin(), shiftedReadings.end());
        return colored;
      }
      this->TellOther("the columns are read as \"" + NamesOfLayout(plain) + "\"; they could be \"" +
                      NamesOfLayout(colored) + "\" too, as " + colors + " (--columns decides)");
      shiftedReadings.clear();
    }
    if (this->InRows && this->Raster.Is() && this->ArePlacesBroken())
    {
      XyzLayout inRows = this->InRows->Guess(shiftedReadings);
      if (Triples(inRows) >= Triples(plain))
      {
        this->TellOther("the columns are read as \"" + NamesOfLayout(inRows) + "\", not \"" +
                        NamesOfLayout(plain) +
                        "\": the first two count rows and columns (--columns decides)");
        this->ShiftByRows();
        readings.insert(readings.end(), shiftedReadings.begin(), shiftedReadings.end());
        return inRows;
      }
      shiftedReadings.clear();
    }
    const Meaning means = this->Shifted ? this->MeaningOfFirst() : Meaning::X;
    if (means != Meaning::X)
    {
      XyzLayout shifted = this->Shifted->Guess(shiftedReadings);
      // A layout that has no place for colours that exist is wrong.
      const bool fits = this->IsShiftedUsual || Triples(shifted) >= Triples(plain);
      const bool isX = means == Meaning::Rises || means == Meaning::Differs;
      if (fits && !isX && this->PlacesVary())
      {
        this->TellOther("the columns are read as \"" + NamesOfLayout(shifted) + "\", not \"" +
                        NamesOfLayout(plain) + "\": the first " +
                        (means == Meaning::Counter     ? "counts the lines"
                          : means == Meaning::Shuffled ? "numbers the lines, in another order"
                                                       : "rises as a time does") +
                        " (--columns decides)");
        this->Shift();
        readings.insert(readings.end(), shiftedReadings.begin(), shiftedReadings.end());
        return shifted;
      }
      if (fits && isX && !this->IsFourthOther())
      {
        this->TellOther("the columns are read as \"" + NamesOfLayout(plain) +
                        "\"; they could be \"" + NamesOfLayout(shifted) + "\" too, as the first " +
                        (means == Meaning::Rises ? "never falls" : "has no number twice") +
                        " (--columns decides)");
      }
    }
    else if (this->MayBeginWithClass(plain))
    {
      this->TellOther("the columns are read as \"" + NamesOfLayout(plain) +
                      "\"; the first could be a class, as it has few whole numbers and the next "
                      "three have fractions (--columns decides)");
    }
    readings.insert(readings.end(), plainReadings.begin(), plainReadings.end());
    return plain;
  }

  // Whether the columns may be "r g b x y z". The first three must be bytes; the next three must be
  // neither colours nor normals, all must vary, and at least two must have fractions.
  bool MayBeginWithColors(const XyzLayout& plain) const
  {
    constexpr std::size_t fewest = 20;
    const auto isOfPlaces = [](const XyzLayout::Block& block)
    { return block.kind != XyzLayout::Kind::Number && block.columns[0] < 6; };
    if (!this->AfterColors || this->Places.size() < fewest ||
        std::any_of(plain.blocks.begin(), plain.blocks.end(), isOfPlaces))
    {
      return false;
    }
    std::size_t varying = 0, broken = 0;
    for (std::size_t k = 0; k < 3; ++k)
    {
      const auto any = [&](const auto& is)
      { return std::any_of(this->Places.begin(), this->Places.end(), is) ? 1U : 0U; };
      varying += any([&](const Vec3& place) { return place[k] != this->Places[0][k]; });
      broken += any([&](const Vec3& place) { return place[k] != std::floor(place[k]); });
    }
    return varying == 3 && broken >= 2;
  }

  // Whether the first column may be a class before x y z: it has only a few different whole
  // numbers, and the three columns after it have fractions and are neither colours nor normals.
  bool MayBeginWithClass(const XyzLayout& plain) const
  {
    constexpr std::size_t fewest = 20, most = 32;
    const std::vector<Vec3>& points = this->Out.mesh.points;
    const std::size_t extra = this->ColumnCount - 3;
    const bool isFourthKnown = std::any_of(plain.blocks.begin(), plain.blocks.end(),
      [](const XyzLayout::Block& block)
      { return block.kind != XyzLayout::Kind::Number && block.columns[0] == 3; });
    if (extra == 0 || isFourthKnown || points.size() < fewest)
    {
      return false;
    }
    std::set<double> classes;
    std::array<bool, 3> areBroken{};
    for (std::size_t i = 0; i < points.size(); ++i)
    {
      const double first = points[i][0], fourth = double(this->Extra[i * extra]);
      if (first < 0 || first > 255 || first != std::floor(first))
      {
        return false;
      }
      if (classes.insert(first).second && classes.size() > most)
      {
        return false;
      }
      areBroken[0] = areBroken[0] || points[i][1] != std::floor(points[i][1]);
      areBroken[1] = areBroken[1] || points[i][2] != std::floor(points[i][2]);
      areBroken[2] = areBroken[2] || fourth != std::floor(fourth);
    }
    return 2 * classes.size() <= points.size() &&
           std::all_of(areBroken.begin(), areBroken.end(), [](bool is) { return is; });
  }

  static std::size_t CountDifferent(std::vector<Vec3> points)
  {
    std::sort(points.begin(), points.end());
    return static_cast<std::size_t>(std::unique(points.begin(), points.end()) - points.begin());
  }

  // Makes points of columns 4 to 6. The first three columns are stored before the columns after
  // them.
  void PutPlacesFirst()
  {
    std::vector<Vec3>& points = this->Out.mesh.points;
    const std::size_t extra = this->ColumnCount - 3;
    for (std::size_t i = 0; i < points.size(); ++i)
    {
      for (std::size_t k = 0; k < 3; ++k)
      {
        this->Extra[i * extra + k] = float(points[i][k]);
      }
    }
    points.swap(this->Places);
    this->Precision = this->PlacesPrecision;
  }

  // Whether the fourth column cannot be a coordinate: all its values are whole, and those of the
  // two columns before it are not.
  bool IsFourthOther() const
  {
    const std::vector<Vec3>& points = this->Out.mesh.points;
    const auto isWhole = [](double v) { return v == std::floor(v); };
    const auto areWhole = [&](std::size_t k)
    {
      return std::all_of(
        points.begin(), points.end(), [&](const Vec3& point) { return isWhole(point[k]); });
    };
    return std::all_of(this->Fourth.begin(), this->Fourth.end(), isWhole) && !areWhole(1) &&
           !areWhole(2);
  }

  // Numbers in no order can be numbers of points only if other columns have fractions.
  XyzFirstColumn::Meaning MeaningOfFirst() const
  {
    using Meaning = XyzFirstColumn::Meaning;
    const std::vector<Vec3>& points = this->Out.mesh.points;
    const auto isBroken = [](double v) { return v != std::floor(v); };
    const Meaning means = this->First.Means();
    if (means != Meaning::X ||
        (std::none_of(this->Fourth.begin(), this->Fourth.end(), isBroken) &&
          std::none_of(points.begin(), points.end(),
            [&](const Vec3& point) { return isBroken(point[1]) || isBroken(point[2]); })))
    {
      return means;
    }
    std::vector<double> first;
    for (const Vec3& point : points)
    {
      first.push_back(point[0]);
    }
    return this->First.MeansByAll(std::move(first));
  }

  void TellOther(const std::string& what)
  {
    this->Out.tolerance.Count(Lapse::ColumnsGuessed, 1, what);
  }

  static std::ptrdiff_t Triples(const XyzLayout& layout)
  {
    return std::count_if(layout.blocks.begin(), layout.blocks.end(),
      [](const XyzLayout::Block& block) { return block.kind != XyzLayout::Kind::Number; });
  }

  // Whether columns 2 to 4 can be a place: at least two of them must vary.
  bool PlacesVary() const
  {
    const std::vector<Vec3>& points = this->Out.mesh.points;
    std::size_t varying = 0;
    for (const std::size_t k : { 1, 2 })
    {
      varying += std::any_of(points.begin(), points.end(),
                   [&](const Vec3& point) { return point[k] != points[0][k]; })
                   ? 1
                   : 0;
    }
    return varying + (std::any_of(this->Fourth.begin(), this->Fourth.end(),
                        [&](double v) { return v != this->Fourth[0]; })
                         ? 1
                         : 0) >=
           2;
  }

  // Whether columns 3, 4 and 5 all have fractions.
  bool ArePlacesBroken() const
  {
    const auto isBroken = [](double v) { return v != std::floor(v); };
    const std::vector<Vec3>& points = this->Out.mesh.points;
    return std::any_of(
             points.begin(), points.end(), [&](const Vec3& point) { return isBroken(point[2]); }) &&
           std::any_of(this->Later.begin(), this->Later.end(),
             [&](const auto& later) { return isBroken(later[0]); }) &&
           std::any_of(this->Later.begin(), this->Later.end(),
             [&](const auto& later) { return isBroken(later[1]); });
  }

  // Makes points of columns 3 to 5. The first two columns become their attributes "row" and
  // "column".
  void ShiftByRows()
  {
    std::vector<Vec3>& points = this->Out.mesh.points;
    for (const std::size_t k : { 0, 1 })
    {
      Attribute number =
        MakePointAttribute(k == 0 ? "row" : "column", AttributeType::Float64, 1, points.size());
      for (std::size_t i = 0; i < points.size(); ++i)
      {
        number.Set(i, 0, points[i][k]);
      }
      this->Out.mesh.attributes.push_back(std::move(number));
    }
    for (std::size_t i = 0; i < points.size(); ++i)
    {
      points[i] = { points[i][2], this->Later[i][0], this->Later[i][1] };
    }
    this->Precision = this->InRowsPrecision;
    this->IsShifted = true;
  }

  // Makes points of columns 2 to 4. The first column becomes their attribute "number".
  void Shift()
  {
    std::vector<Vec3>& points = this->Out.mesh.points;
    Attribute number = MakePointAttribute("number", AttributeType::Float64, 1, points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
    {
      number.Set(i, 0, points[i][0]);
      points[i] = { points[i][1], points[i][2], this->Fourth[i] };
    }
    this->Out.mesh.attributes.push_back(std::move(number));
    this->Precision = this->ShiftedPrecision;
    this->IsShifted = true;
  }

  void TellCommas(std::vector<std::string>& readings) const
  {
    const std::string line = "line " + std::to_string(this->CommaLine) + ": commas are taken ";
    if (this->Comma == Commas::Decimal)
    {
      readings.push_back(line + "as decimal commas, as in 1,5");
    }
    else if (this->Comma == Commas::Separators && this->AlsoDecimal && !this->PointSeen &&
             this->ColumnCount == 6 && !this->Layout)
    {
      readings.push_back(
        line +
        "to separate columns; as decimal commas they would leave 3 columns (--columns decides)");
    }
  }

  void TellNames(std::vector<std::string>& readings) const
  {
    if (this->OtherNames > 0 && !this->Layout)
    {
      readings.push_back("line " + std::to_string(this->OtherNames) +
                         " seems to name the columns, but with unknown names: they are read by "
                         "their order (--columns names them)");
    }
    else if (this->Layout && !this->Degrees.empty())
    {
      readings.push_back("line " + std::to_string(this->NamesInFile) + ": " + this->Degrees +
                         " are degrees, which are taken for lengths as they are: project them to "
                         "metres first if lengths are to be right");
    }
    if (!this->WordColumns.empty())
    {
      readings.push_back("left out: columns of text: " + this->WordColumns);
    }
    if (this->Remarks > 0)
    {
      const bool isNamesToo = this->Layout && this->OtherNames > 0; // taken for names
      const std::uint64_t lines = this->Remarks + (isNamesToo ? 1 : 0);
      readings.push_back(
        std::to_string(lines) +
        (lines == 1 ? " line before the points is not a point and is skipped"
                    : " lines before the points are not points and are skipped; the first") +
        ": line " +
        std::to_string(
          isNamesToo ? std::min(this->FirstRemark, this->OtherNames) : this->FirstRemark));
    }
    if (this->HexColorLine > 0)
    {
      readings.push_back("line " + std::to_string(this->HexColorLine) +
                         ": what follows # is a comment, and looks like a colour: write colours as "
                         "three numbers (200 100 50 for #c86432)");
    }
    if (this->Layout && !this->PartNames.empty())
    {
      readings.push_back("line " + std::to_string(this->NamesInFile) + " names " + this->PartNames +
                         " without the other two: kept as numbers");
    }
  }

  // Names the numbers of a guessed layout, if a line of the file has a name for each column.
  void NameNumbers(XyzLayout& layout) const
  {
    if (this->Layout || this->OtherWords.size() != this->ColumnCount)
    {
      return;
    }
    std::set<std::string> taken{ "RGB", "Normals", "number" };
    for (XyzLayout::Block& block : layout.blocks)
    {
      const std::string name(Trimmed(this->OtherWords[block.columns[0]], " \"'"));
      if (block.kind == XyzLayout::Kind::Number && IsAttributeName(name) &&
          taken.insert(name).second)
      {
        block.name = name;
      }
    }
  }

  // Some names may be unknown, but the known ones must not contradict the order in which columns
  // are read. Otherwise points would be mirrored.
  Status CheckNames(const XyzLayout& layout) const
  {
    const bool isOfColumns = this->NameAxes.size() == this->ColumnCount;
    std::array<bool, 3> named{};
    for (const std::optional<std::size_t>& axis : this->NameAxes)
    {
      named[axis.value_or(0)] = named[axis.value_or(0)] || axis;
    }
    if (this->OtherNames == 0 || this->Layout ||
        (!isOfColumns && !std::all_of(named.begin(), named.end(), [](bool is) { return is; })))
    {
      return {};
    }
    for (std::size_t k = 0; k < this->NameAxes.size(); ++k)
    {
      const std::optional<std::size_t> axis = this->NameAxes[k];
      if (axis && layout.coordinates[*axis] != k)
      {
        return BadInput("line " + std::to_string(this->OtherNames) + " names column " +
                          std::to_string(k + 1) + " as " + std::string(axisNames[*axis]) +
                          ", and by its order " + "column " +
                          std::to_string(layout.coordinates[*axis] + 1) +
                          " would be: name all columns with --columns",
          Remedy::InMessage);
      }
    }
    return {};
  }

  void AddBlock(const XyzLayout::Block& block, const std::array<std::size_t, 3>& coordinates,
    std::vector<std::string>& readings)
  {
    if (this->IsShifted && block.columns[0] < coordinates[0])
    {
      return; // made by Shift or ShiftByRows
    }
    const std::size_t tuples = this->Out.mesh.points.size();
    // Columns are stored without the coordinates; if the layout is shifted, without the first
    // three.
    std::array<std::size_t, 3> columns{};
    for (std::size_t k = 0; k < 3; ++k)
    {
      columns[k] =
        block.columns[k] -
        (this->IsShifted
            ? 3
            : static_cast<std::size_t>(std::count_if(coordinates.begin(), coordinates.end(),
                [&](std::size_t place) { return place < block.columns[k]; })));
    }
    Attribute attribute = block.kind == XyzLayout::Kind::Colors ? MakeColors(tuples)
                          : block.kind == XyzLayout::Kind::Normals
                            ? MakeNormals(tuples)
                            : MakePointAttribute(block.name, AttributeType::Float32, 1, tuples);
    const bool colors = block.kind == XyzLayout::Kind::Colors;
    const std::size_t extra = this->ColumnCount - 3;
    ColorWhite white;
    for (std::size_t i = 0; colors && i < tuples; ++i)
    {
      for (const std::size_t column : columns)
      {
        white.Add(double(this->Extra[i * extra + column]));
      }
    }
    const double scale = colors ? 255 / white.White() : 1;
    if (const std::string doubt = white.Doubt(); !doubt.empty())
    {
      readings.push_back("colours are read as from 0 to " +
                         std::to_string(static_cast<int>(white.White())) + ", " + doubt);
    }
    for (std::size_t i = 0; i < tuples; ++i)
    {
      for (std::size_t k = 0; k < attribute.components; ++k)
      {
        attribute.Set(i, k, double(this->Extra[i * extra + columns[k]]) * scale);
      }
    }
    this->Out.mesh.attributes.push_back(std::move(attribute));
  }

  TextLines Lines;
  std::optional<XyzLayout> Layout; // from --columns, or from names in the file
  std::size_t NamedColumns = 0;    // of Layout
  std::uint64_t NamesInFile = 0;   // the line with names; 0 if there is none
  bool NamesAlone = false;         // the line with names is not a comment
  std::vector<std::string_view> Words;
  std::string_view Cells;     // the line, with its quotes
  std::string CellText;       // Cells, with decimal points
  std::string Text, Unquoted; // a line with decimal commas; one with quotes
  Commas Comma = Commas::Unknown;
  std::uint64_t CommaLine = 0;
  bool AlsoDecimal = false; // only commas separate the columns
  bool PointSeen = false;   // a decimal point was seen
  std::size_t ColumnCount = 0;
  std::vector<bool> LeftOut, HasNumbers;      // for each column, if the layout is known
  std::string WordColumns;                    // names of columns that hold words, for a message
  std::optional<XyzColumns> Columns;          // set at the first point
  std::uint64_t CountLine = 0;                // the line of the last count; 0: none
  std::uint64_t Counted = 0, SinceCount = 0;  // points by the last count, and points read after it
  std::uint64_t OtherNames = 0;               // a line of names that are not columns; 0: none
  std::uint64_t Remarks = 0, FirstRemark = 0; // skipped lines before the points
  std::uint64_t HexColorLine = 0;             // with a colour such as #c86432; 0: none
  std::vector<std::optional<std::size_t>> NameAxes; // axes of the named columns
  std::vector<std::string> OtherWords;              // the words of line OtherNames
  std::string Degrees;      // names of columns that are longitudes or latitudes, for messages
  std::string PartNames;    // incomplete r g b or nx ny nz, read as plain numbers
  std::vector<float> Extra; // all columns except the coordinates
  DecimalPrecision Precision;
  // The columns if the first one is not a coordinate, as long as that is possible; nothing if the
  // layout is known.
  std::optional<XyzColumns> Shifted;
  XyzFirstColumn First;
  std::vector<double> Fourth; // the fourth column of all points
  DecimalPrecision ShiftedPrecision;
  // The same if the first two columns count rows and columns.
  std::optional<XyzColumns> InRows;
  XyzRaster Raster;
  std::vector<std::array<double, 2>> Later; // columns 4 and 5 of the points
  DecimalPrecision InRowsPrecision;
  // The columns after "r g b x y z", if the columns begin with a colour; set as long as that is
  // possible.
  std::optional<XyzColumns> AfterColors;
  std::vector<Vec3> Places; // columns 4 to 6 of the points
  DecimalPrecision PlacesPrecision;
  bool IsShifted = false;
  bool IsShiftedUsual = false; // the number of columns is usual only without the first one
  ForeignMesh Out;
};

}

Result<ForeignMesh> ReadXyz(
  const std::filesystem::path& file, const std::string& columns, const Execution& execution)
{
  std::optional<XyzLayout> layout;
  std::vector<std::string_view> names;
  SplitWords(columns, " ,\t", names);
  if (!columns.empty())
  {
    Result<XyzLayout> named = LayoutOfNames(names);
    KDSTREAM_TRY(named);
    layout = std::move(*named);
  }
  Result<ByteSource> source = ByteSource::Open(file);
  KDSTREAM_TRY(source);
  return XyzReader(TextLines(std::move(*source)), std::move(layout), names.size()).Read(execution);
}

}
