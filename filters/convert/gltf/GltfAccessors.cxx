// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/gltf/GltfAccessors.h"

#include "filters/meshio/QuotedText.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <utility>

namespace kdstream
{
namespace
{

using Json = nlohmann::json;

// The number of components for an accessor's type; 0 for an unknown name.
std::size_t ComponentsOf(const Json& type)
{
  static constexpr std::array<std::pair<const char*, std::size_t>, 7> types{ { { "SCALAR", 1 },
    { "VEC2", 2 }, { "VEC3", 3 }, { "VEC4", 4 }, { "MAT2", 4 }, { "MAT3", 9 }, { "MAT4", 16 } } };
  const auto found = std::find_if(
    types.begin(), types.end(), [&](const auto& known) { return type == known.first; });
  return found == types.end() ? 0 : found->second;
}

// The bytes of a component of this type; 0 for an unknown type.
std::size_t BytesOf(const Json& componentType)
{
  static constexpr std::array<std::size_t, 7> bytes{ 1, 1, 2, 2, 0, 4, 4 }; // for 5120 and more
  const double kind = NumberOf(componentType, 0) - 5120;
  return kind >= 0 && kind < double(bytes.size()) ? bytes[static_cast<std::size_t>(kind)] : 0;
}

std::size_t SizeOf(GltfComponent type)
{
  return BytesOf(static_cast<int>(type));
}

static_assert(std::endian::native == std::endian::little, "numbers are read as they lie");

template <class T>
double NumberAt(const std::uint8_t* place)
{
  T value{};
  std::memcpy(&value, place, sizeof(T));
  return double(value);
}

double NumberAt(const std::uint8_t* place, GltfComponent type)
{
  switch (type)
  {
    case GltfComponent::Byte:
      return NumberAt<std::int8_t>(place);
    case GltfComponent::UnsignedByte:
      return NumberAt<std::uint8_t>(place);
    case GltfComponent::Short:
      return NumberAt<std::int16_t>(place);
    case GltfComponent::UnsignedShort:
      return NumberAt<std::uint16_t>(place);
    case GltfComponent::UnsignedInt:
      return NumberAt<std::uint32_t>(place);
    case GltfComponent::Float:
      break;
  }
  return NumberAt<float>(place);
}

// Finds the `count` elements of `size` bytes that an object has in its bufferView. The object is an
// accessor, or a part of a sparse one. written: the count as the file has it.
struct Elements
{
  GltfBytes bytes; // from the first element on
  std::size_t stride = 0;
};
Result<Elements> Place(const GltfDocument& document, GltfBuffers& buffers, const Json& object,
  const Json& written, double count, std::size_t size)
{
  const Json& views = Member(document.json, "bufferViews");
  const Json& number = Member(object, "bufferView");
  const std::size_t at = IndexIn(views, number);
  if (at == CountOf(views))
  {
    return GltfError(NamesNone("bufferView", number, views));
  }
  const Result<GltfBuffers::View> view = buffers.ViewOf(at);
  if (!view)
  {
    return Within("lies in a bufferView that ", view.GetError());
  }
  const double offset = WholeOf(Member(object, "byteOffset"), 0);
  const double stride = view->stride > 0 ? double(view->stride) : double(size);
  const double room = double(view->bytes.size()) - offset - double(size);
  if (count < 0 || offset < 0 || (count > 0 && (room < 0 || (count - 1) * stride > room)))
  {
    const std::string claimed =
      written.is_number() || written.is_null() ? written.dump() : "no number of";
    return GltfError("claims " + claimed + " elements, more than its bufferView has");
  }
  return Elements{ view->bytes.subspan(static_cast<std::size_t>(count > 0 ? offset : 0)),
    static_cast<std::size_t>(stride) };
}

}

GltfAccessor::GltfAccessor(
  std::vector<std::uint8_t> elements, GltfComponent type, std::size_t components, bool normalized)
  : Own(std::make_shared<const std::vector<std::uint8_t>>(std::move(elements)))
  , ComponentCount(components)
  , Stride(components * SizeOf(type))
  , ComponentType(type)
  , Normalized(normalized)
{
  this->Bytes = *this->Own;
  this->ElementCount = this->Bytes.size() / this->Stride;
}

std::size_t GltfAccessor::ComponentsIn(const Json& accessor)
{
  return ComponentsOf(Member(accessor, "type"));
}

GltfComponent GltfAccessor::TypeIn(const Json& accessor)
{
  const Json& type = Member(accessor, "componentType");
  return BytesOf(type) > 0 ? static_cast<GltfComponent>(static_cast<int>(NumberOf(type, 0)))
                           : GltfComponent::Float;
}

Result<GltfAccessor> GltfAccessor::Open(
  const GltfDocument& document, GltfBuffers& buffers, std::size_t number)
{
  const std::string named = "accessor " + std::to_string(number) + " ";
  const Json& json = Member(document.json, "accessors")[number];
  const Json &type = Member(json, "type"), &componentType = Member(json, "componentType");
  const std::size_t size = BytesOf(componentType);
  GltfAccessor accessor;
  accessor.ComponentCount = ComponentsOf(type);
  if (accessor.ComponentCount == 0 || size == 0)
  {
    return GltfError(named + "has an unknown type: type " + QuotedText(type.dump()) +
                     ", componentType " + QuotedText(componentType.dump()));
  }
  accessor.ComponentType = TypeIn(json);
  accessor.Normalized = Member(json, "normalized") == true;
  accessor.Stride = accessor.ComponentCount * size;
  const double count = WholeOf(Member(json, "count"), -1);
  const Json& sparse = Member(json, "sparse");
  if (!Member(json, "bufferView").is_null())
  {
    const Result<Elements> elements =
      Place(document, buffers, json, Member(json, "count"), count, accessor.Stride);
    if (!elements)
    {
      return Within(named, elements.GetError());
    }
    accessor.Bytes = elements->bytes;
    accessor.Stride = elements->stride;
  }
  else if (count < 0 || count > double(mostZeros))
  {
    return GltfError(named + "claims " + Member(json, "count").dump() +
                     " elements without a bufferView; at most 1048576 can be read");
  }
  accessor.ElementCount = static_cast<std::size_t>(count);
  if (!sparse.is_null())
  {
    if (const Status overlaid = accessor.Overlay(document, buffers, sparse); !overlaid)
    {
      return Within(named, overlaid.GetError());
    }
  }
  return accessor;
}

// Steps: 1. copy all elements, one after the other 2. overwrite those that `sparse` lists.
Status GltfAccessor::Overlay(const GltfDocument& document, GltfBuffers& buffers, const Json& sparse)
{
  const Json &written = Member(sparse, "count"), &indices = Member(sparse, "indices");
  const double count = WholeOf(written, -1);
  const std::size_t size = this->ComponentCount * SizeOf(this->ComponentType);
  const std::size_t indexSize = BytesOf(Member(indices, "componentType"));
  const GltfComponent indexType = TypeIn(indices);
  if (indexSize == 0 || indexType == GltfComponent::Float)
  {
    return GltfError("is sparse, but its indices are not whole numbers");
  }
  const Result<Elements> at = Place(document, buffers, indices, written, count, indexSize);
  const Result<Elements> values =
    at ? Place(document, buffers, Member(sparse, "values"), written, count, size) : at;
  if (!values)
  {
    return Within("has a property 'sparse' that ", values.GetError());
  }
  std::vector<std::uint8_t> all(this->ElementCount * size, 0);
  for (std::size_t i = 0; i < this->ElementCount && !this->Bytes.empty(); ++i)
  {
    std::copy_n(this->Bytes.data() + i * this->Stride, size, all.data() + i * size);
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
  {
    const double place = NumberAt(at->bytes.data() + i * at->stride, indexType);
    if (place < 0 || place >= double(this->ElementCount))
    {
      return GltfError("is sparse, and names its element " +
                       std::to_string(static_cast<std::int64_t>(place)) + ", but there are " +
                       std::to_string(this->ElementCount));
    }
    std::copy_n(values->bytes.data() + i * values->stride, size,
      all.data() + static_cast<std::size_t>(place) * size);
  }
  this->Own = std::make_shared<const std::vector<std::uint8_t>>(std::move(all));
  this->Bytes = *this->Own;
  this->Stride = size;
  return {};
}

double GltfAccessor::Get(std::size_t element, std::size_t component) const
{
  return this->Bytes.empty() ? 0
                             : NumberAt(this->Bytes.data() + element * this->Stride +
                                          component * SizeOf(this->ComponentType),
                                 this->ComponentType);
}

double GltfAccessor::Part(std::size_t element, std::size_t component, bool always) const
{
  const double value = this->Get(element, component);
  if (!this->Normalized && !always)
  {
    return value;
  }
  switch (this->ComponentType)
  {
    case GltfComponent::Byte:
      return std::max(value / std::numeric_limits<std::int8_t>::max(), -1.0);
    case GltfComponent::UnsignedByte:
      return value / std::numeric_limits<std::uint8_t>::max();
    case GltfComponent::Short:
      return std::max(value / std::numeric_limits<std::int16_t>::max(), -1.0);
    case GltfComponent::UnsignedShort:
      return value / std::numeric_limits<std::uint16_t>::max();
    case GltfComponent::UnsignedInt:
      return value / std::numeric_limits<std::uint32_t>::max();
    case GltfComponent::Float:
      break;
  }
  return value;
}

}
