// SPDX-License-Identifier: BSD-3-Clause
// Random meshes in random PLY notation, with the mesh that a reader must make of them.
#pragma once

#include "filters/core/CutPolygon.h"
#include "filters/meshio/Testing/PlyEmitter.h"
#include "filters/meshio/Testing/RandomGenerator.h"

#include <limits>
#include <map>
#include <utility>

namespace kdstream::test
{

class RandomPlyMaker : private RandomGenerator
{
public:
  explicit RandomPlyMaker(unsigned seed)
    : RandomGenerator(seed)
  {
  }

  // Makes a file of at most `mostVertices` vertices and twice as many faces.
  RandomFile Make(std::uint64_t mostVertices)
  {
    this->Ply = {};
    EmitStyle style;
    style.encoding = static_cast<EmitEncoding>(this->Pick(3));
    style.newline = this->PickOf({ "\n", "\r\n", "\r" });
    style.blank = this->PickOf({ " ", "\t", "   ", " \t " });
    style.comments = this->Chance(0.3);

    const EmitElement vertices = this->MakeVertices(1 + this->Pick(mostVertices));
    std::vector<EmitElement> faces;
    const std::uint64_t mostFaces = 2 * this->Ply.points.size();
    if (this->Chance(0.8))
    {
      faces.push_back(this->MakeFaces("face", this->Pick(mostFaces + 1)));
    }
    if (this->Chance(0.3))
    {
      faces.push_back(this->MakeFaces("tristrips", this->Pick(4)));
    }
    if (this->Chance(0.5))
    {
      std::reverse(faces.begin(), faces.end());
    }
    std::vector<EmitElement> elements;
    this->MaybeAddStranger(elements, "material");
    bool placed = false;
    for (EmitElement& element : faces)
    {
      if (!placed && this->Chance(0.7))
      {
        elements.push_back(vertices);
        placed = true;
      }
      this->MaybeAddStranger(elements, "edge" + std::to_string(elements.size()));
      elements.push_back(std::move(element));
    }
    if (!placed)
    {
      elements.push_back(vertices);
    }
    this->MaybeAddStranger(elements, "camera");
    this->Describe(elements);
    this->Ply.bytes = PlyEmitter(style).Emit(elements);
    return this->Ply;
  }

  RandomGenerator& Generator() { return *this; }

private:
  static constexpr const char* extraNames[] = { "red", "nx", "quality", "flags", "texcoord",
    "wide_0", "wide_1", "wide_2", "one_0", "a%20b", "%0a" };

  std::string AnyType()
  {
    return this->PickOf({ "char", "uchar", "short", "ushort", "int", "uint", "float", "double",
      "int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64" });
  }

  // A finite value of the type: for floats any bits, often a small value, sometimes one at the ends
  // of the range.
  double AnyValue(const std::string& type)
  {
    switch (EmitTypeCode(type))
    {
      case 'b':
        return static_cast<std::int8_t>(this->Pick(256));
      case 'B':
        return static_cast<std::uint8_t>(this->Pick(256));
      case 'h':
        return static_cast<std::int16_t>(this->Pick(65536));
      case 'H':
        return static_cast<std::uint16_t>(this->Pick(65536));
      case 'i':
        return static_cast<std::int32_t>(static_cast<std::uint32_t>(this->Random()));
      case 'I':
        return static_cast<std::uint32_t>(this->Random());
      case 'f':
        return this->AnyReal<float, std::uint32_t>();
      default:
        return this->AnyReal<double, std::uint64_t>();
    }
  }

  template <class Real, class Bits>
  double AnyReal()
  {
    const std::vector<Real> edges{ Real{ 0 }, -Real{ 0 }, std::numeric_limits<Real>::max(),
      std::numeric_limits<Real>::lowest(), std::numeric_limits<Real>::denorm_min(),
      -std::numeric_limits<Real>::denorm_min(), std::numeric_limits<Real>::min() };
    if (this->Chance(0.05))
    {
      return static_cast<double>(edges[this->Pick(edges.size())]);
    }
    if (this->Chance(0.5))
    {
      return static_cast<double>(std::uniform_real_distribution<Real>(-1, 1)(this->Random));
    }
    const Real value = std::bit_cast<Real>(static_cast<Bits>(this->Random()));
    return std::isfinite(value) ? static_cast<double>(value) : 0.5;
  }

