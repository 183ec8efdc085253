// SPDX-License-Identifier: BSD-3-Clause
// Finds out what the columns of an .xyz file mean, by their names or by their values. Part of step
// "convert".
#pragma once

#include "filters/core/Result.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

inline constexpr std::size_t mostXyzColumns = 64;
inline constexpr std::array<std::string_view, 3> axisNames{ "x", "y", "z" };

// Which columns are the coordinates, and what the other columns form. Columns are counted from 0.
struct XyzLayout
{
  enum class Kind
  {
    Colors,  // three columns
    Normals, // three columns
    Number
  };
  struct Block
  {
    Kind kind = Kind::Number;
    std::array<std::size_t, 3> columns{}; // for a number, only the first counts
    std::string name{};                   // of a number
  };

  std::array<std::size_t, 3> coordinates{ 0, 1, 2 };
  std::vector<Block> blocks;
};

// The layout for these names: x y z; r g b (red green blue, rf gf bf); nx ny nz; i, intensity;
// class, classification; - for a column to leave out. Any other name makes a numeric array. For the
// known names, case and quotes do not matter. Errors: InvalidArgument if x, y or z is missing, a
// name occurs twice, or only a part of r g b or of nx ny nz is there.
Result<XyzLayout> LayoutOfNames(const std::vector<std::string_view>& names);
// The same for names that a file has, which are never an error. An incomplete r g b or nx ny nz is
// read as plain numbers. If names are equal, the first counts, and the other columns are named by
// their column numbers. parts: gets the names of incomplete groups.
Result<XyzLayout> LayoutOfNamesInFile(
  const std::vector<std::string_view>& names, std::string& parts);

// Whether the words are a line of column names before the points: x, y and z are among them, and
// none is a number.
bool AreXyzNames(const std::vector<std::string_view>& words);
// The words that are taken as x and y but mean longitudes and latitudes in degrees, quoted for
// messages; empty if there are none.
std::string DegreesOf(const std::vector<std::string_view>& words);
// Which coordinate each of the words names, 0 to 2; nothing for all other words.
std::vector<std::optional<std::size_t>> AxesOfNames(const std::vector<std::string_view>& words);
// Whether none of the words begins as a number does.
bool AreOtherNames(const std::vector<std::string_view>& words);

// Collects the values of the columns after x y z, and then guesses what the columns mean. O(k^2)
// for a point of k columns.
class XyzColumns
{
public:
  // columns: how many there are after the coordinates. before: how many columns come before these.
  explicit XyzColumns(std::size_t columns, std::size_t before = 3);

  void Add(const float* values);

  // Guesses what the columns after x y z are.
  // - Three columns are normals if all vectors have length one, or are zero or not finite (no
  //   normal).
  // - Three columns are colours if all are whole numbers from 0 to 255, or numbers from 0 to 1 that
  //   are neither all whole nor normals.
  // - At most one normal and one colour are searched for. A column that fits nothing else is a
  //   number.
  //
  // If several layouts fit, the first of these rules decides which column is the number: the last
  // column, if it is an opacity of 255 for all points; the only column that varies, or the only one
  // that does not; the only one that looks like a class (below 32); the one that is least like its
  // neighbours; the order "intensity r g b"; the layout with normals and colours first. readings:
  // gets a sentence for each ambiguous case.
  XyzLayout Guess(std::vector<std::string>& readings) const;
  // Whether the number of columns is that of colours, normals and one number, or of some of these.
  bool IsCountUsual() const;

private:
  struct Column
  {
    double least = 0, greatest = 0, sum = 0;
    bool whole = true, finite = true;
  };
  struct Triple
  {
    bool unit = true;      // every vector has length one, or is zero or not finite
    bool someUnit = false; // at least one vector has length one
  };
  // The first column of the colours and of the normals, if there are any.
  struct Candidate
  {
    std::optional<std::size_t> colors, normals;
  };

  // Whether the colours in these three columns are from 0 to 1, and not all whole.
  bool BelowOne(const std::array<std::size_t, 3>& columns) const;
  double Greatest(const std::array<std::size_t, 3>& columns) const;
  bool LooksLikeClass(std::size_t column) const;
  std::optional<std::size_t> LookForOpacity(const std::vector<std::size_t>& rests) const;
  bool FitsColors(std::size_t first) const;
  bool FitsNormals(std::size_t first) const;
  std::vector<Candidate> Candidates() const;
  std::optional<std::size_t> RestOf(const Candidate& candidate) const;
  bool Varies(std::size_t column) const;
  double Correlation(std::size_t a, std::size_t b) const;
  double Belongs(std::size_t column) const;
  std::size_t Choose(const std::vector<Candidate>& candidates) const;
  XyzLayout LayoutOf(const Candidate& candidate) const;

  std::size_t Count, Before;
  std::uint64_t Points = 0;
  std::vector<Column> Columns;
  std::vector<Triple> Triples;  // by first column
  std::vector<double> Products; // sums over points, [a * Count + b] for a <= b
};

// Decides whether the first column, before x y z, is not a coordinate but a number or a time of
// each point. A rising column is taken for a number only if a coordinate would hardly rise in this
// way. O(1) a point.
class XyzFirstColumn
{
public:
  enum class Meaning
  {
    X,
    Rises,    // never falls: taken for x, but it could be a number or a time
    Differs,  // different whole numbers: taken for x, but could be numbers
    Counter,  // whole numbers that rise (or fall) by one each line
    Shuffled, // the same numbers in another order, which jumps
    Time      // never falls, at least 10^8, as seconds since 1970 or of GPS
  };

  void Add(double value);
  bool MayBeOther() const
  {
    return this->Counts || this->NeverFalls || (this->Whole && !this->Repeats);
  }
  // What the column means. Counter needs three points. Rises needs twenty, or three if they are
  // whole numbers that all rise. Returns X if only a look at all values can decide.
  Meaning Means() const;
  // For a column for which Means returns X: decides by all its values, which it sorts. Shuffled
  // needs at least twenty points, Differs three. O(n log n).
  Meaning MeansByAll(std::vector<double> values) const;

private:
  std::uint64_t Points = 0, Rising = 0;
  double First = 0, Last = 0, Step = 0;
  bool Counts = true, Whole = true, NeverFalls = true;
  bool Repeats = false; // of the first value, or of the one before
};

// Decides whether the first two columns, before x y z, are the row and the column of each point in
// a scan. These are whole numbers from 0 or 1 on; the second rises while the first stays, or the
// reverse. O(1) a point.
class XyzRaster
{
public:
  void Add(double first, double second);
  bool MayBe() const { return this->InOrder[0] || this->InOrder[1]; }
  // Whether both columns vary, in at least twenty points.
  bool Is() const;

private:
  std::uint64_t Points = 0;
  std::array<bool, 2> InOrder{ true, true }; // the first column is the slower; or the second
  std::array<double, 2> Least{}, Greatest{}, Last{};
};

// The argument of --columns for this layout: "x y z r g b class".
std::string NamesOfLayout(const XyzLayout& layout);

}
