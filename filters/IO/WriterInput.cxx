// SPDX-License-Identifier: BSD-3-Clause
#include "filters/IO/WriterInput.h"

#include "filters/adapter/DropGhosts.h"
#include "filters/adapter/PolyDataAttributes.h"
#include "filters/adapter/PolyDataMesh.h"

#include <vtkCellData.h>
#include <vtkDataSetAttributes.h>
#include <vtkPartitionedDataSet.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <utility>

namespace kdstream
{
namespace
{

constexpr unsigned char notOwn = vtkDataSetAttributes::DUPLICATECELL |
                                 vtkDataSetAttributes::HIDDENCELL |
                                 vtkDataSetAttributes::REFINEDCELL;

// Whether the ghost array marks an entry.
class Marks
{
public:
  Marks(vtkDataSetAttributes& attributes, unsigned char mask)
    : Array(vtkUnsignedCharArray::SafeDownCast(
        attributes.GetAbstractArray(vtkDataSetAttributes::GhostArrayName())))
    , Mask(mask)
  {
  }
  bool Has(vtkIdType i) const
  {
    return this->Array && i < this->Array->GetNumberOfValues() &&
           (this->Array->GetValue(i) & this->Mask) != 0;
  }

private:
  vtkUnsignedCharArray* Array;
  unsigned char Mask;
};

// Joins parts into one mesh, whose arrays are those that all of them have.
class Joining
{
public:
  explicit Joining(WriterInput& joined)
    : Joined(joined)
  {
  }

  Status Add(vtkPolyData& part, const Execution& execution)
  {
    if (part.GetNumberOfPoints() == 0)
    {
      return {};
    }
    const Result<std::vector<Vec3>> points = ReadPoints(part, execution);
    KDSTREAM_TRY(points);
    if (points->size() >= noVertex - this->Joined.mesh.points.size())
    {
      return Error{ ErrorCode::LimitExceeded,
        "more than 4294967294 points: at most so many fit a tree in memory" };
    }
    const Result<PolyDataElements> elements = ReadElements(part);
    KDSTREAM_TRY(elements);
    PolyDataAttributes read = ReadAttributes(part, *elements);
    this->AddArrays(std::move(read));
    this->AddPoints(part, *points);
    this->AddTriangles(part, *elements);
    this->Joined.mesh.scalarType = part.GetPoints()->GetDataType() == VTK_FLOAT && this->AllFloats
                                     ? ScalarType::Float32
                                     : ScalarType::Float64;
    this->AllFloats = this->Joined.mesh.scalarType == ScalarType::Float32;
    return {};
  }
  // When all parts are there.
  void DropGhosts() { DropUnusedGhosts(this->Joined.mesh, this->IsGhost); }

private:
  // Keeps the arrays that this part has too; the first part's say which there may be.
  void AddArrays(PolyDataAttributes read)
  {
    for (std::string& skipped : read.skipped)
    {
      this->Skip(std::move(skipped));
    }
    std::vector<Attribute>& arrays = this->Joined.mesh.attributes;
    if (std::exchange(this->IsFirst, false))
    {
      for (const Attribute& array : read.attributes)
      {
        arrays.push_back({ array.Info(), {} });
      }
    }
    std::erase_if(arrays,
      [&](const Attribute& array)
      {
        const bool lacks = !FindAttribute(read.attributes, array);
        if (lacks)
        {
          this->Skip("array \"" + array.name + "\": not all parts have it");
        }
        return lacks;
      });
    this->Read = std::move(read.attributes);
  }

  void Skip(std::string what)
  {
    auto& skipped = this->Joined.skipped;
    if (std::find(skipped.begin(), skipped.end(), what) == skipped.end())
    {
      skipped.push_back(std::move(what));
    }
  }

