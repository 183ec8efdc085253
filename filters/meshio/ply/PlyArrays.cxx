// SPDX-License-Identifier: BSD-3-Clause
// Finds out which scalar properties of a PLY element make up which array: see PlyArrays.h.
#include "filters/meshio/ply/PlyArrays.h"

#include "filters/core/Texts.h"

#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <string_view>

namespace kdstream
{
namespace
{

constexpr std::size_t mostComponents = 255;

// The type of the properties that hold an array, and how many properties make up one component.
struct PropertyKind
{
  AttributeType type;
  std::size_t number = 1;
};

PropertyKind KindOf(AttributeType type)
{
  const bool isWide = type == AttributeType::Int64 || type == AttributeType::UInt64;
  return isWide ? PropertyKind{ AttributeType::UInt32, 2 } : PropertyKind{ type };
}

// Properties that form one array by convention. The last of four is optional.
struct KnownGroup
{
  std::array<std::string_view, 4> properties;
  std::size_t components;
  bool color;
  std::string_view name;
};

constexpr std::array<KnownGroup, 7> knownGroups{ {
  { { "nx", "ny", "nz", "" }, 3, false, "Normals" },
  { { "red", "green", "blue", "alpha" }, 3, true, "RGB" },
  { { "diffuse_red", "diffuse_green", "diffuse_blue", "diffuse_alpha" }, 3, true, "RGB" },
  { { "r", "g", "b", "a" }, 3, true, "RGB" },
  { { "u", "v", "", "" }, 2, false, "TCoords" },
  { { "s", "t", "", "" }, 2, false, "TCoords" },
  { { "texture_u", "texture_v", "", "" }, 2, false, "TCoords" },
} };

// Turns each %HH into a byte; any other % stays.
std::string Unescape(std::string_view name)
{
  std::string plain;
  for (std::size_t i = 0; i < name.size(); ++i)
  {
    const bool room = name[i] == '%' && i + 2 < name.size();
    const auto byte = room ? PercentDecoded(name.substr(i, 3)) : std::nullopt;
    plain += byte ? *byte : std::string(1, name[i]);
    i += byte ? 2 : 0;
  }
  return plain;
}

void AppendEscaped(std::string& text, char byte)
{
  constexpr std::string_view digits = "0123456789ABCDEF";
  const auto value = static_cast<unsigned char>(byte);
  text += '%';
  text += digits[value >> 4];
  text += digits[value & 15U];
}

// The property name for an array's name. `guarded`: the first and last byte are escaped in any
// case, so that the result neither is a known name nor ends like one.
std::string Escape(std::string_view name, bool guarded)
{
  std::string text;
  for (std::size_t i = 0; i < name.size(); ++i)
  {
    const char c = name[i];
    const bool isEscape = c == '%' && Unescape(name.substr(i)) != name.substr(i);
    if ((c >= 0 && c <= ' ') || c == 0x7F || isEscape ||
        (guarded && (i == 0 || i + 1 == name.size())))
    {
      AppendEscaped(text, c);
    }
    else
    {
      text += c;
    }
  }
  return text;
}

class ArrayFinder
{
public:
  ArrayFinder(
    const PlyElement& element, AttributeAssociation association, std::span<const std::size_t> taken)
    : Element(element)
    , Association(association)
    , Used(element.properties.size(), false)
  {
    std::set<std::string_view> names;
    for (std::size_t p = 0; p < this->Used.size(); ++p)
    {
      const PlyProperty& property = element.properties[p];
      this->Used[p] = !names.insert(property.name).second || property.isList;
    }
    for (const std::size_t p : taken)
    {
      this->Used[p] = true;
    }
  }

  std::vector<PlyArray> Find(std::size_t most)
  {
    for (const KnownGroup& group : knownGroups)
    {
      this->TakeGroup(group);
    }
    for (std::size_t p = 0; p < this->Used.size(); ++p)
    {
      if (!this->Used[p] && !this->TakeNumbered(p))
      {
        this->Take(Unescape(this->Element.properties[p].name), { p });
      }
    }
    std::sort(this->Arrays.begin(), this->Arrays.end(),
      [](const PlyArray& a, const PlyArray& b) { return a.properties[0] < b.properties[0]; });
    this->Arrays.resize(std::min(most, this->Arrays.size()));
    return std::move(this->Arrays);
  }

private:
  // The property with this name. anyCase: if there is none, one with this name in another case.
  std::size_t Find(std::string_view name, bool anyCase) const
  {
    const std::size_t exact = this->Element.Find(name);
    if (exact < this->Used.size() || !anyCase)
    {
      return exact;
    }
    const auto same = [&](const PlyProperty& property)
    {
      return property.name.size() == name.size() &&
             std::equal(name.begin(), name.end(), property.name.begin(),
               [](char a, char b) { return a == (b >= 'A' && b <= 'Z' ? b - 'A' + 'a' : b); });
    };
    const auto& all = this->Element.properties;
    return static_cast<std::size_t>(std::find_if(all.begin(), all.end(), same) - all.begin());
  }

