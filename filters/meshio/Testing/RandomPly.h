// Random meshes in random PLY dresses, with what a reader must make of them.
#pragma once

#include "filters/core/Types.h"
#include "filters/meshio/Testing/PlyEmitter.h"

#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

namespace kdstream::test
{

struct RandomPly
{
  std::string bytes;
  std::vector<Vec3> points;
  std::vector<Triangle> triangles;
  std::uint64_t faces = 0;
  ScalarType scalarType = ScalarType::Float32;
  std::vector<std::string> ignored;
};

class RandomPlyMaker
{
public:
  explicit RandomPlyMaker(unsigned seed)
    : Random(seed)
  {
  }

  // A file of at most `mostVertices` vertices and twice as many faces.
  RandomPly Make(std::uint64_t mostVertices)
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

  std::uint64_t Pick(std::uint64_t below)
  {
    return std::uniform_int_distribution<std::uint64_t>(0, below - 1)(this->Random);
  }
  bool Chance(double probability) { return std::bernoulli_distribution(probability)(this->Random); }
  std::string PickOf(const std::vector<std::string>& words)
  {
    return words[this->Pick(words.size())];
  }

private:
  static constexpr const char* extraNames[] = { "red", "nx", "quality", "flags", "texcoord" };

  std::string AnyType()
  {
    return this->PickOf({ "char", "uchar", "short", "ushort", "int", "uint", "float", "double",
      "int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64" });
  }

  // A finite value of the type: any bits for floats, often small, sometimes at the ends of the
  // range.
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

  // Extra properties between which the wanted ones are put; their values come with the records.
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
        if (property.name.size() == 1)
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

  // Triangles in the order of the file, and the names of what is left out.
  void Describe(const std::vector<EmitElement>& elements)
  {
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
      for (std::size_t p = 0; p < element.properties.size(); ++p)
      {
        const std::string& name = element.properties[p].name;
        const bool corners = !vertices && name.starts_with("vertex_ind");
        if (!corners && !(vertices && name.size() == 1))
        {
          this->Ply.ignored.push_back(element.name + "." + name);
        }
        for (std::size_t i = 0; corners && i < element.records.size(); ++i)
        {
          strips ? this->ExpectStrips(element.records[i][p])
                 : this->ExpectPolygon(element.records[i][p]);
        }
      }
    }
  }

  void ExpectPolygon(const std::vector<double>& corners)
  {
    for (std::size_t k = 2; k < corners.size(); ++k)
    {
      this->Expect(corners[0], corners[k - 1], corners[k]);
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

  std::mt19937_64 Random;
  RandomPly Ply;
  bool Plain = false;
};

}
