// SPDX-License-Identifier: BSD-3-Clause
#include "filters/adapter/PolyDataAttributes.h"

#include "filters/core/Attribute.h"

#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataSetAttributes.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>

namespace kdstream
{
namespace
{

AttributeType SignedOfSize(std::size_t bytes)
{
  return bytes == 8 ? AttributeType::Int64 : AttributeType::Int32;
}

AttributeType UnsignedOfSize(std::size_t bytes)
{
  return bytes == 8 ? AttributeType::UInt64 : AttributeType::UInt32;
}

// The type with the same bits; nothing for arrays of single bits.
std::optional<AttributeType> TypeOf(int vtkType)
{
  switch (vtkType)
  {
    case VTK_CHAR:
      return std::numeric_limits<char>::is_signed ? AttributeType::Int8 : AttributeType::UInt8;
    case VTK_SIGNED_CHAR:
      return AttributeType::Int8;
    case VTK_UNSIGNED_CHAR:
      return AttributeType::UInt8;
    case VTK_SHORT:
      return AttributeType::Int16;
    case VTK_UNSIGNED_SHORT:
      return AttributeType::UInt16;
    case VTK_INT:
      return AttributeType::Int32;
    case VTK_UNSIGNED_INT:
      return AttributeType::UInt32;
    case VTK_LONG:
      return SignedOfSize(sizeof(long));
    case VTK_UNSIGNED_LONG:
      return UnsignedOfSize(sizeof(unsigned long));
    case VTK_LONG_LONG:
      return AttributeType::Int64;
    case VTK_UNSIGNED_LONG_LONG:
      return AttributeType::UInt64;
    case VTK_ID_TYPE:
      return SignedOfSize(sizeof(vtkIdType));
    case VTK_FLOAT:
      return AttributeType::Float32;
    case VTK_DOUBLE:
      return AttributeType::Float64;
    default:
      return {};
  }
}

// An array with the same values whose tuples are contiguous, of a type that TypeOf knows.
vtkSmartPointer<vtkDataArray> Plain(vtkDataArray& array)
{
  if (array.HasStandardMemoryLayout() && TypeOf(array.GetDataType()))
  {
    return &array;
  }
  const int type = TypeOf(array.GetDataType()) ? array.GetDataType() : VTK_UNSIGNED_CHAR;
  auto copy = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(type));
  copy->DeepCopy(&array);
  return copy;
}

// The name by which RoleOf recognizes the array, if it is active and has the type that this role
// needs.
std::string NameFor(vtkDataSetAttributes& data, vtkDataArray& array, AttributeInfo info)
{
  std::string own = array.GetName() ? array.GetName() : "";
  const auto fits = [&](const char* name, AttributeRole role)
  {
    info.name = name;
    return RoleOf(info) == role;
  };
  if (&array == data.GetNormals() && fits("Normals", AttributeRole::Normals))
  {
    return "Normals";
  }
  if (&array == data.GetTCoords() && fits("TCoords", AttributeRole::TextureCoordinates))
  {
    return "TCoords";
  }
  for (const char* name : { "RGB", "RGBA" })
  {
    if (&array == data.GetScalars() && fits(name, AttributeRole::Colors))
    {
      return name;
    }
  }
  for (const auto& [name, active] : { std::pair{ "GlobalIds", data.GetGlobalIds() },
         std::pair{ "PedigreeIds", vtkDataArray::SafeDownCast(data.GetPedigreeIds()) } })
  {
    info.name = name;
    if (&array == active && HoldsIds(info))
    {
      return name;
    }
  }
  return own;
}

bool IsActive(vtkDataSetAttributes& data, vtkAbstractArray* array)
{
  return array == data.GetNormals() || array == data.GetTCoords() || array == data.GetScalars() ||
         array == data.GetGlobalIds() || array == data.GetPedigreeIds();
}

class Reader
{
public:
  explicit Reader(PolyDataAttributes& result)
    : Result(result)
  {
  }

  // cells: for each tuple of the attributes the tuple of the arrays; null: the same one. Active
  // arrays are read first, so that no other array takes their names.
  void Read(vtkDataSetAttributes& data, AttributeAssociation association, vtkIdType tuples,
    const std::span<const vtkIdType>* cells)
  {
    std::vector<Attribute> found(static_cast<std::size_t>(data.GetNumberOfArrays()));
    for (const bool active : { true, false })
    {
      for (int i = 0; i < data.GetNumberOfArrays(); ++i)
      {
        vtkAbstractArray* const array = data.GetAbstractArray(i);
        if (IsActive(data, array) == active)
        {
          this->ReadArray(
            data, *array, association, tuples, cells, found, found[static_cast<std::size_t>(i)]);
        }
      }
    }
    for (Attribute& attribute : found)
    {
      if (!attribute.name.empty())
      {
        this->Result.attributes.push_back(std::move(attribute));
      }
    }
  }

private:
  void ReadArray(vtkDataSetAttributes& data, vtkAbstractArray& array,
    AttributeAssociation association, vtkIdType tuples, const std::span<const vtkIdType>* cells,
    const std::vector<Attribute>& found, Attribute& attribute)
  {
    const std::string own = array.GetName() ? array.GetName() : "";
    const auto skip = [&](const std::string& why)
    {
      this->Result.skipped.push_back(
        (association == AttributeAssociation::Point ? "point array \"" : "cell array \"") + own +
        "\": " + why);
    };
    vtkDataArray* const numbers = vtkDataArray::SafeDownCast(&array);
    if (!numbers || (!TypeOf(array.GetDataType()) && array.GetDataType() != VTK_BIT))
    {
      return skip("is not numeric");
    }
    const int components = array.GetNumberOfComponents();
    if (components < 1 || components > std::numeric_limits<std::uint8_t>::max())
    {
      return skip("has " + std::to_string(components) + " components; 1 to 255 are supported");
    }
    if (array.GetNumberOfTuples() != tuples)
    {
      return skip("has " + std::to_string(array.GetNumberOfTuples()) + " tuples for " +
                  std::to_string(tuples) +
                  (association == AttributeAssociation::Point ? " points" : " cells"));
    }
    if (own == vtkDataSetAttributes::GhostArrayName())
    {
      return;
    }
    if (cells && &array == data.GetGlobalIds() &&
        std::adjacent_find(cells->begin(), cells->end()) != cells->end())
    {
      return skip("cells were split, so several would have the same global id");
    }
    AttributeInfo info;
    info.type = TypeOf(array.GetDataType()).value_or(AttributeType::UInt8);
    info.association = association;
    info.components = static_cast<std::uint8_t>(components);
    info.name = NameFor(data, *numbers, info);
    if (info.name.empty())
    {
      return skip("has no name");
    }
    if (std::any_of(found.begin(), found.end(),
          [&](const Attribute& other) { return other.name == info.name; }))
    {
      return skip("another array has the name \"" + info.name + "\"");
    }
    static_cast<AttributeInfo&>(attribute) = info;
    CopyValues(*Plain(*numbers), cells, attribute);
  }

