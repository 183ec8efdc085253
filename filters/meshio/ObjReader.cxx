// SPDX-License-Identifier: BSD-3-Clause
// Reads Wavefront OBJ files in chunks: see ObjReader.h. Steps:
// 1. look at all statements: count them, find out whether floats are enough and what corners name
// 2. if corners name more than places: make tables on disk
// 3. read the vertices
// 4. read the faces.
#include "filters/meshio/ObjReader.h"

#include "filters/meshio/DroppedPoints.h"
#include "filters/meshio/MakeRoom.h"
#include "filters/meshio/NumberText.h"
#include "filters/meshio/ObjCorners.h"
#include "filters/meshio/ObjPlaceNumbers.h"
#include "filters/meshio/ObjStatements.h"
#include "filters/meshio/ObjVertices.h"
#include "filters/meshio/PolygonFaces.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

namespace kdstream
{

namespace
{

constexpr std::uint64_t mostPlaces = noVertex - 1; // for places, texture coordinates, normals

// What the first pass finds out.
struct Survey
{
  ObjCounts counts{};
  std::uint64_t faces = 0, triangles = 0;
  std::uint64_t statements = 0; // v, vt, vn, f
  bool materials = false;
  ObjPassedOver passedOver;
  std::array<bool, 3> named{}; // whether a corner names a texture coordinate, or a normal
  ObjPlaceNumbers places;
  DecimalPrecision precision;
};

class ObjReader : public MeshReader
{
public:
  // again: a second source for the same file.
  ObjReader(ByteSource source, ByteSource again, std::filesystem::path scratch)
    : Statements(std::move(source))
    , Again(std::move(again))
    , Scratch(std::move(scratch))
  {
  }

  Status Start(const Execution& execution);

  const MeshFileInfo& Info() const override { return this->FileInfo; }
  Result<std::size_t> ReadVertices(Mesh& mesh, std::size_t limit) override;
  Result<std::size_t> ReadTriangles(Mesh& mesh, std::size_t limit) override;
  bool CountsNotFinite() const override { return true; }
  std::string LineOfFace() const override { return this->LineHere(); }
  std::uint64_t FileSize() const override { return this->Statements.GetLines().Size(); }
  std::uint64_t Position() const override { return this->Statements.GetLines().End(); }

private:
  template <class Visit>
  Status ForEachStatement(const Execution& execution, Visit&& visit);
  void LookAtPlace(std::string_view text);
  void LookAtFace(std::string_view text);
  void Describe();
  Status MakeTables(const Execution& execution);
  Status AddToTables();

  Status NextOf(ObjKeyword wanted);
  Status ReadPlaces(Mesh& mesh, std::size_t number);
  Status ReadVerticesOfTables(Mesh& mesh, std::size_t number);
  Status ReadFaces(Mesh& mesh, std::size_t number);
  Status ReadFace(std::vector<Triangle>& triangles);
  Status CutPolygons(Mesh& mesh);
  Status KeepPlaces();
  Status ReadCorners();
  void AppendColor(const ObjPlace& place, Attribute& attribute) const;
  void Count(ObjKeyword keyword);

  bool AsFloats() const { return this->FileInfo.scalarType == ScalarType::Float32; }
  // Counts a vertex of the file that is not finite. Such a vertex becomes several vertices of the
  // mesh if faces name several normals for it; it is counted once.
  void CheckFinite(const Vec3& point);
  // Returns " (line 5)", or nothing if the line is not known.
  std::string LineHere() const;
  // Returns "face 0 (line 5)".
  std::string PlaceOf(const char* element, std::uint64_t index) const;
  Error At(const char* element, std::uint64_t index, const Error& error) const
  {
    return AtPlaceInObj(this->PlaceOf(element, index), error);
  }

  ObjStatements Statements;
  ByteSource Again;
  std::filesystem::path Scratch;
  Survey Found;
  ObjPlaceColumns PlacesHave;
  MeshFileInfo FileInfo;
  std::unique_ptr<ObjVertices> Tables; // only if corners name more than places
  PolygonFaces Polygons;
  std::unique_ptr<ScratchTable<Vec3>> Places; // made for the first polygon

  ObjCorners Corners; // of the current face

