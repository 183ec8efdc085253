// SPDX-License-Identifier: BSD-3-Clause
// Predicts an attribute's values one after the other; only differences from the prediction are
// coded. Layout: doc/formats.md, "Attributes".
#pragma once

#include "filters/codec/TriangleWalk.h"
#include "filters/core/Attribute.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// Turns the components of one type into unsigned integers of the same order, and back. Inverts the
// sign bit, or all bits of a negative float.
class ComponentOrder
{
public:
  explicit ComponentOrder(AttributeType type)
    : IsFloat(type >= AttributeType::Float32)
    , Sign(std::uint64_t{ 1 } << (8 * SizeOf(type) - 1))
  {
    const bool isUnsigned = !this->IsFloat && static_cast<unsigned>(type) % 2 == 1;
    this->Turned = isUnsigned ? 0 : this->Sign;
  }

  std::uint64_t Ordered(std::uint64_t bits) const
  {
    const bool isNegativeFloat = this->IsFloat && (bits & this->Sign) != 0;
    return bits ^ (isNegativeFloat ? this->AllBits() : this->Turned);
  }
  std::uint64_t BitsOf(std::uint64_t ordered) const
  {
    const bool isNegativeFloat = this->IsFloat && (ordered & this->Sign) == 0;
    return ordered ^ (isNegativeFloat ? this->AllBits() : this->Turned);
  }

private:
  std::uint64_t AllBits() const { return this->Sign | (this->Sign - 1); }

  bool IsFloat;
  std::uint64_t Sign, Turned;
};

// A component of a coarse colour is one of 16 steps of 17, coded by its number.
constexpr std::uint64_t coarseMask = 15, coarseStep = 17;
constexpr std::uint64_t CoarseOf(std::uint64_t component)
{
  return (component * coarseMask + 127) / 255;
}

// Predicts components, as ordered integers, from earlier ones. For vertices, which come in the
// order of the walk, the prediction is the mean of the values at the gate's start and end. For
// triangles, which come in the order of the piece, it is the value of the previous triangle.
class AttributePredictor
{
public:
  // walk: for an attribute of vertices; otherwise empty.
  AttributePredictor(
    const AttributeInfo& attribute, std::size_t tuples, std::span<const WalkVertex> walk)
    : Components(attribute.components)
    , UnusedBits(static_cast<unsigned>(64 - 8 * SizeOf(attribute.type)))
    , Walk(walk)
    , Known(tuples * attribute.components)
  {
  }

  // ofRed: 0, or for a coarse colour the difference of its red: green and blue mostly differ from
  // their predictions as red does. REQUIRES: all tuples before are set.
  std::uint64_t Predict(std::size_t tuple, std::size_t component, std::uint64_t ofRed) const
  {
    const std::size_t before = tuple > 0 ? tuple - 1 : 0;
    const std::size_t first = this->Walk.empty() ? before : this->Walk[tuple].gate[0];
    const std::size_t second = this->Walk.empty() ? before : this->Walk[tuple].gate[1];
    const std::uint64_t a = this->Known[first * this->Components + component];
    const std::uint64_t b = this->Known[second * this->Components + component];
    const std::uint64_t mean = (a & b) + ((a ^ b) >> 1); // rounded down; a + b could overflow
    return mean + (component == 1 || component == 2 ? ofRed : 0);
  }
  void Set(std::size_t tuple, std::size_t component, std::uint64_t value)
  {
    this->Known[tuple * this->Components + component] = value;
  }

  // The difference from a prediction, as a signed number of the type's width; and the inverse.
  std::int64_t Difference(std::uint64_t value, std::uint64_t predicted) const
  {
    return static_cast<std::int64_t>((value - predicted) << this->UnusedBits) >> this->UnusedBits;
  }
  std::uint64_t Sum(std::uint64_t predicted, std::int64_t difference) const
  {
    const std::uint64_t sum = predicted + static_cast<std::uint64_t>(difference);
    return sum << this->UnusedBits >> this->UnusedBits;
  }

private:
  std::size_t Components;
  unsigned UnusedBits; // 64 minus the bits of the type
  std::span<const WalkVertex> Walk;
  std::vector<std::uint64_t> Known;
};

}
