// SPDX-License-Identifier: BSD-3-Clause
// Reads VTK's own formats, by VTK.
#include "filters/adapter/PolyDataCells.h"
#include "filters/adapter/SharedArrays.h"
#include "filters/convert/ForeignMesh.h"
#include "filters/convert/LegacyVtk.h"
#include "filters/convert/PlainCopy.h"
#include "filters/convert/PolyDataParts.h"
#include "filters/convert/VtkMessages.h"
#include "filters/convert/VtkWords.h"
#include "filters/core/Texts.h"
#include "filters/core/VectorMath.h"
#include "filters/meshio/TextWords.h"

#include <vtkCallbackCommand.h>
#include <vtkCell.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDataSet.h>
#include <vtkDataSetSurfaceFilter.h>
#include <vtkGenericCell.h>
#include <vtkGenericDataObjectReader.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkRectilinearGrid.h>
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
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace kdstream
{
namespace
{

// Sends the reader's progress to the execution. VTK's readers do not stop when asked to abort, so
// neither does this function.
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

// VTK reads as many points and cells as a piece declares; this class counts the ones after these.
// It also reads files that VTK does not: those whose first piece is empty, and those that list
// where cells begin instead of where they end.
class CountingReader : public vtkXMLPolyDataReader
{
public:
  static CountingReader* New()
  {
    auto* const reader = new CountingReader; // messages show the name of the base class
    reader->InitializeObjectBase();
    return reader;
  }

  Tolerance Surplus;
  std::set<std::string> Dropped; // names of arrays that are not read
  std::string Wrong;             // errors that VTK does not report

protected:
  // VTK reads the arrays that the first piece has from all pieces. If the first piece is empty,
  // takes the arrays of the next one that is not.
  int ReadPrimaryElement(vtkXMLDataElement* element) override
  {
    if (!vtkXMLPolyDataReader::ReadPrimaryElement(element))
    {
      return 0;
    }
    std::vector<vtkIdType> points, cells; // of each piece
    for (int i = 0; i < this->NumberOfPieces; ++i)
    {
      points.push_back(this->NumberOfPoints[i]);
      cells.push_back(this->NumberOfVerts[i] + this->NumberOfLines[i] + this->NumberOfStrips[i] +
                      this->NumberOfPolys[i]);
    }
    this->CheckPointTypes(points);
    this->AlignArrays(this->PointDataElements, points);
    this->AlignArrays(this->CellDataElements, cells);
    this->IsFirstEmpty = !points.empty() && points[0] == 0;
    for (const auto& [ofPieces, counts] :
      { std::pair{ this->PointElements, &points }, std::pair{ this->PointDataElements, &points },
        std::pair{ this->CellDataElements, &cells } })
    {
      const auto first =
        std::find_if(counts->begin(), counts->end(), [](vtkIdType count) { return count > 0; });
      if (first != counts->end())
      {
        ofPieces[0] = ofPieces[first - counts->begin()];
      }
    }
    return 1;
  }

  int ReadPieceData() override
  {
    if (!vtkXMLPolyDataReader::ReadPieceData())
    {
      return 0;
    }
    const int piece = this->Piece;
    auto* const output = vtkPolyData::SafeDownCast(this->GetCurrentOutput());
    vtkXMLDataElement* const points = this->PointElements[piece];
    const bool isOfAnother = piece == 0 && this->IsFirstEmpty;
    if (!isOfAnother && points && points->GetNumberOfNestedElements() > 0)
    {
      this->CountSurplus(
        this->WordsAfter(points->GetNestedElement(0), 3 * this->NumberOfPoints[piece]) / 3,
        this->NumberOfPoints[piece], "Points");
    }
    for (const auto& [elements, counts, cells, name] :
      { std::tuple{ this->VertElements, this->NumberOfVerts, output->GetVerts(), "Verts" },
        std::tuple{ this->LineElements, this->NumberOfLines, output->GetLines(), "Lines" },
        std::tuple{ this->StripElements, this->NumberOfStrips, output->GetStrips(), "Strips" },
        std::tuple{ this->PolyElements, this->NumberOfPolys, output->GetPolys(), "Polys" } })
    {
      const vtkIdType counted = counts[piece];
      vtkXMLDataElement* const offsets =
        elements[piece] ? this->FindDataArrayWithName(elements[piece], "offsets") : nullptr;
      if (!offsets)
      {
        continue;
      }
      const std::uint64_t surplus = this->WordsAfter(offsets, counted);
      const vtkIdType first = cells->GetNumberOfCells() - counted;
      // The file lists where each cell begins, as VTK keeps it in memory, not where it ends. VTK
      // then takes the first cell for an empty one, and does not read the last one.
      const bool areBegins =
        surplus == 1 && counted > 0 && first >= 0 && cells->GetCellSize(first) == 0;
      if (areBegins && !this->MoveCells(elements[piece], counted, *cells))
      {
        vtkErrorMacro("Cannot read cells from "
                      << name << " in piece " << piece
                      << " because the \"connectivity\" array is not long enough");
        return 0;
      }
      this->CountSurplus(areBegins ? 0 : surplus, counted, name);
    }
    return 1;
  }

private:
  // VTK reads the points of all pieces in the type of the first piece.
  void CheckPointTypes(const std::vector<vtkIdType>& points)
  {
    std::set<std::string> types;
    for (std::size_t i = 0; i < points.size(); ++i)
    {
      vtkXMLDataElement* const piece = points[i] > 0 ? this->PointElements[i] : nullptr;
      if (piece && piece->GetNumberOfNestedElements() > 0)
      {
        const char* const type = piece->GetNestedElement(0)->GetAttribute("type");
        types.insert(type ? type : "");
      }
    }
    if (types.size() > 1)
    {
      this->Wrong = "the points of its pieces are of several types: " + *types.begin() + " and " +
                    *std::next(types.begin());
    }
  }

  // VTK matches the arrays of pieces by their position, whatever their names and types are. For an
  // array that a piece lacks, it takes uninitialized memory. Keeps only the arrays that all pieces
  // have, in the order of the first piece.
  void AlignArrays(vtkXMLDataElement** ofPieces, const std::vector<vtkIdType>& tuples)
  {
    using Arrays = std::map<std::string, vtkSmartPointer<vtkXMLDataElement>>;
    std::vector<std::pair<vtkXMLDataElement*, Arrays>> pieces;
    std::vector<std::string> names; // each with its type
    std::map<std::string, std::size_t> uses;
    for (std::size_t i = 0; i < tuples.size(); ++i)
    {
      if (tuples[i] == 0)
      {
        continue;
      }
      Arrays arrays;
      vtkXMLDataElement* const piece = ofPieces[i];
      for (int k = 0; piece && k < piece->GetNumberOfNestedElements(); ++k)
      {
        vtkXMLDataElement* const array = piece->GetNestedElement(k);
        const char* const name = array->GetAttribute("Name");
        const char* const components = array->GetAttribute("NumberOfComponents");
        const char* const type = array->GetAttribute("type");
        const std::string key = std::string(name ? name : "") + '\n' +
                                (components ? components : "1") + (type ? type : "");
        if (arrays.emplace(key, array).second && ++uses[key] == 1)
        {
          names.push_back(key);
        }
      }
      pieces.push_back({ piece, std::move(arrays) });
    }
    if (pieces.size() < 2)
    {
      return;
    }
    for (const auto& [piece, arrays] : pieces)
    {
      if (piece)
      {
        piece->RemoveAllNestedElements();
      }
      for (const std::string& name : names)
      {
        if (uses[name] == pieces.size())
        {
          piece->AddNestedElement(arrays.at(name));
        }
        else
        {
          this->Dropped.insert(name.substr(0, name.find('\n')));
        }
      }
    }
  }

  // The numbers of a list from `begin` on; empty if it has fewer than `count` of them.
  std::vector<vtkIdType> NumbersOf(vtkXMLDataElement* list, vtkIdType begin, vtkIdType count)
  {
    const auto array = vtkSmartPointer<vtkAbstractArray>::Take(this->CreateArray(list));
    auto* const numbers = vtkDataArray::SafeDownCast(array);
    std::vector<vtkIdType> found;
    constexpr vtkIdType atOnce = 4096; // so that memory grows only with the list
    while (numbers && static_cast<vtkIdType>(found.size()) < count)
    {
      const auto done = static_cast<vtkIdType>(found.size());
      const vtkIdType some = std::min(atOnce, count - done);
      numbers->SetNumberOfComponents(1);
      numbers->SetNumberOfTuples(some);
      if (!this->ReadArrayValues(list, 0, numbers, begin + done, some))
      {
        return {};
      }
      for (vtkIdType i = 0; i < some; ++i)
      {
        found.push_back(static_cast<vtkIdType>(numbers->GetComponent(i, 0)));
      }
    }
    return found;
  }

  // Removes the empty first cell of a piece, and reads the last one. False if the file lacks the
  // last one.
  bool MoveCells(vtkXMLDataElement* lists, vtkIdType counted, vtkCellArray& cells)
  {
    const std::vector<vtkIdType> ends =
      this->NumbersOf(this->FindDataArrayWithName(lists, "offsets"), counted - 1, 2);
    if (ends.size() < 2 || ends[0] < 0 || ends[1] <= ends[0])
    {
      return false;
    }
    std::vector<vtkIdType> last = this->NumbersOf(
      this->FindDataArrayWithName(lists, "connectivity"), ends[0], ends[1] - ends[0]);
    for (vtkIdType& corner : last)
    {
      corner += this->StartPoint; // the first point of the piece
    }
    vtkNew<vtkCellArray> moved;
    const vtkIdType empty = cells.GetNumberOfCells() - counted;
    for (vtkIdType cell = 0; cell < cells.GetNumberOfCells(); ++cell)
    {
      vtkIdType size = 0;
      const vtkIdType* corners = nullptr;
      cells.GetCellAtId(cell, size, corners);
      if (cell != empty)
      {
        moved->InsertNextCell(size, corners);
      }
    }
    moved->InsertNextCell(static_cast<vtkIdType>(last.size()), last.data());
    cells.ShallowCopy(moved);
    return !last.empty();
  }

  // How many words an array has after the first `words` of them.
  std::uint64_t WordsAfter(vtkXMLDataElement* array, vtkIdType words)
  {
    int type = 0;
    if (!array->GetWordTypeAttribute("type", type))
    {
      return 0;
    }
    const VtkMessages notReported; // errors do not matter: the array has been read
    constexpr std::size_t block = 4096;
    std::array<double, block> values{}; // room for words of up to eight bytes
    // Begins with the last known word, because VTK fails if it must begin after the end.
    auto known = static_cast<std::uint64_t>(words);
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
    return known - static_cast<std::uint64_t>(words);
  }

  void CountSurplus(std::uint64_t found, vtkIdType counted, const char* name)
  {
    this->Surplus.Count(
      Lapse::NotCounted, found, std::string("NumberOf") + name + " is " + std::to_string(counted));
  }

  bool IsFirstEmpty = false;
};

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

// A type of cell: its name, empty if VTK does not know the type; and the number of its points, 0 if
// it may have any number.
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

// VTK orders the corners of a solid cell so that its faces look outward. Faces look inward if the
// grid is mirrored or has a negative spacing, or if its program orders the corners differently:
// this is often so for prisms. Flips such faces of a grid's surface. cells: the cell of each face.
void TurnFacesOutward(vtkDataSet& grid, vtkDataArray& cells, vtkPolyData& surface)
{
  vtkCellArray& faces = *surface.GetPolys();
  const vtkIdType first = surface.GetNumberOfVerts() + surface.GetNumberOfLines();
  const auto pointsOf = [](vtkDataSet& data, vtkIdList& corners)
  {
    std::vector<Vec3> points;
    for (const vtkIdType corner : corners)
    {
      const double* const at = data.GetPoint(corner);
      points.push_back({ at[0], at[1], at[2] });
    }
    return points;
  };
  const auto middleOf = [](const std::vector<Vec3>& points)
  {
    const Vec3 sum = std::accumulate(points.begin(), points.end(), Vec3{}, Plus<double>);
    return Times(sum, 1 / static_cast<double>(points.size()));
  };
  vtkNew<vtkIdList> inCell, inFace;
  for (vtkIdType face = 0; face < faces.GetNumberOfCells(); ++face)
  {
    const auto cell = static_cast<vtkIdType>(cells.GetComponent(first + face, 0));
    // Cells of arbitrary shape have no order of corners that could be wrong.
    const int type = grid.GetCellType(cell);
    if (type == VTK_CONVEX_POINT_SET || type == VTK_POLYHEDRON ||
        grid.GetCell(cell)->GetCellDimension() < 3)
    {
      continue;
    }
    grid.GetCellPoints(cell, inCell);
    faces.GetCellAtId(face, inFace);
    const std::vector<Vec3> corners = pointsOf(surface, *inFace);
    const Vec3 middle = middleOf(corners);
    Vec3 normal{};
    for (std::size_t i = 0; i < corners.size(); ++i)
    {
      const Vec3& next = corners[(i + 1) % corners.size()];
      normal = Plus(normal, Cross(Minus(corners[i], middle), Minus(next, middle)));
    }
    if (Dot(normal, Minus(middle, middleOf(pointsOf(grid, *inCell)))) < 0)
    {
      faces.ReverseCellAtId(face);
    }
  }
}

// Checks two things that VTK's filters rely on: that a grid's cells are valid, and that it has as
// many points as it says. Arrays of a wrong length are removed, and listed.
Status CheckGrid(vtkDataSet& grid, std::vector<std::string>& dropped)
{
  if (auto* const cells = vtkUnstructuredGrid::SafeDownCast(&grid))
  {
    KDSTREAM_TRY(CheckCellsOf(*cells));
  }
  if (auto* const rectilinear = vtkRectilinearGrid::SafeDownCast(&grid))
  {
    int sides[3];
    rectilinear->GetDimensions(sides);
    vtkDataArray* const all[] = { rectilinear->GetXCoordinates(), rectilinear->GetYCoordinates(),
      rectilinear->GetZCoordinates() };
    for (std::size_t k = 0; k < 3; ++k)
    {
      const vtkIdType count = all[k] ? all[k]->GetNumberOfTuples() : 0;
      if (count != sides[k])
      {
        return Error{ ErrorCode::InvalidInput,
          std::string("holds ") + std::to_string(count) + " " + "XYZ"[k] +
            "_COORDINATES, but DIMENSIONS requires " + std::to_string(sides[k]) };
      }
    }
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

// Turns vtkNotFinite back into NaN.
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
    return DamagedVtk(isBlamed && !damage.part.empty() ? damage.part : damage.lastPart);
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
  constexpr const char* cellNumbers = "kdstreamCell";
  vtkNew<vtkDataSetSurfaceFilter> surface;
  surface->SetInputData(grid);
  surface->PassThroughCellIdsOn();
  surface->SetOriginalCellIdsName(cellNumbers);
  surface->Update();
  vtkCellData& ofFaces = *surface->GetOutput()->GetCellData();
  if (vtkDataArray* const cells = ofFaces.GetArray(cellNumbers))
  {
    TurnFacesOutward(*grid, *cells, *surface->GetOutput());
  }
  ofFaces.RemoveArray(cellNumbers);
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
  if (!reader->Wrong.empty())
  {
    return DamagedVtk(reader->Wrong);
  }
  if (const std::vector<std::string> errors = messages.Errors(); !errors.empty())
  {
    return DamagedVtk(XmlDamage(errors, plain->File()));
  }
  Result<ForeignMesh> mesh = Finish(reader->GetOutput(), messages, execution);
  if (mesh)
  {
    mesh->tolerance.Add(tolerance);
    mesh->tolerance.Add(reader->Surplus);
    for (const std::string& array : reader->Dropped)
    {
      mesh->warnings.push_back(
        "array " + Quoted(array) + " is dropped: not all pieces have it, of one type");
    }
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
    return DamagedVtk(damage.part);
  }
  const Result<PlainCopy> ordered = PlainCopy::WithDatasetFirst(plain->File(), damage.order);
  KDSTREAM_TRY(ordered);
  Tolerance counted; // what was already counted
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
