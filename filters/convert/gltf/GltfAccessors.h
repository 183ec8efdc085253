// SPDX-License-Identifier: BSD-3-Clause
// Reads the numbers of a glTF file: checks an accessor's claims against its bytes, then reads the
// numbers in place.
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

// The component types, with glTF's numbers.
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
  // Opens the accessor of this number. Its `sparse` elements replace those of the bufferView. If it
  // has no bufferView, they replace zeros: then at most 2^20 elements are accepted, because the
  // file has no bytes for them. The document and the buffers must outlive the accessor. Memory: all
  // elements of a sparse accessor, else none. Errors: InvalidInput naming the accessor;
  // Unsupported; those of GltfBuffers::ViewOf.
  static constexpr std::uint64_t mostZeros = std::uint64_t{ 1 } << 20;
  static Result<GltfAccessor> Open(
    const GltfDocument& document, GltfBuffers& buffers, std::size_t number);

  // elements: in sequence, little-endian.
  GltfAccessor(std::vector<std::uint8_t> elements, GltfComponent type, std::size_t components,
    bool normalized);

  // Properties from an accessor's JSON: the number of components (0 for an unknown type), and their
  // type.
  static std::size_t ComponentsIn(const nlohmann::json& accessor);
  static GltfComponent TypeIn(const nlohmann::json& accessor);

  std::size_t Count() const { return this->ElementCount; }
  std::size_t Components() const { return this->ComponentCount; }
  GltfComponent Type() const { return this->ComponentType; }
  // A component of an element as the file has it. REQUIRES: the element and the component exist.
  double Get(std::size_t element, std::size_t component) const;
  // The same, but whole numbers are divided by the largest of their type, which gives 0 … 1 or -1 …
  // 1. This is done only if the file says that they are normalized, or with `always`.
  double Part(std::size_t element, std::size_t component, bool always = false) const;

private:
  GltfAccessor() = default;
  Status Overlay(const GltfDocument& document, GltfBuffers& buffers, const nlohmann::json& sparse);

  GltfBytes Bytes;                                      // from the first element on; empty: zeros
  std::shared_ptr<const std::vector<std::uint8_t>> Own; // the bytes, if they are not in a view
  std::size_t ElementCount = 0, ComponentCount = 1, Stride = 0;
  GltfComponent ComponentType = GltfComponent::Float;
  bool Normalized = false;
};

}
