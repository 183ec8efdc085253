// SPDX-License-Identifier: BSD-3-Clause
// Chunked mesh readers: step "read" of the pipeline picture. A file goes through them in
// pieces that fit any memory limit: PLY, STL, OBJ and OFF.
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

// What the header says, or a first pass over a text, before anything is read. Counts are claims: no
// memory is allocated by them.
struct MeshFileInfo
{
  std::uint64_t vertices = 0;
  std::uint64_t faces = 0; // polygons and strips, before triangulation
  // More triangles do not come of the faces. Counted in the first pass over an OBJ or an STL,
  // else a bound by the file's size. A file with more is damaged (PlyReader.h).
  std::uint64_t mostTriangles = 0;
  ScalarType scalarType = ScalarType::Float32;
  std::vector<AttributeInfo> attributes; // the arrays that are read: point arrays, then cell arrays
  // Whether each triangle has vertices of its own (STL): they are welded whatever the options say.
  bool soup = false;
  // Whether a face can be a strip, or several.
  bool strips = false;
  // What is not read: properties ("face.texcoord"), elements ("edge"), pictures ("texture a.png").
  std::vector<std::string> ignoredAttributes;
  // What was dropped or forgiven so far, of what has been read.
  Tolerance tolerance{};
};

class MeshReader
{
public:
  virtual ~MeshReader() = default;

  // Chooses the reader by the file's name. Text formats without a header are read once to count;
  // this is reported to the execution as "read". scratch: a folder for tables that a reader may
  // need (OBJ, polygons); empty: the system's for temporary files. Errors: NotFound; Unsupported
  // for another format, naming it; InvalidInput for a file of no known format; Cancelled; those of
  // the readers.
  static Result<std::unique_ptr<MeshReader>> Open(const std::filesystem::path& file,
    const Execution& execution = {}, const std::filesystem::path& scratch = {});

  virtual const MeshFileInfo& Info() const = 0;

  // Reads at most `limit` further vertices of the file; returns how many, 0 at the end. Those that
  // are finite are appended to `mesh`, with a tuple of each point array; the others are dropped and
  // counted (Info().tolerance). Sets the scalar type, and the attributes if the mesh has none.
  // Vertices are read before triangles. REQUIRES: a mesh that is empty, or whose attributes come
  // from here. Errors: a truncated body, naming element and index.
  virtual Result<std::size_t> ReadVertices(Mesh& mesh, std::size_t limit) = 0;

  // Appends the triangles of at most `limit` further faces, and for each triangle the tuples of its
  // face; returns how many faces, 0 at the end. Polygons are cut as core/CutPolygon.h says, strips
  // into triangles of alternating orientation.
  //
  // To cut a polygon, its corners' positions are needed. They are the mesh's points, if it has all
  // vertices of the file. Else the file is read once more, and the positions are put into a table
  // on disk, 24 bytes each, with 2 MiB in memory. Corners have the numbers of the appended
  // vertices.
  //
  // Faces of fewer than three corners, and faces with a dropped vertex, are dropped and counted.
  // Indices are checked. Errors: an index out of range, a truncated body, as above.
  virtual Result<std::size_t> ReadTriangles(Mesh& mesh, std::size_t limit) = 0;

  // The same, but stops after about `mostTriangles` triangles, because a polygon or strip may give
  // many. At most as many faces.
  Result<std::size_t> ReadFaces(Mesh& mesh, std::size_t mostTriangles);

  // Reads the rest of the file, in chunks; a soup is welded. Progress is reported as step "read".
  // Memory: the mesh. Errors: as above; Cancelled.
  Status ReadRest(Mesh& mesh, const Execution& execution);

  // Skips at most `count` further vertices, or faces, as if they had been read; returns how many, 0
  // at the end. If the format gives their size (binary STL; binary PLY without lists, or whose
  // faces may all be triangles), they are not read and not checked; of faces only the assumed size
  // is checked. Else they are read and dropped. Errors: as above.
  virtual Result<std::uint64_t> SkipVertices(std::uint64_t count);
  virtual Result<std::uint64_t> SkipFaces(std::uint64_t count);
  // The same by reading: so that what lies between is checked and, where it is not finite, known.
  Result<std::uint64_t> PassVertices(std::uint64_t count);
  Result<std::uint64_t> PassFaces(std::uint64_t count);

  // For the readers of formats, which append points whether finite or not: whether all points of
  // the last ReadVertices are known to be finite.
  virtual bool KnowsFinite() const { return false; }
  // For these readers: whether they count points that are not finite; and the place of the last
  // face read, " (line 17)", or nothing.
  virtual bool CountsNotFinite() const { return false; }
  virtual std::string LineOfFace() const { return {}; }

  // Bytes of the file, and how far into it the reader is: for progress.
  virtual std::uint64_t FileSize() const = 0;
  virtual std::uint64_t Position() const = 0;
};

}
