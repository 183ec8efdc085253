// SPDX-License-Identifier: BSD-3-Clause
// Random meshes in random OBJ notation, with the mesh that a reader must make of them.
#pragma once

#include "filters/meshio/PolygonFaces.h"
#include "filters/meshio/Testing/RandomGenerator.h"

#include <algorithm>
#include <map>
#include <stdexcept>

namespace kdstream::test
{

class RandomObjMaker
{
public:
  explicit RandomObjMaker(unsigned seed)
    : Chooser(seed)
  {
  }

  // Makes a file of 3 to `mostPlaces` + 2 places and at most twice as many faces.
  RandomFile Make(std::uint64_t mostPlaces)
  {
    RandomGenerator& generator = this->Chooser;
    this->Obj = {};
    this->Text.clear();
    this->Newline = generator.PickOf({ "\n", "\r\n" });
    this->Blank = generator.PickOf({ " ", "\t", "  " });
    this->Doubles = generator.Chance(0.5);
    this->Obj.scalarType = this->Doubles ? ScalarType::Float64 : ScalarType::Float32;
    this->Colors = generator.Pick(4); // 0: none; up to 1; up to 255; not all places
    this->Counts = { 3 + generator.Pick(mostPlaces), 0, 0 };
    this->Named[1] = generator.Chance(0.3);
    this->Named[2] = generator.Chance(0.3);
    for (const std::size_t part : { 1U, 2U })
    {
      // Elements may be in the file without being named.
      this->Counts[part] =
        this->Named[part] || generator.Chance(0.1) ? 1 + generator.Pick(mostPlaces) : 0;
    }
    this->MakeValues();
    this->EmitAll();
    this->Describe();
    return this->Obj;
  }

  RandomGenerator& Generator() { return this->Chooser; }

private:
  using Corner = std::array<std::uint64_t, 3>; // counted from 1; 0 if there is none

  template <class Real>
  std::string Number(Real value)
  {
    return (this->Chooser.Chance(0.05) && !std::signbit(value) ? "+" : "") + ShortText(value);
  }

  void MakeValues()
  {
    RandomGenerator& generator = this->Chooser;
    this->Values = {};
    for (std::size_t part = 0; part < 3; ++part)
    {
      for (std::uint64_t i = 0; i < this->Counts[part]; ++i)
      {
        Vec3 value{};
        for (double& each : value)
        {
          each = part == 0 && this->Doubles ? generator.AnyReal<double>()
                                            : double(generator.AnyReal<float>());
        }
        this->Values[part].push_back(value);
      }
    }
    if (this->Doubles)
    {
      this->Values[0][generator.Pick(this->Counts[0])][generator.Pick(3)] = 0.1234567890123;
    }
    this->Bytes.clear();
    for (std::uint64_t i = 0; i < 3 * this->Counts[0]; ++i)
    {
      this->Bytes.push_back(static_cast<std::uint8_t>(generator.Pick(256)));
    }
    this->Bytes[generator.Pick(this->Bytes.size())] = 7; // above 1
  }

  void EmitAll()
  {
    RandomGenerator& generator = this->Chooser;
    std::array<std::uint64_t, 3> emitted{};
    std::uint64_t left = generator.Pick(2 * this->Counts[0] + 1);
    this->Obj.faces = left;
    while (left > 0 || emitted != this->Counts)
    {
      const std::size_t part = generator.Pick(3);
      this->EmitNoise();
      if (generator.Chance(0.7))
      {
        if (emitted[part] < this->Counts[part])
        {
          this->EmitValue(part, emitted[part]++);
        }
      }
      else if (left > 0)
      {
        this->EmitFace(emitted);
        --left;
      }
    }
    this->Text += generator.Chance(0.5) ? "end" : "";
  }

  void EmitNoise()
  {
    RandomGenerator& generator = this->Chooser;
    if (generator.Chance(0.8))
    {
      return;
    }
    const std::string line = generator.PickOf({ "", "# f 1 2 3 and \\", "g a b", "o thing", "s off",
      "usemtl red", "mtllib a.mtl", "l 1 2", "vp 0.5", "p 1", "MG 0", "  \t ", "#" });
    this->Materials |= line.find("mtl") != std::string::npos;
    this->Curves += line == "l 1 2" ? 1 : 0;
    this->Text += line + this->Newline;
  }