  static void CopyValues(
    vtkDataArray& array, const std::span<const vtkIdType>* cells, Attribute& attribute)
  {
    const std::size_t size = attribute.TupleSize();
    const auto* const from = static_cast<const std::uint8_t*>(array.GetVoidPointer(0));
    if (!cells)
    {
      const std::size_t bytes = size * static_cast<std::size_t>(array.GetNumberOfTuples());
      attribute.values.assign(from, from + bytes);
      return;
    }
    attribute.values.resize(size * cells->size());
    for (std::size_t i = 0; i < cells->size(); ++i)
    {
      std::memcpy(attribute.values.data() + i * size,
        from + static_cast<std::size_t>((*cells)[i]) * size, size);
    }
  }

  PolyDataAttributes& Result;
};

}

int VtkTypeOf(const AttributeInfo& attribute)
{
  static constexpr int types[] = { VTK_TYPE_INT8, VTK_TYPE_UINT8, VTK_TYPE_INT16, VTK_TYPE_UINT16,
    VTK_TYPE_INT32, VTK_TYPE_UINT32, VTK_TYPE_INT64, VTK_TYPE_UINT64, VTK_TYPE_FLOAT32,
    VTK_TYPE_FLOAT64 };
  const bool isId = HoldsIds(attribute) && attribute.type == SignedOfSize(sizeof(vtkIdType));
  return isId ? VTK_ID_TYPE : types[static_cast<std::size_t>(attribute.type)];
}

PolyDataAttributes ReadAttributes(vtkPolyData& input, const PolyDataElements& elements)
{
  PolyDataAttributes result;
  Reader reader(result);
  reader.Read(
    *input.GetPointData(), AttributeAssociation::Point, input.GetNumberOfPoints(), nullptr);
  const auto cells = std::span(elements.cells).subspan(elements.vertices + elements.segments);
  reader.Read(*input.GetCellData(), AttributeAssociation::Cell, input.GetNumberOfCells(), &cells);
  return result;
}

Status WriteAttributes(std::span<const Attribute> attributes, vtkPolyData& output)
{
  const auto isPoint = [](const Attribute& attribute)
  { return attribute.association == AttributeAssociation::Point; };
  for (const Attribute& attribute : attributes)
  {
    const vtkIdType count =
      isPoint(attribute) ? output.GetNumberOfPoints() : output.GetNumberOfCells();
    if (attribute.TupleCount() != static_cast<std::size_t>(count))
    {
      return Error{ ErrorCode::InvalidInput,
        "attribute \"" + attribute.name + "\" has " + std::to_string(attribute.TupleCount()) +
          " tuples for " + std::to_string(count) + (isPoint(attribute) ? " points" : " cells") };
    }
  }
  for (const Attribute& attribute : attributes)
  {
    const auto array =
      vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(VtkTypeOf(attribute)));
    array->SetName(attribute.name.c_str());
    array->SetNumberOfComponents(attribute.components);
    array->SetNumberOfTuples(static_cast<vtkIdType>(attribute.TupleCount()));
    if (!attribute.values.empty())
    {
      std::memcpy(array->GetVoidPointer(0), attribute.values.data(), attribute.values.size());
    }
    vtkDataSetAttributes* const data = isPoint(attribute)
                                         ? static_cast<vtkDataSetAttributes*>(output.GetPointData())
                                         : static_cast<vtkDataSetAttributes*>(output.GetCellData());
    data->AddArray(array);
    if (HoldsIds(attribute))
    {
      data->SetActiveAttribute(attribute.name.c_str(), attribute.name == "GlobalIds"
                                                         ? vtkDataSetAttributes::GLOBALIDS
                                                         : vtkDataSetAttributes::PEDIGREEIDS);
    }
    switch (RoleOf(attribute))
    {
      case AttributeRole::Normals:
        data->SetActiveNormals(attribute.name.c_str());
        break;
      case AttributeRole::Colors:
        data->SetActiveScalars(attribute.name.c_str());
        break;
      case AttributeRole::TextureCoordinates:
        data->SetActiveTCoords(attribute.name.c_str());
        break;
      case AttributeRole::Other:
        break;
    }
  }
  return {};
}

}
