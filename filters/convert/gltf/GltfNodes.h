// SPDX-License-Identifier: BSD-3-Clause
// Where the meshes of a glTF file are placed: the nodes of its scene, each with its transform, in
// doubles.
#pragma once

#include "filters/convert/gltf/GltfBuffers.h"
#include "filters/convert/gltf/GltfDocument.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <array>
#include <cstddef>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace kdstream
{

// Transforms coordinates of a node to those of the scene: axes[k] is the image of axis k.
struct GltfPlace
{
  std::array<Vec3, 3> axes{ { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } } };
  Vec3 origin{};
  bool operator==(const GltfPlace&) const = default;

  Vec3 Of(const Vec3& point) const;
  // Transforms a normal, by the transposed inverse, and scales it to length 1 (0 stays 0).
  Vec3 OfNormal(const Vec3& normal) const;
  // Below 0 if the transform mirrors the node.
  double Determinant() const;
};
// The transform that applies first `inner`, then `outer`.
GltfPlace Combined(const GltfPlace& outer, const GltfPlace& inner);
// The same for an `outer` far from the origin, as on the globe. The axes do not lose precision by
// that.
GltfPlace CombinedFarAway(const GltfPlace& outer, const GltfPlace& inner);

// How a scene is placed in a larger whole, such as a tile in its tileset. It is turned first; then
// come the document's own centre (CESIUM_RTC) and the place of the tile.
struct GltfStand
{
  GltfPlace turned{}, outer{};
  bool operator==(const GltfStand&) const = default;
};

class GltfNodes
{
public:
  // Pairs of a node and its parent.
  using Parents = std::vector<std::pair<std::size_t, std::size_t>>;

  // The document must outlive it.
  explicit GltfNodes(const GltfDocument& document, const GltfStand& stand = {});

  // Finds the scene: the one that the file names; else the first one; else all nodes that are not
  // children. Checks the nodes below it, without memory for their descendants. Errors: InvalidInput
  // naming a missing object to which a scene or node refers; a malformed matrix, translation,
  // rotation or scale; a node that is its own descendant; or a node that has, through shared nodes,
  // far more descendants than there are nodes.
  Status Open();
  // Says how the scene was chosen if the file does not name one, what of the scene is hidden
  // (KHR_node_visibility), and which nodes are named more than once.
  const std::vector<std::string>& Notes() const { return this->NoteTexts; }

  // Calls `visit` with each node that has a mesh, for the place of each of its instances
  // (EXT_mesh_gpu_instancing). Nodes come before their children, and children in their order.
  // Errors: visit's; those of accessors. REQUIRES: Open.
  using Visit = std::function<Status(std::size_t node, const GltfPlace& place)>;
  Status ForEachMesh(GltfBuffers& buffers, const Visit& visit) const;

  // A node's place in the scene. A node with several parents has the place that its first parent
  // gives it; a node outside the scene has none. REQUIRES: a node of this number exists; Open.
  const GltfPlace& PlaceInScene(std::size_t node) const { return this->Places[node]; }

private:
  Status ChooseScene();
  GltfPlace Standing(const GltfPlace& inScene) const;
  Result<Parents> CheckNodes() const;
  void LeaveOutRepeated(const Parents& entered);
  void NoteContradictions(const Parents& entered);
  Result<std::vector<GltfPlace>> InstancesOf(std::size_t node, GltfBuffers& buffers) const;

  const GltfDocument& Document;
  const nlohmann::json& Nodes;
  const GltfStand Stand;
  std::vector<std::size_t> Roots;
  std::set<std::pair<std::size_t, std::size_t>> Repeated; // node, index of a repeated child
  std::vector<GltfPlace> Places;                          // of all nodes
  Vec3 Center{}; // the origin of the scene's places (CESIUM_RTC)
  std::vector<std::string> NoteTexts;
};

}