  // The gap between two words: a blank, or a backslash and a line break.
  std::string Gap()
  {
    return this->Chooser.Chance(0.03) ? this->Blank + "\\" + this->Newline : this->Blank;
  }

  void EmitValue(std::size_t part, std::uint64_t index)
  {
    RandomGenerator& generator = this->Chooser;
    this->Text += (generator.Chance(0.1) ? this->Blank : "") +
                  std::array<const char*, 3>{ "v", "vt", "vn" }[part];
    const std::size_t numbers = part == 1 ? 2 : 3;
    for (std::size_t k = 0; k < numbers; ++k)
    {
      const double value = this->Values[part][index][k];
      this->Text +=
        this->Gap() + (part == 0 && this->Doubles ? this->Number(value)
                                                  : this->Number(static_cast<float>(value)));
    }
    if (part == 0)
    {
      this->EmitColor(index);
    }
    this->Text += part == 1 && generator.Chance(0.3) ? this->Gap() + "0.25" : "";
    this->Text += (generator.Chance(0.1) ? " # 1 2 3" : "") + this->Newline;
  }

  void EmitColor(std::uint64_t index)
  {
    const bool bare = this->Colors == 0 || (this->Colors == 3 && index % 2 == 0);
    if (bare)
    {
      this->Text += this->Chooser.Chance(0.1) ? this->Gap() + "1.0" : "";
      return;
    }
    for (std::size_t k = 0; k < 3; ++k)
    {
      const std::uint8_t byte = this->Bytes[3 * index + k];
      this->Text +=
        this->Gap() + (this->Colors == 2 ? std::to_string(byte) : ShortText(float(byte) / 255.0F));
    }
    this->Text += this->Chooser.Chance(0.1) ? this->Gap() + "1.0" : "";
  }

  void EmitFace(const std::array<std::uint64_t, 3>& emitted)
  {
    RandomGenerator& generator = this->Chooser;
    const std::uint64_t size = 3 + (generator.Chance(0.2) ? generator.Pick(6) : 0);
    const std::array<bool, 3> named{ true, this->Named[1] && generator.Chance(0.9),
      this->Named[2] && generator.Chance(0.9) };
    std::vector<Corner> corners;
    this->Text += "f";
    for (std::uint64_t i = 0; i < size; ++i)
    {
      Corner corner{};
      this->Text += this->Gap();
      for (std::size_t part = 0; part < 3; ++part)
      {
        const bool further = named[2] && part == 2;
        this->Text += (part == 1 && (named[1] || named[2])) || further ? "/" : "";
        if (named[part])
        {
          // Few different combinations, so that they occur again.
          corner[part] =
            1 + generator.Pick(
                  part == 0 ? this->Counts[0] : std::min<std::uint64_t>(this->Counts[part], 3));
          const bool back = generator.Chance(0.3) && corner[part] <= emitted[part];
          this->Text += back ? "-" + std::to_string(emitted[part] + 1 - corner[part])
                             : std::to_string(corner[part]);
        }
      }
      corners.push_back(corner);
    }
    this->Text += this->Newline;
    this->Polygons.Add(this->Corners.size() / 3, corners.size() - 2);
    for (std::size_t i = 2; i < corners.size(); ++i)
    {
      this->Corners.insert(this->Corners.end(), { corners[0], corners[i - 1], corners[i] });
    }
  }

