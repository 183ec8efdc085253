// SPDX-License-Identifier: BSD-3-Clause
#include "filters/adapter/RankParts.h"

#include "filters/adapter/JoinPolyData.h"

#include <vtkBitArray.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkIdTypeArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <algorithm>
#include <array>
#include <cstdint>

namespace kdstream
{
namespace
{

using Bytes = std::vector<unsigned char>;

std::size_t SizeOf(vtkDataArray& array)
{
  const vtkIdType values = array.GetNumberOfTuples() * array.GetNumberOfComponents();
  return static_cast<std::size_t>(values * array.GetDataTypeSize());
}

Bytes ValuesOf(vtkDataArray& array)
{
  vtkSmartPointer<vtkDataArray> plain = &array;
  if (!array.HasStandardMemoryLayout())
  {
    plain.TakeReference(vtkDataArray::CreateDataArray(array.GetDataType()));
    plain->DeepCopy(&array);
  }
  const auto* const begin = static_cast<const unsigned char*>(plain->GetVoidPointer(0));
  return Bytes(begin, begin + SizeOf(*plain));
}

void PutArray(vtkDataArray& array, int active, RankMessage& message)
{
  const std::string name = array.GetName() ? array.GetName() : "";
  message.Put(std::vector<char>(name.begin(), name.end()));
  message.Put(std::vector<int>{ array.GetDataType(), array.GetNumberOfComponents(), active });
  message.Put(ValuesOf(array));
}

// The array, and whether it is active as which attribute (-1: none).
std::pair<vtkSmartPointer<vtkDataArray>, int> TakeArray(RankMessage& message)
{
  const std::vector<char> name = message.Take<char>();
  const std::vector<int> kind = message.Take<int>();
  const Bytes values = message.Take<unsigned char>();
  auto array = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(kind[0]));
  array->SetName(std::string(name.begin(), name.end()).c_str());
  array->SetNumberOfComponents(kind[1]);
  const std::size_t tuple = static_cast<std::size_t>(kind[1] * array->GetDataTypeSize());
  array->SetNumberOfTuples(static_cast<vtkIdType>(tuple == 0 ? 0 : values.size() / tuple));
  std::copy(values.begin(), values.end(), static_cast<unsigned char*>(array->GetVoidPointer(0)));
  return { array, kind[2] };
}

void PutData(vtkDataSetAttributes& data, const char* kind, RankMessage& message,
  std::vector<std::string>& leftOut)
{
  std::vector<int> sent;
  for (int i = 0; i < data.GetNumberOfArrays(); ++i)
  {
    auto* const array = vtkDataArray::SafeDownCast(data.GetAbstractArray(i));
    if (array && !vtkBitArray::SafeDownCast(array) && array->GetName())
    {
      sent.push_back(i);
      continue;
    }
    const std::string name = data.GetArrayName(i) ? data.GetArrayName(i) : "";
    const std::string what = std::string(kind) + " array \"" + name + "\": is not of numbers";
    if (std::find(leftOut.begin(), leftOut.end(), what) == leftOut.end())
    {
      leftOut.push_back(what);
    }
  }
  message.Put(std::vector<std::uint64_t>{ sent.size() });
  for (const int i : sent)
  {
    PutArray(*data.GetArray(i), data.IsArrayAnAttribute(i), message);
  }
}

void TakeData(RankMessage& message, vtkDataSetAttributes& data)
{
  for (std::uint64_t left = message.Take<std::uint64_t>()[0]; left > 0; --left)
  {
    const auto [array, active] = TakeArray(message);
    data.AddArray(array);
    if (active >= 0)
    {
      data.SetActiveAttribute(array->GetName(), active);
    }
  }
}

void PutPart(vtkPolyData& part, RankMessage& message, std::vector<std::string>& leftOut)
{
  PutArray(*part.GetPoints()->GetData(), -1, message);
  for (vtkCellArray* const cells : std::array<vtkCellArray*, 4>{
         part.GetVerts(), part.GetLines(), part.GetPolys(), part.GetStrips() })
  {
    vtkNew<vtkCellArray> none;
    vtkCellArray* const sent = cells ? cells : none.Get();
    PutArray(*sent->GetOffsetsArray(), -1, message);
    PutArray(*sent->GetConnectivityArray(), -1, message);
  }
  PutData(*part.GetPointData(), "point", message, leftOut);
  PutData(*part.GetCellData(), "cell", message, leftOut);
}

vtkSmartPointer<vtkPolyData> TakePart(RankMessage& message)
{
  auto part = vtkSmartPointer<vtkPolyData>::New();
  vtkNew<vtkPoints> points;
  points->SetData(TakeArray(message).first);
  part->SetPoints(points);
  std::array<vtkNew<vtkCellArray>, 4> cells;
  for (const auto& kind : cells)
  {
    const auto offsets = TakeArray(message).first, corners = TakeArray(message).first;
    kind->SetData(offsets, corners);
  }
  part->SetVerts(cells[0]);
  part->SetLines(cells[1]);
  part->SetPolys(cells[2]);
  part->SetStrips(cells[3]);
  TakeData(message, *part->GetPointData());
  TakeData(message, *part->GetCellData());
  return part;
}

}

Result<GatheredParts> GatherParts(const RankGroup& ranks, const Status& ready, vtkDataObject& input,
  std::vector<std::string>& leftOut)
{
  const Result<std::vector<InputPart>> parts = PartsOf(input);
  KDSTREAM_TRY(ranks.Agree(!ready || parts ? ready : Status(parts.GetError())));
  RankMessage message;
  for (const InputPart& part : *parts)
  {
    if (part.mesh->GetNumberOfPoints() > 0)
    {
      PutPart(*part.mesh, message, leftOut);
    }
  }
  std::vector<RankGroup::Bytes> out(ranks.Count());
  out[0] = message.Release();
  auto came = ranks.Exchange(std::move(out));
  KDSTREAM_TRY(came);
  GatheredParts all{ vtkSmartPointer<vtkPartitionedDataSet>::New(), false };
  all.areSame = !came->front().empty() &&
                std::all_of(came->begin(), came->end(),
                  [&](const RankGroup::Bytes& bytes) { return bytes == came->front(); });
  for (RankGroup::Bytes& bytes : *came)
  {
    for (RankMessage told(std::move(bytes)); !told.AtEnd();)
    {
      all.parts->SetPartition(all.parts->GetNumberOfPartitions(), TakePart(told));
    }
  }
  return all;
}

}