  // Extra properties, among which the wanted ones are placed; their values come with the records.
  std::vector<EmitProperty> MakeExtras()
  {
    std::vector<EmitProperty> extras;
    for (const char* name : extraNames)
    {
      if (this->Chance(this->Plain ? 0 : 0.25))
      {
        const bool list = this->Chance(0.3);
        extras.push_back(
          { name, this->AnyType(), list ? this->PickOf({ "uchar", "int", "uint16" }) : "" });
      }
    }
    // Groups of properties, sometimes with one of another type or with one missing.
    for (const auto& [names, types] : { std::pair{ std::vector<std::string>{ "nx", "ny", "nz" },
                                          std::vector<std::string>{ "float", "double" } },
           std::pair{ std::vector<std::string>{ "red", "green", "blue", "alpha" },
             std::vector<std::string>{ "uchar", "float" } },
           std::pair{ std::vector<std::string>{ "u", "v" },
             std::vector<std::string>{ "float", "double", "short" } } })
    {
      const std::string type = this->PickOf(types);
      if (this->Plain || this->Chance(0.6))
      {
        continue;
      }
      std::erase_if(extras, [&names = names](const EmitProperty& property)
        { return std::find(names.begin(), names.end(), property.name) != names.end(); });
      for (const std::string& name : names)
      {
        if (this->Chance(0.9))
        {
          extras.push_back({ name, this->Chance(0.95) ? type : this->AnyType(), "" });
        }
      }
    }
    return extras;
  }

  std::vector<double> ExtraValues(const EmitProperty& property)
  {
    std::vector<double> values(property.countType.empty() ? 1 : this->Pick(4));
    for (double& value : values)
    {
      value = this->AnyValue(property.type);
    }
    return values;
  }

  EmitElement MakeVertices(std::uint64_t count)
  {
    this->Plain = this->Chance(0.3);
    const bool allFloat = this->Chance(0.4);
    const std::string one = this->Chance(0.5) ? "float" : "double";
    EmitElement element{ "vertex", this->MakeExtras(), {} };
    for (const char* name : { "x", "y", "z" })
    {
      const std::string type = allFloat ? one : this->AnyType();
      const char code = EmitTypeCode(type);
      if (code == 'i' || code == 'I' || code == 'd')
      {
        this->Ply.scalarType = ScalarType::Float64;
      }
      element.properties.push_back({ name, type, "" });
    }
    if (!this->Plain)
    {
      std::shuffle(element.properties.begin(), element.properties.end(), this->Random);
    }
    for (std::uint64_t i = 0; i < count; ++i)
    {
      Vec3 point{};
      auto& record = element.records.emplace_back();
      for (const EmitProperty& property : element.properties)
      {
        record.push_back(this->ExtraValues(property));
        if (IsCoordinate(property.name))
        {
          point[static_cast<std::size_t>(property.name[0] - 'x')] = record.back()[0];
        }
      }
      this->Ply.points.push_back(point);
    }
    return element;
  }

  std::string IndexType(bool mayBeNegative)
  {
    const std::uint64_t count = this->Ply.points.size();
    std::vector<std::string> types{ "int", "int32" };
    if (count <= 127)
    {
      types.push_back("char");
    }
    if (count <= 32767)
    {
      types.insert(types.end(), { "short", "int16" });
    }
    if (!mayBeNegative)
    {
      types.insert(types.end(), { "uint", "uint32" });
      if (count <= 255)
      {
        types.push_back("uchar");
      }
      if (count <= 65535)
      {
        types.push_back("ushort");
      }
    }
    return this->PickOf(types);
  }

  EmitElement MakeFaces(const std::string& name, std::uint64_t count)
  {
    const bool strips = name == "tristrips";
    const bool onlyTriangles = this->Chance(0.4);
    EmitElement element{ name, this->MakeExtras(), {} };
    element.properties.push_back(
      { this->PickOf({ "vertex_indices", "vertex_index" }), this->IndexType(strips),
        strips ? "int" : this->PickOf({ "uchar", "uint8", "char", "ushort", "int", "uint" }) });
    std::shuffle(element.properties.begin(), element.properties.end(), this->Random);
    for (std::uint64_t i = 0; i < count; ++i)
    {
      const std::uint64_t corners = strips               ? this->Pick(60)
                                    : onlyTriangles      ? 3
                                    : this->Chance(0.02) ? 3 + this->Pick(120)
                                                         : 3 + this->Pick(4);
      std::vector<double> list;
      for (std::uint64_t k = 0; k < corners; ++k)
      {
        const bool separator = strips && this->Chance(0.1);
        list.push_back(separator ? -1.0 : static_cast<double>(this->Pick(this->Ply.points.size())));
      }
      auto& record = element.records.emplace_back();
      for (const EmitProperty& property : element.properties)
      {
        record.push_back(
          property.name.starts_with("vertex_ind") ? list : this->ExtraValues(property));
      }
    }
    return element;
  }