  // Makes a vertex for each combination. The first combination of a place has the number of the
  // place.
  void Describe()
  {
    RandomFile& obj = this->Obj;
    obj.bytes = this->Text;
    std::vector<Corner> vertices;
    std::map<Corner, VertexId> known;
    std::vector<bool> taken(this->Counts[0], false);
    for (std::uint64_t i = 0; i < this->Counts[0]; ++i)
    {
      vertices.push_back({ i + 1, 0, 0 });
    }
    std::array<bool, 3> used{};
    for (const std::size_t part : { 1U, 2U })
    {
      used[part] = this->Corners.empty() && this->Counts[part] == this->Counts[0]; // for a cloud
      for (Corner& vertex : vertices)
      {
        vertex[part] = used[part] ? vertex[0] : 0;
      }
    }
    for (std::size_t i = 0; i < this->Corners.size(); ++i)
    {
      const Corner& corner = this->Corners[i];
      used[1] = used[1] || corner[1] > 0;
      used[2] = used[2] || corner[2] > 0;
      if (!taken[corner[0] - 1])
      {
        taken[corner[0] - 1] = true;
        vertices[corner[0] - 1] = corner;
        known[corner] = static_cast<VertexId>(corner[0] - 1);
      }
      const auto [found, isNew] = known.try_emplace(corner, static_cast<VertexId>(vertices.size()));
      if (isNew)
      {
        vertices.push_back(corner);
      }
      if (i % 3 == 0)
      {
        obj.triangles.emplace_back();
      }
      obj.triangles.back()[i % 3] = found->second;
    }
    for (const Corner& vertex : vertices)
    {
      obj.points.push_back(this->Values[0][vertex[0] - 1]);
    }
    const Status cut = this->Polygons.Cut(
      obj.triangles, [&](VertexId vertex) { return Result<Vec3>(obj.points[vertex]); });
    if (!cut)
    {
      throw std::logic_error(cut.GetError().message);
    }
    if (this->Colors == 1 || this->Colors == 2)
    {
      Attribute colors{ { "RGB", AttributeType::UInt8, AttributeAssociation::Point, 3 }, {} };
      for (const Corner& vertex : vertices)
      {
        const auto begin = this->Bytes.begin() + static_cast<std::ptrdiff_t>(3 * (vertex[0] - 1));
        colors.values.insert(colors.values.end(), begin, begin + 3);
      }
      obj.attributes.push_back(colors);
    }
    this->DescribePart(vertices, 2, "Normals", 3, used[2]);
    this->DescribePart(vertices, 1, "TCoords", 2, used[1]);
    if (this->Materials)
    {
      obj.ignored.push_back("materials and their textures");
    }
    if (this->Curves > 0)
    {
      obj.ignored.push_back(this->Curves == 1 ? "1 line, free-form curve or surface"
                                              : std::to_string(this->Curves) +
                                                  " lines and free-form curves or surfaces");
    }
    for (const std::size_t part : { 1U, 2U })
    {
      if (this->Counts[part] > 0 && !used[part])
      {
        obj.ignored.push_back(
          std::string(part == 1 ? "texture coordinates" : "normals") + ", which no face names");
      }
    }
    if (this->Colors == 3)
    {
      obj.ignored.push_back("colours, which not all vertices have");
    }
    this->Corners.clear();
    this->Materials = false;
    this->Curves = 0;
  }

  void DescribePart(const std::vector<Corner>& vertices, std::size_t part, const char* name,
    std::uint8_t components, bool used)
  {
    if (!used)
    {
      return;
    }
    Attribute attribute{ { name, AttributeType::Float32, AttributeAssociation::Point, components },
      {} };
    attribute.values.resize(vertices.size() * attribute.TupleSize());
    for (std::size_t i = 0; i < vertices.size(); ++i)
    {
      for (std::size_t k = 0; k < components && vertices[i][part] > 0; ++k)
      {
        attribute.Set(i, k, this->Values[part][vertices[i][part] - 1][k]);
      }
    }
    this->Obj.attributes.push_back(attribute);
  }

  RandomGenerator Chooser;
  RandomFile Obj;
  std::string Text, Newline, Blank;
  bool Doubles = false, Materials = false;
  std::uint64_t Colors = 0, Curves = 0;
  std::array<std::uint64_t, 3> Counts{};
  std::array<bool, 3> Named{};
  std::array<std::vector<Vec3>, 3> Values;
  std::vector<std::uint8_t> Bytes; // colours
  std::vector<Corner> Corners;     // three for each triangle
  PolygonFaces Polygons;           // of these triangles
};

}
