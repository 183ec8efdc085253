// SPDX-License-Identifier: BSD-3-Clause
// Reads OBJ files with their materials: see TexturedObj.h. Steps:
// 1. look at all statements: counts, whether floats are enough, the libraries
// 2. read places, texture coordinates and normals; and faces, whose corners may name later elements
// 3. make vertices: one for each combination of place and normal
// 4. split into tiles.
#include "filters/texture/TexturedObj.h"

#include "filters/core/Texts.h"
#include "filters/meshio/DroppedPoints.h"
#include "filters/meshio/NumberText.h"
#include "filters/meshio/ObjCorners.h"
#include "filters/meshio/ObjStatements.h"
#include "filters/meshio/PolygonFaces.h"
#include "filters/meshio/QuotedText.h"
#include "filters/texture/ObjMaterials.h"
#include "filters/texture/PictureTiles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <unordered_map>

namespace kdstream
{
namespace
{

constexpr std::size_t mostUnknown = 20; // materials that warnings name

class TexturedObjReader
{
public:
  TexturedObjReader(std::filesystem::path file, ByteSource source)
    : File(file)
    , Statements(std::move(source))
    , Libraries(std::move(file))
  {
  }

  Result<TexturedFile> Read(const Execution& execution)
  {
    KDSTREAM_TRY(this->ForEachStatement(execution, 0, [this]() { return this->LookAt(); }));
    this->Out.tolerance.Count(Lapse::PaddedEnd, this->Statements.GetLines().Padding());
    this->AsFloats = this->Precision.FloatsSuffice();
    this->Out.textured.mesh.scalarType = this->AsFloats ? ScalarType::Float32 : ScalarType::Float64;
    this->TakeMaterials();
    this->Reserve();
    KDSTREAM_TRY(this->ForEachStatement(execution, 0.5, [this]() { return this->Keep(); }));
    if (this->Colored)
    {
      this->Out.warnings.push_back(
        std::string("vertex colours are left out: ") +
        (this->Out.textured.pictures.empty() ? "materials" : "pictures") + " paint instead");
    }
    KDSTREAM_TRY(this->CutPolygons());
    KDSTREAM_TRY(DropNotFiniteFaces(this->Out.textured.mesh, this->BeginsFace, this->Out.tolerance,
      this->Out.textured.materialOf, this->CornerCoordinates, this->CornerNormals));
    this->MakeNormals();
    if (this->Unknown > mostUnknown)
    {
      this->Out.warnings.push_back(
        std::to_string(this->Unknown - mostUnknown) +
        " further materials are in no material library: they are drawn white");
    }
    this->SplitIntoTiles();
    return std::move(this->Out);
  }

private:
  // One of the two passes. before: the progress of "read" when the pass begins.
  template <class Visit>
  Status ForEachStatement(const Execution& execution, double before, const Visit& visit)
  {
    this->SoFar = {};
    return this->Statements.ForEach(execution, before, 0.5,
      [&]() -> Status
      {
        KDSTREAM_TRY(visit());
        const auto kind = static_cast<std::size_t>(this->Statements.Keyword());
        if (kind < this->SoFar.size() && ++this->SoFar[kind] >= noVertex)
        {
          return Error{ ErrorCode::LimitExceeded,
            "more than 4294967294 " + std::string(objPartNames[kind]) + "s" };
        }
        return {};
      });
  }

  std::uint64_t Line() const { return this->Statements.GetLines().Number(); }

  Status LookAt()
  {
    std::string_view text = this->Statements.Rest();
    const auto kind = static_cast<std::size_t>(this->Statements.Keyword());
    if (kind < this->All.size())
    {
      ++this->All[kind];
    }
    this->AllFaces += this->Statements.Keyword() == ObjKeyword::Face ? 1 : 0;
    if (this->Statements.Keyword() == ObjKeyword::Place)
    {
      for (std::size_t k = 0; k < 3; ++k)
      {
        this->Precision.Add(TakeWord(text));
      }
    }
    else if (this->Statements.Name() == "mtllib")
    {
      this->Libraries.Add(text, this->Line());
    }
    this->PassedOver.Add(this->Statements);
    return {};
  }

  // Reserves memory for all statements, so that nothing is moved as it grows.
  void Reserve()
  {
    TexturedMesh& textured = this->Out.textured;
    textured.mesh.points.reserve(this->All[0]);
    this->Coordinates.reserve(this->All[1]);
    this->NormalsRead.reserve(this->All[2]);
    textured.mesh.triangles.reserve(this->AllFaces);
    textured.materialOf.reserve(this->AllFaces);
    this->CornerCoordinates.reserve(this->AllFaces);
    this->CornerNormals.reserve(this->AllFaces);
  }

