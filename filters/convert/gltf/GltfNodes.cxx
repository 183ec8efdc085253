// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. find the scene's roots
// 2. check all nodes below, depth first, each once
// 3. walk through the nodes, with a stack of nodes and places, and visit the instances of each
//    node.
#include "filters/convert/gltf/GltfNodes.h"

#include "filters/convert/gltf/GltfAccessors.h"
#include "filters/core/UnitVector.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <utility>

namespace kdstream
{
namespace
{

using Json = nlohmann::json;

// Whether the member is missing, or is an array of this number of numbers.
bool HasNumbers(const Json& node, const char* name, std::size_t count)
{
  const Json& numbers = Member(node, name);
  return numbers.is_null() ||
         (CountOf(numbers) == count && std::all_of(numbers.begin(), numbers.end(),
                                         [](const Json& number) { return number.is_number(); }));
}

Status CheckPlace(const Json& node, std::size_t number)
{
  for (const auto& [name, count] : { std::pair<const char*, std::size_t>{ "matrix", 16 },
         { "translation", 3 }, { "rotation", 4 }, { "scale", 3 } })
  {
    if (!HasNumbers(node, name, count))
    {
      return GltfError("node " + std::to_string(number) + " has a " + name + " that is not of " +
                       std::to_string(count) + " numbers");
    }
  }
  // The matrix is written column by column, so these elements are the last row.
  const Json& matrix = Member(node, "matrix");
  constexpr double small = 1e-6;
  for (std::size_t k = 3; k < CountOf(matrix); k += 4)
  {
    if (std::abs(matrix[k].get<double>() - (k == 15 ? 1 : 0)) > small)
    {
      return GltfError("node " + std::to_string(number) +
                       " has a matrix whose last row is not 0 0 0 1 (the numbers 4, 8, 12 and 16): "
                       "it must be written column by column, its translation last");
    }
  }
  return {};
}

// How many descendants nodes may have, beyond those of a tree, because nodes are shared.
constexpr std::uint64_t mostShared = std::uint64_t{ 1 } << 20;

// Goes down from each root. If a node is reached again while it is still open, there is a cycle.
class NodeCheck
{
public:
  explicit NodeCheck(const Json& nodes)
    : Nodes(nodes)
    , Sizes(CountOf(nodes))
    , State(CountOf(nodes))
  {
  }

  Status Check(std::size_t root)
  {
    KDSTREAM_TRY(this->Enter(root, root));
    while (!this->Path.empty())
    {
      KDSTREAM_TRY(this->Step());
    }
    return this->Count(root, this->All);
  }

  // All nodes found, each after its parent; a root's parent is the root itself.
  const GltfNodes::Parents& Entered() const { return this->Found; }

private:
  // Adds a node and its descendants to the sum of its parent, or of all roots.
  Status Count(std::size_t node, std::uint64_t& sum) const
  {
    sum += this->Sizes[node];
    const std::uint64_t most = this->State.size() + mostShared;
    return sum <= most
             ? Status{}
             : Status(GltfError("node " + std::to_string(node) + ", with those beside it, has " +
                                "more than " + std::to_string(most) +
                                " descendants: nodes are shared over and over"));
  }

  Status Enter(std::size_t node, std::size_t parent)
  {
    if (this->State[node] == 0)
    {
      this->State[node] = 1;
      this->Sizes[node] = 1;
      this->Path.push_back({ node, 0 });
      this->Found.push_back({ node, parent });
      return CheckPlace(this->Nodes[node], node);
    }
    return {};
  }

  // Enters the next child of the last node, or leaves this node if it has no more children.
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
      return GltfError("node " + std::to_string(node) + " " +
                       NamesNone("node", children[this->Path.back().second], this->Nodes));
    }
    if (this->State[child] == 1)
    {
      return GltfError("node " + std::to_string(child) + " is its own descendant");
    }
    if (this->State[child] == 0)
    {
      return this->Enter(child, node); // then returns to this child
    }
    ++this->Path.back().second;
    return this->Count(child, this->Sizes[node]);
  }

