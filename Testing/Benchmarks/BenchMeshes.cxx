// SPDX-License-Identifier: BSD-3-Clause
// Generates meshes for the benchmarks, with the sizes of the paper's Table 2, and with shapes that
// the available scans do not have:
//   BenchMeshes OUTPUT_FOLDER
// writes torus.ply (36,000 vertices in even rows, fine relief), bones.ply (about 50,000; branching,
// with uneven triangles, as in surfaces extracted from volumes), gyroid.ply (about 98,000; thin
// walls, many holes) and head.ply (67,418; smooth and closed).
#include "filters/core/Weld.h"
#include "filters/meshio/MeshWriter.h"

#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <iostream>
#include <map>

namespace
{

using namespace kdstream;

constexpr double pi = 3.14159265358979323846;

Mesh Torus()
{
  constexpr unsigned around = 300, through = 120;
  Mesh mesh;
  for (unsigned i = 0; i < around; ++i)
  {
    for (unsigned j = 0; j < through; ++j)
    {
      const double u = 2 * pi * i / around, v = 2 * pi * j / through;
      const double r = 0.45 + 0.03 * std::sin(9 * u) * std::cos(5 * v) +
                       0.006 * std::sin(41 * u + 3) * std::sin(23 * v);
      const auto single = [](double x) { return double(float(x)); };
      mesh.points.push_back({ single((1.2 + r * std::cos(v)) * std::cos(u)),
        single((1.2 + r * std::cos(v)) * std::sin(u)), single(r * std::sin(v)) });
      const auto at = [](unsigned a, unsigned b) { return (a % around) * through + b % through; };
      mesh.triangles.push_back({ at(i, j), at(i + 1, j), at(i + 1, j + 1) });
      mesh.triangles.push_back({ at(i, j), at(i + 1, j + 1), at(i, j + 1) });
    }
  }
  return mesh;
}

// A head: a ball with dents and bumps. The ball is made of a cube's six grids of side × side quads,
// projected onto it: 6 side^2 + 2 vertices. (Igea and Skull of the paper may have been made in this
// way: Skull has 98,306 vertices, which is a number of this form.)
Mesh Head()
{
  constexpr int side = 106;
  // Points on edges and corners belong to several faces.
  std::map<std::array<int, 3>, VertexId> known;
  Mesh mesh;
  const auto vertex = [&](const std::array<int, 3>& at)
  {
    const auto [found, added] = known.try_emplace(at, static_cast<VertexId>(mesh.points.size()));
    if (added)
    {
      Vec3 p{};
      for (std::size_t k = 0; k < 3; ++k)
      {
        // Makes squares near the corners about as large as others.
        p[k] = std::tan(pi / 4 * (2.0 * at[k] / side - 1));
      }
      const double length = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
      const auto bump = [&](double x, double y, double z, double width)
      {
        const double dx = p[0] / length - x, dy = p[1] / length - y, dz = p[2] / length - z;
        return std::exp(-(dx * dx + dy * dy + dz * dz) / (width * width));
      };
      const double relief =
        std::sin(29 * p[0] / length) * std::sin(23 * p[1] / length) * std::sin(31 * p[2] / length);
      const double r = 1 - 0.22 * bump(0.35, 0.2, 0.9, 0.2) - 0.22 * bump(-0.35, 0.2, 0.9, 0.2) +
                       0.25 * bump(0, -0.1, 1, 0.18) - 0.3 * bump(0, -0.9, -0.4, 0.5) +
                       0.012 * relief;
      const double scale[] = { 0.8 * r / length, 1.15 * r / length, r / length };
      mesh.points.push_back({ double(float(scale[0] * p[0])), double(float(scale[1] * p[1])),
        double(float(scale[2] * p[2])) });
    }
    return found->second;
  };
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    for (const int end : { 0, side })
    {
      for (int i = 0; i < side; ++i)
      {
        for (int j = 0; j < side; ++j)
        {
          VertexId quad[4];
          for (int corner = 0; corner < 4; ++corner)
          {
            std::array<int, 3> at{};
            at[axis] = end;
            at[(axis + 1) % 3] = i + (corner == 1 || corner == 2);
            at[(axis + 2) % 3] = j + (corner >= 2);
            quad[corner] = vertex(at);
          }
          if (end == 0)
          {
            std::swap(quad[1], quad[3]);
          }
          mesh.triangles.push_back({ quad[0], quad[1], quad[2] });
          mesh.triangles.push_back({ quad[0], quad[2], quad[3] });
        }
      }
    }
  }
  return mesh;
}

