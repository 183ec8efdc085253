// SPDX-License-Identifier: BSD-3-Clause
// Shared by the tests of VTK filters: inputs, and an observer of a filter's messages and progress.
#pragma once

#include <vtkAlgorithm.h>
#include <vtkCallbackCommand.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkExecutive.h>
#include <vtkIdTypeArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <array>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

namespace kdstream::testing
{

using PolyData = vtkSmartPointer<vtkPolyData>;
using Ids = std::vector<vtkIdType>;

inline void AddCell(vtkCellArray* cells, const Ids& ids)
{
  cells->InsertNextCell(static_cast<vtkIdType>(ids.size()), ids.data());
}

// Numbers all points and cells in the arrays "Point" and "Cell".
inline void AddIds(vtkPolyData& mesh)
{
  const auto add = [](vtkDataSetAttributes* data, const char* name, vtkIdType count)
  {
    vtkNew<vtkIdTypeArray> ids;
    ids->SetName(name);
    for (vtkIdType i = 0; i < count; ++i)
    {
      ids->InsertNextValue(i);
    }
    data->AddArray(ids);
  };
  add(mesh.GetPointData(), "Point", mesh.GetNumberOfPoints());
  add(mesh.GetCellData(), "Cell", mesh.GetNumberOfCells());
}

// A mesh of points without cells.
inline PolyData MakePoints(const std::vector<std::array<double, 3>>& points, int type = VTK_DOUBLE)
{
  auto mesh = PolyData::New();
  vtkNew<vtkPoints> vtkpoints;
  vtkpoints->SetDataType(type);
  for (const auto& p : points)
  {
    vtkpoints->InsertNextPoint(p.data());
  }
  mesh->SetPoints(vtkpoints);
  return mesh;
}

// A triangulated surface over a grid of side × side points.
template <class Surface>
PolyData MakeGrid(int side, const Surface& surface, int type = VTK_FLOAT)
{
  std::vector<std::array<double, 3>> points;
  for (int v = 0; v < side; ++v)
  {
    for (int u = 0; u < side; ++u)
    {
      points.push_back(surface(double(u) / (side - 1), double(v) / (side - 1)));
    }
  }
  PolyData mesh = MakePoints(points, type);
  vtkNew<vtkCellArray> triangles;
  for (vtkIdType v = 0; v + 1 < side; ++v)
  {
    for (vtkIdType u = 0; u + 1 < side; ++u)
    {
      const vtkIdType p = v * side + u;
      AddCell(triangles, { p, p + 1, p + side });
      AddCell(triangles, { p + 1, p + side + 1, p + side });
    }
  }
  mesh->SetPolys(triangles);
  AddIds(*mesh);
  return mesh;
}

// A bumpy sphere. The points of its seam occur twice, and the triangles at its poles are
// degenerate.
inline PolyData MakeSphere(int side, int type = VTK_FLOAT)
{
  return MakeGrid(
    side,
    [](double u, double v)
    {
      const double pi = 3.14159265358979323846, a = 2 * pi * u, b = pi * v;
      const double r = 1 + 0.05 * std::sin(9 * a) * std::sin(7 * b);
      return std::array<double, 3>{ r * std::cos(a) * std::sin(b), r * std::sin(a) * std::sin(b),
        r * std::cos(b) };
    },
    type);
}

// A flat plate: all z are equal, and many x and y.
inline PolyData MakePlate(int side)
{
  return MakeGrid(side, [](double u, double v) { return std::array<double, 3>{ u, v, 0.25 }; });
}

// A single point, repeated side × side times.
inline PolyData MakeRepeatedPoint(int side)
{
  return MakeGrid(side, [](double, double) { return std::array<double, 3>{ 1, 2, 3 }; });
}

// All kinds of cells on the points of an 8 × 8 plate: a vertex, a poly-vertex, a line, a polyline,
// a triangle, a quad, a pentagon, a polygon of two points, and a strip.
inline PolyData MakeAllCells()
{
  PolyData mesh = MakePlate(8);
  vtkNew<vtkCellArray> vertices, lines, polygons, strips;
  AddCell(vertices, { 3 });
  AddCell(vertices, { 0, 63, 7 });
  AddCell(lines, { 0, 63 });
  AddCell(lines, { 8, 9, 17, 16 });
  AddCell(polygons, { 0, 1, 8 });
  AddCell(polygons, { 18, 19, 27, 26 });
  AddCell(polygons, { 32, 33, 34, 42, 40 });
  AddCell(polygons, { 5, 6 });
  AddCell(strips, { 44, 52, 45, 53, 46, 54 });
  mesh->SetVerts(vertices);
  mesh->SetLines(lines);
  mesh->SetPolys(polygons);
  mesh->SetStrips(strips);
  mesh->GetPointData()->Initialize();
  mesh->GetCellData()->Initialize();
  AddIds(*mesh);
  return mesh;
}

// Cells with any offsets and corners, as a file or vtkCellArray::SetData may contain them.
inline vtkSmartPointer<vtkCellArray> MakeCells(const Ids& offsets, const Ids& corners)
{
  const auto arrayOf = [](const Ids& values)
  {
    auto array = vtkSmartPointer<vtkIdTypeArray>::New();
    for (const vtkIdType value : values)
    {
      array->InsertNextValue(value);
    }
    return array;
  };
  auto cells = vtkSmartPointer<vtkCellArray>::New();
  cells->SetData(arrayOf(offsets), arrayOf(corners));
  return cells;
}

inline Ids CellPoints(vtkPolyData& mesh, vtkIdType cell)
{
  vtkNew<vtkIdList> points;
  mesh.GetCellPoints(cell, points);
  return Ids(points->begin(), points->end());
}

inline std::array<double, 3> Point(vtkPolyData& mesh, vtkIdType id)
{
  std::array<double, 3> point{};
  mesh.GetPoint(id, point.data());
  return point;
}

// All content of a vtkPolyData as text: two equal ones give the same text.
inline std::string Describe(vtkPolyData& mesh)
{
  std::ostringstream text;
  text << std::hexfloat << mesh.GetPoints()->GetDataType();
  for (vtkIdType i = 0; i < mesh.GetNumberOfPoints(); ++i)
  {
    const auto p = Point(mesh, i);
    text << '\n' << p[0] << ' ' << p[1] << ' ' << p[2];
  }
  for (vtkIdType c = 0; c < mesh.GetNumberOfCells(); ++c)
  {
    text << "\ncell " << mesh.GetCellType(c);
    for (const vtkIdType id : CellPoints(mesh, c))
    {
      text << ' ' << id;
    }
  }
  for (vtkDataSetAttributes* data :
    std::array<vtkDataSetAttributes*, 2>{ mesh.GetPointData(), mesh.GetCellData() })
  {
    for (int a = 0; a < data->GetNumberOfArrays(); ++a)
    {
      text << '\n' << data->GetArrayName(a) << ' ' << data->GetAbstractArray(a)->GetDataType();
      for (vtkIdType i = 0; i < data->GetAbstractArray(a)->GetNumberOfValues(); ++i)
      {
        text << ' ' << data->GetAbstractArray(a)->GetVariantValue(i).ToString();
      }
    }
  }
  return text.str();
}

// Observes a filter: records its errors (which are then not printed), its progress, and how often
// it ran. May abort the filter.
class FilterObserver
{
public:
  explicit FilterObserver(vtkAlgorithm* filter)
    : Filter(filter)
  {
    this->Command->SetClientData(this);
    this->Command->SetCallback([](vtkObject* caller, unsigned long event, void* self, void* data)
      { static_cast<FilterObserver*>(self)->Handle(caller, event, data); });
    for (const unsigned long event : { vtkCommand::ErrorEvent, vtkCommand::ProgressEvent,
           vtkCommand::StartEvent, vtkCommand::WarningEvent })
    {
      filter->AddObserver(event, this->Command);
    }
    filter->GetExecutive()->AddObserver(vtkCommand::ErrorEvent, this->Command);
  }
  ~FilterObserver()
  {
    this->Filter->RemoveObserver(this->Command);
    this->Filter->GetExecutive()->RemoveObserver(this->Command);
  }
  FilterObserver(const FilterObserver&) = delete;
  FilterObserver& operator=(const FilterObserver&) = delete;

