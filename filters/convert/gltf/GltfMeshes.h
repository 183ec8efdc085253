// SPDX-License-Identifier: BSD-3-Clause
// The meshes of a glTF, part by part ("primitives"), where they lie before a node places them.
#pragma once

#include "filters/convert/gltf/GltfBuffers.h"
#include "filters/convert/gltf/GltfDocument.h"
#include "filters/convert/gltf/GltfMaterials.h"
#include "filters/core/Attribute.h"
#include "filters/core/Light.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/meshio/Tolerance.h"
#include "filters/texture/TexturedMesh.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace kdstream
{

struct GltfPart
{
  std::vector<Vec3> points;
  std::vector<Triangle> triangles;
  std::vector<Vec3> normals;               // of each point, or none
  std::vector<Color> colors;               // the same, in linear light
  std::vector<PictureCoordinate> pictures; // the same: where its material's picture is looked at
  std::vector<Attribute> arrays;           // what else each point has
  std::size_t material = 0;                // the number of materials where it has none
  // What moves a point with a skin: joints and their weights, so many a point.
  std::vector<std::pair<std::uint32_t, double>> joints;
  std::size_t jointsOfPoint = 0;
  std::size_t lines = 0; // of which only points are kept
};

class GltfMeshes
{
public:
  // All of them must outlive it.
  GltfMeshes(
    const GltfDocument& document, GltfBuffers& buffers, const std::vector<GltfMaterial>& materials);

  // What a mesh claims to have, or several of them.
  struct Claims
  {
    std::uint64_t points = 0, triangles = 0;
    std::uint64_t parts = 0;    // that have points
    std::uint64_t coloured = 0; // of these, by themselves or by their material
    std::uint64_t zeros = 0;    // elements of all attributes and indices that have no bytes
    // Arrays of the points, and how many parts have each: "Normals", "TCoords" (TEXCOORD_0),
    // "texcoord_1", then all others by their names, except those that the reader uses up.
    std::vector<std::pair<AttributeInfo, std::uint64_t>> arrays{};

    void Add(const Claims& other);
  };
  // Nothing is read but the JSON. REQUIRES: a mesh that is there. Errors: of points and corners
  // that claim more than their bufferView has; as PartsOf.
  Result<Claims> ClaimsOf(std::size_t mesh) const;

  // The parts of a mesh that have places; of places that several parts have, each keeps those that
  // its triangles name. weights: of the node that shows it, those of its shapes (morph targets);
  // null: the mesh's own. Errors: InvalidInput naming the part, and what of it is not there, of
  // another kind or number than it must be, or beyond its buffer; Unsupported naming the package
  // for what is compressed.
  Result<std::vector<GltfPart>> PartsOf(std::size_t mesh, const nlohmann::json& weights);

  // Points of those parts that are not finite, and triangles that name them, were dropped; so were
  // last triangles that are not whole.
  const Tolerance& Dropped() const { return this->DroppedPoints; }

private:
  class Reader;

  Result<double> CountedBy(const nlohmann::json& number) const;
  std::size_t PlacesOf(const nlohmann::json& part) const;
  bool IsShared(const nlohmann::json& part) const;
  std::uint64_t ZerosOf(const nlohmann::json& part) const;

  const GltfDocument& Document;
  GltfBuffers& Buffers;
  const std::vector<GltfMaterial>& Materials;
  std::map<std::size_t, std::size_t> PartsOfPlaces; // how many have an accessor's places
  Tolerance DroppedPoints;
};

class GltfNodes;

// Moves a part as its skin stands in the scene: points and normals are the scene's then. REQUIRES:
// it has joints. Errors: InvalidInput naming the skin.
Status ApplyGltfSkin(const GltfDocument& document, GltfBuffers& buffers, const GltfNodes& nodes,
  std::size_t skin, GltfPart& part);

}
