// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. count: check the scenes' nodes, and sum up the claims of their meshes before memory is
//    allocated
// 2. append each mesh, at each of its places, to one mesh
// 3. bake pictures, or keep colours; convert to floats if floats are as fine as the files' numbers.
#include "filters/convert/gltf/JoinScenes.h"

#include "filters/convert/JoinParts.h"
#include "filters/convert/gltf/GltfAccessors.h"
#include "filters/core/VectorMath.h"
#include "filters/meshio/QuotedText.h"
#include "filters/texture/BakeTextures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

namespace kdstream
{
namespace
{

using Json = nlohmann::json;

constexpr Color white{ 1, 1, 1, 1 };
constexpr double stepsOfFloats = 0x1p23, leastSteps = 0x1p16;

bool FloatsAreCoarse(const Box& placed)
{
  return LongestSideOf(placed) * stepsOfFloats < leastSteps * LargestCoordinate(placed);
}

// Whether the part's own numbers are finer than floats at its place.
bool IsFiner(const Box& local, const Box& placed, const GltfPlace& place)
{
  constexpr double asFine = 4;
  double scale = 0;
  for (const Vec3& axis : place.axes)
  {
    scale = std::max(scale, Length(axis));
  }
  return LargestCoordinate(placed) > asFine * scale * LargestCoordinate(local);
}

const AttributeInfo normalsInfo{ "Normals", AttributeType::Float32, AttributeAssociation::Point,
  3 };

bool HasMorphTargets(const Json& json)
{
  for (const Json& mesh : Member(json, "meshes"))
  {
    const Json& parts = Member(mesh, "primitives");
    if (std::any_of(parts.begin(), parts.end(),
          [](const Json& part) { return CountOf(Member(part, "targets")) > 0; }))
    {
      return true;
    }
  }
  return false;
}

void AppendNormals(const std::vector<Vec3>& normals, const GltfPlace& place, Attribute& array)
{
  std::size_t tuple = array.TupleCount();
  array.values.resize(array.values.size() + normals.size() * array.TupleSize());
  for (const Vec3& normal : normals)
  {
    const Vec3 turned = place.OfNormal(normal);
    for (std::size_t k = 0; k < 3; ++k)
    {
      array.Set(tuple, k, turned[k]);
    }
    ++tuple;
  }
}

}

// ---- one document

Result<std::unique_ptr<GltfSource>> GltfSource::Open(
  const std::filesystem::path& file, const GltfRange& range, const GltfStand& stand)
{
  Result<GltfDocument> document = ReadGltfDocument(file, range);
  KDSTREAM_TRY(document);
  std::optional<std::string> notRead;
  KDSTREAM_TRY(CheckGltfExtensions(document->json, notRead));
  std::unique_ptr<GltfSource> source(new GltfSource(std::move(*document), file, stand));
  source->NotRead = std::move(notRead);
  KDSTREAM_TRY(source->Nodes.Open());
  return source;
}

GltfSource::GltfSource(GltfDocument document, std::filesystem::path file, const GltfStand& stand)
  : File(std::move(file))
  , Document(std::move(document))
  , Buffers(GltfBuffers::Open(this->Document, this->File))
  , Nodes(this->Document, stand)
  , Materials(ReadGltfMaterials(this->Document, this->Buffers, this->File))
{
}

std::vector<std::filesystem::path> GltfSource::Named() const
{
  std::vector<std::filesystem::path> named = this->Buffers.Files();
  for (const PictureSource& picture : this->Materials.pictures)
  {
    if (!picture.file.empty() && picture.file != this->File)
    {
      named.push_back(picture.file);
    }
  }
  return named;
}

std::vector<std::string> GltfSource::MaterialNotes() const
{
  // Without pictures, lost properties of materials are not reported one by one.
  return Member(this->Document.json, "images").is_null() &&
             Member(this->Document.json, "textures").is_null()
           ? std::vector<std::string>()
           : this->Materials.warnings;
}

std::vector<std::string> GltfSource::OtherNotes() const
{
  std::vector<std::string> notes;
  for (const std::size_t number : this->Buffers.WrongOnes())
  {
    notes.push_back(
      "buffer " + std::to_string(number) + " cannot be read, but no geometry needs it");
  }
  if (this->NotRead)
  {
    notes.push_back(*this->NotRead);
  }
  if (const std::size_t cameras = CountOf(Member(this->Document.json, "cameras")); cameras > 0)
  {
    notes.push_back(
      "left out: " + std::to_string(cameras) + (cameras == 1 ? " camera" : " cameras"));
  }
  if (HasMorphTargets(this->Document.json))
  {
    notes.emplace_back(
      "morph targets are left out: the mesh has the shape that their weights give it");
  }
  return notes;
}

Error GltfSource::Explained(Error error) const
{
  return this->Buffers.Missing().value_or(std::move(error));
}

// ---- all documents

JoinedScenes::JoinedScenes(
  const TextureOptions& textures, Parts parts, std::set<std::string> leftOut)
  : Textures(textures)
  , Joins(parts)
  , LeftOut(std::move(leftOut))
{
}

std::size_t JoinedScenes::MeshOf(const GltfSource& source, std::size_t node)
{
  const Json& json = source.Document.json;
  return IndexIn(Member(json, "meshes"), Member(Member(json, "nodes")[node], "mesh"));
}

Status JoinedScenes::Count(GltfSource& source)
{
  const GltfMeshes meshes(source.Document, source.Buffers, source.Materials.materials);
  std::map<std::size_t, GltfMeshes::Claims> known;
  KDSTREAM_TRY(source.Nodes.ForEachMesh(source.Buffers,
    [&](std::size_t node, const GltfPlace&) -> Status
    {
      const std::size_t mesh = MeshOf(source, node);
      const auto [entry, isNew] = known.try_emplace(mesh);
      if (isNew)
      {
        Result<GltfMeshes::Claims> claims = meshes.ClaimsOf(mesh);
        KDSTREAM_TRY(claims);
        entry->second = std::move(*claims);
      }
      this->Claims.Add(entry->second);
      if (this->Claims.zeros > 4 * GltfAccessor::mostZeros)
      {
        return Error{ ErrorCode::LimitExceeded,
          "its nodes show more than " + std::to_string(4 * GltfAccessor::mostZeros) +
            " elements of accessors without a bufferView, no bytes of which are in the file",
          {}, {}, Remedy::Repair };
      }
      constexpr std::uint64_t most = noVertex - 1;
      return this->Claims.points <= most && this->Claims.triangles <= most
               ? Status{}
               : Status(Error{ ErrorCode::LimitExceeded,
                   "its nodes show more than " + std::to_string(most) +
                     " points or triangles, the maximum: use fewer instances of its meshes",
                   {}, {}, Remedy::InMessage });
    }));
  this->IsAnimated = this->IsAnimated || CountOf(Member(source.Document.json, "animations")) > 0;
  this->AddMaterials(source);
  return {};
}

void JoinedScenes::AddMaterials(const GltfSource& source)
{
  std::vector<std::uint32_t> numbers;
  for (PictureSource picture : source.Materials.pictures)
  {
    const std::tuple place{ picture.file, picture.offset, picture.size };
    const auto number = static_cast<std::uint32_t>(this->Pictures.size());
    const auto found = this->Known.find(place);
    if (this->Documents > 0 && !picture.file.empty() && found != this->Known.end())
    {
      numbers.push_back(found->second);
      continue;
    }
    if (!picture.file.empty())
    {
      this->Known.emplace(place, number);
    }
    if (this->Joins == Parts::OfTiles)
    {
      picture.name = QuotedText(source.File.filename().string()) + ": " + picture.name;
    }
    numbers.push_back(number);
    this->Pictures.push_back(std::move(picture));
  }
  for (const GltfMaterial& material : source.Materials.materials)
  {
    TexturedMaterial& textured = this->Materials.emplace_back(material.textured);
    textured.picture = textured.picture == noPicture ? noPicture : numbers[textured.picture];
  }
  ++this->Documents;
}

void JoinedScenes::Begin()
{
  this->IsTextured = this->Textures.bake && !this->Pictures.empty();
  for (const auto& [info, count] : this->Claims.arrays)
  {
    // Texture coordinates are dropped if pictures become colours or tiles.
    if (this->LeftOut.contains(info.name) ||
        (this->IsTextured && RoleOf(info) == AttributeRole::TextureCoordinates))
    {
      continue;
    }
    if (count < this->Claims.parts)
    {
      this->Joined.warnings.push_back(
        "array \"" + info.name + "\" is dropped: not all parts have it");
      continue;
    }
    static_cast<AttributeInfo&>(this->Joined.mesh.attributes.emplace_back()) = info;
  }
}

Status JoinedScenes::Append(GltfSource& source, const Execution& execution)
{
  if (source.Materials.materials.size() > this->Materials.size() - this->MaterialsAt)
  {
    return Error{ ErrorCode::Changed, "changed while it was read" };
  }
  this->Source = &source;
  this->OfScene = Box{};
  GltfMeshes meshes(source.Document, source.Buffers, source.Materials.materials);
  std::map<std::size_t, std::size_t> uses; // uses of each mesh
  KDSTREAM_TRY(source.Nodes.ForEachMesh(source.Buffers,
    [&](std::size_t node, const GltfPlace&) -> Status
    {
      ++uses[MeshOf(source, node)];
      return {};
    }));
  std::map<std::size_t, std::vector<GltfPart>> kept; // of meshes that are used again
  std::size_t placed = 0;
  const auto total = static_cast<double>(std::max<std::uint64_t>(1, this->Claims.points));
  KDSTREAM_TRY(source.Nodes.ForEachMesh(source.Buffers,
    [&](std::size_t node, const GltfPlace& place) -> Status
    {
      constexpr std::size_t often = 256;
      if (placed++ % often == 0)
      {
        KDSTREAM_TRY(execution.Report("read", double(this->Joined.mesh.points.size()) / total));
      }
      const std::size_t mesh = MeshOf(source, node);
      const Json& weights = Member(Member(source.Document.json, "nodes")[node], "weights");
      const auto found = weights.is_null() ? kept.find(mesh) : kept.end();
      std::vector<GltfPart> read;
      if (found == kept.end())
      {
        Result<std::vector<GltfPart>> parts = meshes.PartsOf(mesh, weights);
        KDSTREAM_TRY(parts);
        read = std::move(*parts);
      }
      for (const GltfPart& part : found == kept.end() ? read : found->second)
      {
        KDSTREAM_TRY(this->AppendPart(part, node, place));
      }
      if (--uses[mesh] == 0)
      {
        kept.erase(mesh);
      }
      else if (found == kept.end() && weights.is_null())
      {
        kept.emplace(mesh, std::move(read));
      }
      return {};
    }));
  this->Joined.tolerance.Add(source.Document.tolerance);
  this->Joined.tolerance.Add(meshes.Dropped());
  this->MaterialsAt += source.Materials.materials.size();
  ++this->Appended;
  this->Source = nullptr;
  return {};
}

Status JoinedScenes::AppendPart(const GltfPart& part, std::size_t node, const GltfPlace& place)
{
  const Json& json = this->Source->Document.json;
  const Json& skins = Member(json, "skins");
  const Json& skin = Member(Member(json, "nodes")[node], "skin");
  if (skin.is_null() || part.jointsOfPoint == 0)
  {
    return this->AppendPlaced(part, place);
  }
  const std::size_t number = IndexIn(skins, skin);
  if (number == CountOf(skins))
  {
    return Error{ ErrorCode::InvalidInput,
      "node " + std::to_string(node) + " " + NamesNone("skin", skin, skins) };
  }
  GltfPart moved = part;
  KDSTREAM_TRY(ApplyGltfSkin(
    this->Source->Document, this->Source->Buffers, this->Source->Nodes, number, moved));
  return this->AppendPlaced(moved, GltfPlace{});
}

Status JoinedScenes::AppendPlaced(const GltfPart& part, const GltfPlace& place)
{
  Mesh& mesh = this->Joined.mesh;
  const std::size_t first = mesh.points.size();
  if (part.points.size() >= noVertex - first) // more than claimed: from Draco
  {
    return Error{ ErrorCode::LimitExceeded, "more than 4294967294 points, the maximum" };
  }
  const bool isMoved = !(place == GltfPlace{});
  this->AppendPoints(part, place, isMoved);
  const std::size_t firstTriangle = mesh.triangles.size();
  const bool isMirrored = isMoved && place.Determinant() < 0;
  const auto offset = static_cast<VertexId>(first);
  for (const Triangle& t : part.triangles)
  {
    mesh.triangles.push_back(
      { t[0] + offset, t[isMirrored ? 2 : 1] + offset, t[isMirrored ? 1 : 2] + offset });
  }
  if (this->Joins == Parts::OfTiles)
  {
    this->Borders.Add(
      mesh, firstTriangle, static_cast<std::uint32_t>(this->Appended), this->Placed);
  }
  for (Attribute& array : mesh.attributes)
  {
    if (array.Info() == normalsInfo)
    {
      AppendNormals(part.normals, place, array);
    }
    else if (const Attribute* const from = FindAttribute(part.arrays, array))
    {
      array.values.insert(array.values.end(), from->values.begin(), from->values.end());
    }
    if (array.TupleCount() != mesh.points.size())
    {
      return Error{ ErrorCode::Changed, "changed while it was read" };
    }
  }
  this->Lines += part.lines;
  this->IsPosed = this->IsPosed || part.jointsOfPoint > 0;
  this->IsTextured ? this->AppendTextured(part, first) : this->AppendColors(part);
  return {};
}

void JoinedScenes::AppendPoints(const GltfPart& part, const GltfPlace& place, bool isMoved)
{
  std::vector<Vec3>& points = this->Joined.mesh.points;
  Box local, placed;
  bool areFloats = true;
  for (const Vec3& point : part.points)
  {
    const Vec3 at = isMoved ? place.Of(point) : WithPositiveZeros(point);
    local.Add(point);
    placed.Add(at);
    areFloats = areFloats && std::all_of(at.begin(), at.end(),
                               [](double value) { return double(float(value)) == value; });
    points.push_back(at);
  }
  this->Placed = placed;
  this->OfScene.Add(placed);
  this->Whole.Add(placed);
  this->AreFloats = this->AreFloats && areFloats;
  this->AreDoubles =
    this->AreDoubles || (this->Joins == Parts::OfOneFile && isMoved && !areFloats &&
                          FloatsAreCoarse(placed) && IsFiner(local, placed, place));
}

// Appends the points' colours: the part's own, times the material's.
void JoinedScenes::AppendColors(const GltfPart& part)
{
  if (this->Claims.coloured == 0)
  {
    return;
  }
  const std::vector<GltfMaterial>& materials = this->Source->Materials.materials;
  const TexturedMaterial textured =
    part.material < materials.size() ? materials[part.material].textured : TexturedMaterial{};
  for (std::size_t i = 0; i < part.points.size(); ++i)
  {
    const Color own = part.colors.empty() ? white : part.colors[i];
    std::array<double, 4> channels{};
    for (std::size_t k = 0; k < 4; ++k)
    {
      const double light = own[k] * textured.factor[k];
      channels[k] = std::clamp(k < 3 ? FromLinear(light) : light, 0.0, 1.0);
    }
    channels[3] = textured.opaque ? 1 : channels[3];
    this->Colors.push_back(channels);
  }
}

// Appends, for textures: the coordinates and the material of each triangle, and colours by which
// the texture is multiplied.
void JoinedScenes::AppendTextured(const GltfPart& part, std::size_t first)
{
  const std::size_t material = part.material < this->Source->Materials.materials.size()
                                 ? this->MaterialsAt + part.material
                                 : this->Materials.size();
  std::vector<Triangle>& triangles = this->Joined.mesh.triangles;
  for (std::size_t t = triangles.size() - part.triangles.size(); t < triangles.size(); ++t)
  {
    std::array<PictureCoordinate, 3>& corners = this->Textured.corners.emplace_back();
    for (std::size_t k = 0; k < 3; ++k)
    {
      corners[k] =
        part.pictures.empty() ? noPictureCoordinate : part.pictures[triangles[t][k] - first];
    }
    this->Textured.materialOf.push_back(static_cast<std::uint32_t>(material));
  }
  this->Colors.resize(this->Joined.mesh.points.size(), white);
  std::copy(part.colors.begin(), part.colors.end(),
    this->Colors.begin() + static_cast<std::ptrdiff_t>(first));
  this->IsTinted = this->IsTinted || std::any_of(part.colors.begin(), part.colors.end(),
                                       [](const Color& color) { return color != white; });
}

void JoinedScenes::RoundToFloats()
{
  this->AreDoubles = this->AreDoubles || (this->Joins == Parts::OfTiles && !this->AreFloats &&
                                           FloatsAreCoarse(this->Whole));
  Mesh& mesh = this->Joined.mesh;
  mesh.scalarType = this->AreDoubles ? ScalarType::Float64 : ScalarType::Float32;
  for (std::size_t i = 0; i < mesh.points.size() && !this->AreDoubles; ++i)
  {
    for (double& value : mesh.points[i])
    {
      value = double(float(value));
    }
  }
}

void JoinedScenes::WarnOfAll(
  const std::vector<std::string>& scenes, const std::vector<std::string>& materials)
{
  std::vector<std::string>& warnings = this->Joined.warnings;
  warnings.insert(warnings.end(), scenes.begin(), scenes.end());
  if (this->Claims.parts == 0)
  {
    warnings.emplace_back("no node of its scene shows a mesh that has points");
  }
  if (this->Claims.skirts > 0)
  {
    warnings.push_back("left out: " + std::to_string(this->Claims.skirts) +
                       (this->Claims.skirts == 1 ? " skirt, which only closes gaps between tiles"
                                                 : " skirts, which only close gaps between tiles"));
  }
  if (this->Lines > 0)
  {
    warnings.push_back("left out: " + std::to_string(this->Lines) +
                       (this->Lines == 1 ? " line cell" : " line cells") + "; their points stay");
  }
  if (this->IsPosed || this->IsAnimated)
  {
    warnings.emplace_back(
      "skins and animations are left out: the mesh is read as its nodes place it");
  }
  warnings.insert(warnings.end(), materials.begin(), materials.end());
  if (!this->IsTextured && !this->Pictures.empty())
  {
    warnings.emplace_back("pictures are left out");
  }
}

Result<ForeignMesh> JoinedScenes::Finish(const std::vector<std::string>& scenes,
  const std::vector<std::string>& materials, const Execution& execution)
{
  this->Borders.Close(this->Joined.mesh);
  this->RoundToFloats();
  this->WarnOfAll(scenes, materials);
  if (this->IsTextured && !this->Joined.mesh.points.empty())
  {
    KDSTREAM_TRY(this->Bake(execution));
  }
  else if (!this->IsTextured && this->Claims.coloured > 0)
  {
    AddColors(this->Joined.mesh, this->Colors);
  }
  return std::move(this->Joined);
}

Status JoinedScenes::Bake(const Execution& execution)
{
  this->Textured.materials = std::move(this->Materials);
  this->Textured.materials.push_back({}); // for parts without a material
  this->Textured.pictures = std::move(this->Pictures);
  this->Textured.mesh = std::move(this->Joined.mesh);
  Result<BakeReport> report = BakeAndKeepTextures(this->Textured, this->Textures, execution,
    this->IsTinted ? std::span<const Color>(this->Colors) : std::span<const Color>());
  KDSTREAM_TRY(report);
  this->Joined.mesh = std::move(this->Textured.mesh);
  this->MultiplyByOwn(this->Joined.mesh.attributes);
  this->Joined.warnings.insert(
    this->Joined.warnings.end(), report->warnings.begin(), report->warnings.end());
  this->Joined.baked = std::move(*report);
  return {};
}

// Multiplies baked colours by the vertex colours. REQUIRES: textures were baked.
void JoinedScenes::MultiplyByOwn(std::vector<Attribute>& arrays) const
{
  Attribute& colors = *std::find_if(arrays.begin(), arrays.end(),
    [](const Attribute& array) { return RoleOf(array) == AttributeRole::Colors; });
  for (std::size_t i = 0; this->IsTinted && i < this->Colors.size(); ++i)
  {
    for (std::size_t k = 0; k < colors.components; ++k)
    {
      const auto byte = static_cast<std::size_t>(colors.Get(i, k));
      colors.Set(i, k,
        k < 3 ? ByteOfLinear(LinearOfBytes()[byte] * this->Colors[i][k])
              : double(byte) * std::clamp(this->Colors[i][k], 0.0, 1.0));
    }
  }
}

}
