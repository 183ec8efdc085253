// SPDX-License-Identifier: BSD-3-Clause
#include "filters/build/UnusedParts.h"

#include "filters/outofcore/files/RecordFile.h"
#include "filters/outofcore/files/Tuples.h"
#include "filters/store/UnusedList.h"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <numeric>
#include <span>
#include <vector>

namespace kdstream
{
namespace
{

// Copies of the point arrays without values.
std::vector<Attribute> PointArraysOf(std::span<const AttributeInfo> attributes)
{
  std::vector<Attribute> arrays;
  for (const AttributeInfo& attribute : attributes)
  {
    if (attribute.association == AttributeAssociation::Point)
    {
      arrays.push_back({ attribute, {} });
    }
  }
  return arrays;
}

// vertices: in the order of the input. The part has them sorted by coordinates, because that
// compresses best.
Piece PartOf(const Mesh& vertices)
{
  std::vector<VertexId> order(vertices.points.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(),
    [&](VertexId a, VertexId b) { return vertices.points[a] < vertices.points[b]; });
  Piece part;
  part.id = UnusedPartId();
  part.primitive = PrimitiveType::Points;
  part.ownVertices = static_cast<std::uint32_t>(order.size());
  part.attributes = PointArraysOf(
    std::vector<AttributeInfo>(vertices.attributes.begin(), vertices.attributes.end()));
  for (const VertexId v : order)
  {
    part.keys.push_back(MakeKey(0, static_cast<std::uint32_t>(part.positions.size())));
    part.positions.push_back(vertices.points[v]);
    for (std::size_t k = 0; k < part.attributes.size(); ++k)
    {
      part.attributes[k].Append(vertices.attributes[k], v);
    }
  }
  return part;
}

// read(first, count, part): appends `count` vertices, beginning with `first`, to `part`, an empty
// mesh that has the arrays.
Status WriteParts(std::uint64_t count, std::span<const AttributeInfo> attributes,
  ScalarType scalarType, StoreWriter& writer, const Execution& execution,
  const std::function<Status(std::uint64_t first, std::size_t count, Mesh& part)>& read)
{
  const std::uint32_t ofPart = UnusedOfPart(attributes);
  for (std::uint64_t first = 0; first < count; first += ofPart)
  {
    Mesh vertices{ {}, {}, scalarType, PointArraysOf(attributes) };
    KDSTREAM_TRY(read(
      first, static_cast<std::size_t>(std::min<std::uint64_t>(ofPart, count - first)), vertices));
    const Piece part = PartOf(vertices);
    KDSTREAM_TRY(writer.AddUnused(part, EncodePiece(part, UnusedCodec(scalarType))));
    KDSTREAM_TRY(execution.Report("write", 0));
  }
  return {};
}

}

Status WriteUnused(const Mesh& unused, StoreWriter& writer, const Execution& execution)
{
  const std::vector<AttributeInfo> attributes(unused.attributes.begin(), unused.attributes.end());
  return WriteParts(unused.points.size(), attributes, unused.scalarType, writer, execution,
    [&](std::uint64_t first, std::size_t count, Mesh& part) -> Status
    {
      const auto begin = unused.points.begin() + std::ptrdiff_t(first);
      part.points.assign(begin, begin + std::ptrdiff_t(count));
      for (std::size_t k = 0; k < part.attributes.size(); ++k)
      {
        const std::size_t size = part.attributes[k].TupleSize();
        const auto values = unused.attributes[k].values.begin() + std::ptrdiff_t(first * size);
        part.attributes[k].values.assign(values, values + std::ptrdiff_t(count * size));
      }
      return {};
    });
}

Status WriteUnused(const VertexFiles& unused, std::span<const AttributeInfo> attributes,
  ScalarType scalarType, StoreWriter& writer, const Execution& execution)
{
  return WriteParts(unused.count, attributes, scalarType, writer, execution,
    [&](std::uint64_t first, std::size_t count, Mesh& part) -> Status
    {
      part.points.resize(count);
      KDSTREAM_TRY(ReadRecords<Vec3>(unused.points, first, std::span<Vec3>(part.points)));
      std::vector<std::byte> tuples(count * unused.tupleBytes);
      if (!tuples.empty())
      {
        KDSTREAM_TRY(unused.tuples.Read(first * unused.tupleBytes, tuples));
      }
      SplitTuples(tuples, part.attributes);
      return {};
    });
}

}
