// SPDX-License-Identifier: BSD-3-Clause
// Makes and joins attributes while other programs' formats are read, and checks the number of
// points.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <cstdint>
#include <string>
#include <vector>

namespace kdstream
{

// Whether VertexId can number this many points. Errors: LimitExceeded.
inline Status CheckPointCount(std::uint64_t points)
{
  return points < noVertex ? Status()
                           : Error{ ErrorCode::LimitExceeded,
                               std::to_string(points) + " points; at most 4294967294 can be read" };
}

// An attribute with `tuples` tuples of zeros.
inline Attribute MakePointAttribute(
  std::string name, AttributeType type, std::uint8_t components, std::size_t tuples)
{
  Attribute attribute;
  attribute.name = std::move(name);
  attribute.type = type;
  attribute.association = AttributeAssociation::Point;
  attribute.components = components;
  attribute.values.resize(tuples * attribute.TupleSize());
  return attribute;
}

// The array "RGB" (uint8), or with alpha "RGBA", with zeros for each point.
inline Attribute MakeColors(std::size_t tuples, bool alpha = false)
{
  return MakePointAttribute(alpha ? "RGBA" : "RGB", AttributeType::UInt8,
    alpha ? std::uint8_t{ 4 } : std::uint8_t{ 3 }, tuples);
}

inline Attribute MakeNormals(std::size_t tuples)
{
  return MakePointAttribute("Normals", AttributeType::Float32, 3, tuples);
}

}
