// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/Meshes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <utility>

namespace kdstream::fixtures
{

void Append(Mesh& mesh, const Mesh& other)
{
  const auto offset = static_cast<VertexId>(mesh.points.size());
  mesh.points.insert(mesh.points.end(), other.points.begin(), other.points.end());
  for (const Triangle& t : other.triangles)
  {
    mesh.triangles.push_back({ t[0] + offset, t[1] + offset, t[2] + offset });
  }
}

namespace
{

void RoundToFloats(Mesh& mesh)
{
  for (Vec3& p : mesh.points)
  {
    for (double& value : p)
    {
      value = double(float(value));
    }
  }
}

// An octahedron on the unit sphere whose triangles are repeatedly divided into four.
Mesh Sphere(unsigned subdivisions)
{
  Mesh mesh;
  mesh.points = { { 1, 0, 0 }, { -1, 0, 0 }, { 0, 1, 0 }, { 0, -1, 0 }, { 0, 0, 1 }, { 0, 0, -1 } };
  mesh.triangles = { { 0, 2, 4 }, { 2, 1, 4 }, { 1, 3, 4 }, { 3, 0, 4 }, { 2, 0, 5 }, { 1, 2, 5 },
    { 3, 1, 5 }, { 0, 3, 5 } };
  for (unsigned i = 0; i < subdivisions; ++i)
  {
    std::map<std::pair<VertexId, VertexId>, VertexId> middles;
    const auto middle = [&](VertexId a, VertexId b)
    {
      const auto [entry, fresh] =
        middles.try_emplace(std::minmax(a, b), static_cast<VertexId>(mesh.points.size()));
      if (fresh)
      {
        Vec3 p;
        double length = 0;
        for (std::size_t k = 0; k < 3; ++k)
        {
          p[k] = mesh.points[a][k] + mesh.points[b][k];
          length += p[k] * p[k];
        }
        for (double& value : p)
        {
          value /= std::sqrt(length);
        }
        mesh.points.push_back(p);
      }
      return entry->second;
    };
    std::vector<Triangle> finer;
    for (const Triangle& t : mesh.triangles)
    {
      const VertexId a = middle(t[0], t[1]), b = middle(t[1], t[2]), c = middle(t[2], t[0]);
      finer.insert(finer.end(), { { t[0], a, c }, { a, t[1], b }, { c, b, t[2] }, { a, b, c } });
    }
    mesh.triangles = std::move(finer);
  }
  return mesh;
}

// Eight places with a thousand vertices each, and triangles between any of them.
Mesh RepeatedCube()
{
  Mesh mesh;
  std::mt19937 random(11);
  for (unsigned i = 0; i < 8000; ++i)
  {
    mesh.points.push_back({ double(i & 1), double((i >> 1) & 1), double((i >> 2) & 1) });
  }
  for (unsigned i = 0; i < 4000; ++i)
  {
    mesh.triangles.push_back(
      { VertexId(random() % 8000), VertexId(random() % 8000), VertexId(random() % 8000) });
  }
  return mesh;
}

// Surfaces that meet in one edge, a thousand times: edges with three or four triangles.
Mesh NonManifold()
{
  Mesh mesh;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0, 1);
  for (unsigned i = 0; i < 1000; ++i)
  {
    const Vec3 base{ unit(random) * 10, unit(random) * 10, unit(random) * 10 };
    const auto first = static_cast<VertexId>(mesh.points.size());
    mesh.points.push_back(base);
    mesh.points.push_back({ base[0] + 0.1, base[1], base[2] });
    for (unsigned wing = 0; wing < 3 + i % 2; ++wing)
    {
      mesh.points.push_back({ base[0], base[1] + unit(random), base[2] + unit(random) });
      mesh.triangles.push_back({ first, first + 1, first + 2 + wing });
    }
  }
  RoundToFloats(mesh);
  return mesh;
}

Mesh WithIsolatedVertices()
{
  Mesh mesh = DisplacedSphere(4);
  Append(mesh, Cloud(4));
  return Shuffled(mesh, 3);
}

Mesh WithDuplicateFaces()
{
  Mesh mesh = DisplacedSphere(4);
  const std::vector<Triangle> once = mesh.triangles;
  for (std::size_t i = 0; i < once.size(); i += 3)
  {
    const Triangle& t = once[i];
    mesh.triangles.push_back({ t[1], t[2], t[0] });
    mesh.triangles.push_back({ t[1], t[0], t[2] });
  }
  return mesh;
}

Mesh WithDegenerateFaces()
{
  Mesh mesh = DisplacedSphere(4);
  const std::vector<Triangle> once = mesh.triangles;
  for (std::size_t i = 0; i < once.size(); i += 5)
  {
    const Triangle& t = once[i];
    mesh.triangles.push_back({ t[0], t[0], t[1] });
    mesh.triangles.push_back({ t[1], t[0], t[0] });
    mesh.triangles.push_back({ t[2], t[2], t[2] });
  }
  return mesh;
}

Mesh HugeOffset()
{
  Mesh mesh = DisplacedSphere(4, { 4e6 + 0.123, 5e6 + 0.456, 789.001 }, 0.5);
  mesh.scalarType = ScalarType::Float64;
  return mesh;
}

Mesh SignedZeros()
{
  Mesh mesh = GridPlate(20);
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
  {
    mesh.points[i][2] = i % 2 == 0 ? 0.0 : -0.0;
  }
  return mesh;
}

}