  void TakeMaterials()
  {
    this->Libraries.AddOwn();
    ObjMaterials found = this->Libraries.Take();
    this->Out.warnings = std::move(found.warnings);
    std::vector<std::string> notCarried;
    this->PassedOver.Name(notCarried);
    for (const std::string& name : notCarried)
    {
      this->Out.warnings.push_back("left out: " + name);
    }
    this->Out.libraries = std::move(found.libraries);
    TexturedMesh& textured = this->Out.textured;
    textured.materials.push_back({}); // for faces without a material
    std::map<std::filesystem::path, std::uint32_t> pictures;
    FilesBeside files(this->File);
    for (ObjMaterial& read : found.materials)
    {
      TexturedMaterial material;
      material.name = read.name;
      material.color = read.color;
      material.wrapU = material.wrapV = read.clamp ? TextureWrap::Clamp : TextureWrap::Repeat;
      material.transform = { { read.scale[0], 0, read.offset[0] },
        { 0, -read.scale[1], 1 - read.offset[1] } };
      if (!read.picture.empty())
      {
        const std::filesystem::path file = files.Find(read.picture);
        const auto [at, added] =
          pictures.try_emplace(file, static_cast<std::uint32_t>(textured.pictures.size()));
        if (added)
        {
          textured.pictures.push_back(
            PictureBeside(file, read.picture, "the picture ", " (" + read.place + ")"));
        }
        material.picture = at->second;
      }
      this->Materials.Add(material.name, static_cast<std::uint32_t>(textured.materials.size()));
      textured.materials.push_back(std::move(material));
    }
  }

  // A tile's picture may have a name in another case than its file.
  void SplitIntoTiles()
  {
    std::vector<PictureSource>& pictures = this->Out.textured.pictures;
    const std::size_t before = pictures.size();
    SplitTiles(this->Out.textured);
    FilesBeside files(this->File);
    for (std::size_t i = before; i < pictures.size(); ++i)
    {
      pictures[i].file =
        files.Find(pictures[i].file.lexically_relative(this->File.parent_path()).string());
    }
  }

  Status Keep()
  {
    const std::string_view text = this->Statements.Rest();
    switch (this->Statements.Keyword())
    {
      case ObjKeyword::Place:
        return this->KeepPlace(text);
      case ObjKeyword::TextureCoordinate:
        return this->KeepTextureCoordinate(text);
      case ObjKeyword::Normal:
        return this->KeepNormal(text);
      case ObjKeyword::Face:
        return this->KeepFace();
      default:
        break;
    }
    if (this->Statements.Name() == "usemtl")
    {
      this->Use(text);
    }
    return {};
  }

  Status KeepPlace(std::string_view text)
  {
    ObjPlace place;
    if (Status parsed = ParseObjPlace(text, this->AsFloats, place); !parsed)
    {
      return this->At("vertex", this->SoFar[0], parsed.GetError());
    }
    this->Colored = this->Colored || place.colored;
    this->Out.textured.mesh.points.push_back(place.point);
    return {};
  }

  Status KeepTextureCoordinate(std::string_view text)
  {
    const Status parsed = ParseObjTextureCoordinate(text, this->Coordinates.emplace_back());
    return parsed ? parsed
                  : Status(this->At("texture coordinate", this->SoFar[1], parsed.GetError()));
  }

  Status KeepNormal(std::string_view text)
  {
    const Status parsed = ParseObjNormal(text, this->NormalsRead.emplace_back());
    return parsed ? parsed : Status(this->At("normal", this->SoFar[2], parsed.GetError()));
  }

  void Use(std::string_view text)
  {
    const std::string name(Trimmed(text, blanksOfNames));
    const std::optional<std::uint32_t> found = this->Materials.Find(name);
    this->Material = found.value_or(0);
    // The number of unknown names that are kept is limited.
    const bool added = !found && (this->UnknownNames.size() >= mostObjMaterials
                                     ? !this->UnknownNames.contains(name)
                                     : this->UnknownNames.insert(name).second);
    if (added && ++this->Unknown <= mostUnknown)
    {
      this->Out.warnings.push_back("line " + std::to_string(this->Line()) + ": the material " +
                                   QuotedText(name) +
                                   " is in no material library: it is drawn white");
    }
  }

  // Keeps the face as a fan of triangles.
  Status KeepFace()
  {
    TexturedMesh& textured = this->Out.textured;
    Tolerance& tolerance = this->Out.tolerance;
    KDSTREAM_TRY(
      this->Corners.Read(this->Statements, this->SoFar, this->All, this->Faces, tolerance));
    const std::span<const ObjCorners::Corner> corners = this->Corners.Get();
    const std::size_t first = textured.mesh.triangles.size();
    for (std::size_t i = 2; i < corners.size(); ++i)
    {
      const ObjCorners::Corner &a = corners[0], &b = corners[i - 1], &c = corners[i];
      textured.mesh.triangles.push_back({ a[0] - 1, b[0] - 1, c[0] - 1 });
      this->CornerCoordinates.push_back({ a[1], b[1], c[1] });
      this->CornerNormals.push_back({ a[2], b[2], c[2] });
      textured.materialOf.push_back(this->Material);
      this->BeginsFace.push_back(i == 2);
    }
    this->Polygons.Add(first, textured.mesh.triangles.size() - first);
    if (corners.size() < 3)
    {
      ForgiveObjFace(Lapse::FaceTooSmall, this->Faces, this->Statements, tolerance);
    }
    ++this->Faces;
    return {};
  }

