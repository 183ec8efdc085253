// SPDX-License-Identifier: BSD-3-Clause
// Random triangle soups in random STL notation, with the mesh that a reader must make of them.
#pragma once

#include "filters/meshio/Testing/RandomGenerator.h"

#include <array>
#include <cstring>

namespace kdstream::test
{

// The binary file of these triangles; header: up to 80 bytes.
inline std::string BinaryStl(std::string header, const std::vector<Vec3>& points)
{
  const auto append = [](std::string& bytes, std::uint32_t value)
  {
    for (int shift = 0; shift < 32; shift += 8)
    {
      bytes += static_cast<char>(value >> shift);
    }
  };
  header.resize(80);
  append(header, static_cast<std::uint32_t>(points.size() / 3));
  for (std::size_t i = 0; i < points.size(); ++i)
  {
    header += i % 3 == 0 ? std::string("\x00\x00\xc0\x7fnormal..", 12) : "";
    for (const double value : points[i])
    {
      append(header, std::bit_cast<std::uint32_t>(static_cast<float>(value)));
    }
    header += i % 3 == 2 ? "at" : "";
  }
  return header;
}

class RandomStlMaker
{
public:
  explicit RandomStlMaker(unsigned seed)
    : Chooser(seed)
  {
  }

  RandomFile Make(std::uint64_t mostFacets)
  {
    RandomFile stl;
    const bool binary = this->Chooser.Chance(0.4);
    const std::uint64_t facets = this->Chooser.Pick(mostFacets + 1);
    const bool doubles = !binary && facets > 0 && this->Chooser.Chance(0.5);
    stl.scalarType = doubles ? ScalarType::Float64 : ScalarType::Float32;
    for (std::uint64_t i = 0; i < 3 * facets; ++i)
    {
      Vec3 point{};
      for (double& value : point)
      {
        value = doubles ? this->Chooser.AnyReal<double>() : double(this->Chooser.AnyReal<float>());
      }
      stl.points.push_back(point);
    }
    if (doubles)
    {
      stl.points[this->Chooser.Pick(stl.points.size())][this->Chooser.Pick(3)] = 0.1234567890123;
    }
    stl.bytes =
      binary ? BinaryStl(this->Chooser.PickOf({ "", "solid", "solid thing\nfacet " }), stl.points)
             : this->Text(stl.points, doubles);
    for (Vec3& point : stl.points)
    {
      point = { point[0] + 0.0, point[1] + 0.0, point[2] + 0.0 }; // turns -0.0 into 0.0
    }
    for (VertexId first = 0; first < stl.points.size(); first += 3)
    {
      stl.triangles.push_back({ first, first + 1, first + 2 });
    }
    if (binary && facets > 0)
    {
      stl.ignored = { "attribute bytes of triangles (colours, mostly)" };
    }
    stl.faces = facets;
    stl.soup = true;
    return stl;
  }

  RandomGenerator& Generator() { return this->Chooser; }

private:
  std::string Word(const char* small)
  {
    std::string word = small;
    for (char& c : word)
    {
      c = this->Capitals ? static_cast<char>(c - 'a' + 'A') : c;
    }
    return word;
  }

  std::string Text(const std::vector<Vec3>& points, bool doubles)
  {
    RandomGenerator& generator = this->Chooser;
    this->Capitals = generator.Chance(0.3);
    const std::string newline = generator.PickOf({ "\n", "\r\n", "\r", "\n\n  " });
    const std::string blank = generator.PickOf({ " ", "\t", "   " });
    // Only the names of solids need a line break after them.
    const std::string between = generator.Chance(0.3) ? blank : newline;
    const std::string name = generator.PickOf({ "", " a b", " facet normal", " solid endsolid" });
    const std::string begin = this->Word("solid") + name + newline;
    const std::string end = this->Word("endsolid") + name + newline;
    std::string text = (generator.Chance(0.2) ? newline : "") + begin;
    for (std::size_t i = 0; i < points.size(); ++i)
    {
      if (i % 3 == 0)
      {
        text += i > 0 && generator.Chance(0.1) ? end + begin : "";
        text += this->Word("facet") + blank + this->Word("normal") + blank +
                generator.PickOf({ "0 0 1", "-nan(ind) 1e999 x" }) + between + this->Word("outer") +
                blank + this->Word("loop") + between;
      }
      text += this->Word("vertex");
      for (const double value : points[i])
      {
        text += blank + (generator.Chance(0.1) && !std::signbit(value) ? "+" : "") +
                (doubles ? ShortText(value) : ShortText(static_cast<float>(value)));
      }
      text += between;
      text += i % 3 == 2 ? this->Word("endloop") + between + this->Word("endfacet") + between : "";
    }
    return text + end;
  }

  RandomGenerator Chooser;
  bool Capitals = false;
};

}
