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
#include <vtkXMLDataElement.h>
#include <vtkXMLDataParser.h>
#include <vtkXMLPolyDataReader.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <tuple>

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

// VTK reads as many points and cells as a piece counts; looks for what the arrays have behind them.
class CountingReader : public vtkXMLPolyDataReader
{
public:
  static CountingReader* New()
  {
    auto* const reader = new CountingReader; // under its base's name in messages
    reader->InitializeObjectBase();
    return reader;
  }

  Tolerance Behind;

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
      this->LookBehind(points->GetNestedElement(0), 3, this->NumberOfPoints[piece], "Points");
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
        this->LookBehind(offsets, 1, counts[piece], name);
      }
    }
    return 1;
  }

private:
  void LookBehind(
    vtkXMLDataElement* array, std::uint64_t components, vtkIdType counted, const char* name)
  {
    int type = 0;
    if (!array->GetWordTypeAttribute("type", type))
    {
      return;
    }
    const VtkMessages notTold; // what is there was read
    constexpr std::size_t block = 4096;
    std::array<double, block> values{}; // of at most eight bytes
    // From the last known word on: VTK fails where it is to begin behind the end.
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
    this->Behind.Count(Lapse::NotCounted, found / components,
      std::string("NumberOf") + name + " is " + std::to_string(counted));
  }
};

// VTK's words do not say what to do.
Error Damaged(const Error& error)
{
  return error.code == ErrorCode::InvalidInput
           ? Error{ error.code, "is damaged, or is not as its header says: write it again by the "
                                "program that it comes from (" +
                                  error.message + ")" }
           : error;
}

Result<ForeignMesh> Finish(vtkPolyData* output, VtkMessages& messages, const Execution& execution)
{
  if (const Status read = messages.FirstError(); !read)
  {
    return Damaged(read.GetError());
  }
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
  vtkNew<CountingReader> reader;
  reader->SetFileName(file.c_str());
  Update(*reader, execution);
  Result<ForeignMesh> mesh = Finish(reader->GetOutput(), messages, execution);
  if (mesh)
  {
    mesh->tolerance.Add(reader->Behind);
  }
  return mesh;
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
  if (const Status read = messages.FirstError(); !read)
  {
    return Damaged(read.GetError());
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