  Status CutPolygons()
  {
    Mesh& mesh = this->Out.textured.mesh;
    return this->Polygons.Cut(
      mesh.triangles, [&](VertexId vertex) { return Result<Vec3>(mesh.points[vertex]); },
      [&](std::size_t first, std::span<const Triangle> cut)
      {
        for (auto* const corners :
          { &mesh.triangles, &this->CornerNormals, &this->CornerCoordinates })
        {
          ScatterToTriangles(std::span(*corners).subspan(first, cut.size()), cut);
        }
      });
  }

  // Makes a vertex for each normal that corners name at a place. The first is the place's own
  // vertex.
  void MakeNormals()
  {
    TexturedMesh& textured = this->Out.textured;
    textured.corners.reserve(this->CornerCoordinates.size());
    for (const std::array<std::uint32_t, 3>& named : this->CornerCoordinates)
    {
      std::array<PictureCoordinate, 3>& corners = textured.corners.emplace_back();
      for (std::size_t k = 0; k < 3; ++k)
      {
        corners[k] = named[k] == 0 ? noPictureCoordinate : this->Coordinates[named[k] - 1];
      }
    }
    const bool named = std::any_of(this->CornerNormals.begin(), this->CornerNormals.end(),
      [](const std::array<std::uint32_t, 3>& n) { return n[0] + n[1] + n[2] > 0; });
    if (!named)
    {
      return;
    }
    std::vector<Vec3>& points = textured.mesh.points;
    constexpr std::uint32_t unset = noVertex;
    std::vector<std::uint32_t> normalOf(points.size(), unset); // for each vertex
    std::unordered_map<std::uint64_t, VertexId> others;        // vertices by place and normal
    for (std::size_t t = 0; t < textured.mesh.triangles.size(); ++t)
    {
      for (std::size_t k = 0; k < 3; ++k)
      {
        VertexId& vertex = textured.mesh.triangles[t][k];
        const std::uint32_t normal = this->CornerNormals[t][k];
        if (normalOf[vertex] == unset)
        {
          normalOf[vertex] = normal;
        }
        if (normalOf[vertex] == normal)
        {
          continue;
        }
        const auto [at, added] = others.try_emplace(
          (std::uint64_t{ vertex } << 32U) | normal, static_cast<VertexId>(points.size()));
        if (added)
        {
          points.push_back(Vec3(points[vertex]));
          normalOf.push_back(normal);
        }
        vertex = at->second;
      }
    }
    Attribute normals{ { "Normals", AttributeType::Float32, AttributeAssociation::Point, 3 }, {} };
    for (const std::uint32_t normal : normalOf)
    {
      const std::array<float, 3> values =
        normal == unset || normal == 0 ? std::array<float, 3>{} : this->NormalsRead[normal - 1];
      const auto* const bytes = reinterpret_cast<const std::uint8_t*>(values.data());
      normals.values.insert(normals.values.end(), bytes, bytes + sizeof values);
    }
    textured.mesh.attributes.push_back(std::move(normals));
  }

  Error At(const char* element, std::uint64_t index, const Error& error) const
  {
    return AtPlaceInObj(PlaceInObj(element, index, this->Statements), error);
  }

  std::filesystem::path File;
  ObjStatements Statements;
  ObjLibraries Libraries;
  DecimalPrecision Precision;
  ObjPassedOver PassedOver;
  bool AsFloats = true, Colored = false;
  ObjCounts All{}, SoFar{};
  std::uint64_t Faces = 0, AllFaces = 0;
  MaterialNames Materials;
  std::set<std::string> UnknownNames;
  std::uint32_t Material = 0;
  std::size_t Unknown = 0;
  std::vector<PictureCoordinate> Coordinates;
  std::vector<std::array<float, 3>> NormalsRead;
  std::vector<std::array<std::uint32_t, 3>> CornerCoordinates, CornerNormals; // from 1; 0: none
  PolygonFaces Polygons;
  std::vector<bool> BeginsFace; // for each triangle
  ObjCorners Corners;           // of the current face
  TexturedFile Out;
};

}

Result<TexturedFile> ReadTexturedObj(const std::filesystem::path& file, const Execution& execution)
{
  Result<ByteSource> source = ByteSource::Open(file);
  KDSTREAM_TRY(source);
  return TexturedObjReader(file, std::move(*source)).Read(execution);
}

}
