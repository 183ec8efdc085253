// SPDX-License-Identifier: BSD-3-Clause
// Arrays of a vtkPolyData to attributes and back: types, roles, split cells, skipped arrays.
#include "Testing/Fixtures/ErrorAt.h"
#include "filters/adapter/PolyDataAttributes.h"

#include "filters/adapter/Testing/FilterTools.h"

#include <gtest/gtest.h>
#include <vtkBitArray.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkSOADataArrayTemplate.h>
#include <vtkStringArray.h>
#include <vtkUnsignedCharArray.h>

#include <cstring>
#include <limits>
#include <map>

namespace kdstream
{
namespace
{

using namespace kdstream::testing;

PolyDataAttributes Read(vtkPolyData& mesh)
{
  const Result<PolyDataElements> elements = ReadElements(mesh);
  EXPECT_TRUE(elements);
  return ReadAttributes(mesh, *elements);
}

const Attribute* Find(
  const PolyDataAttributes& read, const std::string& name, AttributeAssociation association)
{
  for (const Attribute& attribute : read.attributes)
  {
    if (attribute.name == name && attribute.association == association)
    {
      return &attribute;
    }
  }
  return nullptr;
}

vtkSmartPointer<vtkDataArray> MakeArray(
  int type, const char* name, int components, vtkIdType tuples, double value)
{
  auto array = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(type));
  array->SetName(name);
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(tuples);
  for (int c = 0; c < components; ++c)
  {
    array->FillComponent(c, value + c);
  }
  return array;
}

TEST(PolyDataAttributes, TypesBitForBitThereAndBack)
{
  const PolyData mesh = MakePoints({ { 0, 0, 0 }, { 1, 0, 0 } });
  const std::map<int, AttributeType> types{ { VTK_SIGNED_CHAR, AttributeType::Int8 },
    { VTK_UNSIGNED_CHAR, AttributeType::UInt8 }, { VTK_SHORT, AttributeType::Int16 },
    { VTK_UNSIGNED_SHORT, AttributeType::UInt16 }, { VTK_INT, AttributeType::Int32 },
    { VTK_UNSIGNED_INT, AttributeType::UInt32 }, { VTK_LONG_LONG, AttributeType::Int64 },
    { VTK_UNSIGNED_LONG_LONG, AttributeType::UInt64 }, { VTK_FLOAT, AttributeType::Float32 },
    { VTK_DOUBLE, AttributeType::Float64 } };
  for (const auto& [type, expected] : types)
  {
    const auto array = MakeArray(type, std::to_string(type).c_str(), 2, 2, 3);
    const auto bytes = static_cast<std::size_t>(4 * array->GetDataTypeSize());
    for (std::size_t i = 0; i < bytes; ++i)
    {
      static_cast<unsigned char*>(array->GetVoidPointer(0))[i] = static_cast<unsigned char>(37 * i);
    }
    mesh->GetPointData()->AddArray(array);
  }
  const PolyDataAttributes read = Read(*mesh);
  EXPECT_TRUE(read.skipped.empty());
  ASSERT_EQ(read.attributes.size(), types.size());
  const PolyData written = MakePoints({ { 0, 0, 0 }, { 1, 0, 0 } });
  ASSERT_TRUE(WriteAttributes(read.attributes, *written));
  for (const auto& [type, expected] : types)
  {
    const std::string name = std::to_string(type);
    const Attribute* const attribute = Find(read, name, AttributeAssociation::Point);
    ASSERT_TRUE(attribute);
    EXPECT_EQ(attribute->type, expected);
    EXPECT_EQ(attribute->components, 2);
    vtkDataArray* const from = mesh->GetPointData()->GetArray(name.c_str());
    vtkDataArray* const back = written->GetPointData()->GetArray(name.c_str());
    ASSERT_TRUE(back);
    EXPECT_EQ(from->GetDataTypeSize(), back->GetDataTypeSize());
    EXPECT_EQ(from->GetNumberOfTuples(), back->GetNumberOfTuples());
    EXPECT_EQ(
      std::memcmp(from->GetVoidPointer(0), back->GetVoidPointer(0), attribute->values.size()), 0);
  }
}

TEST(PolyDataAttributes, IdsBitsAndOtherLayouts)
{
  const PolyData mesh = MakePoints({ { 0, 0, 0 }, { 1, 0, 0 }, { 2, 0, 0 } });
  vtkNew<vtkIdTypeArray> ids;
  ids->SetName("Ids");
  vtkNew<vtkBitArray> bits;
  bits->SetName("Bits");
  vtkNew<vtkSOADataArrayTemplate<float>> columns;
  columns->SetName("Columns");
  columns->SetNumberOfComponents(2);
  columns->SetNumberOfTuples(3);
  for (const vtkIdType i : { 0, 1, 2 })
  {
    ids->InsertNextValue(std::numeric_limits<vtkIdType>::max() - i);
    bits->InsertNextValue(i == 1 ? 1 : 0);
    columns->SetTuple2(i, 0.5 * double(i), -double(i));
  }
  mesh->GetPointData()->AddArray(ids);
  mesh->GetPointData()->AddArray(bits);
  mesh->GetPointData()->AddArray(columns);
  const PolyDataAttributes read = Read(*mesh);
  EXPECT_TRUE(read.skipped.empty());
  const Attribute* const first = Find(read, "Ids", AttributeAssociation::Point);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->type, sizeof(vtkIdType) == 8 ? AttributeType::Int64 : AttributeType::Int32);
  EXPECT_EQ(std::memcmp(first->values.data(), ids->GetPointer(0), 3 * sizeof(vtkIdType)), 0);
  const Attribute* const second = Find(read, "Bits", AttributeAssociation::Point);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->type, AttributeType::UInt8);
  EXPECT_EQ(second->values, (std::vector<std::uint8_t>{ 0, 1, 0 }));
  const Attribute* const third = Find(read, "Columns", AttributeAssociation::Point);
  ASSERT_TRUE(third);
  EXPECT_EQ(third->Get(2, 0), 1);
  EXPECT_EQ(third->Get(2, 1), -2);
}

