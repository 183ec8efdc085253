// SPDX-License-Identifier: BSD-3-Clause
// VRML 2: scenes of many parts, read by VTK and joined to one mesh.
#include "filters/convert/FloatCoordinates.h"
#include "filters/convert/ForeignMesh.h"
#include "filters/convert/JoinParts.h"
#include "filters/convert/PolyDataParts.h"
#include "filters/convert/VtkMessages.h"
#include "filters/meshio/ByteSource.h"

#include <vtkActor.h>
#include <vtkActorCollection.h>
#include <vtkLookupTable.h>
#include <vtkMapper.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkRendererCollection.h>
#include <vtkTransform.h>
#include <vtkTransformPolyDataFilter.h>
#include <vtkVRMLImporter.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <sstream>

namespace kdstream
{
namespace
{

Status CheckVrmlHeader(const std::filesystem::path& file)
{
  Result<ByteSource> source = ByteSource::Open(file);
  KDSTREAM_TRY(source);
  const Result<std::string_view> head = source->Peek(10);
  KDSTREAM_TRY(head);
  if (head->substr(0, 10) != "#VRML V2.0")
  {
    return Error{ ErrorCode::InvalidInput, head->substr(0, 5) == "#VRML"
                                             ? "is of another version than VRML 2"
                                             : "is not a VRML 2 file" };
  }
  return {};
}

// What is written to std::cerr while one lives: VTK's parser of VRML tells of errors there only,
// and keeps what it had read before.
class CapturedErrors
{
public:
  CapturedErrors()
    : Before(std::cerr.rdbuf(this->Text.rdbuf()))
  {
  }
  ~CapturedErrors() { std::cerr.rdbuf(this->Before); }
  CapturedErrors(const CapturedErrors&) = delete;
  CapturedErrors& operator=(const CapturedErrors&) = delete;

  std::string Get() const { return PlainVtkMessage(this->Text.str()); }

private:
  std::ostringstream Text;
  std::streambuf* Before;
};

// The colour that a material has which names none. A shape without a material is white.
constexpr double vrmlGrey = 0.8;

Result<ForeignMesh> ReadActor(vtkActor& actor, const Execution& execution)
{
  auto* const mapper = vtkPolyDataMapper::SafeDownCast(actor.GetMapper());
  if (!mapper || mapper->GetNumberOfInputConnections(0) == 0)
  {
    return ForeignMesh{};
  }
  mapper->GetInputAlgorithm()->Update();
  vtkPolyData* const shape = mapper->GetInput();
  vtkNew<vtkTransform> place;
  place->SetMatrix(actor.GetMatrix());
  vtkNew<vtkTransformPolyDataFilter> moved;
  moved->SetInputData(shape);
  moved->SetTransform(place);
  moved->Update();
  Result<ForeignMesh> part = ReadPolyData(*moved->GetOutput(), execution);
  KDSTREAM_TRY(part);
  Mesh& mesh = part->mesh;
  // Of arrays that the importer itself needs.
  part->warnings.erase(
    std::remove_if(part->warnings.begin(), part->warnings.end(),
      [](const std::string& warning) { return warning.rfind("dropped: ", 0) == 0; }),
    part->warnings.end());
  mesh.attributes.erase(
    std::remove_if(mesh.attributes.begin(), mesh.attributes.end(),
      [](const Attribute& attribute) { return RoleOf(attribute) == AttributeRole::Other; }),
    mesh.attributes.end());
  // The importer confuses the numbers of colours; its table has the colours themselves in order,
  // which is that of the points where there are as many.
  auto* const table = mapper->GetScalarVisibility()
                        ? vtkLookupTable::SafeDownCast(mapper->GetLookupTable())
                        : nullptr;
  const auto points = static_cast<vtkIdType>(mesh.points.size());
  const bool colored = table && points > 0 && table->GetNumberOfTableValues() == points;
  if (table && !colored)
  {
    part->warnings.push_back("colours are dropped: there are not as many as vertices");
  }
  double diffuse[3];
  actor.GetProperty()->GetDiffuseColor(diffuse);
  if (colored)
  {
    std::vector<Color> colors(mesh.points.size(), Color{ 1, 1, 1, 1 });
    for (std::size_t i = 0; i < colors.size(); ++i)
    {
      const double* const value = table->GetTableValue(static_cast<vtkIdType>(i));
      std::copy(value, value + 3, colors[i].begin());
    }
    AddColors(mesh, colors);
  }
  else if (std::any_of(
             diffuse, diffuse + 3, [](double v) { return std::abs(v - vrmlGrey) > 0.01; }) &&
           std::any_of(diffuse, diffuse + 3, [](double v) { return v < 1; }))
  {
    AddColors(
      mesh, std::vector<Color>(mesh.points.size(), Color{ diffuse[0], diffuse[1], diffuse[2], 1 }));
  }
  return part;
}

}

Result<ForeignMesh> ReadVrml(const std::filesystem::path& file, const Execution& execution)
{
  KDSTREAM_TRY(CheckVrmlHeader(file));
  VtkMessages messages;
  vtkNew<vtkVRMLImporter> importer;
  importer->SetFileName(file.c_str());
  KDSTREAM_TRY(execution.Report("read", 0));
  {
    const CapturedErrors errors;
    importer->Update();
    if (!errors.Get().empty())
    {
      return Error{ ErrorCode::InvalidInput, errors.Get() };
    }
  }
  KDSTREAM_TRY(messages.FirstError());
  if (!importer->GetRenderer())
  {
    return Error{ ErrorCode::InvalidInput, "is not a VRML 2 file" };
  }
  std::vector<ForeignMesh> parts;
  vtkActorCollection* const actors = importer->GetRenderer()->GetActors();
  vtkCollectionSimpleIterator position;
  actors->InitTraversal(position);
  while (vtkActor* const actor = actors->GetNextActor(position))
  {
    Result<ForeignMesh> part = ReadActor(*actor, execution);
    KDSTREAM_TRY(part);
    parts.push_back(std::move(*part));
  }
  Result<ForeignMesh> joined = JoinParts(parts);
  KDSTREAM_TRY(joined);
  for (std::string& warning : messages.TakeWarnings())
  {
    joined->warnings.push_back(std::move(warning));
  }
  WarnOfFloats(*joined);
  return joined;
}

}