Mesh DisplacedSphere(unsigned subdivisions, const Vec3& centre, double radius)
{
  Mesh mesh = Sphere(subdivisions);
  for (Vec3& p : mesh.points)
  {
    const double wave =
      1 + 0.1 * std::sin(9 * p[0] + 1) * std::sin(7 * p[1] + 2) + 0.03 * std::sin(23 * p[2]);
    for (std::size_t k = 0; k < 3; ++k)
    {
      p[k] = centre[k] + radius * wave * p[k];
    }
  }
  if (centre == Vec3{})
  {
    RoundToFloats(mesh);
  }
  return mesh;
}

Mesh Torus(unsigned around, unsigned through)
{
  Mesh mesh;
  constexpr double turn = 6.283185307179586;
  for (unsigned i = 0; i < around; ++i)
  {
    for (unsigned j = 0; j < through; ++j)
    {
      const double u = turn * i / around, v = turn * j / through;
      const double r = 2 + 0.7 * std::cos(v);
      mesh.points.push_back({ r * std::cos(u), r * std::sin(u), 0.7 * std::sin(v) });
      const auto at = [&](unsigned a, unsigned b) { return (a % around) * through + b % through; };
      mesh.triangles.push_back({ at(i, j), at(i + 1, j), at(i + 1, j + 1) });
      mesh.triangles.push_back({ at(i, j), at(i + 1, j + 1), at(i, j + 1) });
    }
  }
  RoundToFloats(mesh);
  return mesh;
}

Mesh NestedSpheres(unsigned subdivisions)
{
  Mesh mesh = DisplacedSphere(subdivisions);
  Mesh inner = DisplacedSphere(subdivisions, {}, 0.98);
  for (Triangle& t : inner.triangles)
  {
    std::swap(t[1], t[2]);
  }
  Append(mesh, inner);
  return mesh;
}

Mesh ThinPlate(unsigned side)
{
  // Two grids of (side + 1)² vertices, joined along the rim.
  Mesh mesh;
  const unsigned row = side + 1;
  for (unsigned layer = 0; layer < 2; ++layer)
  {
    for (unsigned i = 0; i < row * row; ++i)
    {
      mesh.points.push_back(
        { double(i % row) / side, double(i / row) / side, layer == 0 ? 0.0 : 0.001 });
    }
  }
  const unsigned top = row * row;
  for (unsigned y = 0; y < side; ++y)
  {
    for (unsigned x = 0; x < side; ++x)
    {
      const VertexId a = y * row + x, b = a + 1, c = a + row, d = c + 1;
      mesh.triangles.insert(mesh.triangles.end(),
        { { a, c, b }, { b, c, d }, { top + a, top + b, top + c }, { top + b, top + d, top + c } });
    }
  }
  const auto wall = [&](VertexId a, VertexId b)
  {
    mesh.triangles.push_back({ a, b, top + a });
    mesh.triangles.push_back({ b, top + b, top + a });
  };
  for (unsigned i = 0; i < side; ++i)
  {
    wall(i, i + 1);
    wall(i * row + side, (i + 1) * row + side);
    wall(side * row + i + 1, side * row + i);
    wall((i + 1) * row, i * row);
  }
  RoundToFloats(mesh);
  return mesh;
}

Mesh GridPlate(unsigned side)
{
  Mesh mesh;
  const unsigned row = side + 1;
  for (unsigned i = 0; i < row * row; ++i)
  {
    mesh.points.push_back({ double(i % row), double(i / row), double(0.1F) });
  }
  for (unsigned y = 0; y < side; ++y)
  {
    for (unsigned x = 0; x < side; ++x)
    {
      const VertexId a = y * row + x;
      mesh.triangles.push_back({ a, a + 1, a + row });
      mesh.triangles.push_back({ a + 1, a + row + 1, a + row });
    }
  }
  return mesh;
}

Mesh HeightField(unsigned side)
{
  Mesh mesh = GridPlate(side);
  for (Vec3& p : mesh.points)
  {
    p[2] =
      6 * std::sin(0.05 * p[0]) * std::cos(0.04 * p[1]) + 1.5 * std::sin(0.2 * p[0] + 0.3 * p[1]);
  }
  return mesh;
}