TEST(PolyDataAttributes, ActiveArraysGetTheNamesOfTheirRoles)
{
  const PolyData mesh = MakePoints({ { 0, 0, 0 }, { 1, 0, 0 } });
  vtkPointData* const data = mesh->GetPointData();
  data->AddArray(MakeArray(VTK_FLOAT, "Normals", 3, 2, 9)); // not the active one
  data->SetNormals(MakeArray(VTK_FLOAT, "smooth", 3, 2, 1));
  data->SetScalars(MakeArray(VTK_UNSIGNED_CHAR, "vertex colours", 4, 2, 10));
  data->SetTCoords(MakeArray(VTK_DOUBLE, "uv", 2, 2, 0.5));
  const PolyDataAttributes read = Read(*mesh);
  ASSERT_EQ(read.attributes.size(), 3U);
  EXPECT_EQ(read.skipped, (std::vector<std::string>{
                            "point array \"Normals\": another array has the name \"Normals\"" }));
  const Attribute* const normals = Find(read, "Normals", AttributeAssociation::Point);
  ASSERT_TRUE(normals);
  EXPECT_EQ(normals->Get(1, 2), 3);
  ASSERT_TRUE(Find(read, "RGBA", AttributeAssociation::Point));
  ASSERT_TRUE(Find(read, "TCoords", AttributeAssociation::Point));

  const PolyData written = MakePoints({ { 0, 0, 0 }, { 1, 0, 0 } });
  ASSERT_TRUE(WriteAttributes(read.attributes, *written));
  ASSERT_TRUE(written->GetPointData()->GetNormals());
  ASSERT_TRUE(written->GetPointData()->GetScalars());
  ASSERT_TRUE(written->GetPointData()->GetTCoords());
  EXPECT_STREQ(written->GetPointData()->GetScalars()->GetName(), "RGBA");
  EXPECT_EQ(written->GetPointData()->GetScalars()->GetComponent(1, 3), 13);
}

TEST(PolyDataAttributes, IdsStayIds)
{
  const PolyData mesh = MakePlate(2); // 4 points, 2 triangles
  mesh->GetPointData()->SetGlobalIds(MakeArray(VTK_ID_TYPE, "node", 1, 4, 100));
  mesh->GetPointData()->SetPedigreeIds(MakeArray(VTK_INT, "parent", 1, 4, 7));
  mesh->GetCellData()->SetGlobalIds(MakeArray(VTK_ID_TYPE, "element", 1, 2, 200));
  mesh->GetCellData()->SetPedigreeIds(MakeArray(VTK_ID_TYPE, "from", 1, 2, 3));
  const PolyDataAttributes read = Read(*mesh);
  for (const AttributeAssociation of : { AttributeAssociation::Point, AttributeAssociation::Cell })
  {
    ASSERT_TRUE(Find(read, "GlobalIds", of));
    ASSERT_TRUE(Find(read, "PedigreeIds", of));
  }
  EXPECT_TRUE(read.skipped.empty());
  const PolyData written = MakePlate(2);
  ASSERT_TRUE(WriteAttributes(read.attributes, *written));
  vtkDataArray* const points = written->GetPointData()->GetGlobalIds();
  ASSERT_TRUE(points);
  EXPECT_EQ(points->GetDataType(), VTK_ID_TYPE);
  EXPECT_EQ(points->GetComponent(3, 0), 100);
  ASSERT_TRUE(written->GetPointData()->GetPedigreeIds());
  EXPECT_EQ(written->GetPointData()->GetPedigreeIds()->GetDataType(), VTK_INT);
  ASSERT_TRUE(written->GetCellData()->GetGlobalIds());
  EXPECT_EQ(written->GetCellData()->GetGlobalIds()->GetComponent(1, 0), 200);
  ASSERT_TRUE(written->GetCellData()->GetPedigreeIds());

  // Levels have no ids, and nothing is coloured by ids.
  for (const Attribute& ids : read.attributes)
  {
    EXPECT_EQ(IsScalar(ids), ids.name == "Point") << ids.name;
  }
  // The parts of a split cell would have the same id.
  const PolyData cut = MakeAllCells();
  cut->GetCellData()->SetGlobalIds(MakeArray(VTK_ID_TYPE, "element", 1, 9, 0));
  const PolyDataAttributes parts = Read(*cut);
  EXPECT_FALSE(Find(parts, "GlobalIds", AttributeAssociation::Cell));
  ASSERT_EQ(parts.skipped.size(), 1U);
  EXPECT_NE(parts.skipped[0].find("\"element\": cells were split"), std::string::npos);
}

