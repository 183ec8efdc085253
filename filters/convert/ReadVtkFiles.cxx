// STL, and VTK's own formats: read by VTK.
#include "filters/convert/FloatCoordinates.h"
#include "filters/convert/ForeignMesh.h"
#include "filters/convert/PolyDataParts.h"
#include "filters/convert/VtkMessages.h"
#include "filters/core/Weld.h"
#include "filters/meshio/ByteSource.h"

#include <vtkCallbackCommand.h>
#include <vtkDataSet.h>
#include <vtkDataSetSurfaceFilter.h>
#include <vtkGenericDataObjectReader.h>
#include <vtkNew.h>
#include <vtkSTLReader.h>
#include <vtkXMLPolyDataReader.h>

#include <cstring>

namespace kdstream
{
namespace
{

constexpr std::uint64_t stlHeaderBytes = 84, stlTriangleBytes = 50;

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
  if (Status status = messages.FirstError(); !status)
  {
    return status.GetError();
  }
  if (Status status = execution.Report("read", 1); !status)
  {
    return status.GetError();
  }
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

// vtkSTLReader reads what there is of a binary file, whatever its header says: it must have the
// size that it claims. Returns the number of triangles that are claimed, or none for text.
Result<std::optional<std::uint64_t>> CheckBinaryStl(const std::filesystem::path& file)
{
  Result<ByteSource> source = ByteSource::Open(file);
  if (!source)
  {
    return source.GetError();
  }
  const Result<std::string_view> head = source->Peek(stlHeaderBytes);
  if (!head)
  {
    return head.GetError();
  }
  std::uint32_t triangles = 0;
  if (head->size() >= stlHeaderBytes)
  {
    std::memcpy(&triangles, head->data() + stlHeaderBytes - 4, 4);
  }
  const std::uint64_t size = stlHeaderBytes + stlTriangleBytes * triangles;
  if (head->size() >= stlHeaderBytes && source->Size() == size)
  {
    return std::optional<std::uint64_t>(triangles);
  }
  if (head->substr(0, 5) == "solid")
  {
    return std::optional<std::uint64_t>();
  }
  if (head->size() < stlHeaderBytes)
  {
    return Error{ ErrorCode::InvalidInput, "is not an STL file" };
  }
  return Error{ ErrorCode::InvalidInput,
    "the header claims " + std::to_string(triangles) + " triangles, " + std::to_string(size) +
      " bytes with it; the file has " + std::to_string(source->Size()) };
}

}

Result<ForeignMesh> ReadStl(const std::filesystem::path& file, const Execution& execution)
{
  const Result<std::optional<std::uint64_t>> claimed = CheckBinaryStl(file);
  if (!claimed)
  {
    return claimed.GetError();
  }
  VtkMessages messages;
  vtkNew<vtkSTLReader> reader;
  reader->SetFileName(file.c_str());
  reader->MergingOff(); // it would drop degenerate triangles
  Update(*reader, execution);
  Result<ForeignMesh> result = Finish(reader->GetOutput(), messages, execution);
  if (!result)
  {
    return result;
  }
  Mesh& mesh = result->mesh;
  if (*claimed && **claimed != mesh.triangles.size())
  {
    return Error{ ErrorCode::InvalidInput, "the header claims " + std::to_string(**claimed) +
                                             " triangles, VTK found " +
                                             std::to_string(mesh.triangles.size()) };
  }
  WarnOfFloats(*result);
  WeldVertices(mesh);
  return result;
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
  if (Status status = messages.FirstError(); !status)
  {
    return status.GetError();
  }
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