  const Json& Nodes;
  std::vector<std::uint64_t> Sizes;                      // number of descendants, with the node
  std::vector<std::uint8_t> State;                       // 0 unknown, 1 open, 2 done
  std::vector<std::pair<std::size_t, std::size_t>> Path; // node, index of the next child
  GltfNodes::Parents Found;
  std::uint64_t All = 0;
};

// Whether KHR_node_visibility hides the node, with its descendants.
bool IsHidden(const Json& node)
{
  return Member(Member(Member(node, "extensions"), "KHR_node_visibility"), "visible") == false;
}

// rotation: a quaternion x y z w of any length.
GltfPlace PlaceOf(const Vec3& translation, const std::array<double, 4>& rotation, const Vec3& scale)
{
  GltfPlace place;
  place.origin = translation;
  const auto& [x, y, z, w] = rotation;
  const double xx = x * x, yy = y * y, zz = z * z, ww = w * w;
  const double square = xx + yy + zz + ww;
  if (square > 0)
  {
    // Written so that quarter turns give exact zeros.
    place.axes = { { { ww + xx - yy - zz, 2 * (x * y + z * w), 2 * (x * z - y * w) },
      { 2 * (x * y - z * w), ww - xx + yy - zz, 2 * (y * z + x * w) },
      { 2 * (x * z + y * w), 2 * (y * z - x * w), ww - xx - yy + zz } } };
  }
  for (std::size_t k = 0; k < 3; ++k)
  {
    place.axes[k] = Times(place.axes[k], scale[k]);
    if (square > 0 && square != 1)
    {
      place.axes[k] = { place.axes[k][0] / square, place.axes[k][1] / square,
        place.axes[k][2] / square };
    }
  }
  return place;
}

template <std::size_t count>
std::array<double, count> NumbersOf(
  const Json& node, const char* name, std::array<double, count> otherwise)
{
  const Json& numbers = Member(node, name);
  for (std::size_t k = 0; k < std::min(count, CountOf(numbers)); ++k)
  {
    otherwise[k] = numbers[k].get<double>();
  }
  return otherwise;
}

// The transform by the node's translation, rotation and scale.
GltfPlace PlaceByParts(const Json& node)
{
  return PlaceOf(NumbersOf<3>(node, "translation", {}),
    NumbersOf<4>(node, "rotation", { 0, 0, 0, 1 }), NumbersOf<3>(node, "scale", { 1, 1, 1 }));
}

// The node's transform in its parent. REQUIRES: CheckPlace.
GltfPlace PlaceInParent(const Json& node)
{
  const Json& matrix = Member(node, "matrix");
  if (matrix.is_null())
  {
    return PlaceByParts(node);
  }
  const std::array<double, 16> m = NumbersOf<16>(node, "matrix", {});
  return { { { { m[0], m[1], m[2] }, { m[4], m[5], m[6] }, { m[8], m[9], m[10] } } },
    { m[12], m[13], m[14] } };
}

// Whether the transforms are equal, except for rounding.
bool IsSamePlace(const GltfPlace& one, const GltfPlace& other)
{
  constexpr double rounding = 1e-5;
  const auto isSame = [](const Vec3& a, const Vec3& b)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      if (!(std::abs(a[k] - b[k]) <= rounding * std::max(1.0, std::abs(a[k]))))
      {
        return false;
      }
    }
    return true;
  };
  return isSame(one.origin, other.origin) && isSame(one.axes[0], other.axes[0]) &&
         isSame(one.axes[1], other.axes[1]) && isSame(one.axes[2], other.axes[2]);
}

}

Vec3 GltfPlace::Of(const Vec3& point) const
{
  Vec3 place;
  for (std::size_t k = 0; k < 3; ++k)
  {
    place[k] = this->axes[0][k] * point[0] + this->axes[1][k] * point[1] +
               this->axes[2][k] * point[2] + this->origin[k];
  }
  return place;
}

