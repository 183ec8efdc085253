// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/GltfDocument.h"

#include "filters/meshio/FileEnding.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <utility>
#include <vector>

namespace kdstream
{
namespace
{

using Json = nlohmann::json;

// Descendants that nodes may have by being shared, beyond those of trees.
constexpr std::uint64_t mostShared = std::uint64_t{ 1 } << 20;

// Goes down from each root; what is reached again while it is open is a cycle.
class NodeCheck
{
public:
  explicit NodeCheck(const Json& nodes)
    : Nodes(nodes)
    , Sizes(CountOf(nodes))
    , State(CountOf(nodes))
  {
  }

  Status Check()
  {
    for (std::size_t root = 0; root < this->State.size(); ++root)
    {
      this->Enter(root);
      while (!this->Path.empty())
      {
        KDSTREAM_TRY(this->Step());
      }
    }
    return {};
  }

private:
  void Enter(std::size_t node)
  {
    if (this->State[node] == 0)
    {
      this->State[node] = 1;
      this->Sizes[node] = 1;
      this->Path.push_back({ node, 0 });
    }
  }

  // Takes the next child of the last node, or leaves that one.
  Status Step()
  {
    const std::size_t node = this->Path.back().first;
    const Json& children = Member(this->Nodes[node], "children");
    if (this->Path.back().second == CountOf(children))
    {
      this->State[node] = 2;
      this->Path.pop_back();
      return {};
    }
    const std::size_t child = IndexIn(this->Nodes, children[this->Path.back().second]);
    if (child == this->State.size())
    {
      ++this->Path.back().second;
      return {};
    }
    if (this->State[child] == 1)
    {
      return Error{ ErrorCode::InvalidInput,
        "node " + std::to_string(child) + " is its own descendant" };
    }
    if (this->State[child] == 0)
    {
      this->Enter(child); // and comes back to this child when it is done
      return {};
    }
    ++this->Path.back().second;
    this->Sizes[node] += this->Sizes[child];
    const std::uint64_t most = this->State.size() + mostShared;
    return this->Sizes[node] <= most
             ? Status{}
             : Status(Error{ ErrorCode::InvalidInput,
                 "node " + std::to_string(node) + " has more than " + std::to_string(most) +
                   " descendants: nodes are shared over and over" });
  }

  const Json& Nodes;
  std::vector<std::uint64_t> Sizes;                      // with descendants
  std::vector<std::uint8_t> State;                       // 0 unknown, 1 open, 2 done
  std::vector<std::pair<std::size_t, std::size_t>> Path; // node, next child
};

}

std::optional<GltfDocument> ReadGltfDocument(const std::filesystem::path& file)
{
  std::ifstream text(file, std::ios::binary);
  GltfDocument document;
  document.isGlb = FileEnding(file) == ".glb";
  if (!document.isGlb)
  {
    document.json = Json::parse(text, nullptr, false);
    return document.json.is_object() ? std::optional(std::move(document)) : std::nullopt;
  }
  std::array<char, 20> head{};
  std::error_code failed;
  const std::uintmax_t bytes = std::filesystem::file_size(file, failed);
  std::uint32_t length = 0;
  if (failed || !text.read(head.data(), head.size()) || std::memcmp(head.data(), "glTF", 4) != 0)
  {
    return std::nullopt;
  }
  std::memcpy(&length, head.data() + 12, sizeof length);
  if (length > bytes - head.size())
  {
    return std::nullopt;
  }
  std::string json(length, ' ');
  text.read(json.data(), static_cast<std::streamsize>(length));
  document.json = Json::parse(json, nullptr, false);
  document.binary = head.size() + length + 8;
  std::uint32_t chunk = 0;
  if (text.read(reinterpret_cast<char*>(&chunk), sizeof chunk) && document.binary <= bytes)
  {
    document.binaryBytes = std::min<std::uint64_t>(chunk, bytes - document.binary);
  }
  return document.json.is_object() ? std::optional(std::move(document)) : std::nullopt;
}

const Json& Member(const Json& value, const char* name)
{
  static const Json null;
  const auto found = value.is_object() ? value.find(name) : value.end();
  return value.is_object() && found != value.end() ? *found : null;
}

double NumberOf(const Json& value, double otherwise)
{
  return value.is_number() && std::isfinite(value.get<double>()) ? value.get<double>() : otherwise;
}

std::size_t CountOf(const Json& array)
{
  return array.is_array() ? array.size() : 0;
}

std::size_t IndexIn(const Json& array, const Json& index)
{
  const std::size_t size = CountOf(array);
  return index.is_number_unsigned() ? std::min<std::size_t>(index.get<std::size_t>(), size) : size;
}

std::optional<std::vector<std::uint8_t>> DataOf(const std::string& uri)
{
  static constexpr std::string_view digits =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  static constexpr std::string_view mark = ";base64,";
  const std::size_t begin = uri.find(mark);
  if (begin == std::string::npos)
  {
    return std::nullopt;
  }
  std::vector<std::uint8_t> bytes;
  std::uint32_t bits = 0;
  unsigned held = 0;
  for (std::size_t i = begin + mark.size(); i < uri.size() && uri[i] != '='; ++i)
  {
    const std::size_t digit = digits.find(uri[i]);
    if (digit == std::string_view::npos)
    {
      return std::nullopt;
    }
    bits = (bits << 6U) | static_cast<std::uint32_t>(digit);
    held += 6;
    if (held >= 8)
    {
      held -= 8;
      bytes.push_back(static_cast<std::uint8_t>((bits >> held) & 255U));
    }
  }
  return bytes;
}

std::string NamesNone(const std::string& element, const Json& index, const Json& array)
{
  const std::size_t count = CountOf(array);
  return index.is_number() ? "names " + element + " " + index.dump() + ", but there " +
                               (count == 1 ? "is 1" : "are " + std::to_string(count))
                           : "names no " + element;
}

Status CheckGltfExtensions(const Json& json)
{
  const Json& required = Member(json, "extensionsRequired");
  for (std::size_t i = 0; i < CountOf(required); ++i)
  {
    for (const char* const compressed :
      { "KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression" })
    {
      if (required[i] == compressed)
      {
        return Error{ ErrorCode::InvalidInput,
          std::string("its geometry is compressed (") + compressed +
            "), which is not read: save it without compression" };
      }
    }
  }
  return {};
}

Status CheckGltfNodes(const Json& json)
{
  return NodeCheck(Member(json, "nodes")).Check();
}

}
