// SPDX-License-Identifier: BSD-3-Clause
// Decides what the numbers after the coordinates of an OBJ file's vertices mean: see
// ObjPlaceNumbers.h.
#include "filters/meshio/ObjPlaceNumbers.h"

#include "filters/meshio/NumberText.h"
#include "filters/meshio/TextWords.h"

#include <cmath>

namespace kdstream
{

void ObjPlaceNumbers::Add(std::string_view text)
{
  std::array<float, 5> values{};
  std::size_t count = 0;
  for (std::string_view word = TakeWord(text); !word.empty() && count < values.size();
       word = TakeWord(text))
  {
    static_cast<void>(ParseNumber(word, values[count++]));
  }
  this->Weights += count == 1 && values[0] != 1 ? 1 : 0;
  this->Two += count == 2 ? 1 : 0;
  if (count < 3)
  {
    return;
  }
  ++this->Six;
  if (count > 3)
  {
    ++this->Seven;
    this->WeightOne = this->WeightOne && values[0] == 1;
    this->LastOpaque = this->LastOpaque && (values[3] == 1 || values[3] == 255);
  }
  for (std::size_t first = 0; first < (count > 3 ? 2U : 1U); ++first)
  {
    Triple& triple = this->Triples[first];
    double square = 0;
    for (std::size_t k = first; k < first + 3; ++k)
    {
      triple.white.Add(double(values[k]));
      triple.negative = triple.negative || values[k] < 0;
      square += double(values[k]) * double(values[k]);
    }
    constexpr double rounding = 0.02;
    triple.unit += std::abs(square - 1) < rounding ? 1 : 0;
  }
}

ObjPlaceColumns ObjPlaceNumbers::Decide(
  std::uint64_t vertices, bool normalsNamed, Tolerance& tolerance) const
{
  ObjPlaceColumns columns;
  if (this->Six == 0)
  {
    columns.ignored = this->Two > 0       ? "two numbers after the coordinates of vertices"
                      : this->Weights > 0 ? "a fourth number of vertices that is not 1 (a weight): "
                                            "coordinates are not divided by it"
                                          : "";
    return columns;
  }
  if (this->Six < vertices)
  {
    columns.ignored = "colours, which not all vertices have";
    return columns;
  }
  const bool weight = this->Seven == vertices && this->WeightOne && !this->LastOpaque;
  const Triple& triple = this->Triples[weight ? 1 : 0];
  columns.at = weight ? 4 : 3;
  if (weight)
  {
    tolerance.Tell(
      "vertices of seven numbers are read as x y z w r g b, as the fourth is always 1");
  }
  if (triple.negative && triple.unit > vertices / 2)
  {
    tolerance.Tell(
      "the numbers after x y z are read as normals, not as colours: most have length 1, and some "
      "are negative");
    columns.what = normalsNamed ? ObjPlaceColumns::What::Nothing : ObjPlaceColumns::What::Normals;
    columns.ignored = normalsNamed
                        ? "normals after the coordinates, because faces name other normals"
                        : std::string();
    return columns;
  }
  columns.what = ObjPlaceColumns::What::Colors;
  columns.ignored = this->Seven > 0 && !weight && !this->LastOpaque
                      ? "the numbers after the colours of vertices (transparency, mostly)"
                      : "";
  const double white = triple.white.White();
  constexpr double most = 255;
  columns.scale = most / white;
  const std::string doubt = triple.white.Doubt();
  if (!doubt.empty() || white > most)
  {
    tolerance.Tell("colours of vertices are read as from 0 to " +
                   std::to_string(static_cast<int>(white)) + (doubt.empty() ? "" : ", " + doubt));
  }
  return columns;
}

}