  // The property with this name and type, unless it is already used.
  std::optional<std::size_t> FindFree(std::string_view name, AttributeType type, bool anyCase) const
  {
    const std::size_t p = name.empty() ? this->Used.size() : this->Find(name, anyCase);
    const bool found =
      p < this->Used.size() && !this->Used[p] && this->Element.properties[p].type == type;
    return found ? std::optional(p) : std::nullopt;
  }

  void TakeGroup(const KnownGroup& group)
  {
    const std::size_t first = this->Find(group.properties[0], group.color);
    if (first == this->Used.size())
    {
      return;
    }
    const AttributeType type = this->Element.properties[first].type;
    if (group.color ? type != AttributeType::UInt8 : IsInteger(type))
    {
      return;
    }
    std::vector<std::size_t> properties;
    for (std::size_t k = 0; k < group.components; ++k)
    {
      const auto p = this->FindFree(group.properties[k], type, group.color);
      if (!p)
      {
        return;
      }
      properties.push_back(*p);
    }
    const auto alpha = this->FindFree(group.properties[3], type, group.color);
    if (alpha)
    {
      properties.push_back(*alpha);
    }
    // If there is already a colour or texture coordinate, a second group does not become another.
    const bool second = this->Names.contains(std::string(group.name)) ||
                        (group.color && this->Names.contains("RGBA"));
    if (!second)
    {
      this->Take(alpha ? "RGBA" : std::string(group.name), std::move(properties));
    }
  }

  // Takes the array NAME_0 NAME_1 …, beginning at property p.
  bool TakeNumbered(std::size_t p)
  {
    const PlyProperty& first = this->Element.properties[p];
    if (!first.name.ends_with("_0") || first.name.size() == 2)
    {
      return false;
    }
    const std::string base = first.name.substr(0, first.name.size() - 2);
    std::vector<std::size_t> properties{ p };
    for (std::size_t next = p + 1; next < this->Used.size() && !this->Used[next]; ++next)
    {
      const PlyProperty& property = this->Element.properties[next];
      if (property.type != first.type || property.name != base + "_" + std::to_string(next - p))
      {
        break;
      }
      properties.push_back(next);
    }
    for (const auto& [ending, type] : { std::pair{ "_int64", AttributeType::Int64 },
           std::pair{ "_uint64", AttributeType::UInt64 } })
    {
      const std::string_view end = ending;
      if (first.type == AttributeType::UInt32 && properties.size() % 2 == 0 &&
          base.size() > end.size() && base.ends_with(end) &&
          properties.size() / 2 <= mostComponents)
      {
        this->Take(Unescape(base.substr(0, base.size() - end.size())), std::move(properties), type);
        return true;
      }
    }
    if (properties.size() == 1 || properties.size() > mostComponents)
    {
      return false;
    }
    this->Take(Unescape(base), std::move(properties));
    return true;
  }

  void Take(std::string name, std::vector<std::size_t> properties,
    std::optional<AttributeType> wide = std::nullopt)
  {
    for (const std::size_t p : properties)
    {
      this->Used[p] = true;
    }
    if (!IsAttributeName(name) || !this->Names.insert(name).second)
    {
      return;
    }
    PlyArray array;
    array.type = this->Element.properties[properties[0]].type;
    array.info = { std::move(name), wide ? *wide : array.type, this->Association,
      static_cast<std::uint8_t>(properties.size() / (wide ? 2 : 1)) };
    array.properties = std::move(properties);
    this->Arrays.push_back(std::move(array));
  }

