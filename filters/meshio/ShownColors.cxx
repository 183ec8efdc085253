// SPDX-License-Identifier: BSD-3-Clause
// Converts colours to the array that viewers show: see ShownColors.h.
#include "filters/meshio/ShownColors.h"

#include "filters/core/BitCast.h"
#include "filters/meshio/TextWords.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>
#include <utility>

namespace kdstream
{
namespace
{

// A name that the new array can have; nothing if both are taken.
std::optional<AttributeInfo> FreeName(std::span<const AttributeInfo> attributes)
{
  for (const auto& [name, components] :
    { std::pair{ "RGB", std::uint8_t{ 3 } }, { "RGBA", std::uint8_t{ 4 } } })
  {
    const char* const wanted = name;
    if (std::none_of(attributes.begin(), attributes.end(),
          [&](const AttributeInfo& array)
          { return array.association == AttributeAssociation::Point && array.name == wanted; }))
    {
      return AttributeInfo{ wanted, AttributeType::UInt8, AttributeAssociation::Point, components };
    }
  }
  return std::nullopt;
}

// Finds three arrays of one number each.
std::optional<HiddenColors> FindTriple(std::span<const AttributeInfo> attributes)
{
  constexpr std::array<std::array<std::string_view, 3>, 7> triples{ { { "red", "green", "blue" },
    { "r", "g", "b" }, { "diffuse_red", "diffuse_green", "diffuse_blue" },
    { "diffuse_r", "diffuse_g", "diffuse_b" }, { "color_red", "color_green", "color_blue" },
    { "color_r", "color_g", "color_b" }, { "ambient_red", "ambient_green", "ambient_blue" } } };
  for (const auto& names : triples)
  {
    HiddenColors colors;
    std::size_t found = 0;
    for (std::size_t k = 0; k < 3; ++k)
    {
      const auto at = std::find_if(attributes.begin(), attributes.end(),
        [&](const AttributeInfo& array)
        {
          return array.association == AttributeAssociation::Point && array.components == 1 &&
                 LowercaseText(array.name) == names[k];
        });
      found += at != attributes.end() ? 1 : 0;
      colors.arrays[k] = static_cast<std::size_t>(at - attributes.begin());
    }
    if (found == 3 && attributes[colors.arrays[0]].type == attributes[colors.arrays[1]].type &&
        attributes[colors.arrays[0]].type == attributes[colors.arrays[2]].type)
    {
      return colors;
    }
  }
  return std::nullopt;
}

bool IsPackedName(const AttributeInfo& array)
{
  const std::string name = LowercaseText(array.name);
  return array.association == AttributeAssociation::Point && array.components == 1 &&
         (name == "rgb" || name == "rgba");
}

// Whether the name says that an array has colours. In arrays of bytes, parts of names count too,
// such as "PaintedColor".
bool IsColorName(const AttributeInfo& array, bool isPart)
{
  constexpr std::array<std::string_view, 7> names{ "rgb", "rgba", "color", "colour", "colors",
    "colours", "diffuse" };
  const std::string name = LowercaseText(array.name);
  return std::any_of(names.begin(), names.end(),
    [&](std::string_view each)
    {
      return name == each || (isPart && array.type == AttributeType::UInt8 &&
                               each.starts_with("col") && name.find(each) != name.npos);
    });
}

// Finds one array of three or four components, or of spherical harmonics.
std::optional<HiddenColors> FindArray(
  std::span<const AttributeInfo> attributes, bool harmonics, bool isPart = false)
{
  for (std::size_t i = 0; i < attributes.size(); ++i)
  {
    const AttributeInfo& array = attributes[i];
    const std::string name = LowercaseText(array.name);
    const bool known =
      harmonics ? name == "f_dc" && array.components == 3 && !IsInteger(array.type)
                : IsColorName(array, isPart) && (array.components == 3 || array.components == 4);
    if (known && array.association == AttributeAssociation::Point)
    {
      return HiddenColors{ { i, i, i }, { 0, 1, 2 }, harmonics, false, false, false, {} };
    }
    if (!harmonics && IsPackedName(array) && SizeOf(array.type) == 4 && IsInteger(array.type))
    {
      return HiddenColors{ { i, i, i }, {}, false, true, false, false, {} };
    }
  }
  return std::nullopt;
}

std::optional<HiddenColors> FindPacked(std::span<const AttributeInfo> attributes)
{
  for (std::size_t i = 0; i < attributes.size(); ++i)
  {
    if (IsPackedName(attributes[i]))
    {
      return HiddenColors{ { i, i, i }, {}, false, true, true, false, {} };
    }
  }
  return std::nullopt;
}

float FloatAt(const Attribute& array, std::size_t tuple)
{
  if (array.type != AttributeType::Float32)
  {
    return static_cast<float>(array.Get(tuple, 0));
  }
  float value = 0; // bit for bit: it may be NaN
  std::memcpy(&value, array.values.data() + tuple * sizeof(value), sizeof(value));
  return value;
}

class ShownColorsReader : public MeshReader
{
public:
  ShownColorsReader(std::unique_ptr<MeshReader> reader, ColorScale scale)
    : Reader(std::move(reader))
    , Scale(std::move(scale))
    , Arrays(this->Reader->Info().attributes.size())
    , Reported(this->Scale.Tell(this->Reader->Info().attributes))
  {
    this->TakeInfo();
  }

