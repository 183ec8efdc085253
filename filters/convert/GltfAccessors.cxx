// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/GltfAccessors.h"

#include "filters/meshio/QuotedText.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

namespace kdstream
{
namespace
{

using Json = nlohmann::json;

constexpr double mostMode = 6; // fans of triangles

// Bytes of an accessor's element; 0 where its kind is unknown.
double ElementBytes(const Json& accessor)
{
  static constexpr std::array<std::pair<const char*, double>, 7> types{ { { "SCALAR", 1 },
    { "VEC2", 2 }, { "VEC3", 3 }, { "VEC4", 4 }, { "MAT2", 4 }, { "MAT3", 9 }, { "MAT4", 16 } } };
  static constexpr std::array<double, 7> bytes{ 1, 1, 2, 2, 0, 4, 4 }; // of 5120 …
  const auto type = std::find_if(types.begin(), types.end(),
    [&](const auto& known) { return Member(accessor, "type") == known.first; });
  const double kind = NumberOf(Member(accessor, "componentType"), 0) - 5120;
  const bool known = type != types.end() && kind >= 0 && kind < double(bytes.size());
  return known ? type->second * bytes[static_cast<std::size_t>(kind)] : 0;
}

// A whole number from 0 to 2^53, which JSON has exactly; -1 where it is none.
double WholeOf(const Json& value, double otherwise)
{
  const double number = value.is_null() ? otherwise : NumberOf(value, -1);
  return number >= 0 && number <= 0x1p53 && number == std::floor(number) ? number : -1;
}

Status CheckView(const GltfDocument& document, const Json& view)
{
  const Json& buffers = Member(document.json, "buffers");
  const std::size_t buffer = IndexIn(buffers, Member(view, "buffer"));
  if (buffer == CountOf(buffers))
  {
    return Error{ ErrorCode::InvalidInput,
      "lies in a bufferView that " + NamesNone("buffer", Member(view, "buffer"), buffers) };
  }
  const bool there = Member(buffers[buffer], "uri").is_string() || (document.isGlb && buffer == 0);
  const double all = there ? NumberOf(Member(buffers[buffer], "byteLength"), 0) : 0;
  const double offset = WholeOf(Member(view, "byteOffset"), 0);
  return offset >= 0 && offset + NumberOf(Member(view, "byteLength"), 0) <= all
           ? Status{}
           : Status(Error{
               ErrorCode::InvalidInput, "lies in a bufferView that reaches beyond its buffer" });
}

Status CheckAccessor(const GltfDocument& document, const Json& accessor)
{
  const Json& views = Member(document.json, "bufferViews");
  const Json& number = Member(accessor, "bufferView");
  const std::size_t at = IndexIn(views, number);
  if (number.is_null())
  {
    return {}; // zeros
  }
  if (at == CountOf(views))
  {
    return Error{ ErrorCode::InvalidInput, NamesNone("bufferView", number, views) };
  }
  const Json& view = views[at];
  const Json& told = Member(accessor, "count");
  const double count = WholeOf(told, -1), size = ElementBytes(accessor);
  const double stride = WholeOf(Member(view, "byteStride"), size);
  const double offset = WholeOf(Member(accessor, "byteOffset"), 0);
  const double room = WholeOf(Member(view, "byteLength"), -1) - offset - size;
  const bool fits = count >= 0 && stride >= 0 && offset >= 0 &&
                    (count == 0 || (room >= 0 && (count - 1) * stride <= room));
  const std::string claimed = told.is_number() || told.is_null() ? told.dump() : "no number of";
  return fits ? CheckView(document, view)
              : Status(Error{ ErrorCode::InvalidInput,
                  "claims " + claimed + " elements, more than its bufferView has" });
}

// Of which kinds an attribute may be, by the beginning of its name. Others may be of any.
struct AttributeKinds
{
  std::string_view name, types;
  bool isFloat = false; // alone; else bytes and shorts without sign, too
};
constexpr std::array<AttributeKinds, 7> attributeKinds{ { { "POSITION", "VEC3", true },
  { "NORMAL", "VEC3", true }, { "TANGENT", "VEC3 VEC4", true }, { "TEXCOORD_", "VEC2" },
  { "COLOR_", "VEC3 VEC4" }, { "JOINTS_", "VEC4" }, { "WEIGHTS_", "VEC4" } } };
constexpr int unsignedByte = 5121, unsignedShort = 5123, unsignedInt = 5125, floating = 5126;

Status CheckKind(const std::string& name, const Json& accessor)
{
  const auto kinds = std::find_if(attributeKinds.begin(), attributeKinds.end(),
    [&](const AttributeKinds& each) { return name.starts_with(each.name); });
  if (kinds == attributeKinds.end())
  {
    return {};
  }
  const Json &type = Member(accessor, "type"), &component = Member(accessor, "componentType");
  constexpr std::size_t letters = 4; // of each type
  const bool isOfType =
    type.is_string() && (type == kinds->types.substr(0, letters) ||
                          type == kinds->types.substr(kinds->types.size() - letters));
  const bool isOfComponent =
    component == floating ||
    (!kinds->isFloat && (component == unsignedByte || component == unsignedShort));
  return isOfType && isOfComponent
           ? Status{}
           : Status(Error{ ErrorCode::InvalidInput,
               QuotedText(name) + " is of a kind that is not read: type " +
                 QuotedText(type.dump()) + ", componentType " + QuotedText(component.dump()) });
}

Status CheckAttributes(const Json& accessors, const Json& attributes, double& points)
{
  if (!attributes.is_object())
  {
    return {};
  }
  for (const auto& [name, number] : attributes.items())
  {
    const std::size_t at = IndexIn(accessors, number);
    if (at == CountOf(accessors))
    {
      return Error{ ErrorCode::InvalidInput,
        QuotedText(name) + " " + NamesNone("accessor", number, accessors) };
    }
    KDSTREAM_TRY(CheckKind(name, accessors[at]));
    const double count = NumberOf(Member(accessors[at], "count"), 0);
    points = points < 0 ? count : points;
    if (count != points)
    {
      return Error{ ErrorCode::InvalidInput,
        QuotedText(name) + " has not as many elements as the others" };
    }
  }
  return {};
}

Status CheckIndices(const Json& accessors, const Json& indices)
{
  const std::size_t at = IndexIn(accessors, indices);
  if (at == CountOf(accessors))
  {
    return Error{ ErrorCode::InvalidInput,
      "'indices' " + NamesNone("accessor", indices, accessors) };
  }
  const Json& component = Member(accessors[at], "componentType");
  const bool known =
    component == unsignedByte || component == unsignedShort || component == unsignedInt;
  return known && Member(accessors[at], "type") == "SCALAR" &&
             !Member(accessors[at], "bufferView").is_null()
           ? Status{}
           : Status(Error{ ErrorCode::InvalidInput, "'indices' are no whole numbers" });
}

Status CheckPart(const Json& accessors, const Json& part)
{
  double points = -1;
  KDSTREAM_TRY(CheckAttributes(accessors, Member(part, "attributes"), points));
  const Json& targets = Member(part, "targets");
  for (std::size_t i = 0; i < CountOf(targets); ++i)
  {
    KDSTREAM_TRY(CheckAttributes(accessors, targets[i], points));
  }
  const Json& mode = Member(part, "mode");
  if (!mode.is_null() && !(WholeOf(mode, -1) >= 0 && WholeOf(mode, -1) <= mostMode))
  {
    return Error{ ErrorCode::InvalidInput, "there is no mode " + QuotedText(mode.dump()) };
  }
  const Json& indices = Member(part, "indices");
  return indices.is_null() ? Status{} : CheckIndices(accessors, indices);
}

Status CheckNumbers(const Json& node, const char* name, std::size_t count)
{
  const Json& numbers = Member(node, name);
  const bool fits =
    numbers.is_null() ||
    (CountOf(numbers) == count && std::all_of(numbers.begin(), numbers.end(),
                                    [](const Json& number) { return number.is_number(); }));
  return fits ? Status{}
              : Status(Error{ ErrorCode::InvalidInput, std::string("has a ") + name +
                                                         " that is not of " +
                                                         std::to_string(count) + " numbers" });
}

Status CheckNode(const Json& node, const Json& meshes)
{
  KDSTREAM_TRY(CheckNumbers(node, "matrix", 16));
  KDSTREAM_TRY(CheckNumbers(node, "translation", 3));
  KDSTREAM_TRY(CheckNumbers(node, "rotation", 4));
  KDSTREAM_TRY(CheckNumbers(node, "scale", 3));
  const Json& mesh = Member(node, "mesh");
  return mesh.is_null() || IndexIn(meshes, mesh) < CountOf(meshes)
           ? Status{}
           : Status(Error{ ErrorCode::InvalidInput, NamesNone("mesh", mesh, meshes) });
}

Error Within(const std::string& element, const Status& wrong)
{
  return { ErrorCode::InvalidInput, element + wrong.GetError().message };
}

}

Status CheckGltfAccessors(const GltfDocument& document)
{
  const Json& accessors = Member(document.json, "accessors");
  for (std::size_t i = 0; i < CountOf(accessors); ++i)
  {
    if (const Status checked = CheckAccessor(document, accessors[i]); !checked)
    {
      return Within("accessor " + std::to_string(i) + " ", checked);
    }
  }
  return {};
}

Status CheckGltfMeshes(const Json& json)
{
  const Json &accessors = Member(json, "accessors"), &meshes = Member(json, "meshes"),
             &nodes = Member(json, "nodes");
  for (std::size_t mesh = 0; mesh < CountOf(meshes); ++mesh)
  {
    const Json& parts = Member(meshes[mesh], "primitives");
    for (std::size_t i = 0; i < CountOf(parts); ++i)
    {
      if (const Status checked = CheckPart(accessors, parts[i]); !checked)
      {
        return Within(
          "mesh " + std::to_string(mesh) + ", part " + std::to_string(i) + ": ", checked);
      }
    }
  }
  for (std::size_t i = 0; i < CountOf(nodes); ++i)
  {
    if (const Status checked = CheckNode(nodes[i], meshes); !checked)
    {
      return Within("node " + std::to_string(i) + " ", checked);
    }
  }
  return {};
}

std::optional<std::string> IncompleteGltfTriangles(const Json& json)
{
  constexpr double triangles = 4; // of modes
  const Json &accessors = Member(json, "accessors"), &meshes = Member(json, "meshes");
  std::string first;
  std::size_t found = 0;
  for (std::size_t mesh = 0; mesh < CountOf(meshes); ++mesh)
  {
    const Json& parts = Member(meshes[mesh], "primitives");
    for (std::size_t i = 0; i < CountOf(parts); ++i)
    {
      const Json& indices = Member(parts[i], "indices");
      const std::size_t at = IndexIn(accessors,
        indices.is_null() ? Member(Member(parts[i], "attributes"), "POSITION") : indices);
      const double corners =
        at < CountOf(accessors) ? WholeOf(Member(accessors[at], "count"), 0) : 0;
      if (NumberOf(Member(parts[i], "mode"), triangles) == triangles && std::fmod(corners, 3) > 0 &&
          found++ == 0)
      {
        first = "mesh " + std::to_string(mesh) + ", part " + std::to_string(i) + ": " +
                std::to_string(static_cast<std::uint64_t>(corners)) +
                (indices.is_null() ? " vertices" : " indices");
      }
    }
  }
  const std::string others = found == 2  ? " (and 1 other part)"
                             : found > 2 ? " (and " + std::to_string(found - 1) + " other parts)"
                                         : "";
  return found == 0
           ? std::nullopt
           : std::optional(first + " of triangles, which is no multiple of three" + others +
                           ": the last triangle, which is not whole, is left out");
}

}