  void MaybeAddStranger(std::vector<EmitElement>& elements, const std::string& name)
  {
    if (!this->Chance(0.2))
    {
      return;
    }
    EmitElement element{ name, this->MakeExtras(), {} };
    element.records.resize(this->Pick(5));
    for (auto& record : element.records)
    {
      for (const EmitProperty& property : element.properties)
      {
        record.push_back(this->ExtraValues(property));
      }
    }
    elements.push_back(std::move(element));
  }

  // Records the triangles in the order of the file, and the names of what the reader leaves out.
  void Describe(const std::vector<EmitElement>& elements)
  {
    this->DescribeArrays(elements);
    for (const EmitElement& element : elements)
    {
      if (element.records.empty())
      {
        continue;
      }
      const bool vertices = element.name == "vertex";
      const bool strips = element.name == "tristrips";
      if (!vertices && !strips && element.name != "face")
      {
        this->Ply.ignored.push_back(element.name);
        continue;
      }
      this->Ply.faces += vertices ? 0 : element.records.size();
      for (std::size_t i = 0; vertices && i < element.records.size(); ++i)
      {
        this->ExpectTuples(element, i, 1);
      }
      for (std::size_t p = 0; p < element.properties.size(); ++p)
      {
        const std::string& name = element.properties[p].name;
        const bool corners = !vertices && name.starts_with("vertex_ind");
        if (!corners && !(vertices && IsCoordinate(name)) && !this->IsKept(element, p))
        {
          this->Ply.ignored.push_back(element.name + "." + name);
        }
        for (std::size_t i = 0; corners && i < element.records.size(); ++i)
        {
          const std::size_t before = this->Ply.triangles.size();
          strips ? this->ExpectStrips(element.records[i][p])
                 : this->ExpectPolygon(element.records[i][p]);
          this->ExpectTuples(element, i, this->Ply.triangles.size() - before);
        }
      }
    }
  }

  static bool IsCoordinate(const std::string& name)
  {
    return name == "x" || name == "y" || name == "z";
  }

  // The arrays that the reader must make from an element's properties.
  struct Array
  {
    AttributeInfo info;
    std::vector<std::size_t> properties;
  };

  static AttributeType TypeOfCode(char code)
  {
    const std::string codes = "bBhHiI..fd";
    return static_cast<AttributeType>(codes.find(code));
  }

  static std::vector<Array> ArraysOf(const EmitElement& element)
  {
    const bool vertices = element.name == "vertex";
    const auto association = vertices ? AttributeAssociation::Point : AttributeAssociation::Cell;
    std::vector<bool> used;
    for (const EmitProperty& property : element.properties)
    {
      used.push_back(!property.countType.empty() || (vertices && IsCoordinate(property.name)));
    }
    const auto find = [&](const std::string& name, const std::string& codes)
    {
      for (std::size_t p = 0; p < used.size(); ++p)
      {
        const EmitProperty& property = element.properties[p];
        if (!used[p] && property.name == name &&
            codes.find(EmitTypeCode(property.type)) != std::string::npos)
        {
          return p;
        }
      }
      return used.size();
    };
    std::vector<Array> arrays;
    const auto take = [&](const std::string& name, const std::vector<std::size_t>& properties)
    {
      for (const std::size_t p : properties)
      {
        used[p] = true;
      }
      if (name != "\n")
      {
        arrays.push_back({ { name, TypeOfCode(EmitTypeCode(element.properties[properties[0]].type)),
                             association, static_cast<std::uint8_t>(properties.size()) },
          properties });
      }
    };
    const auto group =
      [&](const std::string& name, const std::vector<std::string>& names, const std::string& codes)
    {
      for (const char code : codes)
      {
        std::vector<std::size_t> properties;
        for (const std::string& each : names)
        {
          properties.push_back(find(each, std::string(1, code)));
        }
        if (std::find(properties.begin(), properties.end(), used.size()) == properties.end())
        {
          take(name, properties);
        }
      }
    };
    group("Normals", { "nx", "ny", "nz" }, "fd");
    group("RGBA", { "red", "green", "blue", "alpha" }, "B");
    group("RGB", { "red", "green", "blue" }, "B");
    group("TCoords", { "u", "v" }, "fd");
    for (std::size_t p = 0; p < used.size(); ++p)
    {
      if (used[p])
      {
        continue;
      }
      const std::string& name = element.properties[p].name;
      std::vector<std::size_t> run{ p };
      while (name == "wide_0" && p + run.size() < used.size() && !used[p + run.size()] &&
             element.properties[p + run.size()].name == "wide_" + std::to_string(run.size()) &&
             EmitTypeCode(element.properties[p + run.size()].type) ==
               EmitTypeCode(element.properties[p].type))
      {
        run.push_back(p + run.size());
      }
      take(run.size() > 1 ? "wide" : name == "a%20b" ? "a b" : name == "%0a" ? "\n" : name, run);
    }
    std::sort(arrays.begin(), arrays.end(),
      [](const Array& a, const Array& b) { return a.properties[0] < b.properties[0]; });
    return arrays;
  }

