// SPDX-License-Identifier: BSD-3-Clause
// glTF files for tests, composed by hand.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace kdstream::fixtures
{

// Makes a .glb of two chunks.
inline std::string GlbOf(std::string json, std::string bytes)
{
  json.resize((json.size() + 3) / 4 * 4, ' ');
  bytes.resize((bytes.size() + 3) / 4 * 4);
  const auto number = [](std::size_t value)
  {
    const auto small = static_cast<std::uint32_t>(value);
    return std::string(reinterpret_cast<const char*>(&small), 4);
  };
  return "glTF" + number(2) + number(12 + 8 + json.size() + 8 + bytes.size()) +
         number(json.size()) + "JSON" + json + number(bytes.size()) + std::string("BIN\0", 4) +
         bytes;
}

// The bytes of a glTF buffer, and the JSON of its views and accessors.
class GltfBuffer
{
public:
  // Adds an accessor, and returns its number. type: SCALAR, VEC2, VEC3 or VEC4.
  template <class T>
  int Add(const std::vector<T>& values, const std::string& type, int componentType,
    const std::string& bounds = "")
  {
    const int components = type == "SCALAR" ? 1 : type[3] - '0';
    const int view = this->AddView(values.data(), values.size() * sizeof(T));
    this->Accessors += std::string(this->AccessorCount == 0 ? "" : ",") +
                       "{\"bufferView\":" + std::to_string(view) +
                       ",\"componentType\":" + std::to_string(componentType) +
                       ",\"count\":" + std::to_string(values.size() / std::size_t(components)) +
                       ",\"type\":\"" + type + "\"" + bounds + "}";
    return this->AccessorCount++;
  }
  // Adds an accessor that is already written as JSON.
  int AddJson(const std::string& accessor)
  {
    this->Accessors += (this->AccessorCount == 0 ? "" : ",") + accessor;
    return this->AccessorCount++;
  }
  // Marks the last accessor as normalized: its integers are fractions of the largest integer.
  void NormalizeLast()
  {
    this->Accessors.insert(this->Accessors.size() - 1, ",\"normalized\":true");
  }
  int AddView(const void* bytes, std::size_t size)
  {
    this->Bytes.resize((this->Bytes.size() + 3) / 4 * 4);
    this->Views += std::string(this->ViewCount == 0 ? "" : ",") +
                   "{\"buffer\":0,\"byteOffset\":" + std::to_string(this->Bytes.size()) +
                   ",\"byteLength\":" + std::to_string(size) + "}";
    this->Bytes.append(static_cast<const char*>(bytes), size);
    return this->ViewCount++;
  }

  // The whole document. rest: its other members. uri: of the buffer; "" in a .glb.
  std::string Json(const std::string& rest, const std::string& uri = "") const
  {
    return "{\"asset\":{\"version\":\"2.0\"}," + rest + ",\"accessors\":[" + this->Accessors +
           "],\"bufferViews\":[" + this->Views +
           "],\"buffers\":[{\"byteLength\":" + std::to_string(this->Bytes.size()) +
           (uri.empty() ? "" : ",\"uri\":\"" + uri + "\"") + "}]}";
  }

  std::string Glb(const std::string& rest) const { return GlbOf(this->Json(rest), this->Bytes); }

  std::string Bytes;

private:
  std::string Views, Accessors;
  int ViewCount = 0, AccessorCount = 0;
};

constexpr int gltfFloat = 5126, gltfUnsignedShort = 5123, gltfUnsignedByte = 5121;

}
