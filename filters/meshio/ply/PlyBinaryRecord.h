// SPDX-License-Identifier: BSD-3-Clause
// Where values are in the binary records of a PLY file, and how they are loaded. Only for
// PlyBinaryBody.cxx.
#pragma once

#include "filters/meshio/ply/PlyBody.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <type_traits>
#include <vector>

namespace kdstream
{

template <class T, bool Swap>
T Load(const char* bytes)
{
  if constexpr (!Swap || sizeof(T) == 1)
  {
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return value;
  }
  else
  {
    using Bits = std::conditional_t<sizeof(T) == 2, std::uint16_t,
      std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>>;
    Bits bits;
    std::memcpy(&bits, bytes, sizeof(T));
    if constexpr (sizeof(T) == 2)
    {
      bits = __builtin_bswap16(bits);
    }
    else if constexpr (sizeof(T) == 4)
    {
      bits = __builtin_bswap32(bits);
    }
    else
    {
      bits = __builtin_bswap64(bits);
    }
    return std::bit_cast<T>(bits);
  }
}

// The number of bytes of a record, or of some of its properties, if none of them is a list.
struct RecordSize
{
  bool fixed = true;
  std::size_t bytes = 0;
};

inline RecordSize SizeOfProperties(const PlyElement& element, std::size_t begin, std::size_t end)
{
  RecordSize size;
  for (std::size_t k = begin; k < end; ++k)
  {
    size.fixed = size.fixed && !element.properties[k].isList;
    size.bytes += SizeOf(element.properties[k].type);
  }
  return size;
}

// Polygons of more corners than this take the slow path.
inline constexpr std::int64_t mostFastCorners = 64;

// Where the corners are in a face's record. Applies if the record has no other list and indices
// have four bytes, as in nearly all files.
struct FaceLayout
{
  bool applies = false;
  std::size_t cornerList = 0;       // the property with the corners
  std::vector<std::size_t> offsets; // of each property, if the list took no bytes
  std::size_t listOffset = 0;
  std::size_t countSize = 0;
  std::size_t triangleSize = 0; // bytes of a record with three corners
  std::uint64_t indexLimit = 0; // valid indices are below; negative ones, read as unsigned, not
  AttributeType countType = AttributeType::UInt8;

  FaceLayout(const PlyElement& element, std::size_t list, const PlyFaceSink& sink)
  {
    const PlyProperty& property = element.properties[list];
    const RecordSize before = SizeOfProperties(element, 0, list);
    const RecordSize after = SizeOfProperties(element, list + 1, element.properties.size());
    this->countType = property.countType;
    this->listOffset = before.bytes;
    this->cornerList = list;
    std::size_t bytes = 0;
    for (const PlyProperty& each : element.properties)
    {
      this->offsets.push_back(bytes);
      bytes += each.isList ? 0 : SizeOf(each.type);
    }
    this->offsets.push_back(bytes);
    this->countSize = SizeOf(property.countType);
    this->triangleSize = before.bytes + this->countSize + 3 * sizeof(VertexId) + after.bytes;
    this->applies = sink.GetKind() == PlyFaceSink::Kind::Polygon && before.fixed && after.fixed &&
                    IsInteger(property.countType) && IsInteger(property.type) &&
                    SizeOf(property.type) == sizeof(VertexId) &&
                    this->triangleSize <= ByteSource::blockSize;
    const std::uint64_t typeLimit = std::uint64_t{ 1 }
                                    << (property.type == AttributeType::Int32 ? 31 : 32);
    this->indexLimit = std::min(sink.GetVertexCount(), typeLimit);
  }
};

// Where each property lies in a record without lists.
inline std::vector<std::size_t> OffsetsOf(const PlyElement& element)
{
  std::vector<std::size_t> offsets;
  std::size_t bytes = 0;
  for (const PlyProperty& property : element.properties)
  {
    offsets.push_back(bytes);
    bytes += SizeOf(property.type);
  }
  return offsets;
}

}