  // Fills this->Kept, and adds the attributes, without values.
  void DescribeArrays(const std::vector<EmitElement>& elements)
  {
    this->Kept.clear();
    const EmitElement* firstFaces = nullptr;
    for (const EmitElement& element : elements)
    {
      if (element.name == "vertex")
      {
        this->Kept[element.name] = ArraysOf(element);
        for (const Array& array : this->Kept[element.name])
        {
          this->Ply.attributes.push_back({ array.info, {} });
        }
      }
      const bool faces = element.name == "face" || element.name == "tristrips";
      if (faces && !element.records.empty())
      {
        this->Kept[element.name] = ArraysOf(element);
        firstFaces = firstFaces ? firstFaces : &element;
      }
    }
    if (!firstFaces)
    {
      return;
    }
    for (const Array& array : std::vector(this->Kept[firstFaces->name]))
    {
      const bool everywhere = std::all_of(this->Kept.begin(), this->Kept.end(),
        [&](const auto& kept)
        {
          return kept.first == "vertex" ||
                 std::any_of(kept.second.begin(), kept.second.end(),
                   [&](const Array& other) { return other.info == array.info; });
        });
      if (everywhere)
      {
        this->Ply.attributes.push_back({ array.info, {} });
      }
    }
    for (auto& [name, arrays] : this->Kept)
    {
      std::erase_if(arrays, [this](const Array& array) { return !this->Find(array.info); });
    }
  }

  Attribute* Find(const AttributeInfo& info)
  {
    for (Attribute& attribute : this->Ply.attributes)
    {
      if (static_cast<const AttributeInfo&>(attribute) == info)
      {
        return &attribute;
      }
    }
    return nullptr;
  }

  bool IsKept(const EmitElement& element, std::size_t property)
  {
    for (const Array& array : this->Kept[element.name])
    {
      for (const std::size_t p : array.properties)
      {
        if (p == property)
        {
          return true;
        }
      }
    }
    return false;
  }

  void ExpectTuples(const EmitElement& element, std::size_t record, std::size_t times)
  {
    for (const Array& array : this->Kept[element.name])
    {
      Attribute& attribute = *this->Find(array.info);
      for (std::size_t i = 0; i < times; ++i)
      {
        for (const std::size_t p : array.properties)
        {
          PlyEmitter emitter({ EmitEncoding::LittleEndian, "", "", false });
          const std::string bytes =
            emitter.EmitOne(element.properties[p].type, element.records[record][p][0]);
          attribute.values.insert(attribute.values.end(), bytes.begin(), bytes.end());
        }
      }
    }
  }

  void ExpectPolygon(const std::vector<double>& corners)
  {
    std::vector<Vec3> places;
    for (const double corner : corners)
    {
      places.push_back(this->Ply.points[static_cast<std::size_t>(corner)]);
    }
    PolygonCutter cutter;
    for (const Triangle& t : cutter.Cut(places))
    {
      this->Expect(corners[t[0]], corners[t[1]], corners[t[2]]);
    }
  }

  void ExpectStrips(const std::vector<double>& corners)
  {
    std::size_t begin = 0;
    for (std::size_t k = 0; k <= corners.size(); ++k)
    {
      if (k < corners.size() && corners[k] >= 0)
      {
        continue;
      }
      for (std::size_t t = begin; t + 2 < k; ++t)
      {
        const bool odd = (t - begin) % 2 == 1;
        this->Expect(corners[odd ? t + 1 : t], corners[odd ? t : t + 1], corners[t + 2]);
      }
      begin = k + 1;
    }
  }

  void Expect(double a, double b, double c)
  {
    this->Ply.triangles.push_back(
      { static_cast<VertexId>(a), static_cast<VertexId>(b), static_cast<VertexId>(c) });
  }

  RandomFile Ply;
  bool Plain = false;
  std::map<std::string, std::vector<Array>> Kept; // by element
};

}