Vec3 GltfPlace::OfNormal(const Vec3& normal) const
{
  const std::array<Vec3, 3> across{ Cross(this->axes[1], this->axes[2]),
    Cross(this->axes[2], this->axes[0]), Cross(this->axes[0], this->axes[1]) };
  const double sign = this->Determinant() < 0 ? -1 : 1;
  const Vec3 turned =
    UnitVector(Plus(Plus(Times(across[0], sign * normal[0]), Times(across[1], sign * normal[1])),
      Times(across[2], sign * normal[2])));
  return turned != Vec3{} ? turned : normal;
}

double GltfPlace::Determinant() const
{
  return Dot(this->axes[0], Cross(this->axes[1], this->axes[2]));
}

GltfPlace Combined(const GltfPlace& outer, const GltfPlace& inner)
{
  GltfPlace place;
  for (std::size_t k = 0; k < 3; ++k)
  {
    place.axes[k] = Minus(outer.Of(inner.axes[k]), outer.origin);
  }
  place.origin = outer.Of(inner.origin);
  return place;
}

GltfPlace CombinedFarAway(const GltfPlace& outer, const GltfPlace& inner)
{
  const GltfPlace turned{ outer.axes, {} };
  return { { turned.Of(inner.axes[0]), turned.Of(inner.axes[1]), turned.Of(inner.axes[2]) },
    outer.Of(inner.origin) };
}

GltfNodes::GltfNodes(const GltfDocument& document, const GltfStand& stand)
  : Document(document)
  , Nodes(Member(document.json, "nodes"))
  , Stand(stand)
{
}

GltfPlace GltfNodes::Standing(const GltfPlace& inScene) const
{
  const bool isPart = !(this->Stand == GltfStand{});
  GltfPlace place = isPart ? CombinedFarAway(this->Stand.turned, inScene) : inScene;
  place.origin = Plus(place.origin, this->Center);
  return isPart ? CombinedFarAway(this->Stand.outer, place) : place;
}

Status GltfNodes::ChooseScene()
{
  const Json &scenes = Member(this->Document.json, "scenes"),
             &named = Member(this->Document.json, "scene");
  const std::size_t count = CountOf(scenes);
  const std::size_t chosen = named.is_null() ? 0 : IndexIn(scenes, named);
  if (!named.is_null() && chosen == count)
  {
    return GltfError(
      "the scene that is to be shown: the file " + NamesNone("scene", named, scenes));
  }
  if (count == 0)
  {
    std::vector<bool> isChild(CountOf(this->Nodes));
    for (const Json& node : this->Nodes)
    {
      for (const Json& child : Member(node, "children"))
      {
        const std::size_t number = IndexIn(this->Nodes, child);
        if (number < isChild.size())
        {
          isChild[number] = true;
        }
      }
    }
    for (std::size_t i = 0; i < isChild.size(); ++i)
    {
      if (!isChild[i])
      {
        this->Roots.push_back(i);
      }
    }
    if (!isChild.empty())
    {
      this->NoteTexts.emplace_back("it has no scene: all of its nodes are read");
    }
    return {};
  }
  if (named.is_null() && count > 1)
  {
    this->NoteTexts.push_back(
      "the default scene does not exist; the first of " + std::to_string(count) + " is read");
  }
  for (const Json& root : Member(scenes[chosen], "nodes"))
  {
    const std::size_t number = IndexIn(this->Nodes, root);
    if (number == CountOf(this->Nodes))
    {
      return GltfError(
        "scene " + std::to_string(chosen) + " " + NamesNone("node", root, this->Nodes));
    }
    this->Roots.push_back(number);
  }
  return {};
}

// The nodes of the scene, each after its parent; a root's parent is the root itself.
Result<GltfNodes::Parents> GltfNodes::CheckNodes() const
{
  NodeCheck check(this->Nodes);
  for (const std::size_t root : this->Roots)
  {
    KDSTREAM_TRY(check.Check(root));
  }
  return check.Entered();
}