  ObjCounts SoFar{}; // statements so far in this pass
  std::uint64_t VerticesRead = 0;
  std::uint64_t FacesRead = 0;
  bool AtFaces = false, Opened = false;
  std::optional<Error> Failure;
};

std::string ObjReader::PlaceOf(const char* element, std::uint64_t index) const
{
  return std::string(element) + " " + std::to_string(index) + this->LineHere();
}

std::string ObjReader::LineHere() const
{
  return this->Opened && this->Tables
           ? std::string()
           : " (line " + std::to_string(this->Statements.GetLines().Number()) + ")";
}

void ObjReader::CheckFinite(const Vec3& point)
{
  if (IsFinite(point))
  {
    return;
  }
  Tolerance& tolerance = this->FileInfo.tolerance;
  constexpr Lapse kind = Lapse::PointNotFinite;
  tolerance.Count(kind, 1,
    tolerance.Of(kind) > 0
      ? std::string()
      : this->PlaceOf("vertex", this->VerticesRead) + ", " + WhatIsNotFinite(point));
}

void ObjReader::Count(ObjKeyword keyword)
{
  switch (keyword)
  {
    case ObjKeyword::Place:
      ++this->SoFar[0];
      break;
    case ObjKeyword::TextureCoordinate:
      ++this->SoFar[1];
      break;
    case ObjKeyword::Normal:
      ++this->SoFar[2];
      break;
    default:
      break;
  }
}

// One pass over the whole text; afterwards the source stands at the beginning again.
template <class Visit>
Status ObjReader::ForEachStatement(const Execution& execution, Visit&& visit)
{
  this->SoFar = {};
  KDSTREAM_TRY(this->Statements.ForEach(execution, 0, 1,
    [&]() -> Status
    {
      KDSTREAM_TRY(visit());
      this->Count(this->Statements.Keyword());
      return {};
    }));
  this->Statements.Restart();
  this->SoFar = {};
  return {};
}

void ObjReader::LookAtPlace(std::string_view text)
{
  for (std::size_t k = 0; k < 3; ++k)
  {
    this->Found.precision.Add(TakeWord(text));
  }
  this->Found.places.Add(text);
}

// Adds how many triangles the face can have, and whether its corners name more than places.
void ObjReader::LookAtFace(std::string_view text)
{
  bool isBlank = true;
  std::uint64_t corners = 0;
  for (const char c : text)
  {
    corners += isBlank && !IsBlank(c) ? 1 : 0;
    isBlank = IsBlank(c);
  }
  this->Found.triangles += corners - std::min<std::uint64_t>(corners, 2);
  if (text.find('/') == std::string_view::npos || (this->Found.named[1] && this->Found.named[2]))
  {
    return;
  }
  for (std::string_view word = TakeWord(text); !word.empty(); word = TakeWord(text))
  {
    std::size_t part = 0;
    for (const char c : word)
    {
      part += c == '/' ? 1 : 0;
      if (c != '/' && part < 3)
      {
        this->Found.named[part] = true;
      }
    }
  }
}

Status ObjReader::Start(const Execution& execution)
{
  Survey& found = this->Found;
  Status surveyed = this->ForEachStatement(execution,
    [&]() -> Status
    {
      const ObjKeyword keyword = this->Statements.Keyword();
      found.statements += keyword <= ObjKeyword::Face ? 1 : 0;
      found.materials |= keyword == ObjKeyword::Material;
      found.passedOver.Add(this->Statements);
      if (keyword == ObjKeyword::Face)
      {
        ++found.faces;
        this->LookAtFace(this->Statements.Rest());
      }
      if (keyword > ObjKeyword::Normal)
      {
        return {};
      }
      if (++found.counts[static_cast<std::size_t>(keyword)] > mostPlaces)
      {
        return Error{ ErrorCode::LimitExceeded, "more than " + std::to_string(mostPlaces) + " " +
                                                  objPartNames[static_cast<std::size_t>(keyword)] +
                                                  "s" };
      }
      if (keyword == ObjKeyword::Place)
      {
        this->LookAtPlace(this->Statements.Rest());
      }
      return {};
    });
  KDSTREAM_TRY(surveyed);
  if (this->FileSize() == 0)
  {
    return BadInput("the file is empty", Remedy::CopyAgain);
  }
  if (found.statements == 0)
  {
    return BadInput("is not an OBJ file: no line says v, vt, vn or f", Remedy::Rename);
  }
  this->FileInfo.tolerance.Count(Lapse::PaddedEnd, this->Statements.GetLines().Padding());
  // Texture coordinates or normals that no corner names do not become an attribute. In a cloud,
  // each point uses the ones of its own number.
  for (const std::size_t part : { 1, 2 })
  {
    found.named[part] &= found.counts[part] > 0;
    found.named[part] |=
      found.faces == 0 && found.counts[0] > 0 && found.counts[part] == found.counts[0];
  }
  this->Describe();
  if (found.named[1] || found.named[2])
  {
    KDSTREAM_TRY(this->MakeTables(execution));
  }
  this->Opened = true;
  return {};
}

void ObjReader::Describe()
{
  Survey& found = this->Found;
  MeshFileInfo& info = this->FileInfo;
  info.vertices = found.counts[0];
  info.faces = found.faces;
  info.mostTriangles = found.triangles;
  info.scalarType = found.precision.FloatsSuffice() ? ScalarType::Float32 : ScalarType::Float64;
  this->PlacesHave = found.places.Decide(found.counts[0], found.named[2], info.tolerance);
  if (this->PlacesHave.what == ObjPlaceColumns::What::Colors)
  {
    info.attributes.push_back({ "RGB", AttributeType::UInt8, AttributeAssociation::Point, 3 });
  }
  if (found.named[2] || this->PlacesHave.what == ObjPlaceColumns::What::Normals)
  {
    info.attributes.push_back(
      { "Normals", AttributeType::Float32, AttributeAssociation::Point, 3 });
  }
  if (found.named[1])
  {
    info.attributes.push_back(
      { "TCoords", AttributeType::Float32, AttributeAssociation::Point, 2 });
  }
  if (found.materials)
  {
    info.ignoredAttributes.push_back(objMaterialsName);
  }
  found.passedOver.Name(info.ignoredAttributes);
  for (const std::size_t part : { 1, 2 })
  {
    if (found.counts[part] > 0 && !found.named[part])
    {
      info.ignoredAttributes.push_back(std::string(objPartNames[part]) + "s, which no face names");
    }
  }
  if (!this->PlacesHave.ignored.empty())
  {
    info.ignoredAttributes.push_back(this->PlacesHave.ignored);
  }
}

// Makes two passes, because the elements that corners name must be in the tables before the corners
// are read.
Status ObjReader::MakeTables(const Execution& execution)
{
  this->Tables = std::make_unique<ObjVertices>(this->Scratch);
  Status made = this->ForEachStatement(execution, [this]() { return this->AddToTables(); });
  KDSTREAM_TRY(made);
  made = this->ForEachStatement(execution,
    [&]() -> Status
    {
      if (this->Found.faces == 0 && this->Statements.Keyword() == ObjKeyword::Place)
      {
        const auto number = static_cast<std::uint32_t>(this->SoFar[0] + 1);
        const ObjVertices::Corner corner{ number, this->Found.named[1] ? number : 0,
          this->Found.named[2] ? number : 0 };
        return this->Tables->AddFace(std::span(&corner, 1)); // the face is not read
      }
      if (this->Statements.Keyword() != ObjKeyword::Face)
      {
        return {};
      }
      KDSTREAM_TRY(this->ReadCorners());
      ++this->FacesRead;
      // A face with too few corners is counted later, when it is read.
      const auto corners = this->Corners.Get();
      return this->Tables->AddFace(
        corners.size() < 3 ? std::span<const ObjVertices::Corner>() : corners);
    });
  this->FacesRead = 0;
  this->FileInfo.vertices = this->Tables->Size();
  return made;
}

// Takes a statement that is not a face.
Status ObjReader::AddToTables()
{
  const std::string_view text = this->Statements.Rest();
  switch (this->Statements.Keyword())
  {
    case ObjKeyword::Place:
    {
      ObjPlace place;
      const Status parsed = ParseObjPlace(text, this->AsFloats(), place, this->PlacesHave.at);
      return parsed ? this->Tables->AddPlace(place)
                    : this->At("vertex", this->SoFar[0], parsed.GetError());
    }
    case ObjKeyword::TextureCoordinate:
    {
      std::array<float, 2> values{};
      const Status parsed = ParseObjTextureCoordinate(text, values);
      return parsed ? this->Tables->AddTextureCoordinate(values)
                    : this->At("texture coordinate", this->SoFar[1], parsed.GetError());
    }
    case ObjKeyword::Normal:
    {
      std::array<float, 3> values{};
      const Status parsed = ParseObjNormal(text, values);
      return parsed ? this->Tables->AddNormal(values)
                    : this->At("normal", this->SoFar[2], parsed.GetError());
    }
    default:
      return {};
  }
}

Status ObjReader::ReadCorners()
{
  return this->Corners.Read(
    this->Statements, this->SoFar, this->Found.counts, this->FacesRead, this->FileInfo.tolerance);
}

Result<std::size_t> ObjReader::ReadVertices(Mesh& mesh, std::size_t limit)
{
  PrepareArrays(mesh, this->FileInfo);
  if (this->Failure)
  {
    return *this->Failure;
  }
  const auto number = static_cast<std::size_t>(
    std::min<std::uint64_t>(limit, this->FileInfo.vertices - this->VerticesRead));
  MakeRoom(mesh.points, number); // all places were counted
  if (Status read =
        this->Tables ? this->ReadVerticesOfTables(mesh, number) : this->ReadPlaces(mesh, number);
      !read)
  {
    this->Failure = read.GetError();
    return *this->Failure;
  }
  return number;
}

Result<std::size_t> ObjReader::ReadTriangles(Mesh& mesh, std::size_t limit)
{
  PrepareArrays(mesh, this->FileInfo);
  if (this->Failure)
  {
    return *this->Failure;
  }
  const auto number = static_cast<std::size_t>(
    std::min<std::uint64_t>(limit, this->FileInfo.faces - this->FacesRead));
  MakeRoom(mesh.triangles, number);
  if (Status read = this->ReadFaces(mesh, number); !read)
  {
    this->Failure = read.GetError();
    return *this->Failure;
  }
  return number;
}

// Goes to the next statement of this kind, which existed when the file was opened.
Status ObjReader::NextOf(ObjKeyword wanted)
{
  for (;;)
  {
    const Result<bool> more = this->Statements.Next();
    KDSTREAM_TRY(more);
    if (!*more)
    {
      return BadInput("truncated: the file has changed since it was opened", Remedy::Retry);
    }
    if (this->Statements.Keyword() == wanted)
    {
      return {};
    }
    this->Count(this->Statements.Keyword());
  }
}

Status ObjReader::ReadPlaces(Mesh& mesh, std::size_t number)
{
  for (std::size_t i = 0; i < number; ++i)
  {
    KDSTREAM_TRY(this->NextOf(ObjKeyword::Place));
    ObjPlace place;
    if (Status parsed =
          ParseObjPlace(this->Statements.Rest(), this->AsFloats(), place, this->PlacesHave.at);
        !parsed)
    {
      return this->At("vertex", this->VerticesRead, parsed.GetError());
    }
    mesh.points.push_back(place.point);
    this->CheckFinite(place.point);
    if (!mesh.attributes.empty())
    {
      this->AppendColor(place, mesh.attributes[0]);
    }
    ++this->VerticesRead;
  }
  return {};
}

// Appends a colour, or a normal that follows the coordinates.
void ObjReader::AppendColor(const ObjPlace& place, Attribute& attribute) const
{
  const std::size_t tuple = attribute.TupleCount();
  attribute.values.resize(attribute.values.size() + attribute.TupleSize());
  for (std::size_t k = 0; k < 3; ++k)
  {
    attribute.Set(tuple, k, double(place.color[k]) * this->PlacesHave.scale);
  }
}

Status ObjReader::ReadVerticesOfTables(Mesh& mesh, std::size_t number)
{
  const auto append = [](Attribute& attribute, const auto& values)
  {
    const auto* const bytes = reinterpret_cast<const std::uint8_t*>(values.data());
    attribute.values.insert(attribute.values.end(), bytes, bytes + sizeof(values));
  };
  for (std::size_t i = 0; i < number; ++i)
  {
    const Result<ObjVertices::Vertex> vertex = this->Tables->GetVertex(this->VerticesRead);
    KDSTREAM_TRY(vertex);
    mesh.points.push_back(vertex->place.point);
    if (this->VerticesRead < this->Found.counts[0])
    {
      this->CheckFinite(vertex->place.point);
    }
    for (Attribute& attribute : mesh.attributes)
    {
      const bool behindPlace = attribute.type == AttributeType::UInt8 || !this->Found.named[2];
      if (attribute.components == 3 && behindPlace)
      {
        this->AppendColor(vertex->place, attribute);
      }
      else if (attribute.components == 3)
      {
        append(attribute, vertex->normal);
      }
      else
      {
        append(attribute, vertex->textureCoordinate);
      }
    }
    ++this->VerticesRead;
  }
  return {};
}

Status ObjReader::ReadFaces(Mesh& mesh, std::size_t number)
{
  if (!this->AtFaces && !this->Tables)
  {
    this->Statements.Restart();
    this->SoFar = {};
  }
  this->AtFaces = true;
  for (std::size_t i = 0; i < number; ++i)
  {
    const std::size_t before = mesh.triangles.size();
    KDSTREAM_TRY(
      this->Tables ? this->Tables->ReadFace(mesh.triangles) : this->ReadFace(mesh.triangles));
    this->Polygons.Add(before, mesh.triangles.size() - before);
    if (mesh.triangles.size() == before)
    {
      Tolerance& tolerance = this->FileInfo.tolerance;
      constexpr Lapse kind = Lapse::FaceTooSmall;
      tolerance.Count(
        kind, 1, tolerance.Of(kind) == 0 ? this->PlaceOf("face", this->FacesRead) : std::string());
    }
    ++this->FacesRead;
  }
  return this->CutPolygons(mesh);
}

// Takes the positions from the mesh's points if the mesh has all of them, else from a table.
Status ObjReader::CutPolygons(Mesh& mesh)
{
  if (this->Polygons.Empty())
  {
    return {};
  }
  if (mesh.points.size() == this->FileInfo.vertices)
  {
    return this->Polygons.Cut(
      mesh.triangles, [&](VertexId vertex) { return Result<Vec3>(mesh.points[vertex]); });
  }
  if (this->Tables)
  {
    return this->Polygons.Cut(
      mesh.triangles, [&](VertexId vertex) { return this->Tables->GetPoint(vertex); });
  }
  if (!this->Places)
  {
    KDSTREAM_TRY(this->KeepPlaces());
  }
  return this->Polygons.Cut(
    mesh.triangles, [&](VertexId vertex) { return this->Places->Get(vertex); });
}

// Reads all places into a table. The text has no errors: the first passes have checked it.
Status ObjReader::KeepPlaces()
{
  this->Places = std::make_unique<ScratchTable<Vec3>>(this->Scratch);
  ObjStatements statements(std::move(this->Again));
  return statements.ForEach({}, 0, 1,
    [&]() -> Status
    {
      if (statements.Keyword() != ObjKeyword::Place)
      {
        return {};
      }
      ObjPlace place;
      KDSTREAM_TRY(ParseObjPlace(statements.Rest(), this->AsFloats(), place));
      return this->Places->Append(place.point);
    });
}

// Reads a face as a fan of triangles.
Status ObjReader::ReadFace(std::vector<Triangle>& triangles)
{
  KDSTREAM_TRY(this->NextOf(ObjKeyword::Face));
  KDSTREAM_TRY(this->ReadCorners());
  const auto corners = this->Corners.Get();
  for (std::size_t i = 2; i < corners.size(); ++i)
  {
    triangles.push_back({ corners[0][0] - 1, corners[i - 1][0] - 1, corners[i][0] - 1 });
  }
  return {};
}

}

Result<std::unique_ptr<MeshReader>> OpenObjReader(
  ByteSource source, const Execution& execution, const std::filesystem::path& scratch)
{
  Result<ByteSource> again = source.Again();
  KDSTREAM_TRY(again);
  auto reader = std::make_unique<ObjReader>(std::move(source), std::move(*again), scratch);
  Status started = reader->Start(execution);
  return started ? Result<std::unique_ptr<MeshReader>>(std::move(reader)) : started.GetError();
}

}
