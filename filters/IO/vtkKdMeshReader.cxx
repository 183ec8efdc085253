// SPDX-License-Identifier: BSD-3-Clause
#include "vtkKdMeshReader.h"

#include "filters/adapter/AlgorithmExecution.h"
#include "filters/adapter/ArraySelections.h"
#include "filters/adapter/ErrorCodes.h"
#include "filters/adapter/MeshPolyData.h"
#include "filters/build/BuildInput.h"
#include "filters/core/Weld.h"
#include "filters/meshio/MeshReader.h"

#include <vtkDataArraySelection.h>
#include <vtkErrorCode.h>
#include <vtkInformation.h>
#include <vtkInformationIdTypeKey.h>
#include <vtkInformationInformationVectorKey.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>
#include <vtkPolyData.h>
#include <vtkStreamingDemandDrivenPipeline.h>

#include <algorithm>
#include <string>

vtkStandardNewMacro(vtkKdMeshReader);

vtkInformationKeyMacro(vtkKdMeshReader, NUMBER_OF_POINTS, IdType);
vtkInformationKeyMacro(vtkKdMeshReader, NUMBER_OF_CELLS, IdType);

namespace
{

using namespace kdstream;

Result<std::unique_ptr<MeshReader>> OpenFile(const char* name, const Execution& execution)
{
  if (!name || !*name)
  {
    return Error{ ErrorCode::NotFound, "no FileName is set" };
  }
  return MeshReader::Open(name, execution);
}

Result<Mesh> ReadFile(
  const char* name, bool merging, const Execution& execution, Tolerance& tolerance)
{
  const auto reader = OpenFile(name, execution);
  KDSTREAM_TRY(reader);
  Result<Mesh> mesh = ReadMesh(**reader, BuildOptions(), execution);
  tolerance = (*reader)->Info().tolerance;
  if (mesh && merging && (*reader)->Info().soup)
  {
    WeldVertices(*mesh, execution);
  }
  return mesh;
}

void Tell(const MeshFileInfo& file, bool merging, const ArraySelections& selections,
  vtkInformation& outInfo)
{
  const auto points = static_cast<vtkIdType>(file.vertices);
  ArrayFacts facts;
  if (!file.soup || !merging)
  {
    facts.points = points;
    outInfo.Set(vtkKdMeshReader::NUMBER_OF_POINTS(), points);
  }
  outInfo.Set(vtkKdMeshReader::NUMBER_OF_CELLS(),
    file.faces > 0 ? static_cast<vtkIdType>(file.faces) : points);
  selections.Tell(file.attributes, facts, outInfo);
}

// Removes the information about another file.
void Forget(vtkInformation& outInfo)
{
  outInfo.Remove(vtkKdMeshReader::NUMBER_OF_POINTS());
  outInfo.Remove(vtkKdMeshReader::NUMBER_OF_CELLS());
  outInfo.Remove(vtkDataObject::POINT_DATA_VECTOR());
  outInfo.Remove(vtkDataObject::CELL_DATA_VECTOR());
}

}

vtkKdMeshReader::vtkKdMeshReader()
{
  this->SetNumberOfInputPorts(0);
}

vtkKdMeshReader::~vtkKdMeshReader()
{
  this->SetFileName(nullptr);
}

int vtkKdMeshReader::CanReadFile(const char* name)
{
  return name && MeshReader::Open(name) ? 1 : 0;
}

vtkMTimeType vtkKdMeshReader::GetMTime()
{
  return std::max(
    { this->Superclass::GetMTime(), this->PointArrays->GetMTime(), this->CellArrays->GetMTime() });
}

int vtkKdMeshReader::RequestInformation(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector)
{
  vtkInformation& outInfo = *outputVector->GetInformationObject(0);
  Forget(outInfo);
  if (!this->FileName || !*this->FileName)
  {
    return 1; // panels ask before a file is chosen; RequestData refuses
  }
  const auto reader = OpenFile(this->FileName, MakeAlgorithmExecution(*this, {}));
  if (!reader)
  {
    if (reader.GetError().code != ErrorCode::Cancelled)
    {
      this->SetErrorCode(VtkErrorCodeOf(reader.GetError()));
      vtkErrorMacro(<< this->FileName << ": " << reader.GetError().message);
    }
    return 0;
  }
  const ArraySelections selections(*this->PointArrays, *this->CellArrays);
  selections.Follow((*reader)->Info().attributes);
  Tell((*reader)->Info(), this->Merging, selections, outInfo);
  return 1;
}

int vtkKdMeshReader::RequestData(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector)
{
  vtkPolyData* const output = vtkPolyData::GetData(outputVector);
  vtkInformation* const outInfo = outputVector->GetInformationObject(0);
  if (outInfo->Get(vtkStreamingDemandDrivenPipeline::UPDATE_PIECE_NUMBER()) > 0)
  {
    return 1; // the first piece is the whole mesh
  }
  const Execution execution =
    MakeAlgorithmExecution(*this, { { "read", 0.0, 0.9 }, { "fill", 0.9, 1.0 } });
  Tolerance tolerance;
  const Result<Mesh> mesh = ReadFile(this->FileName, this->Merging, execution, tolerance);
  for (const std::string& warning : tolerance.Warnings())
  {
    vtkWarningMacro(<< this->FileName << ": " << warning);
  }
  const auto isWanted = [selections = ArraySelections(*this->PointArrays, *this->CellArrays)](
                          const AttributeInfo& array) { return selections.IsWanted(array); };
  const Status status =
    mesh ? FillPolyData(*mesh, mesh->points.size(), isWanted, *output, execution) : mesh.GetError();
  if (status)
  {
    this->SetErrorCode(vtkErrorCode::NoError);
    return 1;
  }
  output->Initialize();
  if (status.GetError().code == ErrorCode::Cancelled)
  {
    this->SetErrorCode(vtkErrorCode::NoError);
    return 1;
  }
  const bool isNamed = this->FileName && *this->FileName;
  this->SetErrorCode(isNamed ? VtkErrorCodeOf(status.GetError())
                             : static_cast<unsigned long>(vtkErrorCode::NoFileNameError));
  vtkErrorMacro(<< (isNamed ? this->FileName + std::string(": ") : "")
                << status.GetError().message);
  return 0;
}

void vtkKdMeshReader::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "FileName: " << (this->FileName ? this->FileName : "(none)") << "\n";
  os << indent << "Merging: " << (this->Merging ? "on" : "off") << "\n";
  os << indent << "PointArrays:\n";
  this->PointArrays->PrintSelf(os, indent.GetNextIndent());
  os << indent << "CellArrays:\n";
  this->CellArrays->PrintSelf(os, indent.GetNextIndent());
}