// In glTF, each node has only one parent, which names it once. If a list names a node twice, this
// counts once. A root that is also below another node counts only there. If a node has several
// parents, each of them keeps it.
void GltfNodes::LeaveOutRepeated(const Parents& entered)
{
  const std::size_t none = CountOf(this->Nodes);
  std::vector<std::size_t> lastParent(none, none);
  std::set<std::size_t> repeated, shared;
  for (const auto& [number, parent] : entered)
  {
    const Json& children = Member(this->Nodes[number], "children");
    for (std::size_t i = 0; i < CountOf(children); ++i)
    {
      const std::size_t child = IndexIn(this->Nodes, children[i]);
      if (lastParent[child] == number)
      {
        this->Repeated.insert({ number, i });
        repeated.insert(child);
      }
      else if (lastParent[child] != none)
      {
        shared.insert(child);
      }
      lastParent[child] = number;
    }
  }
  std::vector<bool> isRoot(none);
  std::erase_if(this->Roots,
    [&](std::size_t root)
    {
      const bool isRepeated = isRoot[root] || lastParent[root] != none;
      isRoot[root] = true;
      if (isRepeated)
      {
        repeated.insert(root);
      }
      return isRepeated;
    });
  const auto note = [&](const std::set<std::size_t>& nodes, const char* what)
  {
    if (!nodes.empty())
    {
      this->NoteTexts.push_back(
        "node " + std::to_string(*nodes.begin()) +
        (nodes.size() == 1 ? "" : ", and " + std::to_string(nodes.size() - 1) + " further,") +
        what);
    }
  };
  note(repeated, " is named twice by the scene, by its parent or by both: it is read once");
  note(shared, " has several parents, where glTF has one: it is read for each of them");
}

Status GltfNodes::Open()
{
  KDSTREAM_TRY(this->ChooseScene());
  Result<Parents> entered = this->CheckNodes();
  KDSTREAM_TRY(entered);
  const std::size_t roots = this->Roots.size();
  this->LeaveOutRepeated(*entered);
  if (this->Roots.size() < roots)
  {
    entered = this->CheckNodes(); // their parents have changed
    KDSTREAM_TRY(entered);
  }
  const Json& center =
    Member(Member(Member(this->Document.json, "extensions"), "CESIUM_RTC"), "center");
  for (std::size_t k = 0; k < std::min<std::size_t>(3, CountOf(center)); ++k)
  {
    this->Center[k] = NumberOf(center[k], 0);
  }
  std::size_t hidden = 0;
  this->Places.resize(CountOf(this->Nodes));
  for (const auto& [node, parent] : *entered)
  {
    const GltfPlace place = PlaceInParent(this->Nodes[node]);
    this->Places[node] = parent == node ? place : Combined(this->Places[parent], place);
    hidden += IsHidden(this->Nodes[node]) ? 1 : 0;
  }
  for (const auto& [node, parent] : *entered)
  {
    this->Places[node] = this->Standing(this->Places[node]);
  }
  this->NoteContradictions(*entered);
  if (hidden > 0)
  {
    this->NoteTexts.push_back("left out: " + std::to_string(hidden) +
                              (hidden == 1 ? " node that is hidden, with what is below it"
                                           : " nodes that are hidden, with what is below them"));
  }
  return {};
}

// A node may have either a matrix, or a translation, rotation and scale. If it has both, the matrix
// counts, as in other readers. A warning is noted if they differ.
void GltfNodes::NoteContradictions(const Parents& entered)
{
  std::size_t count = 0, first = 0;
  for (const auto& [number, parent] : entered)
  {
    const Json& node = this->Nodes[number];
    if (Member(node, "matrix").is_null() || IsSamePlace(PlaceInParent(node), PlaceByParts(node)) ||
        (Member(node, "translation").is_null() && Member(node, "rotation").is_null() &&
          Member(node, "scale").is_null()))
    {
      continue;
    }
    first = count++ == 0 ? number : first;
  }
  if (count > 0)
  {
    this->NoteTexts.push_back(
      "node " + std::to_string(first) +
      (count == 1 ? "" : ", and " + std::to_string(count - 1) + " further,") +
      " has a matrix and a different translation, rotation or scale: the matrix is used");
  }
}

