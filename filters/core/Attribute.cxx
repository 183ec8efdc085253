// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/Attribute.h"

#include "filters/core/Texts.h"
#include "filters/core/WithType.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <type_traits>

namespace kdstream
{
namespace
{

static_assert(std::endian::native == std::endian::little, "values are kept little-endian");

// Rounds half away from zero; clamps to the range of T.
template <class T>
T RoundTo(double value)
{
  if constexpr (std::is_floating_point_v<T>)
  {
    return static_cast<T>(value);
  }
  else
  {
    if (std::isnan(value))
    {
      return 0;
    }
    // The limits of T, as doubles, may lie just outside of T. So compare with them instead of
    // converting the clamped value.
    if (value <= double(std::numeric_limits<T>::lowest()))
    {
      return std::numeric_limits<T>::lowest();
    }
    if (value >= double(std::numeric_limits<T>::max()))
    {
      return std::numeric_limits<T>::max();
    }
    return static_cast<T>(std::round(value));
  }
}

}

std::string_view NameOf(AttributeType type)
{
  static constexpr std::string_view names[] = { "int8", "uint8", "int16", "uint16", "int32",
    "uint32", "int64", "uint64", "float32", "float64" };
  return names[static_cast<std::size_t>(type)];
}

AttributeRole RoleOf(const AttributeInfo& attribute)
{
  if (attribute.association != AttributeAssociation::Point)
  {
    return AttributeRole::Other;
  }
  const bool real =
    attribute.type == AttributeType::Float32 || attribute.type == AttributeType::Float64;
  if (real && attribute.name == "Normals" && attribute.components == 3)
  {
    return AttributeRole::Normals;
  }
  if (real && attribute.name == "TCoords" && attribute.components == 2)
  {
    return AttributeRole::TextureCoordinates;
  }
  const bool rgb = attribute.name == "RGB" && attribute.components == 3;
  const bool rgba = attribute.name == "RGBA" && attribute.components == 4;
  return attribute.type == AttributeType::UInt8 && (rgb || rgba) ? AttributeRole::Colors
                                                                 : AttributeRole::Other;
}

bool IsOfCorners(const AttributeInfo& attribute)
{
  return attribute == AttributeInfo{ std::string(textureCornersName), AttributeType::Float32,
    AttributeAssociation::Cell, 6 };
}

bool IsTextureArray(const AttributeInfo& attribute)
{
  return IsOfCorners(attribute) || attribute == AttributeInfo{ std::string(textureMaterialName),
    AttributeType::UInt32, AttributeAssociation::Cell, 1 };
}

bool HoldsIds(const AttributeInfo& attribute)
{
  return attribute.components == 1 && attribute.type < AttributeType::Float32 &&
         (attribute.name == "GlobalIds" || attribute.name == "PedigreeIds");
}

bool IsScalar(const AttributeInfo& attribute)
{
  return attribute.association == AttributeAssociation::Point && attribute.components == 1 &&
         !attribute.name.starts_with("vtk") && !HoldsIds(attribute);
}

bool HoldsClasses(const AttributeInfo& scalar)
{
  std::string name = scalar.name;
  std::transform(name.begin(), name.end(), name.begin(),
    [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  const auto isCalled = [&name](std::string_view word) { return name.find(word) != name.npos; };
  constexpr std::string_view measures[] = { "intens", "reflect", "quality", "confiden", "grey",
    "gray", "alpha" };
  return std::none_of(std::begin(measures), std::end(measures), isCalled) &&
         (SizeOf(scalar.type) == 1 || isCalled("class") || isCalled("label"));
}

std::vector<AttributeInfo> ArraysOfLevels(std::span<const AttributeInfo> attributes)
{
  std::vector<AttributeInfo> arrays;
  std::size_t scalars = 0;
  std::copy_if(attributes.begin(), attributes.end(), std::back_inserter(arrays),
    [&scalars](const AttributeInfo& attribute)
    {
      const AttributeRole role = RoleOf(attribute);
      return role == AttributeRole::Normals || role == AttributeRole::Colors ||
             (IsScalar(attribute) && ++scalars <= mostScalars);
    });
  return arrays;
}

double Attribute::Get(std::size_t tuple, std::size_t component) const
{
  return WithType(this->type,
    [&]<class T>()
    {
      T value;
      std::memcpy(&value, this->values.data() + (tuple * this->components + component) * sizeof(T),
        sizeof(T));
      return static_cast<double>(value);
    });
}

void Attribute::Set(std::size_t tuple, std::size_t component, double value)
{
  WithType(this->type,
    [&]<class T>()
    {
      const T rounded = RoundTo<T>(value);
      std::memcpy(this->values.data() + (tuple * this->components + component) * sizeof(T),
        &rounded, sizeof(T));
    });
}

void Attribute::Append(const Attribute& from, std::size_t tuple)
{
  const std::size_t size = this->TupleSize();
  const std::uint8_t* const begin = from.values.data() + tuple * size;
  this->values.insert(this->values.end(), begin, begin + size);
}

const Attribute* FindRole(std::span<const Attribute> attributes, AttributeRole role)
{
  const auto found = std::find_if(attributes.begin(), attributes.end(),
    [role](const Attribute& attribute) { return RoleOf(attribute) == role; });
  return found == attributes.end() ? nullptr : &*found;
}

const Attribute* FindAttribute(
  std::span<const Attribute> attributes, const AttributeInfo& description)
{
  for (const Attribute& attribute : attributes)
  {
    if (attribute.Info() == description)
    {
      return &attribute;
    }
  }
  return nullptr;
}

Status CheckAttributes(std::span<const Attribute> attributes, std::size_t points, std::size_t cells)
{
  const auto bad = [](const std::string& what) { return Error{ ErrorCode::InvalidInput, what }; };
  if (attributes.size() > mostAttributes)
  {
    return bad(std::to_string(attributes.size()) + " attributes; the maximum is " +
               std::to_string(mostAttributes));
  }
  for (std::size_t i = 0; i < attributes.size(); ++i)
  {
    const Attribute& attribute = attributes[i];
    const std::string which = "attribute " + std::to_string(i);
    if (attribute.name.empty() || attribute.name.size() > longestAttributeName)
    {
      return bad(which + " has a name of " + std::to_string(attribute.name.size()) + " bytes");
    }
    const std::size_t tuples =
      attribute.association == AttributeAssociation::Point ? points : cells;
    if (attribute.components == 0 || attribute.values.size() != tuples * attribute.TupleSize())
    {
      return bad(which + ", \"" + attribute.name + "\", has " +
                 std::to_string(attribute.values.size()) + " bytes");
    }
    for (std::size_t j = 0; j < i; ++j)
    {
      if (attributes[j].association == attribute.association &&
          attributes[j].name == attribute.name)
      {
        return bad(which + " has the name of attribute " + std::to_string(j));
      }
    }
  }
  return {};
}

bool IsAttributeName(std::string_view name)
{
  if (name.empty() || name.size() > longestAttributeName || !IsUtf8(name))
  {
    return false;
  }
  for (std::size_t i = 0; i < name.size(); ++i)
  {
    const auto byte = static_cast<unsigned char>(name[i]);
    // The control characters of Latin-1 (U+0080 to U+009F) are not text either.
    const bool latinControl = byte == 0xC2 && static_cast<unsigned char>(name[i + 1]) < 0xA0;
    if (byte < 0x20 || byte == 0x7F || latinControl)
    {
      return false;
    }
  }
  return true;
}

}
