// SPDX-License-Identifier: BSD-3-Clause
// VTK's own formats: read by VTK.
#include "filters/adapter/PolyDataCells.h"
#include "filters/adapter/SharedArrays.h"
#include "filters/convert/ForeignMesh.h"
#include "filters/convert/LegacyVtk.h"
#include "filters/convert/PlainCopy.h"
#include "filters/convert/PolyDataParts.h"
#include "filters/convert/VtkMessages.h"
#include "filters/convert/VtkWords.h"
#include "filters/meshio/TextWords.h"

#include <vtkCallbackCommand.h>
#include <vtkCell.h>
#include <vtkCellData.h>
#include <vtkDataSet.h>
#include <vtkDataSetSurfaceFilter.h>
#include <vtkGenericCell.h>
#include <vtkGenericDataObjectReader.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>
#include <vtkStructuredGrid.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLDataParser.h>
#include <vtkXMLPolyDataReader.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <map>
#include <string>
#include <tuple>
#include <utility>

namespace kdstream
{
namespace
{

// The reader's progress goes to the execution; a reader does not stop on abort, so this does not
// either.
template <class Reader>
void Update(Reader& reader, const Execution& execution)
{
  vtkNew<vtkCallbackCommand> command;
  command->SetClientData(const_cast<Execution*>(&execution));
  command->SetCallback(
    [](vtkObject* caller, unsigned long, void* data, void* fraction)
    {
      const bool goOn =
        static_cast<Execution*>(data)->progress("read", *static_cast<const double*>(fraction));
      static_cast<vtkAlgorithm*>(caller)->SetAbortExecute(goOn ? 0 : 1);
    });
  reader.AddObserver(vtkCommand::ProgressEvent, command);
  reader.Update();
  reader.RemoveObserver(command);
}

// VTK reads as many points and cells as a piece counts; checks what its arrays have after them.
class CountingReader : public vtkXMLPolyDataReader
{
public:
  static CountingReader* New()
  {
    auto* const reader = new CountingReader; // under its base's name in messages
    reader->InitializeObjectBase();
    return reader;
  }

