// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/gltf/GltfCompression.h"

#include "filters/convert/gltf/GltfDocument.h"
#include "filters/meshio/QuotedText.h"

#ifdef KDSTREAM_HAS_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif
#ifdef KDSTREAM_HAS_DRACO
#include <draco/compression/decode.h>
#endif

#include <algorithm>
#include <exception>
#include <optional>
#include <utility>

namespace kdstream
{
namespace
{

using Json = nlohmann::json;

#ifdef KDSTREAM_HAS_MESHOPTIMIZER

// Whether compressed bytes can hold `count` elements. Attributes need at least a byte for 64 bytes,
// because two bits say that 16 bytes are zeros. Indices need at least a byte for a triangle, or for
// an index.
bool MayHold(std::size_t bytes, const std::string& mode, double count, double stride)
{
  const double least = mode == "ATTRIBUTES"  ? count * stride / 64
                       : mode == "TRIANGLES" ? count / 3
                                             : count;
  return least <= double(bytes);
}

int Decode(const std::string& mode, std::size_t count, std::size_t stride,
  std::span<const std::uint8_t> from, std::uint8_t* to)
{
  return mode == "ATTRIBUTES"
           ? meshopt_decodeVertexBuffer(to, count, stride, from.data(), from.size())
         : mode == "TRIANGLES"
           ? meshopt_decodeIndexBuffer(to, count, stride, from.data(), from.size())
           : meshopt_decodeIndexSequence(to, count, stride, from.data(), from.size());
}

// Applies a filter to decompressed attributes. False if this filter does not exist for this stride.
bool Filter(const std::string& filter, std::size_t count, std::size_t stride, std::uint8_t* values)
{
  if (filter == "OCTAHEDRAL" && (stride == 4 || stride == 8))
  {
    meshopt_decodeFilterOct(values, count, stride);
  }
  else if (filter == "QUATERNION" && stride == 8)
  {
    meshopt_decodeFilterQuat(values, count, stride);
  }
  else if (filter == "EXPONENTIAL" && stride % 4 == 0)
  {
    meshopt_decodeFilterExp(values, count, stride);
  }
  else
  {
    return filter == "NONE";
  }
  return true;
}

#endif

}

const Json& MeshoptOf(const Json& view)
{
  const Json& extensions = Member(view, "extensions");
  const Json& ratified = Member(extensions, "KHR_meshopt_compression");
  return ratified.is_null() ? Member(extensions, "EXT_meshopt_compression") : ratified;
}

#ifdef KDSTREAM_HAS_MESHOPTIMIZER

Result<std::vector<std::uint8_t>> DecodeMeshopt(
  const Json& compressed, std::span<const std::uint8_t> bytes)
{
  const auto textOf = [&](const char* name, const char* otherwise)
  {
    const Json& text = Member(compressed, name);
    return text.is_string() ? text.get<std::string>() : std::string(otherwise);
  };
  const std::string mode = textOf("mode", ""), filter = textOf("filter", "NONE");
  const double count = WholeOf(Member(compressed, "count"), -1);
  const double stride = WholeOf(Member(compressed, "byteStride"), -1);
  const bool attributes = mode == "ATTRIBUTES";
  if (!attributes && mode != "TRIANGLES" && mode != "INDICES")
  {
    return GltfError("is compressed by meshoptimizer in an unknown mode: " + QuotedText(mode));
  }
  const bool strideFits =
    attributes ? stride > 0 && stride <= 256 && int(stride) % 4 == 0 : stride == 2 || stride == 4;
  if (!strideFits || count < 0 ||
      (mode == "TRIANGLES" && static_cast<std::uint64_t>(count) % 3 > 0))
  {
    return GltfError("is compressed by meshoptimizer with an invalid count or byteStride: " +
                     Member(compressed, "count").dump() + ", " +
                     Member(compressed, "byteStride").dump());
  }
  if (!MayHold(bytes.size(), mode, count, stride))
  {
    return GltfError("claims " + Member(compressed, "count").dump() +
                     " compressed elements, more than its " + std::to_string(bytes.size()) +
                     " bytes can hold");
  }
  const auto elements = static_cast<std::size_t>(count), size = static_cast<std::size_t>(stride);
  std::vector<std::uint8_t> decoded(elements * size);
  if (Decode(mode, elements, size, bytes, decoded.data()) != 0)
  {
    // The first byte has the kind and the version. The library here knows only the first versions.
    const unsigned head = bytes.empty() ? 0U : bytes[0];
    const bool isNewer = attributes
                           ? head > 0xa0U && head < 0xb0U
                           : (head > 0xd1U && head < 0xe0U) || (head > 0xe1U && head < 0xf0U);
    return GltfError(
      isNewer ? "has version " + std::to_string(head & 15U) +
                  " of meshoptimizer's compression, which is newer than the library of this program"
              : "is damaged: its " + std::to_string(bytes.size()) +
                  " bytes are not compressed by meshoptimizer");
  }
  if (attributes && !Filter(filter, elements, size, decoded.data()))
  {
    return GltfError(
      "is compressed by meshoptimizer with an unknown filter: " + QuotedText(filter));
  }
  return decoded;
}

#else

Result<std::vector<std::uint8_t>> DecodeMeshopt(const Json&, std::span<const std::uint8_t>)
{
  return Error{ ErrorCode::Unsupported,
    "is compressed by meshoptimizer, but this program was built without libmeshoptimizer-dev: save "
    "the file without compression",
    {}, {}, Remedy::InMessage };
}

#endif

#ifdef KDSTREAM_HAS_DRACO

namespace
{

std::optional<GltfComponent> ComponentOf(draco::DataType type)
{
  switch (type)
  {
    case draco::DT_INT8:
      return GltfComponent::Byte;
    case draco::DT_UINT8:
      return GltfComponent::UnsignedByte;
    case draco::DT_INT16:
      return GltfComponent::Short;
    case draco::DT_UINT16:
      return GltfComponent::UnsignedShort;
    case draco::DT_UINT32:
      return GltfComponent::UnsignedInt;
    case draco::DT_FLOAT32:
      return GltfComponent::Float;
    default:
      return std::nullopt;
  }
}

Result<DracoPart> ReadDraco(const draco::Mesh& mesh,
  const std::map<std::string, std::uint32_t>& attributes, const std::set<std::string>& normalized)
{
  DracoPart part;
  part.corners.reserve(std::size_t{ mesh.num_faces() } * 3);
  for (draco::FaceIndex face(0); face < mesh.num_faces(); ++face)
  {
    for (const draco::PointIndex& corner : mesh.face(face))
    {
      part.corners.push_back(corner.value());
    }
  }
  for (const auto& [name, number] : attributes)
  {
    const draco::PointAttribute* const attribute = mesh.GetAttributeByUniqueId(number);
    if (!attribute)
    {
      return GltfError(QuotedText(name) + " names attribute " + std::to_string(number) +
                       " of what Draco compressed, which is not there");
    }
    const std::optional<GltfComponent> type = ComponentOf(attribute->data_type());
    if (!type)
    {
      return GltfError(
        QuotedText(name) + " is compressed by Draco with a number type that cannot be read");
    }
    const auto size = static_cast<std::size_t>(attribute->byte_stride());
    std::vector<std::uint8_t> elements(std::size_t{ mesh.num_points() } * size);
    for (draco::PointIndex point(0); point < mesh.num_points(); ++point)
    {
      attribute->GetMappedValue(point, elements.data() + std::size_t{ point.value() } * size);
    }
    part.attributes.emplace(
      name, GltfAccessor(std::move(elements), *type, attribute->num_components(),
              attribute->normalized() || normalized.contains(name)));
  }
  return part;
}

}

Result<DracoPart> DecodeDraco(std::span<const std::uint8_t> bytes,
  const std::map<std::string, std::uint32_t>& attributes, const std::set<std::string>& normalized)
{
  const Error damaged = GltfError(
    "is damaged: its " + std::to_string(bytes.size()) + " bytes are not compressed by Draco");
  try
  {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    draco::Decoder decoder;
    const auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
    return decoded.ok() ? ReadDraco(*decoded.value(), attributes, normalized) : damaged;
  }
  catch (const std::exception&) // meshoptimizer trusts the sizes in the data
  {
    return damaged;
  }
}

#else

Result<DracoPart> DecodeDraco(std::span<const std::uint8_t>,
  const std::map<std::string, std::uint32_t>&, const std::set<std::string>&)
{
  return Error{ ErrorCode::Unsupported,
    "is compressed by Draco, but this program was built without libdraco-dev: save the file "
    "without compression",
    {}, {}, Remedy::InMessage };
}

#endif

}