// The surface value = 0 in [-1, 1]^3, by marching cubes over side^3 samples.
Mesh Surface(int side, const std::function<double(const Vec3&)>& value)
{
  vtkNew<vtkImageData> volume;
  volume->SetDimensions(side, side, side);
  const double spacing = 2.0 / (side - 1);
  volume->SetSpacing(spacing, spacing, spacing);
  volume->SetOrigin(-1, -1, -1);
  vtkNew<vtkFloatArray> samples;
  samples->SetNumberOfValues(vtkIdType{ side } * side * side);
  for (vtkIdType i = 0; i < samples->GetNumberOfValues(); ++i)
  {
    Vec3 p;
    volume->GetPoint(i, p.data());
    samples->SetValue(i, static_cast<float>(value(p)));
  }
  volume->GetPointData()->SetScalars(samples);
  vtkNew<vtkFlyingEdges3D> contour;
  contour->SetInputData(volume);
  contour->SetValue(0, 0);
  contour->ComputeNormalsOff();
  contour->ComputeScalarsOff();
  contour->Update();
  vtkPolyData* const surface = contour->GetOutput();
  Mesh mesh;
  mesh.points.resize(static_cast<std::size_t>(surface->GetNumberOfPoints()));
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
  {
    surface->GetPoint(static_cast<vtkIdType>(i), mesh.points[i].data());
  }
  vtkIdType count = 0;
  const vtkIdType* ids = nullptr;
  vtkCellArray* const cells = surface->GetPolys();
  for (cells->InitTraversal(); cells->GetNextCell(count, ids);)
  {
    mesh.triangles.push_back({ static_cast<VertexId>(ids[0]), static_cast<VertexId>(ids[1]),
      static_cast<VertexId>(ids[2]) });
  }
  WeldVertices(mesh);
  return mesh;
}

// Balls along branches that merge smoothly, with fine relief.
class Bones
{
public:
  Bones()
  {
    for (int branch = 0; branch < 5; ++branch)
    {
      const double angle = 2 * pi * branch / 5, lift = 0.35 * (branch % 3 - 1);
      for (int i = 0; i < 9; ++i)
      {
        const double along = 0.09 * i, radius = 0.11 - 0.006 * i + (i > 6 ? 0.04 : 0);
        this->Balls.push_back(
          { { along * std::cos(angle + 0.05 * i), along * std::sin(angle + 0.05 * i),
              lift * along / 0.72 + 0.02 * std::sin(3.0 * i) },
            3.2 * radius * radius });
      }
    }
  }

  double operator()(const Vec3& p) const
  {
    double field = 0;
    for (const Ball& ball : this->Balls)
    {
      const double x = p[0] - ball.centre[0], y = p[1] - ball.centre[1], z = p[2] - ball.centre[2];
      const double rest = 1 - (x * x + y * y + z * z) / ball.square;
      field += rest > 0 ? rest * rest * rest : 0;
    }
    const double relief = std::sin(37 * p[0]) * std::sin(31 * p[1] + 1) * std::sin(41 * p[2] + 2);
    return 0.55 + 0.03 * relief - field;
  }

private:
  struct Ball
  {
    Vec3 centre;
    double square; // the square of the radius of its influence
  };
  std::vector<Ball> Balls;
};

// A wall along a triply periodic surface, inside a ball.
double Gyroid(const Vec3& p)
{
  const double scale = 2.4 * pi;
  const double wave = std::sin(scale * p[0]) * std::cos(scale * p[1]) +
                      std::sin(scale * p[1]) * std::cos(scale * p[2]) +
                      std::sin(scale * p[2]) * std::cos(scale * p[0]);
  const double wall = std::abs(wave) - 0.42;
  const double ball = (std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) - 0.93) * 6;
  return std::max(wall, ball);
}

}

int main(int argc, char** argv)
{
  if (argc != 2)
  {
    std::cerr << "usage: BenchMeshes OUTPUT_FOLDER\n";
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  const std::pair<const char*, Mesh> meshes[] = { { "torus.ply", Torus() },
    { "bones.ply", Surface(270, Bones()) }, { "gyroid.ply", Surface(98, Gyroid) },
    { "head.ply", Head() } };
  for (const auto& [name, mesh] : meshes)
  {
    if (const Status status = WriteMesh(folder / name, mesh); !status)
    {
      std::cerr << "BenchMeshes: error: " << name << ": " << status.GetError().message << "\n";
      return 1;
    }
    std::printf(
      "%-12s %7zu vertices, %7zu triangles\n", name, mesh.points.size(), mesh.triangles.size());
  }
  return 0;
}
