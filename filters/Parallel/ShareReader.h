// SPDX-License-Identifier: BSD-3-Clause
// A rank's share of a mesh file: step "read" of a parallel build.
#pragma once

#include "filters/meshio/MeshReader.h"

#include <cstddef>
#include <cstdint>
#include <memory>

namespace kdstream
{

// Reads the share of rank r of R ranks, as if the file had nothing else: the vertices [r n / R, (r
// + 1) n / R), with n as the header claims, and the faces likewise. The last share extends to the
// end of the file. Corners of triangles have the file's numbers of vertices. The rest is skipped as
// the format allows (MeshReader::SkipVertices): by seeking, or by reading and dropping. Corners are
// numbered as if no vertex of another share were dropped. If some are dropped, everything must be
// read (`seek` false). Info().tolerance counts the problems of this share; in the first share also
// those found when the file was opened. Errors: those of the reader; InvalidInput if the file ends
// before the share.
class ShareReader : public MeshReader
{
public:
  // seek: whether the file's content before and between the parts of the share may be skipped
  // unread. REQUIRES: share < shares.
  ShareReader(
    std::unique_ptr<MeshReader> reader, std::size_t share, std::size_t shares, bool seek = true);

  const MeshFileInfo& Info() const override { return this->FileInfo; }
  Result<std::size_t> ReadVertices(Mesh& mesh, std::size_t limit) override;
  Result<std::size_t> ReadTriangles(Mesh& mesh, std::size_t limit) override;
  std::uint64_t FileSize() const override { return this->Reader->FileSize(); }
  std::uint64_t Position() const override { return this->Reader->Position(); }

private:
  using Skip = Result<std::uint64_t> (MeshReader::*)(std::uint64_t);
  using Read = Result<std::size_t> (MeshReader::*)(Mesh&, std::size_t);
  struct Span
  {
    std::uint64_t begin = 0, end = 0, at = 0;
  };

  Span SpanOf(std::uint64_t count) const;
  Status GoTo(Skip skip, Span& span, std::uint64_t to);
  Result<std::size_t> ReadShare(Read read, Span& span, Mesh& mesh, std::size_t limit);

  std::unique_ptr<MeshReader> Reader;
  MeshFileInfo FileInfo; // the reader's, with the tolerance of this share
  std::size_t Share, Shares;
  bool Seeks;
  Span Vertices, Faces;
  bool AtFaces = false;
};

}
