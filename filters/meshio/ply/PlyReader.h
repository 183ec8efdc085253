// SPDX-License-Identifier: BSD-3-Clause
// Reads PLY files in chunks: step "read" of the pipeline picture.
#pragma once

#include "filters/meshio/MeshReader.h"
#include "filters/meshio/PolygonFaces.h"
#include "filters/meshio/ScratchTable.h"
#include "filters/meshio/ply/PlyBody.h"
#include "filters/meshio/ply/PlyHeader.h"

#include <array>
#include <optional>

namespace kdstream
{

// ASCII and binary PLY of either byte order, version 1.0. Elements and properties may come in any
// order. The vertices are always read first, so a file that has faces before vertices is read
// twice.
//
// Read: element "vertex" (x, y, z of any scalar type); elements "face" and "tristrips" (the list
// that PlyElement::FindCorners finds, of whole numbers of any type). Their other scalar properties
// become attributes (names: PlyArrays.h), at most 255; those of faces only if every element with
// faces has them. Everything else is skipped, and named in Info().ignoredAttributes. Bytes after
// the end are counted when the end is reached.
// - Coordinates are Float32 if x, y and z are all floats or integers of at most 16 bits, which
//   floats hold exactly; else Float64. ASCII values are rounded once, to the type in the header.
// - A strip of fewer than three vertices has no triangle and is skipped; a polygon of fewer than
//   three is counted.
// - Info().mostTriangles is how many triangles the file has room for beside everything else that
//   its header claims. A file with more is refused when they are read: it is truncated, or has
//   faces of fewer than two vertices although its bytes could only just hold this number of
//   triangles.
//
// Memory: one block of the file, and the vectors that the caller passes. These grow with the bytes
// that were read, never because of a claim in the header or in a list. One face can have as many
// triangles as the file has bytes; its attributes, repeated for each triangle, can take 16 times
// the file's bytes.
class PlyReader : public MeshReader
{
public:
  // Errors: those of ReadPlyHeader; InvalidInput for a header without vertices, coordinates or
  // corners; LimitExceeded for more vertices than VertexId can number. scratch: a folder for a
  // table of positions, needed when polygons are read into a mesh without vertices (see
  // MeshReader::ReadTriangles); if empty, the system's folder.
  static Result<std::unique_ptr<MeshReader>> Open(
    ByteSource source, const std::filesystem::path& scratch = {});
  // The same for a body at which `source` stands, with a header that other code has made. reported:
  // the counts that this code has already reported.
  static Result<std::unique_ptr<MeshReader>> OpenAs(ByteSource source, PlyHeader header,
    const std::filesystem::path& scratch, const Tolerance& reported = {});

  const MeshFileInfo& Info() const override { return this->FileInfo; }
  // After an error, every further call gives the same error.
  Result<std::size_t> ReadVertices(Mesh& mesh, std::size_t limit) override;
  Result<std::size_t> ReadTriangles(Mesh& mesh, std::size_t limit) override;
  Result<std::uint64_t> SkipVertices(std::uint64_t count) override;
  Result<std::uint64_t> SkipFaces(std::uint64_t count) override;
  bool KnowsFinite() const override { return this->Finite; }
  std::uint64_t FileSize() const override { return this->Source.Size(); }
  std::uint64_t Position() const override { return this->Source.Position(); }

private:
  // An element with faces, and which of its properties has the corners.
  struct FaceElement
  {
    std::size_t element = 0;
    std::size_t list = 0;
    PlyFaceSink::Kind kind = PlyFaceSink::Kind::Polygon;
    PlyArraySink arrays{};
  };

  PlyReader(ByteSource source, PlyHeader header, std::filesystem::path scratch);

  Status UnderstandHeader();
  Status UnderstandVertices();
  Status UnderstandFaces(std::size_t element, PlyFaceSink::Kind kind);
  Status CheckOrder() const;
  void FindAttributes();
  void FindFaceAttributes();
  void ListIgnoredAttributes();
  std::uint64_t MostTriangles() const;

  Status MoveTo(std::size_t element, std::uint64_t record);
  Status SkipToRecord(std::uint64_t record);
  Result<std::size_t> ReadSomeVertices(Mesh& mesh, std::size_t limit);
  Result<std::size_t> ReadSomeTriangles(Mesh& mesh, std::size_t limit);
  Result<std::uint64_t> SkipSomeFaces(std::uint64_t count);
  std::uint64_t BytesOfTriangles(
    const FaceElement& faces, std::uint64_t begin, std::uint64_t number) const;
  Status CheckTriangles(const FaceElement& faces) const;
  Status CountTriangles(const PlyElement& element, std::uint64_t made);
  template <class Number>
  Result<Number> Remember(Result<Number> result);
  Status CheckBytesAfterEnd();
  void CountLongLines();
  Status CutPolygons(Mesh& mesh);
  Status KeepPlaces();

  ByteSource Source;
  PlyHeader Header;
  std::unique_ptr<PlyBody> Body;
  MeshFileInfo FileInfo;

  std::size_t VertexElement = 0;
  std::array<std::size_t, 3> Coordinates{}; // numbers of the properties x, y, z
  std::vector<std::vector<bool>> Read;      // [element][property]: whether it is used
  PlyArraySink VertexArrays;
  std::size_t PointArrays = 0; // the number of point arrays, the first of Info().attributes
  std::vector<FaceElement> Faces;

  // Where the source stands, and where each element begins that has been reached so far.
  std::size_t CurrentElement = 0;
  std::uint64_t CurrentRecord = 0;
  std::vector<std::uint64_t> ElementBegins;

  std::uint64_t VerticesRead = 0;
  std::size_t FaceElementsDone = 0;
  std::uint64_t FacesRead = 0; // of the element Faces[FaceElementsDone]
  std::uint64_t TrianglesMade = 0;
  // If faces were skipped on the assumption that all are triangles: the bytes of one face, and
  // where the first face begins.
  std::uint64_t TriangleBytes = 0, TrianglesBegin = 0;
  std::filesystem::path Scratch;
  PolygonFaces Polygons;
  std::unique_ptr<ScratchTable<Vec3>> Places; // of all vertices; made at the first polygon
  bool CheckedBytesAfterEnd = false;
  bool Finite = false; // whether all vertices of the last read are known to be finite
  std::optional<Error> Failure;
};

}