  // Points that are another part's come along where a triangle of this one may use them: what no
  // triangle uses is dropped at the end.
  void AddPoints(vtkPolyData& part, const std::vector<Vec3>& points)
  {
    const Marks ghosts(*part.GetPointData(),
      vtkDataSetAttributes::DUPLICATEPOINT | vtkDataSetAttributes::HIDDENPOINT);
    this->First = static_cast<VertexId>(this->Joined.mesh.points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
    {
      this->Joined.mesh.points.push_back(points[i]);
      this->IsGhost.push_back(ghosts.Has(static_cast<vtkIdType>(i)));
      this->AppendTuples(AttributeAssociation::Point, i);
    }
  }

  void AddTriangles(vtkPolyData& part, const PolyDataElements& elements)
  {
    const Marks ghosts(*part.GetCellData(), notOwn);
    const auto triangles = elements.Triangles();
    const std::size_t before = elements.vertices + elements.segments;
    for (std::size_t i = 0; i < triangles.size(); ++i)
    {
      if (!ghosts.Has(elements.cells[before + i]))
      {
        const Triangle& t = triangles[i];
        this->Joined.mesh.triangles.push_back(
          { this->First + t[0], this->First + t[1], this->First + t[2] });
        this->AppendTuples(AttributeAssociation::Cell, i);
      }
    }
  }

  void AppendTuples(AttributeAssociation association, std::size_t tuple)
  {
    for (Attribute& array : this->Joined.mesh.attributes)
    {
      if (array.association == association)
      {
        array.Append(*FindAttribute(this->Read, array), tuple);
      }
    }
  }

  WriterInput& Joined;
  std::vector<Attribute> Read; // of the part that is being added
  std::vector<bool> IsGhost;   // of each point
  VertexId First = 0;          // point of the part
  bool IsFirst = true, AllFloats = true;
};

RankGroup::Bytes Pack(const Mesh& mesh)
{
  RankMessage message;
  message.Put(mesh.points);
  message.Put(mesh.triangles);
  message.Put(std::vector<ScalarType>{ mesh.scalarType });
  for (const Attribute& array : mesh.attributes)
  {
    message.Put(std::vector<char>(array.name.begin(), array.name.end()));
    message.Put(std::vector<AttributeType>{ array.type });
    message.Put(std::vector<AttributeAssociation>{ array.association });
    message.Put(std::vector<std::uint8_t>{ array.components });
    message.Put(array.values);
  }
  return message.Release();
}

Mesh Unpack(RankMessage message)
{
  Mesh mesh;
  mesh.points = message.Take<Vec3>();
  mesh.triangles = message.Take<Triangle>();
  mesh.scalarType = message.Take<ScalarType>()[0];
  while (!message.AtEnd())
  {
    const std::vector<char> name = message.Take<char>();
    Attribute& array = mesh.attributes.emplace_back();
    array.name.assign(name.begin(), name.end());
    array.type = message.Take<AttributeType>()[0];
    array.association = message.Take<AttributeAssociation>()[0];
    array.components = message.Take<std::uint8_t>()[0];
    array.values = message.Take<std::uint8_t>();
  }
  return mesh;
}

// Behind what is there, with the arrays that both have.
Status Append(Mesh part, WriterInput& all)
{
  Mesh& mesh = all.mesh;
  if (part.points.empty() || mesh.points.empty())
  {
    mesh = part.points.empty() ? std::move(mesh) : std::move(part);
    return {};
  }
  if (part.points.size() >= noVertex - mesh.points.size())
  {
    return Error{ ErrorCode::LimitExceeded,
      "all ranks have more than 4294967294 points: at most so many fit a tree in memory" };
  }
  const auto first = static_cast<VertexId>(mesh.points.size());
  mesh.points.insert(mesh.points.end(), part.points.begin(), part.points.end());
  for (const Triangle& t : part.triangles)
  {
    mesh.triangles.push_back({ first + t[0], first + t[1], first + t[2] });
  }
  mesh.scalarType = std::max(mesh.scalarType, part.scalarType);
  std::erase_if(mesh.attributes,
    [&](Attribute& array)
    {
      const Attribute* const theirs = FindAttribute(part.attributes, array);
      if (!theirs)
      {
        all.skipped.push_back("array \"" + array.name + "\": not all ranks have it");
        return true;
      }
      array.values.insert(array.values.end(), theirs->values.begin(), theirs->values.end());
      return false;
    });
  return {};
}

}

Result<WriterInput> GatherWriterInput(const RankGroup& ranks, WriterInput own)
{
  std::vector<RankGroup::Bytes> out(ranks.Count());
  out[0] = Pack(own.mesh);
  own.mesh = {};
  const auto came = ranks.Exchange(std::move(out));
  KDSTREAM_TRY(came);
  for (std::size_t rank = 0; rank < came->size() && ranks.Rank() == 0; ++rank)
  {
    KDSTREAM_TRY(Append(Unpack(RankMessage((*came)[rank])), own));
  }
  return own;
}

Result<WriterInput> ReadWriterInput(vtkDataObject& input, const Execution& execution)
{
  WriterInput joined;
  Joining joining(joined);
  if (auto* const whole = vtkPolyData::SafeDownCast(&input))
  {
    KDSTREAM_TRY(joining.Add(*whole, execution));
  }
  else if (auto* const parts = vtkPartitionedDataSet::SafeDownCast(&input))
  {
    for (unsigned int i = 0; i < parts->GetNumberOfPartitions(); ++i)
    {
      vtkDataObject* const part = parts->GetPartitionAsDataObject(i);
      auto* const mesh = vtkPolyData::SafeDownCast(part);
      if (part && !mesh)
      {
        return Error{ ErrorCode::InvalidInput, "partition " + std::to_string(i) + " is a " +
                                                 part->GetClassName() + ", and no vtkPolyData" };
      }
      const Status added = mesh ? joining.Add(*mesh, execution) : Status();
      if (!added)
      {
        return Error{ added.GetError().code,
          "partition " + std::to_string(i) + ": " + added.GetError().message };
      }
    }
  }
  else
  {
    return Error{ ErrorCode::InvalidInput,
      std::string("a ") + input.GetClassName() + " cannot be written" };
  }
  joining.DropGhosts();
  return joined;
}

}
