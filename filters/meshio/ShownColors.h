// SPDX-License-Identifier: BSD-3-Clause
// Converts colours into the array that viewers show. Files may have them as floats, as 16-bit
// integers, or as the spherical harmonics of Gaussian splats. Part of step "read".
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

// Which arrays of a mesh have colours that viewers cannot show directly, or that may be nearly
// black.
struct HiddenColors
{
  // For red, green and blue: the number of the array, and the component in it.
  std::array<std::size_t, 3> arrays{}, components{};
  bool harmonics = false; // f_dc: colour is 0.5 + 0.2820948 f
  bool packed = false;    // 0xRRGGBB in one number
  bool maybe = false;     // packed if the values say so (ColorScale)
  bool bytes = false;     // shown without conversion: only the values are checked
  AttributeInfo shown{};  // the array to make: "RGB", or "RGBA" if "RGB" is taken
};

// Finds arrays that may be colours; nothing if there are none. If viewers already show colours
// (RoleOf), returns these arrays.
//
// Certainly colours, in lower or upper case:
// - three arrays of numbers of one type: red green blue, r g b, diffuse_red …, ambient_red …;
// - one array of three or four components that is named rgb, rgba, color, colour, colors or
//   diffuse, or that has bytes and color or colour in its name;
// - rgb or rgba of one whole number of 32 bits;
// - f_dc of three floats.
//
// Possibly colours: rgb or rgba of one number of another type.
std::optional<HiddenColors> FindHiddenColors(std::span<const AttributeInfo> attributes);

// Finds which value means white in colours that are numbers, for every format: 1, 255 or 65535, by
// the majority of values. Zeros, and values that are not finite, do not count. O(1) a value.
class ColorWhite
{
public:
  // whole: the values have an integer type. These are taken as 0 to 1 only if all are.
  void Add(double value, bool whole = false);
  double White() const;
  bool IsBlack() const { return this->ToOne + this->ToByte + this->Above == 0; }
  // If not all values agree, part of a sentence: "as most of their values are: 1 of 24 is above it
  // and counts as white"; else empty.
  std::string Doubt() const;

private:
  std::uint64_t Negative = 0, ToOne = 0, ToByte = 0, Above = 0; // below 0, to 1, to 255, above
  std::uint64_t Fractions = 0;                                  // in (0, 1)
  bool Whole = false;
};

// Finds out what the numbers of an array rgb are: floats whose bits are 0x00RRGGBB or 0xFFRRGGBB,
// as PCL writes them; whole numbers 0xRRGGBB; or not colours. O(1) a value.
class PackedColors
{
public:
  void Add(float value);
  bool AreBits() const { return this->Any && this->Bits; }
  bool AreNumbers() const { return this->Whole && this->AnyRed; }

private:
  bool Bits = true, Whole = true, Any = false, AnyRed = false;
};

// Converts colours to the array that is shown.
class ColorScale
{
public:
  explicit ColorScale(HiddenColors colors)
    : Colors(std::move(colors))
  {
  }

  // Learns from the values of the tuples from `begin` on.
  void LookAt(std::span<const Attribute> attributes, std::size_t begin);
  // Appends to `shown` the colours of the tuples from `begin` to `end`.
  void Append(std::span<const Attribute> attributes, std::size_t begin, std::size_t end,
    Attribute& shown) const;
  // "red, green and blue of type float32 are shown as RGB: 1 is white". Empty if there is nothing
  // to report.
  std::string Tell(std::span<const AttributeInfo> attributes) const;
  const AttributeInfo& Shown() const { return this->Colors.shown; }
  // False if the values are not colours, or are shown without conversion: nothing is appended.
  bool AreColors() const
  {
    return !this->Colors.bytes &&
           (!this->Colors.maybe || this->Packed.AreBits() || this->Packed.AreNumbers());
  }
  // Whether further values cannot change the colours, and there is nothing to report about them.
  bool AreUsual() const { return this->Colors.bytes && this->White.White() > 1; }

private:
  HiddenColors Colors;
  ColorWhite White;
  PackedColors Packed;
};

// Finds colours in a whole mesh, adds the array that is shown, and reports it.
void AddShownColors(Mesh& mesh, Tolerance& tolerance);

// Wraps the reader of a file and adds the array, after all others. scale: must have seen all
// vertices.
std::unique_ptr<MeshReader> WithShownColors(std::unique_ptr<MeshReader> reader, ColorScale scale);

}
