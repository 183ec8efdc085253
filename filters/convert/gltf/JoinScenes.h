// SPDX-License-Identifier: BSD-3-Clause
// Joins glTF scenes into one mesh: the scene of one file, or those of a tileset's tiles.
//
//   JoinedScenes joined(textures, JoinedScenes::Parts::OfOneFile);
//   for each document: joined.Count(document)   // what they claim, before memory is taken
//   joined.Begin();
//   for each document: joined.Append(document)
//   Result<ForeignMesh> mesh = joined.Finish(…);
#pragma once

#include "filters/convert/ForeignMesh.h"
#include "filters/convert/gltf/GltfBuffers.h"
#include "filters/convert/gltf/GltfDocument.h"
#include "filters/convert/gltf/GltfMaterials.h"
#include "filters/convert/gltf/GltfMeshes.h"
#include "filters/convert/gltf/GltfNodes.h"
#include "filters/convert/gltf/JoinedBorders.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <vector>

namespace kdstream
{

// A document, with everything that is read from it.
class GltfSource
{
public:
  // Errors: those of ReadGltfDocument, CheckGltfExtensions and GltfNodes::Open.
  static Result<std::unique_ptr<GltfSource>> Open(
    const std::filesystem::path& file, const GltfRange& range = {}, const GltfStand& stand = {});
  GltfSource(const GltfSource&) = delete;
  GltfSource& operator=(const GltfSource&) = delete;

  // The files that it names, except its own.
  std::vector<std::filesystem::path> Named() const;
  // Warnings for the user: about the scene, about materials, and, after reading, about everything
  // else.
  const std::vector<std::string>& SceneNotes() const { return this->Nodes.Notes(); }
  std::vector<std::string> MaterialNotes() const;
  std::vector<std::string> OtherNotes() const;
  // Adds the reason to an error if a buffer is missing or too short.
  Error Explained(Error error) const;

private:
  friend class JoinedScenes;
  GltfSource(GltfDocument document, std::filesystem::path file, const GltfStand& stand);

  const std::filesystem::path File;
  const GltfDocument Document;
  GltfBuffers Buffers;
  GltfNodes Nodes;
  const GltfMaterials Materials;
  std::optional<std::string> NotRead;
};

class JoinedScenes
{
public:
  // What the mesh is joined from. OfOneFile: the mesh has doubles if the numbers of one of its
  // parts need them: floats would leave this part fewer than 2^16 steps along its longest side, and
  // its own numbers are finer. OfTiles: the same for all parts together. Also closes the borders
  // between neighbouring tiles (JoinedBorders.h).
  enum class Parts
  {
    OfOneFile,
    OfTiles
  };
  // leftOut: names of arrays that are not carried. textures must outlive the object.
  JoinedScenes(const TextureOptions& textures, Parts parts, std::set<std::string> leftOut = {});

  // Adds up the scene's claims, before memory is allocated for them. Errors: LimitExceeded for more
  // points or triangles than can be read; those of GltfMeshes::ClaimsOf.
  Status Count(GltfSource& source);
  // Chooses the arrays: those that all parts have.
  void Begin();
  // Appends each mesh, at each of its places. Errors: those of GltfMeshes::PartsOf.
  Status Append(GltfSource& source, const Execution& execution);
  // Bakes pictures, or keeps colours. Converts to floats if floats are as fine as the files'
  // numbers. scenes, materials: notes, which become warnings. Errors: those of BakeAndKeepTextures.
  Result<ForeignMesh> Finish(const std::vector<std::string>& scenes,
    const std::vector<std::string>& materials, const Execution& execution);

  std::uint64_t Points() const { return this->Claims.points; } // as claimed
  // The box of all points.
  const Box& Bounds() const { return this->Whole; }
  const Box& LastBounds() const { return this->OfScene; } // of the last scene

private:
  static std::size_t MeshOf(const GltfSource& source, std::size_t node);
  void AddMaterials(const GltfSource& source);
  Status AppendPart(const GltfPart& part, std::size_t node, const GltfPlace& place);
  Status AppendPlaced(const GltfPart& part, const GltfPlace& place);
  void AppendPoints(const GltfPart& part, const GltfPlace& place, bool isMoved);
  void AppendColors(const GltfPart& part);
  void AppendTextured(const GltfPart& part, std::size_t first);
  void RoundToFloats();
  void WarnOfAll(const std::vector<std::string>& scenes, const std::vector<std::string>& materials);
  Status Bake(const Execution& execution);
  void MultiplyByOwn(std::vector<Attribute>& arrays) const;

  const TextureOptions& Textures;
  const Parts Joins;
  const std::set<std::string> LeftOut;
  GltfMeshes::Claims Claims;
  bool IsTextured = false;

  // The materials of all documents, in order. A picture file that is named again is used again.
  std::vector<TexturedMaterial> Materials;
  std::vector<PictureSource> Pictures;
  std::map<std::tuple<std::filesystem::path, std::uint64_t, std::uint64_t>, std::uint32_t> Known;
  std::size_t Documents = 0;    // counted so far
  std::size_t MaterialsAt = 0;  // first material of the current document, in Materials
  GltfSource* Source = nullptr; // the current document

  ForeignMesh Joined;
  std::vector<Color> Colors; // vertex colours; with textures, factors of the texture's colours
  TexturedMesh Textured;
  Box Whole, OfScene, Placed; // of all, of the current scene, of the current part
  JoinedBorders Borders;
  std::size_t Appended = 0; // documents
  std::size_t Lines = 0;
  bool AreDoubles = false, IsPosed = false, IsAnimated = false;
  bool AreFloats = true; // all places are floats
  // Whether some vertex colours are not white (untextured parts are written as white).
  bool IsTinted = false;
};

}