  const MeshFileInfo& Info() const override { return this->FileInfo; }

  Result<std::size_t> ReadVertices(Mesh& mesh, std::size_t limit) override
  {
    const std::size_t before = mesh.points.size();
    const Result<std::size_t> read = this->Reader->ReadVertices(mesh, limit);
    KDSTREAM_TRY(read);
    this->Prepare(mesh);
    if (this->Scale.AreColors())
    {
      this->Scale.Append(
        mesh.attributes, before, mesh.points.size(), mesh.attributes[this->Arrays]);
    }
    this->TakeInfo();
    return read;
  }
  Result<std::size_t> ReadTriangles(Mesh& mesh, std::size_t limit) override
  {
    Result<std::size_t> read = this->Reader->ReadTriangles(mesh, limit);
    this->Prepare(mesh);
    this->TakeInfo();
    return read;
  }
  Result<std::uint64_t> SkipVertices(std::uint64_t count) override
  {
    Result<std::uint64_t> skipped = this->Reader->SkipVertices(count);
    this->TakeInfo();
    return skipped;
  }
  Result<std::uint64_t> SkipFaces(std::uint64_t count) override
  {
    Result<std::uint64_t> skipped = this->Reader->SkipFaces(count);
    this->TakeInfo();
    return skipped;
  }
  std::uint64_t FileSize() const override { return this->Reader->FileSize(); }
  std::uint64_t Position() const override { return this->Reader->Position(); }

private:
  void TakeInfo()
  {
    this->FileInfo = this->Reader->Info();
    if (this->Scale.AreColors())
    {
      this->FileInfo.attributes.push_back(this->Scale.Shown());
    }
    if (!this->Reported.empty())
    {
      this->FileInfo.tolerance.Tell(this->Reported);
    }
  }

  void Prepare(Mesh& mesh) const
  {
    if (this->Scale.AreColors() && mesh.attributes.size() == this->Arrays)
    {
      mesh.attributes.push_back({ this->Scale.Shown(), {} });
    }
  }