  Tolerance Surplus;

protected:
  int ReadPieceData() override
  {
    if (!vtkXMLPolyDataReader::ReadPieceData())
    {
      return 0;
    }
    const int piece = this->Piece;
    vtkXMLDataElement* const points = this->PointElements[piece];
    if (points && points->GetNumberOfNestedElements() > 0)
    {
      this->CheckBytesAfter(points->GetNestedElement(0), 3, this->NumberOfPoints[piece], "Points");
    }
    for (const auto& [elements, counts, name] :
      { std::tuple{ this->VertElements, this->NumberOfVerts, "Verts" },
        std::tuple{ this->LineElements, this->NumberOfLines, "Lines" },
        std::tuple{ this->StripElements, this->NumberOfStrips, "Strips" },
        std::tuple{ this->PolyElements, this->NumberOfPolys, "Polys" } })
    {
      if (vtkXMLDataElement* const offsets =
            elements[piece] ? this->FindDataArrayWithName(elements[piece], "offsets") : nullptr)
      {
        this->CheckBytesAfter(offsets, 1, counts[piece], name);
      }
    }
    return 1;
  }

private:
  void CheckBytesAfter(
    vtkXMLDataElement* array, std::uint64_t components, vtkIdType counted, const char* name)
  {
    int type = 0;
    if (!array->GetWordTypeAttribute("type", type))
    {
      return;
    }
    const VtkMessages notReported; // what is there was read
    constexpr std::size_t block = 4096;
    std::array<double, block> values{}; // of at most eight bytes
    // From the last known word on, because VTK fails if it must begin after the end.
    std::uint64_t known = static_cast<std::uint64_t>(counted) * components;
    for (std::size_t read = block; read == block;)
    {
      const std::uint64_t begin = known > 0 ? known - 1 : 0;
      vtkTypeInt64 offset = 0;
      const char* const format = array->GetAttribute("format");
      read = array->GetScalarAttribute("offset", offset)
               ? this->XMLParser->ReadAppendedData(offset, values.data(), begin, block, type)
               : this->XMLParser->ReadInlineData(array,
                   !format || std::strcmp(format, "binary") != 0 ? 1 : 0, values.data(), begin,
                   block, type);
      known = std::max(known, begin + read);
    }
    const std::uint64_t found = known - static_cast<std::uint64_t>(counted) * components;
    this->Surplus.Count(Lapse::NotCounted, found / components,
      std::string("NumberOf") + name + " is " + std::to_string(counted));
  }
};

// part: what is wrong with which part.
Error Damaged(const std::string& part)
{
  return { ErrorCode::InvalidInput, "is damaged, or is not as its header says: " + part };
}

// Checks that the cells of each part use existing points. Counts faces of fewer than three corners,
// which are dropped. Errors: InvalidInput naming part, cell and point.
Status CheckParts(vtkPolyData& mesh, Tolerance& tolerance)
{
  for (const auto& [cells, part] : { std::pair{ mesh.GetVerts(), "VERTICES: " },
         std::pair{ mesh.GetLines(), "LINES: " }, std::pair{ mesh.GetPolys(), "POLYGONS: " },
         std::pair{ mesh.GetStrips(), "TRIANGLE_STRIPS: " } })
  {
    const bool areFaces = cells == mesh.GetPolys() || cells == mesh.GetStrips();
    const Status right = ForEachCell(cells, 0, mesh.GetNumberOfPoints(),
      [&, named = part](vtkIdType cell, std::span<const vtkIdType> corners)
      {
        if (areFaces && corners.size() < 3)
        {
          tolerance.Count(
            Lapse::FaceTooSmall, 1, std::string(named) + "cell " + std::to_string(cell));
        }
      });
    if (!right)
    {
      return Error{ right.GetError().code, part + right.GetError().message };
    }
  }
  return {};
}

Result<ForeignMesh> Finish(vtkPolyData* output, VtkMessages& messages, const Execution& execution)
{
  Tolerance small;
  KDSTREAM_TRY(CheckParts(*output, small));
  KDSTREAM_TRY(execution.Report("read", 1));
  Result<ForeignMesh> mesh = ReadPolyData(*output, execution);
  if (mesh)
  {
    mesh->tolerance.Add(small);
    for (const std::string& warning : messages.TakeWarnings())
    {
      std::string own = VtkWarning(warning);
      if (!own.empty())
      {
        mesh->warnings.push_back(std::move(own));
      }
    }
  }
  return mesh;
}

// A type of cells: its name, empty if VTK does not know it, and the number of its points; 0: any
// number.
struct CellShape
{
  std::string name{};
  vtkIdType points = 0;
};

CellShape ShapeOf(int type)
{
  const auto cell = vtkSmartPointer<vtkCell>::Take(vtkGenericCell::InstantiateCell(type));
  if (!cell)
  {
    return {};
  }
  constexpr std::size_t prefix = 3; // "vtk"
  return { LowercaseText(std::string(cell->GetClassName()).substr(prefix)),
    type < VTK_CONVEX_POINT_SET ? cell->GetNumberOfPoints() : 0 };
}

Status CheckCellsOf(vtkUnstructuredGrid& grid)
{
  vtkCellArray* const cells = grid.GetCells();
  vtkUnsignedCharArray* const types = grid.GetCellTypesArray();
  const vtkIdType count = types ? types->GetNumberOfValues() : 0;
  if (cells && cells->GetNumberOfCells() != count)
  {
    return Error{ ErrorCode::InvalidInput, "holds the types of " + std::to_string(count) +
                                             " cells for " +
                                             std::to_string(cells->GetNumberOfCells()) };
  }
  std::map<int, CellShape> shapes;
  Status fits;
  vtkIdType visited = 0;
  const Status right = ForEachCell(cells, 0, grid.GetNumberOfPoints(),
    [&](vtkIdType cell, std::span<const vtkIdType> corners)
    {
      ++visited;
      const int type = types->GetValue(cell);
      const auto [entry, isNew] = shapes.try_emplace(type);
      entry->second = isNew ? ShapeOf(type) : entry->second;
      const auto& [name, points] = entry->second;
      if (fits &&
          (name.empty() || (points > 0 && points != static_cast<vtkIdType>(corners.size()))))
      {
        fits = Error{ ErrorCode::InvalidInput,
          "CELLS: cell " + std::to_string(cell) + " of the type " + std::to_string(type) + " has " +
            std::to_string(corners.size()) + " points, " +
            (name.empty() ? "and this type is unknown"
                          : "not " + std::to_string(points) + " as a " + name + " has") };
      }
    });
  if (!right)
  {
    const std::string name =
      visited < count ? ShapeOf(types->GetValue(visited)).name : std::string();
    return Error{ right.GetError().code,
      "CELLS: " + right.GetError().message + (name.empty() ? "" : " (it is a " + name + ")") };
  }
  return fits;
}

// Checks what VTK's filters assume of a grid: that its cells are valid, and that it has as many
// points as it says. Arrays of a wrong length are removed, and listed.
Status CheckGrid(vtkDataSet& grid, std::vector<std::string>& dropped)
{
  if (auto* const cells = vtkUnstructuredGrid::SafeDownCast(&grid))
  {
    KDSTREAM_TRY(CheckCellsOf(*cells));
  }
  if (auto* const structured = vtkStructuredGrid::SafeDownCast(&grid))
  {
    int sides[3];
    structured->GetDimensions(sides);
    const double points = double(sides[0]) * double(sides[1]) * double(sides[2]);
    if (points != static_cast<double>(grid.GetNumberOfPoints()))
    {
      return Error{ ErrorCode::InvalidInput, "holds " + std::to_string(grid.GetNumberOfPoints()) +
                                               " points for a grid of " + std::to_string(sides[0]) +
                                               " x " + std::to_string(sides[1]) + " x " +
                                               std::to_string(sides[2]) };
    }
  }
  RemoveUnusableArrays({ grid.GetPointData(), grid.GetNumberOfPoints() }, "point", dropped);
  RemoveUnusableArrays({ grid.GetCellData(), grid.GetNumberOfCells() }, "cell", dropped);
  return {};
}

}

namespace
{

// vtkNotFinite becomes NaN again.
void ReplaceSentinels(Mesh& mesh)
{
  const double sentinel = std::strtod(vtkNotFinite, nullptr);
  const auto singleSentinel = double(static_cast<float>(sentinel));
  const auto isSentinel = [&](double value)
  { return value == sentinel || value == singleSentinel; };
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  for (Vec3& point : mesh.points)
  {
    std::replace_if(point.begin(), point.end(), isSentinel, nan);
  }
  for (Attribute& array : mesh.attributes)
  {
    const bool isReal =
      array.type == AttributeType::Float32 || array.type == AttributeType::Float64;
    const std::size_t tuples = isReal ? array.TupleCount() : 0;
    for (std::size_t i = 0; i < tuples; ++i)
    {
      for (std::size_t k = 0; k < array.components; ++k)
      {
        if (isSentinel(array.Get(i, k)))
        {
          array.Set(i, k, nan);
        }
      }
    }
  }
}

Result<ForeignMesh> ReadVtkText(
  const std::filesystem::path& file, const VtkDamage& damage, const Execution& execution)
{
  VtkMessages messages;
  vtkNew<vtkGenericDataObjectReader> reader;
  reader->SetFileName(file.c_str());
  for (const auto readAll :
    { &vtkGenericDataObjectReader::ReadAllScalarsOn, &vtkGenericDataObjectReader::ReadAllVectorsOn,
      &vtkGenericDataObjectReader::ReadAllNormalsOn, &vtkGenericDataObjectReader::ReadAllFieldsOn,
      &vtkGenericDataObjectReader::ReadAllColorScalarsOn,
      &vtkGenericDataObjectReader::ReadAllTCoordsOn })
  {
    (*reader.*readAll)();
  }
  Update(*reader, execution);
  vtkDataObject* const output = reader->GetOutput();
  const std::vector<std::string> errors = messages.Errors();
  if (!errors.empty())
  {
    const bool isBlamed = errors.front().find(damage.unknownWord) != std::string::npos;
    return Damaged(isBlamed && !damage.part.empty() ? damage.part : damage.lastPart);
  }
  if (vtkPolyData* const mesh = vtkPolyData::SafeDownCast(output))
  {
    return Finish(mesh, messages, execution);
  }
  auto* const grid = vtkDataSet::SafeDownCast(output);
  if (!grid)
  {
    return Error{ ErrorCode::InvalidInput,
      "holds " + std::string(output ? output->GetClassName() : "nothing") +
        ", which is not a mesh" };
  }
  std::vector<std::string> dropped;
  KDSTREAM_TRY(CheckGrid(*grid, dropped));
  vtkNew<vtkDataSetSurfaceFilter> surface;
  surface->SetInputData(grid);
  surface->Update();
  Result<ForeignMesh> mesh = Finish(surface->GetOutput(), messages, execution);
  if (mesh)
  {
    for (const std::string& array : dropped)
    {
      mesh->warnings.push_back("dropped: " + array);
    }
    mesh->warnings.push_back(
      "holds " + std::string(output->GetClassName()) + ", whose surface is used");
  }
  return mesh;
}

}

Result<ForeignMesh> ReadVtp(const std::filesystem::path& file, const Execution& execution)
{
  Tolerance tolerance;
  const Result<PlainCopy> plain = PlainCopy::OfXml(file, tolerance);
  KDSTREAM_TRY(plain);
  VtkMessages messages;
  vtkNew<CountingReader> reader;
  reader->SetFileName(plain->File().c_str());
  Update(*reader, execution);
  if (const std::vector<std::string> errors = messages.Errors(); !errors.empty())
  {
    return Damaged(XmlDamage(errors, plain->File()));
  }
  Result<ForeignMesh> mesh = Finish(reader->GetOutput(), messages, execution);
  if (mesh)
  {
    mesh->tolerance.Add(tolerance);
    mesh->tolerance.Add(reader->Surplus);
  }
  return mesh;
}

Result<ForeignMesh> ReadVtk(const std::filesystem::path& file, const Execution& execution)
{
  Tolerance tolerance;
  const Result<PlainCopy> plain = PlainCopy::OfVtk(file, false, tolerance);
  KDSTREAM_TRY(plain);
  const VtkDamage damage = FindVtkDamage(plain->File());
  if (damage.isCut)
  {
    return Damaged(damage.part);
  }
  const Result<PlainCopy> ordered = PlainCopy::WithDatasetFirst(plain->File(), damage.order);
  KDSTREAM_TRY(ordered);
  Tolerance counted; // already
  const Result<PlainCopy> numbers =
    PlainCopy::OfVtk(ordered->File(), damage.hasOtherNumbers, counted);
  KDSTREAM_TRY(numbers);
  Result<ForeignMesh> mesh = ReadVtkText(numbers->File(), damage, execution);
  if (mesh)
  {
    mesh->tolerance.Add(tolerance);
    mesh->tolerance.Add(damage.forgiven);
  }
  if (mesh && damage.hasOtherNumbers)
  {
    ReplaceSentinels(mesh->mesh);
  }
  return mesh;
}

}