  // Takes an abort back, so that the next Update executes: since VTK 9.3 no Update does this.
  void StopAborting()
  {
    this->abortAt = 2;
    this->Filter->AbortExecuteOff();
    this->Filter->Modified();
  }

  std::string error; // text of the filter's errors
  std::string warning;
  bool failed = false; // whether the pipeline was informed of the failure
  std::vector<double> progress;
  int runs = 0;
  double abortAt = 2; // progress at which to abort

private:
  void Handle(vtkObject* caller, unsigned long event, void* data)
  {
    if (event == vtkCommand::ErrorEvent)
    {
      (caller == this->Filter.Get() ? this->error : this->executiveError) +=
        static_cast<const char*>(data);
      this->failed |= caller != this->Filter.Get();
    }
    else if (event == vtkCommand::WarningEvent)
    {
      this->warning += static_cast<const char*>(data);
    }
    else if (event == vtkCommand::ProgressEvent)
    {
      this->progress.push_back(*static_cast<const double*>(data));
      if (this->progress.back() >= this->abortAt)
      {
        this->Filter->SetAbortExecute(1);
      }
    }
    else
    {
      ++this->runs;
    }
  }

  vtkSmartPointer<vtkAlgorithm> Filter;
  vtkNew<vtkCallbackCommand> Command;
  std::string executiveError;
};

// Checks how a setter treats vectors that are not finite. Returns the first that the setter
// accepts, or refuses without naming its member; empty if there is none.
template <class Filter>
std::string NotFiniteTakenBy(Filter& filter, const std::string& name,
  void (Filter::*set)(double, double, double), double* (Filter::*get)())
{
  (filter.*set)(1, 2, 3);
  for (const double bad : { std::numeric_limits<double>::quiet_NaN(),
         std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity() })
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      std::array<double, 3> vector{ 4, 5, 6 };
      vector[k] = bad;
      FilterObserver heard(&filter);
      const vtkMTimeType before = filter.GetMTime();
      (filter.*set)(vector[0], vector[1], vector[2]);
      const double* const now = (filter.*get)();
      const bool stays = now[0] == 1 && now[1] == 2 && now[2] == 3 && filter.GetMTime() == before;
      if (!stays || heard.error.find(name + " must be finite, not (") == std::string::npos)
      {
        return name + "[" + std::to_string(k) + "] = " + std::to_string(bad) + " " + heard.error;
      }
    }
  }
  return {};
}

}