  std::unique_ptr<MeshReader> Reader;
  ColorScale Scale;
  std::size_t Arrays; // number of arrays in the file
  std::string Reported;
  MeshFileInfo FileInfo;
};

}

std::optional<HiddenColors> FindHiddenColors(std::span<const AttributeInfo> attributes)
{
  const auto bytes = std::find_if(attributes.begin(), attributes.end(),
    [](const AttributeInfo& array) { return RoleOf(array) == AttributeRole::Colors; });
  if (bytes != attributes.end())
  {
    const auto i = static_cast<std::size_t>(bytes - attributes.begin());
    return HiddenColors{ { i, i, i }, { 0, 1, 2 }, false, false, false, true, *bytes };
  }
  if (attributes.size() >= mostAttributes)
  {
    return std::nullopt;
  }
  std::optional<HiddenColors> found = FindTriple(attributes);
  found = found ? found : FindArray(attributes, false);
  found = found ? found : FindArray(attributes, true);
  found = found ? found : FindPacked(attributes);
  found = found ? found : FindArray(attributes, false, true);
  const std::optional<AttributeInfo> shown = FreeName(attributes);
  if (!found || !shown)
  {
    return std::nullopt;
  }
  found->shown = *shown;
  return found;
}

void ColorWhite::Add(double value, bool whole)
{
  this->Whole = this->Whole || whole;
  if (!std::isfinite(value) || value == 0)
  {
    return;
  }
  this->Fractions += value > 0 && value < 1 ? 1 : 0;
  ++(value < 0      ? this->Negative
     : value <= 1   ? this->ToOne
     : value <= 255 ? this->ToByte
                    : this->Above);
}

double ColorWhite::White() const
{
  const std::uint64_t aboveOne = this->ToByte + this->Above;
  if (aboveOne == 0 || (!this->Whole && this->ToOne > aboveOne))
  {
    return 1;
  }
  return this->Above == 0 || this->ToOne + this->ToByte > this->Above ? 255 : 65535;
}

std::string ColorWhite::Doubt() const
{
  const std::uint64_t all = this->Negative + this->ToOne + this->ToByte + this->Above;
  const double white = this->White();
  const auto tell = [all](std::uint64_t count, const std::string& what, const std::string& become)
  {
    return (count == 1 ? "1 of " + std::to_string(all) + " is " + what + " and counts as "
                       : std::to_string(count) + " of " + std::to_string(all) + " are " + what +
                           " and count as ") +
           become;
  };
  std::string doubt;
  if (const std::uint64_t over =
        white == 1 ? this->ToByte + this->Above : (white == 255 ? this->Above : 0);
      over > 0)
  {
    doubt = "as most of their values are: " + tell(over, "above it", "white");
  }
  // Values that may be dark shades on this scale, or belong to a scale with a smaller white.
  else if (const std::uint64_t under = white == 65535                 ? this->ToOne + this->ToByte
                                       : white == 255 && !this->Whole ? this->Fractions
                                                                      : 0;
           under > (all - under) / 8)
  {
    doubt = "as most of their values are: " +
            tell(under, white == 65535 ? "at most 255" : "below 1", "black");
  }
  if (this->Negative > 0)
  {
    doubt += (doubt.empty() ? "" : ", ") + tell(this->Negative, "below 0", "0");
  }
  return doubt;
}

void PackedColors::Add(float value)
{
  constexpr float most = 16777215; // 0xFFFFFF
  const auto bits = BitCast<std::uint32_t>(value);
  // A NaN that marks a missing value does not count.
  const bool isMissing = bits == 0x7FC00000 || bits == 0xFFC00000;
  if (isMissing || value == 0)
  {
    return;
  }
  this->Any = true;
  const std::uint32_t top = bits >> 24U;
  this->Bits = this->Bits && (top == 0 || top == 255);
  this->Whole = this->Whole && value > 0 && value <= most && value == std::floor(value);
  this->AnyRed = this->AnyRed || value > 65535;
}

void ColorScale::LookAt(std::span<const Attribute> attributes, std::size_t begin)
{
  if (this->Colors.maybe)
  {
    const Attribute& array = attributes[this->Colors.arrays[0]];
    for (std::size_t i = begin; i < array.TupleCount(); ++i)
    {
      this->Packed.Add(FloatAt(array, i));
    }
  }
  for (std::size_t k = 0; k < 3 && !this->Colors.harmonics && !this->Colors.packed; ++k)
  {
    const Attribute& array = attributes[this->Colors.arrays[k]];
    for (std::size_t i = begin; i < array.TupleCount(); ++i)
    {
      this->White.Add(array.Get(i, this->Colors.components[k]), IsInteger(array.type));
    }
  }
}

void ColorScale::Append(
  std::span<const Attribute> attributes, std::size_t begin, std::size_t end, Attribute& shown) const
{
  constexpr double harmonic = 0.28209479177387814; // of degree 0: 1 / (2 sqrt(pi))
  constexpr double most = 255;
  const double white = this->White.White();
  shown.values.resize(end * shown.TupleSize(), std::uint8_t{ 255 }); // opaque
  for (std::size_t i = begin; i < end && this->Colors.packed; ++i)
  {
    const Attribute& array = attributes[this->Colors.arrays[0]];
    const auto bits = this->Packed.AreBits()
                        ? BitCast<std::uint32_t>(FloatAt(array, i))
                        : static_cast<std::uint32_t>(static_cast<std::int64_t>(array.Get(i, 0)));
    for (std::size_t k = 0; k < 3; ++k)
    {
      shown.Set(i, k, double(bits >> (16 - 8 * k) & 255U));
    }
  }
  if (this->Colors.packed)
  {
    return;
  }
  for (std::size_t k = 0; k < 3; ++k)
  {
    const Attribute& array = attributes[this->Colors.arrays[k]];
    const std::size_t component = this->Colors.components[k];
    for (std::size_t i = begin; i < end; ++i)
    {
      const double value = array.Get(i, component);
      shown.Set(i, k, most * (this->Colors.harmonics ? 0.5 + harmonic * value : value / white));
    }
  }
}

std::string ColorScale::Tell(std::span<const AttributeInfo> attributes) const
{
  const AttributeInfo& first = attributes[this->Colors.arrays[0]];
  const AttributeInfo& last = attributes[this->Colors.arrays[2]];
  const std::string names =
    first == last ? first.name
                  : first.name + ", " + attributes[this->Colors.arrays[1]].name + ", " + last.name;
  if (this->Colors.bytes)
  {
    return this->White.White() > 1 || this->White.IsBlack()
             ? std::string()
             : names + " has only the bytes 0 and 1, which are nearly black, as white is 255: if "
                       "1 is white, export its colours from 0 to 255, or as floats";
  }
  if (this->Colors.harmonics)
  {
    return names + " is taken for the colours of Gaussian splats, and shown as " +
           this->Colors.shown.name;
  }
  if (!this->AreColors())
  {
    return names + " of type " + std::string(NameOf(first.type)) +
           " is not shown: its values are not colours packed into numbers (0xRRGGBB). Colours are "
           "shown as red, green and blue";
  }
  if (this->Colors.packed)
  {
    return names + " is taken for colours of three bytes in a number (0xRRGGBB), and shown as " +
           this->Colors.shown.name;
  }
  const std::string doubt = this->White.Doubt();
  return names + " of type " + std::string(NameOf(first.type)) +
         " are taken for colours, of which " +
         std::to_string(static_cast<int>(this->White.White())) + " is white" +
         (doubt.empty() ? "" : ", " + doubt) + ", and shown as " + this->Colors.shown.name;
}

void AddShownColors(Mesh& mesh, Tolerance& tolerance)
{
  std::vector<AttributeInfo> infos;
  for (const Attribute& attribute : mesh.attributes)
  {
    infos.push_back(attribute.Info());
  }
  std::optional<HiddenColors> found = FindHiddenColors(infos);
  if (!found)
  {
    return;
  }
  ColorScale scale(std::move(*found));
  scale.LookAt(mesh.attributes, 0);
  if (scale.AreColors())
  {
    Attribute shown{ scale.Shown(), {} };
    scale.Append(mesh.attributes, 0, mesh.points.size(), shown);
    mesh.attributes.push_back(std::move(shown));
  }
  if (const std::string reported = scale.Tell(infos); !reported.empty())
  {
    tolerance.Tell(reported);
  }
}

std::unique_ptr<MeshReader> WithShownColors(std::unique_ptr<MeshReader> reader, ColorScale scale)
{
  return std::make_unique<ShownColorsReader>(std::move(reader), std::move(scale));
}

}