Result<std::vector<GltfPlace>> GltfNodes::InstancesOf(std::size_t node, GltfBuffers& buffers) const
{
  const Json& attributes = Member(
    Member(Member(this->Nodes[node], "extensions"), "EXT_mesh_gpu_instancing"), "attributes");
  if (attributes.is_null())
  {
    return std::vector<GltfPlace>(1);
  }
  struct Values
  {
    const char* name;
    std::size_t components;
    std::optional<GltfAccessor> accessor{};
  };
  std::array<Values, 3> all{ { { "TRANSLATION", 3 }, { "ROTATION", 4 }, { "SCALE", 3 } } };
  const Json& accessors = Member(this->Document.json, "accessors");
  const std::string named = "node " + std::to_string(node) + ": its instances' ";
  std::optional<std::size_t> count;
  for (Values& values : all)
  {
    const Json& number = Member(attributes, values.name);
    if (number.is_null())
    {
      continue;
    }
    const std::size_t at = IndexIn(accessors, number);
    if (at == CountOf(accessors))
    {
      return GltfError(named + values.name + " " + NamesNone("accessor", number, accessors));
    }
    Result<GltfAccessor> accessor = GltfAccessor::Open(this->Document, buffers, at);
    KDSTREAM_TRY(accessor);
    if (accessor->Components() != values.components || (count && accessor->Count() != *count))
    {
      return GltfError(named + values.name +
                       " has another type or another number of elements than " + "the others");
    }
    count = accessor->Count();
    values.accessor = std::move(*accessor);
  }
  std::vector<GltfPlace> places(count.value_or(1));
  for (std::size_t i = 0; i < places.size(); ++i)
  {
    Vec3 translation{}, scale{ 1, 1, 1 };
    std::array<double, 4> rotation{ 0, 0, 0, 1 };
    for (std::size_t k = 0; k < 4; ++k)
    {
      if (k < 3 && all[0].accessor)
      {
        translation[k] = all[0].accessor->Part(i, k);
      }
      if (all[1].accessor)
      {
        rotation[k] = all[1].accessor->Part(i, k);
      }
      if (k < 3 && all[2].accessor)
      {
        scale[k] = all[2].accessor->Part(i, k);
      }
    }
    places[i] = PlaceOf(translation, rotation, scale);
  }
  return places;
}

Status GltfNodes::ForEachMesh(GltfBuffers& buffers, const Visit& visit) const
{
  const Json& meshes = Member(this->Document.json, "meshes");
  std::vector<std::pair<std::size_t, GltfPlace>> left; // nodes, with the places of their parents
  for (std::size_t i = this->Roots.size(); i-- > 0;)
  {
    left.push_back({ this->Roots[i], GltfPlace{} });
  }
  while (!left.empty())
  {
    const auto [number, parent] = left.back();
    left.pop_back();
    const Json& node = this->Nodes[number];
    if (IsHidden(node))
    {
      continue;
    }
    const GltfPlace place = Combined(parent, PlaceInParent(node));
    const Json& mesh = Member(node, "mesh");
    if (!mesh.is_null() && IndexIn(meshes, mesh) == CountOf(meshes))
    {
      return GltfError("node " + std::to_string(number) + " " + NamesNone("mesh", mesh, meshes));
    }
    if (!mesh.is_null())
    {
      const Result<std::vector<GltfPlace>> instances = this->InstancesOf(number, buffers);
      KDSTREAM_TRY(instances);
      for (const GltfPlace& instance : *instances)
      {
        KDSTREAM_TRY(visit(number, this->Standing(Combined(place, instance))));
      }
    }
    const Json& children = Member(node, "children");
    for (std::size_t i = CountOf(children); i-- > 0;)
    {
      if (!this->Repeated.contains({ number, i }))
      {
        left.push_back({ IndexIn(this->Nodes, children[i]), place });
      }
    }
  }
  return {};
}

}
