// SPDX-License-Identifier: BSD-3-Clause
// Finds out what the columns of an .xyz file mean: see XyzColumns.h.
#include "filters/convert/XyzColumns.h"

#include "filters/core/Texts.h"
#include "filters/meshio/NumberText.h"
#include "filters/meshio/QuotedText.h"
#include "filters/meshio/TextWords.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

namespace kdstream
{
namespace
{

using Kind = XyzLayout::Kind;
using Block = XyzLayout::Block;

constexpr std::uint64_t manyPoints = 20; // with this many points, small values are significant

std::string_view NameWithoutQuotes(std::string_view word)
{
  constexpr std::string_view quotes = "\"'";
  while (word.size() > 1 && quotes.find(word.front()) != quotes.npos && word.front() == word.back())
  {
    word = word.substr(1, word.size() - 2);
  }
  return word;
}

bool IsNumberText(std::string_view word)
{
  double value = 0;
  return ParseNumber(Trimmed(NameWithoutQuotes(word), " "), value) != NumberTextError::NotANumber;
}

// "x" for "x (m)".
std::string_view WithoutUnit(std::string_view name)
{
  const std::size_t unit = name.find_first_of("([");
  return unit == name.npos || unit == 0 ? name
                                        : name.substr(0, name.find_last_not_of(' ', unit - 1) + 1);
}

// "x" for "x_m".
std::string_view WithoutUnitAtEnd(std::string_view name)
{
  constexpr std::array<std::string_view, 11> units{ "m", "km", "dm", "cm", "mm", "ft", "in", "feet",
    "meters", "metres", "deg" };
  const std::size_t gap = name.find_last_of("_ -.");
  const bool isUnit =
    gap != name.npos && gap > 0 &&
    std::find(units.begin(), units.end(), LowercaseText(name.substr(gap + 1))) != units.end();
  return isUnit ? name.substr(0, gap) : name;
}

// The short name, if the name is one of several usual ones for the same thing.
std::string PlainName(std::string_view name)
{
  name = WithoutUnit(NameWithoutQuotes(name));
  constexpr std::array<std::array<std::string_view, 2>, 9> others{ { { "red", "r" },
    { "green", "g" }, { "blue", "b" }, { "rf", "r" }, { "gf", "g" }, { "bf", "b" },
    { "i", "intensity" }, { "class", "classification" }, { "skip", "-" } } };
  std::string plain = LowercaseText(name);
  for (const auto& [other, known] : others)
  {
    plain = plain == other ? std::string(known) : plain;
  }
  static const std::set<std::string, std::less<>> knownNames{ "x", "y", "z", "r", "g", "b", "nx",
    "ny", "nz", "intensity", "classification", "-" };
  return knownNames.contains(plain) ? plain : std::string(name);
}

std::string NameOfNumber(const std::string& plain)
{
  return plain == "intensity" ? "Intensity" : plain;
}

std::string ColumnName(std::size_t column)
{
  return "column" + std::to_string(column + 1);
}

Error Bad(const std::string& what)
{
  return { ErrorCode::InvalidArgument, "--columns: " + what };
}

// The letters and digits of a name, without what programs add to the name of a coordinate:
// "POINT_X", "x-coordinate" and "Points:0" become "x", "x" and "0".
std::string BareName(std::string_view name)
{
  std::string bare;
  for (const char letter : LowercaseText(name))
  {
    const auto byte = static_cast<unsigned char>(letter);
    bare += std::isalnum(byte) != 0 || byte >= 0x80 ? std::string(1, letter) : "";
  }
  const auto isLetter = [](std::string_view word)
  { return word.size() == 1 && std::string_view("xyz012").find(word[0]) != word.npos; };
  for (const std::string_view around :
    { "points", "point", "positions", "position", "pos", "coordinates", "coordinate", "coords",
      "coord", "centre", "center", "utm", "local", "global", "p" })
  {
    const std::string_view whole = bare;
    if (whole.starts_with(around) && isLetter(whole.substr(around.size())))
    {
      return bare.substr(around.size());
    }
    if (whole.ends_with(around) && isLetter(whole.substr(0, whole.size() - around.size())))
    {
      return bare.substr(0, 1);
    }
  }
  return bare;
}

// The names of the three coordinates, the surest first. degrees: longitudes and latitudes.
struct CoordinateName
{
  std::string_view name;
  std::size_t axis;
  bool isDegrees = false;
};
constexpr std::array coordinateNames{ CoordinateName{ "x", 0 }, CoordinateName{ "y", 1 },
  CoordinateName{ "z", 2 }, CoordinateName{ "0", 0 }, CoordinateName{ "1", 1 },
  CoordinateName{ "2", 2 }, CoordinateName{ "easting", 0 }, CoordinateName{ "eastings", 0 },
  CoordinateName{ "east", 0 }, CoordinateName{ "e", 0 }, CoordinateName{ "rechtswert", 0 },
  CoordinateName{ "rechts", 0 }, CoordinateName{ "ostwert", 0 }, CoordinateName{ "este", 0 },
  CoordinateName{ "est", 0 }, CoordinateName{ "northing", 1 }, CoordinateName{ "northings", 1 },
  CoordinateName{ "north", 1 }, CoordinateName{ "n", 1 }, CoordinateName{ "hochwert", 1 },
  CoordinateName{ "hoch", 1 }, CoordinateName{ "nordwert", 1 }, CoordinateName{ "norte", 1 },
  CoordinateName{ "nord", 1 }, CoordinateName{ "longitude", 0, true },
  CoordinateName{ "long", 0, true }, CoordinateName{ "lon", 0, true },
  CoordinateName{ "lng", 0, true }, CoordinateName{ "latitude", 1, true },
  CoordinateName{ "lat", 1, true }, CoordinateName{ "elevation", 2 }, CoordinateName{ "elev", 2 },
  CoordinateName{ "ele", 2 }, CoordinateName{ "height", 2 }, CoordinateName{ "hgt", 2 },
  CoordinateName{ "altitude", 2 }, CoordinateName{ "alt", 2 }, CoordinateName{ "hoehe", 2 },
  CoordinateName{ "höhe", 2 }, CoordinateName{ "altura", 2 }, CoordinateName{ "cota", 2 },
  CoordinateName{ "quota", 2 }, CoordinateName{ "h", 2 } };

// The index in coordinateNames of a name without its unit; nothing for all other names.
std::optional<std::size_t> FindCoordinateName(std::string_view name)
{
  const std::string bare = BareName(WithoutUnitAtEnd(WithoutUnit(NameWithoutQuotes(name))));
  const bool isNumbered = LowercaseText(name).find("point") != std::string::npos;
  const auto* const found = std::find_if(coordinateNames.begin(), coordinateNames.end(),
    [&](const CoordinateName& known)
    { return known.name == bare && (std::isdigit(bare[0]) == 0 || isNumbered); });
  return found == coordinateNames.end()
           ? std::nullopt
           : std::optional(static_cast<std::size_t>(found - coordinateNames.begin()));
}

// Short names for all columns. If x, y or z is missing, a column with another usual name of this
// coordinate becomes it.
std::vector<std::string> PlainNames(const std::vector<std::string_view>& names)
{
  std::vector<std::string> plain;
  std::vector<std::optional<std::size_t>> known;
  for (const std::string_view name : names)
  {
    plain.push_back(PlainName(name));
    known.push_back(FindCoordinateName(name));
  }
  for (std::size_t axis = 0; axis < axisNames.size(); ++axis)
  {
    std::optional<std::size_t> surest;
    for (std::size_t k = 0; k < known.size(); ++k)
    {
      const bool isAxis = known[k] && coordinateNames[*known[k]].axis == axis;
      surest = isAxis && (!surest || *known[k] < *known[*surest]) ? k : surest;
    }
    if (surest && std::find(plain.begin(), plain.end(), axisNames[axis]) == plain.end())
    {
      plain[*surest] = axisNames[axis];
    }
  }
  return plain;
}

// parts: gets the names of incomplete groups; if null, incomplete groups are errors.
Result<XyzLayout> LayoutOf(const std::vector<std::string_view>& names, std::string* parts)
{
  if (names.size() > mostXyzColumns)
  {
    return Bad("more than " + std::to_string(mostXyzColumns) + " names");
  }
  std::vector<std::string> plain = PlainNames(names);
  for (std::size_t k = 0; k < plain.size(); ++k)
  {
    const auto end = plain.begin() + static_cast<std::ptrdiff_t>(k);
    if (plain[k] != "-" && std::find(plain.begin(), end, plain[k]) != end)
    {
      if (!parts)
      {
        return Bad(QuotedText(names[k]) + " is named twice");
      }
      plain[k] = ColumnName(k);
    }
  }
  const auto find = [&](const std::array<const char*, 3>& wanted)
  {
    std::array<std::size_t, 3> found{};
    for (std::size_t k = 0; k < 3; ++k)
    {
      found[k] =
        static_cast<std::size_t>(std::find(plain.begin(), plain.end(), wanted[k]) - plain.begin());
    }
    return found;
  };
  XyzLayout layout;
  layout.coordinates = find({ "x", "y", "z" });
  std::set<std::size_t> used(layout.coordinates.begin(), layout.coordinates.end());
  if (used.contains(plain.size()))
  {
    return Bad("x, y and z are needed");
  }
  for (const auto& [kind, wanted] :
    { std::pair{ Kind::Colors, std::array<const char*, 3>{ "r", "g", "b" } },
      std::pair{ Kind::Normals, std::array<const char*, 3>{ "nx", "ny", "nz" } } })
  {
    const std::array<std::size_t, 3> found = find(wanted);
    const auto missing = std::count(found.begin(), found.end(), plain.size());
    if (missing == 3)
    {
      continue;
    }
    if (missing > 0)
    {
      if (!parts)
      {
        return Bad(std::string("of ") + wanted[0] + " " + wanted[1] + " " + wanted[2] +
                   " all three are needed");
      }
      for (std::size_t k = 0; k < 3; ++k)
      {
        *parts += found[k] == plain.size() ? "" : (parts->empty() ? "" : ", ") + plain[found[k]];
      }
      continue;
    }
    layout.blocks.push_back({ kind, found });
    used.insert(found.begin(), found.end());
  }
  for (std::size_t k = 0; k < plain.size(); ++k)
  {
    if (!used.contains(k) && plain[k] != "-")
    {
      layout.blocks.push_back({ Kind::Number, { k, k, k }, NameOfNumber(plain[k]) });
    }
  }
  std::sort(layout.blocks.begin(), layout.blocks.end(),
    [](const Block& a, const Block& b) { return a.columns[0] < b.columns[0]; });
  return layout;
}

}

Result<XyzLayout> LayoutOfNames(const std::vector<std::string_view>& names)
{
  return LayoutOf(names, nullptr);
}

Result<XyzLayout> LayoutOfNamesInFile(
  const std::vector<std::string_view>& names, std::string& parts)
{
  return LayoutOf(names, &parts);
}

bool AreOtherNames(const std::vector<std::string_view>& words)
{
  return std::all_of(words.begin(), words.end(),
    [](std::string_view word)
    {
      const std::string_view bare = Trimmed(NameWithoutQuotes(word), "\" ");
      return (bare.empty() ||
               std::string_view("0123456789+-.").find(bare.front()) == std::string_view::npos) &&
             !IsNumberText(word);
    });
}

bool AreXyzNames(const std::vector<std::string_view>& words)
{
  if (std::any_of(words.begin(), words.end(), IsNumberText))
  {
    return false;
  }
  const std::vector<std::string> names = PlainNames(words);
  const std::set<std::string> plain(names.begin(), names.end());
  return plain.contains("x") && plain.contains("y") && plain.contains("z");
}

std::string DegreesOf(const std::vector<std::string_view>& words)
{
  const std::vector<std::string> plain = PlainNames(words);
  std::string names;
  for (std::size_t k = 0; k < words.size(); ++k)
  {
    const std::optional<std::size_t> known = FindCoordinateName(words[k]);
    if (known && coordinateNames[*known].isDegrees &&
        plain[k] == axisNames[coordinateNames[*known].axis])
    {
      names += (names.empty() ? "" : " and ") + QuotedText(words[k]);
    }
  }
  return names;
}

std::vector<std::optional<std::size_t>> AxesOfNames(const std::vector<std::string_view>& words)
{
  std::vector<std::optional<std::size_t>> axes;
  for (const std::string_view word : words)
  {
    const std::optional<std::size_t> known = FindCoordinateName(word);
    axes.push_back(known ? std::optional(coordinateNames[*known].axis) : std::nullopt);
  }
  return axes;
}

void XyzFirstColumn::Add(double value)
{
  if (this->Points++ == 0)
  {
    this->First = value;
    this->Counts = this->NeverFalls = std::isfinite(value);
  }
  else
  {
    this->Step = this->Points == 2 ? value - this->Last : this->Step;
    this->Counts = this->Counts && std::abs(this->Step) == 1 && value == this->Last + this->Step;
    this->NeverFalls = this->NeverFalls && value >= this->Last;
    this->Rising += value > this->Last ? 1 : 0;
    this->Repeats = this->Repeats || value == this->First || value == this->Last;
  }
  this->Whole = this->Whole && value == std::floor(value);
  this->Counts = this->Counts && this->Whole;
  this->Last = value;
}

XyzFirstColumn::Meaning XyzFirstColumn::Means() const
{
  constexpr double leastTime = 1e8;
  // The columns of a raster rise, too, but seldom in every line; points of one pulse have the same
  // time.
  if (this->Counts && this->Points >= 3)
  {
    return Meaning::Counter;
  }
  if (!this->NeverFalls || this->Points < 3 || 4 * this->Rising < this->Points)
  {
    return Meaning::X;
  }
  const bool numbers = this->Whole && this->Rising + 1 == this->Points;
  return this->First >= leastTime                ? Meaning::Time
         : numbers || this->Points >= manyPoints ? Meaning::Rises
                                                 : Meaning::X;
}

XyzFirstColumn::Meaning XyzFirstColumn::MeansByAll(std::vector<double> values) const
{
  if (!this->Whole || this->Repeats || values.size() < 3)
  {
    return Meaning::X;
  }
  double steps = 0;
  for (std::size_t i = 1; i < values.size(); ++i)
  {
    steps += std::abs(values[i] - values[i - 1]);
  }
  std::sort(values.begin(), values.end());
  if (std::adjacent_find(values.begin(), values.end()) != values.end())
  {
    return Meaning::X;
  }
  // Numbers in random order jump by a third of their range on average. Coordinates along a path are
  // near the previous one.
  constexpr double leastJump = 1. / 6;
  const double range = values.back() - values.front();
  const auto intervals = static_cast<double>(values.size() - 1);
  const bool dense = range == intervals, jump = steps >= leastJump * range * intervals;
  return dense && jump && values.size() >= manyPoints ? Meaning::Shuffled : Meaning::Differs;
}

void XyzRaster::Add(double first, double second)
{
  const std::array<double, 2> now{ first, second };
  for (std::size_t k = 0; k < 2; ++k)
  {
    const bool isNumber = now[k] >= 0 && now[k] == std::floor(now[k]);
    this->InOrder[0] = this->InOrder[0] && isNumber;
    this->InOrder[1] = this->InOrder[1] && isNumber;
    this->Least[k] = this->Points == 0 ? now[k] : std::min(this->Least[k], now[k]);
    this->Greatest[k] = this->Points == 0 ? now[k] : std::max(this->Greatest[k], now[k]);
  }
  for (const std::size_t slow : { 0, 1 })
  {
    const bool goesOn = now[slow] > this->Last[slow] ||
                        (now[slow] == this->Last[slow] && now[1 - slow] > this->Last[1 - slow]);
    this->InOrder[slow] = this->InOrder[slow] && (this->Points == 0 || goesOn);
  }
  this->Last = now;
  ++this->Points;
}

bool XyzRaster::Is() const
{
  return this->MayBe() && this->Points >= manyPoints && this->Least[0] <= 1 &&
         this->Least[1] <= 1 && this->Greatest[0] > this->Least[0] &&
         this->Greatest[1] > this->Least[1];
}

XyzColumns::XyzColumns(std::size_t columns, std::size_t before)
  : Count(columns)
  , Before(before)
  , Columns(columns)
  , Triples(columns)
  , Products(columns * columns)
{
}

void XyzColumns::Add(const float* values)
{
  for (std::size_t k = 0; k < this->Count; ++k)
  {
    Column& column = this->Columns[k];
    const double v = double(values[k]);
    column.least = this->Points == 0 ? v : std::min(column.least, v);
    column.greatest = this->Points == 0 ? v : std::max(column.greatest, v);
    column.whole = column.whole && v == std::floor(v);
    column.finite = column.finite && std::isfinite(v);
    column.sum += v;
    for (std::size_t other = k; other < this->Count; ++other)
    {
      this->Products[k * this->Count + other] += v * double(values[other]);
    }
    if (k + 3 <= this->Count)
    {
      Triple& triple = this->Triples[k];
      double square = 0;
      for (std::size_t i = k; i < k + 3; ++i)
      {
        square += double(values[i]) * double(values[i]);
      }
      const bool one = std::abs(square - 1) < 0.02;
      triple.someUnit = triple.someUnit || one;
      triple.unit = triple.unit && (one || square == 0 || !std::isfinite(square));
    }
  }
  ++this->Points;
}

bool XyzColumns::FitsColors(std::size_t first) const
{
  const auto* const begin = this->Columns.data() + first;
  const bool range = std::all_of(begin, begin + 3,
    [](const Column& c) { return c.finite && c.least >= 0 && c.greatest <= 255; });
  const bool whole = std::all_of(begin, begin + 3, [](const Column& c) { return c.whole; });
  // If numbers from 0 to 1 have length one, they are normals rather than colours.
  return range &&
         (whole || (this->BelowOne({ first, first + 1, first + 2 }) && !this->FitsNormals(first)));
}

bool XyzColumns::FitsNormals(std::size_t first) const
{
  return this->Triples[first].unit && this->Triples[first].someUnit;
}

bool XyzColumns::BelowOne(const std::array<std::size_t, 3>& columns) const
{
  return this->Greatest(columns) <= 1 &&
         std::any_of(columns.begin(), columns.end(),
           [this](std::size_t k) { return !this->Columns[k].whole; });
}

double XyzColumns::Greatest(const std::array<std::size_t, 3>& columns) const
{
  double greatest = 0;
  for (const std::size_t k : columns)
  {
    greatest = std::max(greatest, this->Columns[k].greatest);
  }
  return greatest;
}

// The candidates that explain the most columns.
std::vector<XyzColumns::Candidate> XyzColumns::Candidates() const
{
  std::vector<std::optional<std::size_t>> colors, normals;
  for (std::size_t first = 0; first + 3 <= this->Count; ++first)
  {
    if (this->FitsNormals(first))
    {
      normals.emplace_back(first);
    }
    if (this->FitsColors(first))
    {
      colors.emplace_back(first);
    }
  }
  colors.emplace_back();
  normals.emplace_back();
  std::vector<Candidate> candidates;
  std::size_t most = 0;
  for (const std::optional<std::size_t>& n : normals)
  {
    for (const std::optional<std::size_t>& c : colors)
    {
      const bool apart = !n || !c || *n + 3 <= *c || *c + 3 <= *n;
      const std::size_t known = (n ? 3U : 0U) + (c ? 3U : 0U);
      // The remaining columns must be one number, or three numbers side by side.
      const std::size_t before = std::min(n.value_or(this->Count), c.value_or(this->Count));
      const bool pieces = known == 0 || this->Count - known != 3 || before % 3 == 0;
      if (!apart || !pieces || known < most)
      {
        continue;
      }
      if (known > most)
      {
        candidates.clear();
        most = known;
      }
      candidates.push_back({ c, n });
    }
  }
  return candidates;
}

// The only column that is neither a colour nor a normal; nothing if there are several.
std::optional<std::size_t> XyzColumns::RestOf(const Candidate& candidate) const
{
  std::optional<std::size_t> rest;
  for (std::size_t k = 0; k < this->Count; ++k)
  {
    const auto in = [k](const std::optional<std::size_t>& first)
    { return first && k >= *first && k < *first + 3; };
    if (!in(candidate.colors) && !in(candidate.normals))
    {
      if (rest)
      {
        return std::nullopt;
      }
      rest = k;
    }
  }
  return rest;
}

bool XyzColumns::Varies(std::size_t column) const
{
  return this->Columns[column].least != this->Columns[column].greatest;
}

// Between -1 and 1; 0 if one of the columns does not vary.
double XyzColumns::Correlation(std::size_t a, std::size_t b) const
{
  const auto n = double(this->Points);
  const auto product = [&](std::size_t i, std::size_t j)
  {
    return this->Products[std::min(i, j) * this->Count + std::max(i, j)] / n -
           this->Columns[i].sum / n * (this->Columns[j].sum / n);
  };
  const double correlation = product(a, b) / std::sqrt(product(a, a) * product(b, b));
  return std::isfinite(correlation) ? std::clamp(correlation, -1.0, 1.0) : 0;
}

// How strongly a column correlates with the two next to it.
double XyzColumns::Belongs(std::size_t column) const
{
  const std::size_t a = column == 0 ? 1 : column - 1, b = column == 0 ? 2 : column - 2;
  return (std::abs(this->Correlation(column, a)) + std::abs(this->Correlation(column, b))) / 2;
}

// Whether all values are below 32.
bool XyzColumns::LooksLikeClass(std::size_t column) const
{
  constexpr double mostClass = 31;
  return this->Columns[column].greatest <= mostClass;
}

// Looks for an opacity: among candidates with these remaining columns, the one whose remaining
// column is the last, if this is 255 for all points, or 1 beside colours from 0 to 1.
std::optional<std::size_t> XyzColumns::LookForOpacity(const std::vector<std::size_t>& rests) const
{
  const auto found = std::find(rests.begin(), rests.end(), this->Count - 1);
  if (found == rests.end() || this->Count < 4 || this->Varies(this->Count - 1))
  {
    return std::nullopt;
  }
  const double value = this->Columns.back().greatest;
  const bool opaque =
    value == 255 ||
    (value == 1 && this->BelowOne({ this->Count - 4, this->Count - 3, this->Count - 2 }));
  return opaque ? std::optional(static_cast<std::size_t>(found - rests.begin())) : std::nullopt;
}

std::size_t XyzColumns::Choose(const std::vector<Candidate>& candidates) const
{
  std::vector<std::size_t> rests;
  for (const Candidate& candidate : candidates)
  {
    const std::optional<std::size_t> rest = this->RestOf(candidate);
    if (!rest)
    {
      return 0;
    }
    rests.push_back(*rest);
  }
  const auto only = [&](const auto& is) -> std::optional<std::size_t>
  {
    const auto found = std::find_if(rests.begin(), rests.end(), is);
    const bool alone = found != rests.end() && std::count_if(rests.begin(), rests.end(), is) == 1;
    return alone ? std::optional(static_cast<std::size_t>(found - rests.begin())) : std::nullopt;
  };
  if (const std::optional<std::size_t> opacity = this->LookForOpacity(rests))
  {
    return *opacity;
  }
  std::size_t varying = 0;
  for (std::size_t k = 0; k < this->Count; ++k)
  {
    varying += this->Varies(k) ? 1 : 0;
  }
  if (varying == 1)
  {
    if (const auto alone = only([this](std::size_t k) { return this->Varies(k); }))
    {
      return *alone;
    }
  }
  // A constant column. If it is not the first one, it must be above 0, else it could be a colour
  // channel that is 0 for all points.
  if (varying + 1 == this->Count)
  {
    if (const auto alone = only([this](std::size_t k)
          { return !this->Varies(k) && (k == 0 || this->Columns[k].greatest > 0); }))
    {
      return *alone;
    }
  }
  if (const auto alone = only([this](std::size_t k) { return this->LooksLikeClass(k); }))
  {
    return *alone;
  }
  // The column that is clearly the odd one out; else "intensity r g b", which has always been read
  // in this way.
  constexpr double clearly = 0.2;
  std::vector<std::size_t> order(candidates.size());
  for (std::size_t i = 0; i < order.size(); ++i)
  {
    order[i] = i;
  }
  std::sort(order.begin(), order.end(),
    [&](std::size_t a, std::size_t b)
    { return this->Belongs(rests[a]) < this->Belongs(rests[b]); });
  if (order.size() > 1 && this->Belongs(rests[order[0]]) + clearly < this->Belongs(rests[order[1]]))
  {
    return order[0];
  }
  return static_cast<std::size_t>(std::min_element(rests.begin(), rests.end()) - rests.begin());
}

XyzLayout XyzColumns::LayoutOf(const Candidate& candidate) const
{
  XyzLayout layout;
  for (std::size_t k = 0; k < 3; ++k)
  {
    layout.coordinates[k] = this->Before - 3 + k;
  }
  for (std::size_t k = 0; k + 3 < this->Before; ++k)
  {
    layout.blocks.push_back({ Kind::Number, { k, k, k },
      this->Before == 4 ? "number"
      : k == 0          ? "row"
                        : "column" });
  }
  const std::optional<std::size_t> rest = this->RestOf(candidate);
  for (std::size_t k = 0; k < this->Count;)
  {
    const std::size_t column = this->Before + k;
    if (candidate.colors == k || candidate.normals == k)
    {
      layout.blocks.push_back({ candidate.colors == k ? Kind::Colors : Kind::Normals,
        { column, column + 1, column + 2 } });
      k += 3;
      continue;
    }
    layout.blocks.push_back({ Kind::Number, { column, column, column },
      rest == k && k == 0 ? "Intensity" : ColumnName(column) });
    ++k;
  }
  return layout;
}

bool XyzColumns::IsCountUsual() const
{
  constexpr std::array<std::size_t, 6> usual{ 0, 1, 3, 4, 6, 7 };
  return std::find(usual.begin(), usual.end(), this->Count) != usual.end();
}

XyzLayout XyzColumns::Guess(std::vector<std::string>& readings) const
{
  const std::vector<Candidate> candidates = this->Candidates();
  const std::size_t chosen = this->Choose(candidates);
  const XyzLayout layout = this->LayoutOf(candidates[chosen]);
  if (candidates.size() > 1)
  {
    constexpr std::size_t mostReported = 8;
    std::string others;
    for (std::size_t i = 0; i < std::min(candidates.size(), mostReported); ++i)
    {
      const std::string names = NamesOfLayout(this->LayoutOf(candidates[i]));
      others += i == chosen ? "" : (others.empty() ? "\"" : ", \"") + names + "\"";
    }
    readings.push_back("the columns are read as \"" + NamesOfLayout(layout) + "\"; they could be " +
                       others + " too (--columns decides)");
  }
  for (const Block& block : layout.blocks)
  {
    if (block.kind == Kind::Colors &&
        this->BelowOne({ block.columns[0] - this->Before, block.columns[1] - this->Before,
          block.columns[2] - this->Before }))
    {
      readings.push_back("columns " + std::to_string(block.columns[0] + 1) + " to " +
                         std::to_string(block.columns[2] + 1) +
                         " are taken as colours from 0 to 1 (--columns decides)");
    }
    else if (block.kind == Kind::Colors && candidates.size() == 1 && this->Points >= manyPoints &&
             std::any_of(block.columns.begin(), block.columns.end(),
               [this](std::size_t column)
               {
                 const std::size_t k = column - this->Before;
                 return this->LooksLikeClass(k) && this->Columns[k].greatest > 0;
               }))
    {
      readings.push_back("columns " + std::to_string(block.columns[0] + 1) + " to " +
                         std::to_string(block.columns[2] + 1) +
                         " are taken as colours, though one has no value above 31 (--columns "
                         "decides)");
    }
  }
  std::string numbers;
  for (const Block& block : layout.blocks)
  {
    numbers += block.kind == Kind::Number && block.name != "Intensity" && block.columns[0] > 0
                 ? (numbers.empty() ? "" : ", ") + block.name
                 : "";
  }
  if (!numbers.empty() && candidates.size() == 1)
  {
    readings.push_back("not all columns are colours or normals: kept as numbers are " + numbers +
                       " (--columns names them)");
  }
  return layout;
}

std::string NamesOfLayout(const XyzLayout& layout)
{
  std::string names;
  bool placed = false;
  for (const Block& block : layout.blocks)
  {
    if (!placed && block.columns[0] > layout.coordinates[0])
    {
      names += names.empty() ? "x y z" : " x y z";
      placed = true;
    }
    names += block.kind == Kind::Colors    ? " r g b"
             : block.kind == Kind::Normals ? " nx ny nz"
             : block.name == "Intensity"   ? " intensity"
                                           : (names.empty() ? "" : " ") + block.name;
  }
  names += placed ? "" : names.empty() ? "x y z" : " x y z";
  return names.substr(std::min(names.find_first_not_of(' '), names.size()));
}

}
