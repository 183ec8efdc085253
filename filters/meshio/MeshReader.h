// SPDX-License-Identifier: BSD-3-Clause
// Chunked mesh readers: step "read" of the pipeline picture. They read PLY, STL, OBJ and OFF in
// pieces that fit any memory limit.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/meshio/Tolerance.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace kdstream
{

// What is known before the vertices and faces are read: from the header, or from a first pass over
// a text file. The counts are claims of the file: no memory is allocated because of them.
struct MeshFileInfo
{
  std::uint64_t vertices = 0;
  std::uint64_t faces = 0; // polygons and strips, before triangulation
  // The faces give at most this number of triangles. OBJ and STL files are counted in the first
  // pass; for other formats it is a bound from the file's size. A file with more is damaged
  // (PlyReader.h).
  std::uint64_t mostTriangles = 0;
  ScalarType scalarType = ScalarType::Float32;
  std::vector<AttributeInfo> attributes; // the arrays that are read: point arrays, then cell arrays
  // Whether each triangle has its own vertices (STL). They are then welded, whatever the options
  // say.
  bool soup = false;
  // Whether a face can be one or several strips.
  bool strips = false;
  // What is not read: properties ("face.texcoord"), elements ("edge"), textures ("texture a.png").
  std::vector<std::string> ignoredAttributes;
  // What has been dropped or forgiven so far.
  Tolerance tolerance{};
};

class MeshReader
{
public:
  virtual ~MeshReader() = default;

  // Chooses the reader by the file's extension. Text formats without a header are read once, to
  // count; the execution sees this pass as step "read". scratch: a folder for tables that a reader
  // may need (OBJ, polygons); if empty, the system's folder for temporary files. Errors: NotFound;
  // Unsupported for a known format that is not read, naming it; InvalidInput for a file of unknown
  // format; Cancelled; the errors of the readers.
  static Result<std::unique_ptr<MeshReader>> Open(const std::filesystem::path& file,
    const Execution& execution = {}, const std::filesystem::path& scratch = {});

  virtual const MeshFileInfo& Info() const = 0;

  // Reads at most `limit` further vertices of the file; returns how many were read, 0 at the end.
  // Finite vertices are appended to `mesh`, with a tuple of each point array; the others are
  // dropped and counted (Info().tolerance). Sets the scalar type, and the attributes if the mesh
  // has none. Vertices are read before triangles. REQUIRES: a mesh that is empty, or whose
  // attributes this reader has set. Errors: a truncated body, naming element and index.
  virtual Result<std::size_t> ReadVertices(Mesh& mesh, std::size_t limit) = 0;

  // Reads at most `limit` further faces; returns how many faces, 0 at the end. Appends their
  // triangles, and for each triangle the tuples of its face. Polygons are cut as core/CutPolygon.h
  // says, strips into triangles of alternating orientation.
  //
  // To cut a polygon, the positions of its corners are needed. If the mesh has all vertices of the
  // file, they are the mesh's points. Otherwise the file is read once more, and the positions go
  // into a table on disk: 24 bytes each, with 2 MiB in memory. Corners have the numbers of the
  // appended vertices.
  //
  // Faces of fewer than three corners, and faces with a dropped vertex, are dropped and counted.
  // Indices are checked. Errors: an index out of range, a truncated body, as above.
  virtual Result<std::size_t> ReadTriangles(Mesh& mesh, std::size_t limit) = 0;

  // The same, but stops after about `mostTriangles` triangles, because one polygon or strip may
  // give many. Reads at most `mostTriangles` faces.
  Result<std::size_t> ReadFaces(Mesh& mesh, std::size_t mostTriangles);

  // Reads the rest of the file, in chunks; a soup is welded. Progress is reported as step "read".
  // Memory: the mesh. Errors: as above; Cancelled.
  Status ReadRest(Mesh& mesh, const Execution& execution);

  // Skips at most `count` further vertices, or faces, as if they had been read; returns how many, 0
  // at the end. They are not read and not checked if the format gives their size: in binary STL,
  // and in binary PLY without lists or whose faces may all be triangles. Of such faces only the
  // assumed size is checked. In other files they are read and dropped. Errors: as above.
  virtual Result<std::uint64_t> SkipVertices(std::uint64_t count);
  virtual Result<std::uint64_t> SkipFaces(std::uint64_t count);
  // The same, but reads the skipped part, so that it is checked and points that are not finite are
  // known.
  Result<std::uint64_t> PassVertices(std::uint64_t count);
  Result<std::uint64_t> PassFaces(std::uint64_t count);

  // For the readers of single formats, which append points whether finite or not: whether all
  // points of the last ReadVertices are known to be finite.
  virtual bool KnowsFinite() const { return false; }
  // For the same readers: whether they count points that are not finite themselves; and where the
  // last face was read, as " (line 17)", or empty.
  virtual bool CountsNotFinite() const { return false; }
  virtual std::string LineOfFace() const { return {}; }

  // Bytes of the file, and how far into it the reader is: for progress.
  virtual std::uint64_t FileSize() const = 0;
  virtual std::uint64_t Position() const = 0;
};

}
