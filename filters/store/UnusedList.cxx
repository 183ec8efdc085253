// SPDX-License-Identifier: BSD-3-Clause
#include "filters/store/UnusedList.h"

#include <algorithm>

namespace kdstream
{

PieceId UnusedPartId()
{
  return { Resolution::Original(), 1 };
}

CodecContext UnusedCodec(ScalarType scalarType)
{
  return { TreeDepths{}, CoordinateGrid::Exact(scalarType) };
}

std::uint32_t UnusedOfPart(std::span<const AttributeInfo> attributes)
{
  constexpr std::uint64_t mostVertices = 8192, mostBytes = std::uint64_t{ 1 } << 20;
  std::uint64_t bytes = sizeof(Vec3);
  for (const AttributeInfo& attribute : attributes)
  {
    bytes += attribute.association == AttributeAssociation::Point ? attribute.TupleSize() : 0;
  }
  return static_cast<std::uint32_t>(std::clamp<std::uint64_t>(mostBytes / bytes, 1, mostVertices));
}

std::uint64_t UnusedPartCount(const ModelDescription& model)
{
  const std::uint64_t ofPart = UnusedOfPart(model.attributes);
  return model.unused ? (model.unused->vertices + ofPart - 1) / ofPart : 0;
}

std::uint64_t SizeOfUnusedPart(const ModelDescription& model, std::uint64_t part)
{
  const std::uint64_t ofPart = UnusedOfPart(model.attributes);
  return std::min(ofPart, model.unused->vertices - part * ofPart);
}

}
