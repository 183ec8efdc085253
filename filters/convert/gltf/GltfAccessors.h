// SPDX-License-Identifier: BSD-3-Clause
// Reads the numbers of a glTF file: checks what an accessor claims against its bytes, then reads
// them in place.
#pragma once

#include "filters/convert/gltf/GltfBuffers.h"
#include "filters/core/Result.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

// As glTF numbers the types of components.
enum class GltfComponent
{
  Byte = 5120,
  UnsignedByte = 5121,
  Short = 5122,
  UnsignedShort = 5123,
  UnsignedInt = 5125,
  Float = 5126
};

class GltfAccessor
{
public:
  // The accessor of this number. `sparse` elements replace those of the bufferView, or zeros if it
  // has none: then at most 2^20 elements, because no bytes of the file stand for them. The document
  // and the buffers must outlive it. Memory: all elements of a sparse accessor, else none. Errors:
  // InvalidInput naming the accessor; Unsupported; those of GltfBuffers::ViewOf.
  static constexpr std::uint64_t mostZeros = std::uint64_t{ 1 } << 20;
  static Result<GltfAccessor> Open(
    const GltfDocument& document, GltfBuffers& buffers, std::size_t number);

  // elements: one after the other, little-endian.
  GltfAccessor(std::vector<std::uint8_t> elements, GltfComponent type, std::size_t components,
    bool normalized);

  // Properties from an accessor's JSON: components (0 for an unknown type); whether it is Float.
  static std::size_t ComponentsIn(const nlohmann::json& accessor);
  static GltfComponent TypeIn(const nlohmann::json& accessor);

  std::size_t Count() const { return this->ElementCount; }
  std::size_t Components() const { return this->ComponentCount; }
  GltfComponent Type() const { return this->ComponentType; }
  // A component of an element as it lies there. REQUIRES: both are there.
  double Get(std::size_t element, std::size_t component) const;
  // The same, with whole numbers scaled by the largest of their type: to 0 … 1, or -1 … 1. Only if
  // the file says that they are normalized; `always`: in any case.
  double Part(std::size_t element, std::size_t component, bool always = false) const;

private:
  GltfAccessor() = default;
  Status Overlay(const GltfDocument& document, GltfBuffers& buffers, const nlohmann::json& sparse);

  GltfBytes Bytes;                                      // from the first element; empty: zeros
  std::shared_ptr<const std::vector<std::uint8_t>> Own; // of Bytes not in a view
  std::size_t ElementCount = 0, ComponentCount = 1, Stride = 0;
  GltfComponent ComponentType = GltfComponent::Float;
  bool Normalized = false;
};

}
