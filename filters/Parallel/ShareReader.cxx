// SPDX-License-Identifier: BSD-3-Clause
#include "filters/Parallel/ShareReader.h"

#include <algorithm>
#include <limits>

namespace kdstream
{
namespace
{

constexpr std::uint64_t toTheEnd = std::numeric_limits<std::uint64_t>::max();

}

ShareReader::ShareReader(
  std::unique_ptr<MeshReader> reader, std::size_t share, std::size_t shares, bool seek)
  : Reader(std::move(reader))
  , FileInfo(this->Reader->Info())
  , Share(share)
  , Shares(shares)
  , Seeks(seek)
  , Vertices(this->SpanOf(this->Reader->Info().vertices))
  , Faces(this->SpanOf(this->Reader->Info().faces))
{
  if (share > 0)
  {
    this->FileInfo.tolerance = {};
  }
}

ShareReader::Span ShareReader::SpanOf(std::uint64_t count) const
{
  // Does not overflow, whatever a header claims.
  const auto begin = [&](std::size_t share)
  { return count / this->Shares * share + count % this->Shares * share / this->Shares; };
  return { begin(this->Share), this->Share + 1 == this->Shares ? toTheEnd : begin(this->Share + 1),
    0 };
}

// Goes to element `to`, or to the end.
Status ShareReader::GoTo(Skip skip, Span& span, std::uint64_t to)
{
  // Calls `skip` even if nothing is to be skipped: when a reader seeks on other ranks, it assumes
  // something about this part, and checks it here.
  const Result<std::uint64_t> count = (*this->Reader.*skip)(to - std::min(to, span.at));
  KDSTREAM_TRY(count);
  span.at += *count;
  return {};
}

Result<std::size_t> ShareReader::ReadShare(Read read, Span& span, Mesh& mesh, std::size_t limit)
{
  const auto most = static_cast<std::size_t>(
    std::min<std::uint64_t>(limit, span.end - std::min(span.end, span.at)));
  if (most == 0)
  {
    return std::size_t{ 0 };
  }
  const Tolerance before = this->Reader->Info().tolerance;
  const Result<std::size_t> count = (*this->Reader.*read)(mesh, most);
  span.at += count ? *count : 0;
  this->FileInfo.tolerance.Add(this->Reader->Info().tolerance.Since(before));
  this->FileInfo.ignoredAttributes = this->Reader->Info().ignoredAttributes;
  return count;
}

Result<std::size_t> ShareReader::ReadVertices(Mesh& mesh, std::size_t limit)
{
  const Skip vertices = this->Seeks ? &MeshReader::SkipVertices : &MeshReader::PassVertices;
  if (this->Vertices.at < this->Vertices.begin)
  {
    KDSTREAM_TRY(this->GoTo(vertices, this->Vertices, this->Vertices.begin));
  }
  return this->ReadShare(&MeshReader::ReadVertices, this->Vertices, mesh, limit);
}

Result<std::size_t> ShareReader::ReadTriangles(Mesh& mesh, std::size_t limit)
{
  const Skip vertices = this->Seeks ? &MeshReader::SkipVertices : &MeshReader::PassVertices;
  if (!this->AtFaces)
  {
    this->AtFaces = true;
    KDSTREAM_TRY(this->GoTo(vertices, this->Vertices, toTheEnd));
    KDSTREAM_TRY(this->GoTo(this->Seeks ? &MeshReader::SkipFaces : &MeshReader::PassFaces,
      this->Faces, this->Faces.begin));
  }
  return this->ReadShare(&MeshReader::ReadTriangles, this->Faces, mesh, limit);
}

}