Mesh Unwelded(const Mesh& shared)
{
  Mesh mesh;
  for (const Triangle& t : shared.triangles)
  {
    const auto first = static_cast<VertexId>(mesh.points.size());
    for (const VertexId v : t)
    {
      mesh.points.push_back(shared.points[v]);
    }
    mesh.triangles.push_back({ first, first + 1, first + 2 });
  }
  return mesh;
}

Mesh Tetrahedra(unsigned count)
{
  Mesh mesh;
  std::mt19937 random(11);
  const auto unit = [&] { return double(random() % 4096) / 4096; };
  for (unsigned i = 0; i < count; ++i)
  {
    const Vec3 p{ unit(), unit(), unit() };
    constexpr double side = 0.004;
    const auto first = static_cast<VertexId>(mesh.points.size());
    mesh.points.push_back(p);
    for (std::size_t k = 0; k < 3; ++k)
    {
      mesh.points.push_back(p);
      mesh.points.back()[k] += side;
    }
    for (const Triangle& t : { Triangle{ 0, 2, 1 }, { 0, 1, 3 }, { 1, 2, 3 }, { 0, 3, 2 } })
    {
      mesh.triangles.push_back({ first + t[0], first + t[1], first + t[2] });
    }
  }
  return mesh;
}

Mesh Soup(unsigned triangles, std::uint32_t seed)
{
  Mesh mesh;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  for (VertexId i = 0; i < 3 * triangles; i += 3)
  {
    const Vec3 base{ unit(random), unit(random), unit(random) };
    for (unsigned k = 0; k < 3; ++k)
    {
      mesh.points.push_back({ base[0] + 0.05 * unit(random), base[1] + 0.05 * unit(random),
        base[2] + 0.05 * unit(random) });
    }
    mesh.triangles.push_back({ i, i + 1, i + 2 });
  }
  RoundToFloats(mesh);
  return mesh;
}

Mesh Cloud(unsigned subdivisions)
{
  Mesh mesh = DisplacedSphere(subdivisions, {}, 1.5);
  mesh.triangles.clear();
  return mesh;
}

Mesh Shuffled(const Mesh& mesh, std::uint32_t seed)
{
  std::mt19937 random(seed);
  std::vector<VertexId> order(mesh.points.size());
  std::iota(order.begin(), order.end(), VertexId{ 0 });
  std::shuffle(order.begin(), order.end(), random);
  Mesh shuffled;
  shuffled.scalarType = mesh.scalarType;
  shuffled.points.resize(mesh.points.size());
  for (std::size_t i = 0; i < order.size(); ++i)
  {
    shuffled.points[order[i]] = mesh.points[i];
  }
  for (const Triangle& t : mesh.triangles)
  {
    shuffled.triangles.push_back({ order[t[0]], order[t[1]], order[t[2]] });
  }
  std::shuffle(shuffled.triangles.begin(), shuffled.triangles.end(), random);
  return shuffled;
}

std::vector<NamedMesh> ClosedMeshes()
{
  return { { "displaced sphere", DisplacedSphere(5) },
    { "shuffled sphere", Shuffled(DisplacedSphere(4), 7) }, { "torus", Torus(96, 48) },
    { "nested spheres", NestedSpheres(4) }, { "thin plate", ThinPlate(40) } };
}

std::vector<NamedMesh> HardMeshes()
{
  std::vector<NamedMesh> meshes{ { "grid plate", GridPlate(60) },
    { "repeated cube", RepeatedCube() }, { "one vertex", { { { 1, 2, 3 } }, {} } },
    { "one degenerate triangle", { { { 1, 2, 3 } }, { { 0, 0, 0 } } } },
    { "three vertices", { { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, { { 0, 1, 2 } } } },
    { "two vertices", { { { 0, 0, 0 }, { 1, 0, 0 } }, {} } }, { "cloud", Cloud(5) },
    { "non-manifold", NonManifold() }, { "isolated vertices", WithIsolatedVertices() },
    { "duplicate faces", WithDuplicateFaces() }, { "degenerate faces", WithDegenerateFaces() },
    { "unwelded sphere", Unwelded(DisplacedSphere(4)) }, { "soup", Soup(3000, 9) },
    { "huge offset", HugeOffset() }, { "signed zeros", SignedZeros() } };
  return meshes;
}

std::vector<NamedMesh> AllMeshes()
{
  std::vector<NamedMesh> meshes = ClosedMeshes();
  for (NamedMesh& hard : HardMeshes())
  {
    meshes.push_back(std::move(hard));
  }
  return meshes;
}

}
