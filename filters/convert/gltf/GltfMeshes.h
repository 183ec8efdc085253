// SPDX-License-Identifier: BSD-3-Clause
// The meshes of a glTF file, part by part ("primitives"), before nodes place them in the scene.
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
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace kdstream
{

struct GltfPart
{
  std::vector<Vec3> points;
  std::vector<Triangle> triangles;
  std::vector<Vec3> normals;               // one for each point, or empty
  std::vector<Color> colors;               // one for each point, or empty; linear light
  std::vector<PictureCoordinate> pictures; // the same: texture coordinates of its picture
  std::vector<Attribute> arrays;           // further attributes of the points
  std::size_t material = 0;                // the number of materials if the part has none
  // How a skin moves a point: joints and their weights, equally many for each point.
  std::vector<std::pair<std::uint32_t, double>> joints;
  std::size_t jointsOfPoint = 0;
  std::size_t lines = 0; // line cells, of which only the points are kept
};

class GltfMeshes
{
public:
  // All arguments must outlive the object.
  GltfMeshes(
    const GltfDocument& document, GltfBuffers& buffers, const std::vector<GltfMaterial>& materials);

  // The claims of a mesh, or the sum over several meshes.
  struct Claims
  {
    std::uint64_t points = 0, triangles = 0;
    std::uint64_t parts = 0;    // parts with points
    std::uint64_t coloured = 0; // parts with colours, their own or their material's
    std::uint64_t zeros = 0;    // elements of all attributes and indices that have no bytes
    std::uint64_t skirts = 0;   // parts that only close gaps between tiles: not read
    // The arrays of the points, with the number of parts that have each. Names: "Normals",
    // "TCoords" (TEXCOORD_0), "texcoord_1"; all others under their own names, or those that a
    // property attribute of EXT_structural_metadata gives them. Arrays that the reader itself uses
    // are left out.
    std::vector<std::pair<AttributeInfo, std::uint64_t>> arrays{};

    void Add(const Claims& other);
  };
  // Reads only the JSON. REQUIRES: a mesh of this number exists. Errors: those of PartsOf; also for
  // a claim of more points or corners than a bufferView has.
  Result<Claims> ClaimsOf(std::size_t mesh) const;

  // The parts of a mesh that have positions. If several parts share positions, each keeps those
  // that its triangles use. weights: for the morph targets, from the node that shows the mesh;
  // null: the mesh's own. Errors: InvalidInput naming the part, and what is missing, has a wrong
  // type or number, or lies beyond its buffer; Unsupported naming the package that would decompress
  // it.
  Result<std::vector<GltfPart>> PartsOf(std::size_t mesh, const nlohmann::json& weights);

  // Counts what was dropped from those parts: points that are not finite, the triangles that use
  // them, and incomplete last triangles. Says how colours brighter than white were read.
  Tolerance Dropped() const;

private:
  class Reader;

  Result<double> CountedBy(const nlohmann::json& number) const;
  std::size_t PlacesOf(const nlohmann::json& part) const;
  bool IsShared(const nlohmann::json& part) const;
  std::uint64_t ZerosOf(const nlohmann::json& part) const;

  const GltfDocument& Document;
  GltfBuffers& Buffers;
  const std::vector<GltfMaterial>& Materials;
  std::map<std::string, std::string> ArrayNames;    // from EXT_structural_metadata, by attribute
  std::map<std::size_t, std::size_t> PartsOfPlaces; // by accessor: how many parts use it
  Tolerance DroppedPoints;
  std::set<std::string> BrightParts; // those with colours brighter than white
  std::string FirstBright;
};

class GltfNodes;

// Poses a part by its skin, which moves points and normals into the scene. REQUIRES: the part has
// joints. Errors: InvalidInput naming the skin.
Status ApplyGltfSkin(const GltfDocument& document, GltfBuffers& buffers, const GltfNodes& nodes,
  std::size_t skin, GltfPart& part);

}
