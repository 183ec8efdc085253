// SPDX-License-Identifier: BSD-3-Clause
// Converts colours that files have as floats, as 16-bit integers, or as the spherical harmonics of
// Gaussian splats, into the array that viewers show. Part of step "read".
#pragma once

#include "filters/core/Types.h"
#include "filters/meshio/MeshReader.h"
#include "filters/meshio/Tolerance.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

namespace kdstream
{

// Where a mesh's arrays have colours that are not shown as they are, or that may be nearly black.
struct HiddenColors
{
  // For red, green and blue: the array, and the component in it.
  std::array<std::size_t, 3> arrays{}, components{};
  bool harmonics = false; // f_dc: colour is 0.5 + 0.2820948 f
  bool packed = false;    // 0xRRGGBB in one number
  bool maybe = false;     // packed, if the values say so (ColorScale)
  bool bytes = false;     // shown as they are: only their values are looked at
  AttributeInfo shown{};  // the array to make: "RGB", or "RGBA" where that name is taken
};

// The arrays that may be colours; nothing if there are none. If viewers already show colours
// (RoleOf), these. Certain colours, in lower or upper case: red green blue, r g b, diffuse_red …,
// ambient_red …, as three arrays of numbers of one type; one array of three or four components
// named rgb, rgba, color, colour, colors, diffuse, or of bytes with color or colour in its name;
// rgb or rgba of one whole number of 32 bits; f_dc of three floats. Possible colours: rgb or rgba
// of one number of another type.
std::optional<HiddenColors> FindHiddenColors(std::span<const AttributeInfo> attributes);

// Finds the value of white in colours that are numbers, for every format: 1, 255 or 65535, by the
// majority of values. Zeros, and values that are not finite, do not count. O(1) a value.
class ColorWhite
{
public:
  // whole: values of a type of whole numbers, which are from 0 to 1 only if all are.
  void Add(double value, bool whole = false);
  double White() const;
  bool IsBlack() const { return this->ToOne + this->ToByte + this->Above == 0; }
  // A sentence part if not all values agree: "as most of their values are: 1 of 24 is above it and
  // counts as white"; else empty.
  std::string Doubt() const;

private:
  std::uint64_t Negative = 0, ToOne = 0, ToByte = 0, Above = 0; // in (0, 1], (1, 255], above
  std::uint64_t Fractions = 0;                                  // in (0, 1)
  bool Whole = false;
};

// Finds out what the numbers of an array rgb are: floats whose bits are 0x00RRGGBB or 0xFFRRGGBB,
// as in PCL, whole numbers 0xRRGGBB, or not colours. O(1) a value.
class PackedColors
{
public:
  void Add(float value);
  bool AreBits() const { return this->Any && this->Bits; }
  bool AreNumbers() const { return this->Whole && this->AnyRed; }

private:
  bool Bits = true, Whole = true, Any = false, AnyRed = false;
};

// Makes colours into the array that is shown.
class ColorScale
{
public:
  explicit ColorScale(HiddenColors colors)
    : Colors(std::move(colors))
  {
  }

  // Looks at the tuples from `begin` on.
  void LookAt(std::span<const Attribute> attributes, std::size_t begin);
  // Appends the shown tuples for those from `begin` to `end` of the others.
  void Append(std::span<const Attribute> attributes, std::size_t begin, std::size_t end,
    Attribute& shown) const;
  // "red, green and blue of type float32 are shown as RGB: 1 is white". Empty: nothing to say.
  std::string Tell(std::span<const AttributeInfo> attributes) const;
  const AttributeInfo& Shown() const { return this->Colors.shown; }
  // False if the values are not colours, or are shown as they are: nothing is appended.
  bool AreColors() const
  {
    return !this->Colors.bytes &&
           (!this->Colors.maybe || this->Packed.AreBits() || this->Packed.AreNumbers());
  }
  // Whether no further values can change the colours, and nothing about them has to be reported.
  bool AreUsual() const { return this->Colors.bytes && this->White.White() > 1; }

private:
  HiddenColors Colors;
  ColorWhite White;
  PackedColors Packed;
};

// Adds the colours of a whole mesh, if it has such arrays, and reports it.
void AddShownColors(Mesh& mesh, Tolerance& tolerance);

// Wraps the reader of a file and adds the array, after all others. scale: after it has seen all
// vertices.
std::unique_ptr<MeshReader> WithShownColors(std::unique_ptr<MeshReader> reader, ColorScale scale);

}
