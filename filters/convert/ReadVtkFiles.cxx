// SPDX-License-Identifier: BSD-3-Clause
// VTK's own formats: read by VTK.
#include "filters/convert/ForeignMesh.h"
#include "filters/convert/PolyDataParts.h"
#include "filters/convert/VtkMessages.h"

#include <vtkCallbackCommand.h>
#include <vtkDataSet.h>
#include <vtkDataSetSurfaceFilter.h>
#include <vtkGenericDataObjectReader.h>
#include <vtkNew.h>
#include <vtkXMLPolyDataReader.h>

namespace kdstream
{
namespace
{

// Progress of the reader goes to the execution; a reader does not stop on abort, so neither does
// this.
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

Result<ForeignMesh> Finish(vtkPolyData* output, VtkMessages& messages, const Execution& execution)
{
  KDSTREAM_TRY(messages.FirstError());
  KDSTREAM_TRY(execution.Report("read", 1));
  Result<ForeignMesh> mesh = ReadPolyData(*output, execution);
  if (mesh)
  {
    for (std::string& warning : messages.TakeWarnings())
    {
      mesh->warnings.push_back(std::move(warning));
    }
  }
  return mesh;
}

}

Result<ForeignMesh> ReadVtp(const std::filesystem::path& file, const Execution& execution)
{
  VtkMessages messages;
  vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName(file.c_str());
  Update(*reader, execution);
  return Finish(reader->GetOutput(), messages, execution);
}

Result<ForeignMesh> ReadVtk(const std::filesystem::path& file, const Execution& execution)
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
  KDSTREAM_TRY(messages.FirstError());
  if (vtkPolyData* const mesh = vtkPolyData::SafeDownCast(output))
  {
    return Finish(mesh, messages, execution);
  }
  if (!vtkDataSet::SafeDownCast(output))
  {
    return Error{ ErrorCode::InvalidInput,
      "holds " + std::string(output ? output->GetClassName() : "nothing") + ", which is no mesh" };
  }
  vtkNew<vtkDataSetSurfaceFilter> surface;
  surface->SetInputData(output);
  surface->Update();
  Result<ForeignMesh> mesh = Finish(surface->GetOutput(), messages, execution);
  if (mesh)
  {
    mesh->warnings.push_back(
      "holds " + std::string(output->GetClassName()) + ", of which the surface is taken");
  }
  return mesh;
}

}