TEST(PolyDataAttributes, ActiveArraysOfAnotherShapeKeepTheirNames)
{
  const PolyData mesh = MakePoints({ { 0, 0, 0 } });
  vtkPointData* const data = mesh->GetPointData();
  data->SetScalars(MakeArray(VTK_FLOAT, "height", 1, 1, 1));
  data->SetTCoords(MakeArray(VTK_FLOAT, "uvw", 3, 1, 1));
  data->AddArray(MakeArray(VTK_UNSIGNED_CHAR, "RGB", 3, 1, 1));
  const PolyDataAttributes read = Read(*mesh);
  EXPECT_TRUE(Find(read, "height", AttributeAssociation::Point));
  EXPECT_TRUE(Find(read, "uvw", AttributeAssociation::Point));
  EXPECT_TRUE(Find(read, "RGB", AttributeAssociation::Point));
  EXPECT_TRUE(read.skipped.empty());
}

TEST(PolyDataAttributes, TrianglesGetTheDataOfTheirCells)
{
  const PolyData mesh = MakeAllCells();
  mesh->GetCellData()->SetScalars(MakeArray(VTK_UNSIGNED_CHAR, "paint", 3, 9, 7));
  const PolyDataAttributes read = Read(*mesh);
  const Attribute* const cells = Find(read, "Cell", AttributeAssociation::Cell);
  ASSERT_TRUE(cells);
  ASSERT_EQ(cells->TupleCount(), 10U);
  const double expected[] = { 4, 5, 5, 6, 6, 6, 8, 8, 8, 8 };
  for (std::size_t i = 0; i < 10; ++i)
  {
    EXPECT_EQ(cells->Get(i, 0), expected[i]) << i;
  }
  EXPECT_TRUE(Find(read, "paint", AttributeAssociation::Cell));
  EXPECT_TRUE(Find(read, "Point", AttributeAssociation::Point));
}

TEST(PolyDataAttributes, SkippedArraysAreNamedWithAReason)
{
  const PolyData mesh = MakePlate(2); // 4 points, 2 triangles
  vtkPointData* const data = mesh->GetPointData();
  vtkNew<vtkStringArray> names;
  names->SetName("Names");
  names->SetNumberOfValues(4);
  data->AddArray(names);
  data->AddArray(MakeArray(VTK_FLOAT, nullptr, 1, 4, 0));
  data->AddArray(MakeArray(VTK_FLOAT, "wide", 256, 4, 0));
  data->AddArray(MakeArray(VTK_FLOAT, "short", 1, 3, 0));
  data->AddArray(MakeArray(VTK_UNSIGNED_CHAR, vtkDataSetAttributes::GhostArrayName(), 1, 4, 0));
  mesh->GetCellData()->AddArray(MakeArray(VTK_FLOAT, "long", 1, 3, 0));
  const PolyDataAttributes read = Read(*mesh);
  EXPECT_EQ(read.attributes.size(), 2U); // "Point" and "Cell"
  EXPECT_EQ(read.skipped, (std::vector<std::string>{ "point array \"Names\": is not numeric",
                            "point array \"\": has no name",
                            "point array \"wide\": has 256 components; 1 to 255 are supported",
                            "point array \"short\": has 3 tuples for 4 points",
                            "cell array \"long\": has 3 tuples for 2 cells" }));
}

TEST(PolyDataAttributes, EmptyInputAndWrongCounts)
{
  EXPECT_TRUE(Read(*PolyData::New()).attributes.empty());
  const PolyData mesh = MakePlate(2);
  Attribute attribute;
  attribute.name = "heat";
  attribute.values.resize(4 * 4);
  ASSERT_TRUE(WriteAttributes({ &attribute, 1 }, *mesh));
  EXPECT_TRUE(mesh->GetPointData()->HasArray("heat"));
  attribute.association = AttributeAssociation::Cell;
  const Status status = WriteAttributes({ &attribute, 1 }, *mesh);
  EXPECT_TRUE(fixtures::FailsAt(status, ErrorCode::InvalidInput, "\"heat\" has 4 tuples"));
  EXPECT_FALSE(mesh->GetCellData()->HasArray("heat"));
}

}
}
