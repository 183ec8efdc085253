// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/Attributes.h"

#include <algorithm>
#include <cstring>
#include <random>

namespace kdstream::fixtures
{
namespace
{

class AttributeMaker
{
public:
  AttributeMaker(Mesh& mesh, std::uint32_t seed)
    : Target(mesh)
    , Random(seed)
  {
  }

  std::uint32_t Next() { return static_cast<std::uint32_t>(this->Random()); }

  // Adds random bits; for colours, normals and texture coordinates also meaningful values.
  void Add(const std::string& name, AttributeType type, AttributeAssociation association,
    std::size_t components)
  {
    Attribute attribute{ { name, type, association, static_cast<std::uint8_t>(components) }, {} };
    const std::size_t tuples = association == AttributeAssociation::Point
                                 ? this->Target.points.size()
                                 : this->Target.triangles.size();
    attribute.values.resize(tuples * attribute.TupleSize());
    for (std::uint8_t& value : attribute.values)
    {
      value = static_cast<std::uint8_t>(this->Next());
    }
    for (std::size_t i = 0; i < tuples; ++i)
    {
      for (std::size_t k = 0; k < components && this->Next() % 4 != 0; ++k)
      {
        attribute.Set(i, k, this->Next() % 200 / 50.0 - 1);
      }
    }
    this->Target.attributes.push_back(std::move(attribute));
  }

private:
  Mesh& Target;
  std::mt19937 Random;
};

}

Mesh WithAttributes(Mesh mesh, std::uint32_t seed)
{
  AttributeMaker maker(mesh, seed);
  const auto point = AttributeAssociation::Point, cell = AttributeAssociation::Cell;
  const bool wide = maker.Next() % 2 == 0;
  const bool alpha = maker.Next() % 2 == 0;
  maker.Add("Normals", wide ? AttributeType::Float64 : AttributeType::Float32, point, 3);
  maker.Add("TCoords", wide ? AttributeType::Float32 : AttributeType::Float64, point, 2);
  maker.Add(alpha ? "RGBA" : "RGB", AttributeType::UInt8, point, alpha ? 4 : 3);
  for (const auto association : { point, cell })
  {
    for (int t = 0; t < 10; ++t)
    {
      const auto type = static_cast<AttributeType>(t);
      maker.Add("any " + std::string(NameOf(type)), type, association, 1 + maker.Next() % 4);
    }
    maker.Add(alpha ? "RGB" : "RGBA", AttributeType::UInt8, association, alpha ? 3 : 4);
    maker.Add("x", AttributeType::Float32, association, 1);
    maker.Add("vertex_indices", AttributeType::UInt16, association, 1);
    maker.Add("nx", AttributeType::Float32, association, 1);
    maker.Add("ny", AttributeType::Float32, association, 1);
    maker.Add("nz", AttributeType::Float32, association, 1);
    maker.Add("a_0", AttributeType::Int16, association, 1);
    maker.Add("a_1", AttributeType::Int16, association, 1);
    maker.Add("b", AttributeType::UInt32, association, 2);
    maker.Add("b_2", AttributeType::UInt32, association, 1);
    maker.Add("c", AttributeType::Int64, association, 1);
    maker.Add("c_int64", AttributeType::UInt32, association, 2);
    maker.Add("d_uint64", AttributeType::UInt32, association, 4);
    maker.Add("red", AttributeType::UInt8, association, 1);
    maker.Add("%41", AttributeType::Int8, association, 1);
    maker.Add("A", AttributeType::Int8, association, 1);
    maker.Add("100%", AttributeType::Float64, association, 255);
    maker.Add("<\"Größe\" & 'mehr'>", AttributeType::Float32, association, 3);
    maker.Add(std::string(255, 'n'), AttributeType::UInt8, association, 3);
  }
  // Makes some tuples equal, so that welding can join points that are equal, too.
  for (std::size_t i = 1; i < mesh.points.size(); ++i)
  {
    const bool equal = maker.Next() % 2 == 0;
    for (Attribute& attribute : mesh.attributes)
    {
      if (equal && attribute.association == point)
      {
        std::copy_n(attribute.values.data(), attribute.TupleSize(),
          attribute.values.data() + i * attribute.TupleSize());
      }
    }
  }
  return mesh;
}

namespace
{

void AddTuples(
  const Mesh& mesh, AttributeAssociation association, std::size_t tuple, std::string& bytes)
{
  for (const Attribute& attribute : mesh.attributes)
  {
    if (attribute.association == association)
    {
      const auto own = TupleOf(attribute, tuple);
      bytes.insert(bytes.end(), own.begin(), own.end());
    }
  }
}

}

std::vector<AttributeInfo> InfosOf(const std::vector<Attribute>& attributes)
{
  std::vector<AttributeInfo> infos;
  for (const Attribute& attribute : attributes)
  {
    infos.push_back(attribute.Info());
  }
  return infos;
}

MeshContent ContentOf(const Mesh& mesh)
{
  MeshContent content;
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
  {
    std::string& bytes = content.vertices.emplace_back(sizeof(Vec3), char{});
    std::memcpy(bytes.data(), mesh.points[v].data(), sizeof(Vec3));
    AddTuples(mesh, AttributeAssociation::Point, v, bytes);
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
  {
    const Triangle& t = mesh.triangles[i];
    std::string lowest;
    for (std::size_t first = 0; first < 3; ++first)
    {
      std::string bytes;
      for (std::size_t k = 0; k < 3; ++k)
      {
        bytes += content.vertices[t[(first + k) % 3]];
      }
      lowest = first == 0 ? bytes : std::min(lowest, bytes);
    }
    AddTuples(mesh, AttributeAssociation::Cell, i, lowest);
    content.triangles.push_back(std::move(lowest));
  }
  std::sort(content.vertices.begin(), content.vertices.end());
  std::sort(content.triangles.begin(), content.triangles.end());
  return content;
}

std::vector<std::uint8_t> TupleOf(const Attribute& attribute, std::size_t tuple)
{
  const std::uint8_t* const begin = attribute.values.data() + tuple * attribute.TupleSize();
  return { begin, begin + attribute.TupleSize() };
}

}