  const PlyElement& Element;
  AttributeAssociation Association;
  std::vector<bool> Used;
  std::set<std::string> Names;
  std::vector<PlyArray> Arrays;
};

// The known groups that are read as this array, the most usual one first.
std::vector<const KnownGroup*> GroupsOf(const AttributeInfo& array)
{
  const PropertyKind kind = KindOf(array.type);
  std::vector<const KnownGroup*> groups;
  for (const KnownGroup& group : knownGroups)
  {
    const bool alpha = group.color && array.name == "RGBA" && array.components == 4;
    const bool same = alpha || (array.name == group.name && array.components == group.components);
    const bool type =
      group.color ? kind.type == AttributeType::UInt8 : kind.number == 1 && !IsInteger(kind.type);
    if (same && type)
    {
      groups.push_back(&group);
    }
  }
  return groups;
}

// The property names to try for one array. The first choices are the known groups that are read as
// this array; if there are none, its plain name. The last choice is the guarded name.
std::vector<std::string> PropertyNames(const AttributeInfo& array, std::size_t choice, bool& isLast)
{
  const PropertyKind kind = KindOf(array.type);
  const std::vector<const KnownGroup*> groups = GroupsOf(array);
  isLast = choice >= std::max<std::size_t>(groups.size(), 1);
  if (choice < groups.size())
  {
    const auto& names = groups[choice]->properties;
    return { names.begin(), names.begin() + array.components };
  }
  const bool guarded = isLast;
  std::string base = Escape(array.name, guarded);
  if (array.components == 1 && kind.number == 1)
  {
    return { base };
  }
  if (kind.number == 2)
  {
    base += array.type == AttributeType::Int64 ? "_int64" : "_uint64";
  }
  std::vector<std::string> names;
  for (std::size_t k = 0; k < array.components * kind.number; ++k)
  {
    names.push_back(base + "_" + std::to_string(k));
  }
  return names;
}

}

std::vector<PlyArray> FindPlyArrays(const PlyElement& element, AttributeAssociation association,
  std::span<const std::size_t> taken, std::size_t most)
{
  return ArrayFinder(element, association, taken).Find(most);
}

void AddPlyProperties(std::span<const Attribute* const> arrays, PlyElement& element)
{
  const std::size_t leading = element.properties.size();
  std::vector<std::size_t> taken(leading);
  for (std::size_t p = 0; p < leading; ++p)
  {
    taken[p] = p;
  }
  // If an array's properties would be read as something else, the array gets the next choice of
  // names, at last the guarded ones. New names can change how another array is read. So this is
  // repeated until all arrays are read back correctly; with only guarded names they always are.
  std::vector<std::size_t> choice(arrays.size(), 0);
  for (bool again = true; again;)
  {
    again = false;
    element.properties.resize(leading);
    std::vector<std::size_t> begins;
    std::set<std::string> names;
    for (const PlyProperty& property : element.properties)
    {
      names.insert(property.name);
    }
    std::vector<bool> repeated(arrays.size(), false), isLast(arrays.size(), false);
    for (std::size_t k = 0; k < arrays.size(); ++k)
    {
      begins.push_back(element.properties.size());
      bool last = false;
      const std::vector<std::string> properties = PropertyNames(*arrays[k], choice[k], last);
      isLast[k] = last;
      for (const std::string& name : properties)
      {
        repeated[k] = !names.insert(name).second || repeated[k];
        element.properties.push_back({ name, KindOf(arrays[k]->type).type });
      }
    }
    begins.push_back(element.properties.size());
    const std::vector<PlyArray> found = FindPlyArrays(element,
      arrays.empty() ? AttributeAssociation::Point : arrays[0]->association, taken, arrays.size());
    for (std::size_t k = 0; k < arrays.size(); ++k)
    {
      const auto back = std::find_if(found.begin(), found.end(),
        [&](const PlyArray& array) { return array.properties[0] == begins[k]; });
      const bool same = back != found.end() && back->info == arrays[k]->Info() &&
                        back->properties.size() == begins[k + 1] - begins[k];
      if (!isLast[k] && (repeated[k] || !same))
      {
        ++choice[k];
        again = true;
      }
    }
  }
}

PlyArraySink::PlyArraySink(const PlyElement& element, const std::vector<PlyArray>& arrays)
  : ColumnOf(element.properties.size(), none)
{
  std::size_t row = 0;
  for (std::size_t k = 0; k < arrays.size(); ++k)
  {
    std::size_t tuple = 0;
    for (const std::size_t p : arrays[k].properties)
    {
      this->ColumnOf[p] = this->ColumnList.size();
      this->ColumnList.push_back({ p, k, tuple, row + tuple, arrays[k].type });
      tuple += SizeOf(arrays[k].type);
    }
    this->Sizes.push_back(tuple);
    row += tuple;
  }
  this->Row.resize(row);
}

bool PlyArraySink::Append(std::size_t times)
{
  this->Repeated += times > 1 ? (times - 1) * this->Row.size() : 0;
  if (this->Repeated > this->MostRepeated)
  {
    return false;
  }
  const std::uint8_t* tuple = this->Row.data();
  for (std::size_t k = 0; k < this->Sizes.size(); ++k)
  {
    std::vector<std::uint8_t>& values = this->Attributes[k].values;
    for (std::size_t i = 0; i < times; ++i)
    {
      values.insert(values.end(), tuple, tuple + this->Sizes[k]);
    }
    tuple += this->Sizes[k];
  }
  return true;
}

std::uint8_t* PlyArraySink::Extend(std::size_t array, std::size_t count)
{
  std::vector<std::uint8_t>& values = this->Attributes[array].values;
  const std::size_t before = values.size();
  values.resize(before + count * this->Sizes[array]);
  return values.data() + before;
}

}
