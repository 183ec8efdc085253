// SPDX-License-Identifier: BSD-3-Clause
// Where the meshes of a glTF stand: its scene's nodes, each with its place, in doubles.
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

// From places in a node to places in the scene: axes[k] is where the k-th axis leads.
struct GltfPlace
{
  std::array<Vec3, 3> axes{ { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } } };
  Vec3 origin{};
  bool operator==(const GltfPlace&) const = default;

  Vec3 Of(const Vec3& point) const;
  // Transforms a normal, by the transposed inverse, to length 1 (0 stays 0).
  Vec3 OfNormal(const Vec3& normal) const;
  // Below 0: what is in the node is mirrored.
  double Determinant() const;
};
// First inner, then outer.
GltfPlace Combined(const GltfPlace& outer, const GltfPlace& inner);
// The same for an outer place far from the origin, as on the globe: the axes lose nothing by that.
GltfPlace CombinedFarAway(const GltfPlace& outer, const GltfPlace& inner);

// How a scene stands in what it is a part of: a tile in its tileset. First it is turned, then come
// the document's own centre (CESIUM_RTC) and the place of the tile.
struct GltfStand
{
  GltfPlace turned{}, outer{};
  bool operator==(const GltfStand&) const = default;
};

class GltfNodes
{
public:
  // Nodes and their parents.
  using Parents = std::vector<std::pair<std::size_t, std::size_t>>;

  // The document must outlive it.
  explicit GltfNodes(const GltfDocument& document, const GltfStand& stand = {});

  // Finds the scene: the one that the file names, else the first, else all nodes that are not
  // children. Checks the nodes below it, without memory for their descendants. Errors: InvalidInput
  // naming a missing object that a scene or node refers to; a malformed matrix, translation,
  // rotation or scale; a node that is its own descendant, or that has, through shared nodes, far
  // more descendants than there are nodes.
  Status Open();
  // How the scene was chosen, if the file does not say; what of it is hidden (KHR_node_visibility);
  // nodes that are named more than once.
  const std::vector<std::string>& Notes() const { return this->NoteTexts; }

  // Calls visit with each node that has a mesh, and the place of each of its instances
  // (EXT_mesh_gpu_instancing): a node before its children, these in their order. Errors: visit's;
  // those of accessors. REQUIRES: Open.
  using Visit = std::function<Status(std::size_t node, const GltfPlace& place)>;
  Status ForEachMesh(GltfBuffers& buffers, const Visit& visit) const;

  // A node's place in the scene. A node with several parents has its place by the first; one
  // outside the scene has none. REQUIRES: there is a node of this number; Open.
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
  std::set<std::pair<std::size_t, std::size_t>> Repeated; // node, number of a child named before
  std::vector<GltfPlace> Places;                          // of all nodes
  Vec3 Center{}; // from which the scene's places are counted (CESIUM_RTC)
  std::vector<std::string> NoteTexts;
};

}
