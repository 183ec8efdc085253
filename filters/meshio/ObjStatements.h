// SPDX-License-Identifier: BSD-3-Clause
// Splits a Wavefront OBJ file into statements: its lines without comments, and their words and
// numbers. Part of step "read". Material libraries, .mtl, have the same statements.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/meshio/TextLines.h"
#include "filters/meshio/TextWords.h"

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

enum class ObjKeyword
{
  Place,             // v
  TextureCoordinate, // vt
  Normal,            // vn
  Face,              // f, fo
  Material,          // usemtl, mtllib
  Curve,             // curv, curv2, surf, l, bsp …: curves and surfaces
  Picture,           // usemap: a texture, without a material, of the faces that follow
  Call,              // call, csh: includes another file, or runs a program
  VertexColors,      // #MRGB: vertex colours that ZBrush writes in comments
  Other,             // a statement that does not matter for a mesh
  Unknown
};

class ObjStatements
{
public:
  // In bytes, with continuation lines. A polygon of 200,000 corners takes about 4 MiB.
  static constexpr std::size_t longestStatement = std::size_t{ 1 } << 24;

  explicit ObjStatements(ByteSource source)
    : Lines(std::move(source), longestStatement)
  {
  }

  // Goes to the next statement; false at the end. A line that ends with a backslash continues on
  // the next line. Comments do not, nor do names whose last character is the backslash. A comment
  // begins a line, or follows numbers; in a name, # is an ordinary character. Errors: InputOutput;
  // a statement longer than longestStatement; text in UTF-16.
  Result<bool> Next();
  ObjKeyword Keyword() const { return this->Word; }
  // The keyword in lower case, because case does not matter, and the keyword as the file has it.
  // Valid until the next call of Next.
  std::string_view Name() const { return this->Folded; }
  std::string_view Written() const { return this->AsWritten; }
  // The text after the keyword. Valid until the next call of Next.
  std::string_view Rest() const { return this->Text; }
  const TextLines& GetLines() const { return this->Lines; }
  void Restart() { this->Lines.Restart(); }

  // Calls visit() at each statement of the whole text. For progress, this pass is the part of step
  // "read" that begins at the fraction `before` and has the length `share`. Errors: those of Next,
  // of `visit` and of `execution`.
  template <class Visit>
  Status ForEach(const Execution& execution, double before, double share, const Visit& visit)
  {
    constexpr std::uint64_t statementsPerReport = 1 << 17;
    this->Restart();
    for (std::uint64_t number = 0;; ++number)
    {
      const Result<bool> more = this->Next();
      KDSTREAM_TRY(more);
      if (!*more)
      {
        return {};
      }
      KDSTREAM_TRY(visit());
      if (number % statementsPerReport == 0)
      {
        KDSTREAM_TRY(execution.Report("read", before + share * this->Lines.Fraction()));
      }
    }
  }

private:
  Status Join();
  void Understand();

  TextLines Lines;
  std::string_view Text, AsWritten, Folded;
  std::string Joined, Lower;
  ObjKeyword Word = ObjKeyword::Other;
};

// Collects the statements that are not read: curves and surfaces, other files, unknown statements.
class ObjPassedOver
{
public:
  // Adds the current statement of `statements`.
  void Add(const ObjStatements& statements);
  // Adds the names of what was skipped, each with its count.
  void Name(std::vector<std::string>& notCarried) const;

private:
  std::uint64_t Curves = 0, Unknown = 0;
  bool HasVertexColors = false;
  std::string FirstUnknown, FirstPicture, FirstCall;
};

// A vertex as its line has it.
struct ObjPlace
{
  Vec3 point{};
  std::array<float, 3> color{};
  bool colored = false;
};

// Reads "x y z [w]" or "x y z r g b [a]". asFloats: round coordinates once, to floats. They may be
// NaN or infinite. colorsAt: the index of red, from 0; 4 means "x y z w r g b". Errors say what is
// wrong, without the place.
Status ParseObjPlace(
  std::string_view text, bool asFloats, ObjPlace& place, std::size_t colorsAt = 3);

// Reads "u [v …]". A number that is too large becomes NaN, which is not a position in a texture.
Status ParseObjTextureCoordinate(std::string_view text, std::array<float, 2>& values);
// Reads "x y z"; one more number is allowed, but is not read.
Status ParseObjNormal(std::string_view text, std::array<float, 3>& values);

// The numbers of a corner's place, texture coordinate and normal, as the file has them: counted
// from 1, or, if negative, back from the last element before the face. noCorner: not given.
using ObjCorner = std::array<std::int64_t, 3>;
inline constexpr std::int64_t noCorner = std::numeric_limits<std::int64_t>::max();
inline constexpr std::array<const char*, 3> objPartNames{ "vertex", "texture coordinate",
  "normal" };

// Errors: as ParseObjPlace.
Status ParseObjCorner(std::string_view word, ObjCorner& corner);

// The element that a corner's number refers to. `before` elements of its kind come before the face,
// and the file has `all`. number: counted from 1; 0 if there is none. exists: true also if the
// corner names no element.
struct ObjPart
{
  std::uint32_t number = 0;
  bool exists = true;
};
ObjPart ResolveObjPart(std::int64_t number, std::uint64_t before, std::uint64_t all);

}
