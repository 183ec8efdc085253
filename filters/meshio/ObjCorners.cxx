// SPDX-License-Identifier: BSD-3-Clause
// The corners of an OBJ file's faces: see ObjCorners.h.
#include "filters/meshio/ObjCorners.h"

#include "filters/meshio/TextWords.h"

namespace kdstream
{
namespace
{

// "there are only 3", for elements that are counted from 1.
std::string ThereAre(std::uint64_t count)
{
  return count == 0   ? "there are none"
         : count == 1 ? "there is only 1"
                      : "there are only " + std::to_string(count);
}

std::string ComeBefore(std::uint64_t count)
{
  return count == 0   ? "none come before it"
         : count == 1 ? "only 1 comes before it"
                      : "only " + std::to_string(count) + " come before it";
}

}

std::string PlaceInObj(const char* element, std::uint64_t index, const ObjStatements& statements)
{
  return std::string(element) + " " + std::to_string(index) + " (line " +
         std::to_string(statements.GetLines().Number()) + ")";
}

Error AtPlaceInObj(const std::string& place, const Error& error)
{
  return error.code == ErrorCode::InvalidInput
           ? BadInput(place + ": " + error.message, error.remedy)
           : error;
}

void ForgiveObjFace(
  Lapse kind, std::uint64_t face, const ObjStatements& statements, Tolerance& tolerance)
{
  tolerance.Count(
    kind, 1, tolerance.Of(kind) == 0 ? PlaceInObj("face", face, statements) : std::string());
}

Status ObjCorners::Read(const ObjStatements& statements, const ObjCounts& before,
  const ObjCounts& all, std::uint64_t face, Tolerance& tolerance)
{
  this->Corners.clear();
  std::array<bool, 3> missing{}; // whether a corner names one that does not exist
  std::string_view text = statements.Rest();
  for (std::string_view word = TakeWord(text); !word.empty(); word = TakeWord(text))
  {
    ObjCorner written{};
    if (const Status parsed = ParseObjCorner(word, written); !parsed)
    {
      return AtPlaceInObj(PlaceInObj("face", face, statements), parsed.GetError());
    }
    Corner& corner = this->Corners.emplace_back();
    for (std::size_t part = 0; part < 3; ++part)
    {
      const ObjPart found = ResolveObjPart(written[part], before[part], all[part]);
      corner[part] = found.number;
      missing[part] |= !found.exists;
    }
    if (missing[0])
    {
      return Error{ ErrorCode::InvalidInput,
        PlaceInObj("face", face, statements) + " names vertex " + std::to_string(written[0]) +
          ", but " + (written[0] > 0 ? ThereAre(all[0]) : ComeBefore(before[0])) };
    }
  }
  if (missing[1] || missing[2])
  {
    ForgiveObjFace(Lapse::AttributeMissing, face, statements, tolerance);
    for (Corner& corner : this->Corners)
    {
      for (std::size_t part = 1; part < 3; ++part)
      {
        corner[part] = missing[part] ? 0 : corner[part];
      }
    }
  }
  return {};
}

}
