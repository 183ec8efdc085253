// SPDX-License-Identifier: BSD-3-Clause
// Gives any bytes to a reader, for its fuzzer and its mutation test, and checks the promises on
// which every caller relies.
#pragma once

#include "filters/meshio/ByteSource.h"
#include "filters/meshio/FiniteReader.h"
#include "filters/meshio/MeshReader.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include <sys/mman.h>
#include <unistd.h>

namespace kdstream::test
{

inline void Require(bool holds, const char* what)
{
  if (!holds)
  {
    std::fprintf(stderr, "broken promise: %s\n", what);
    std::abort();
  }
}

// A file in memory that holds the bytes; it exists as long as the object.
class MemoryFile
{
public:
  explicit MemoryFile(std::string_view bytes)
    : Descriptor(memfd_create("hostile", MFD_CLOEXEC))
  {
    Require(this->Descriptor >= 0, "memfd_create");
    Require(
      write(this->Descriptor, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()),
      "write");
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { close(this->Descriptor); }

  std::string Name() const { return "/proc/self/fd/" + std::to_string(this->Descriptor); }

private:
  int Descriptor;
};

using OpenReader = Result<std::unique_ptr<MeshReader>> (*)(ByteSource source);

// Reads everything, `limit` records at a time. Returns true if it is a mesh; aborts if the reader
// breaks a promise.
inline bool ReadHostile(OpenReader open, const MemoryFile& file, std::size_t limit)
{
  Result<ByteSource> source = ByteSource::Open(file.Name());
  Require(source.HasValue(), "the file can be opened");
  Result<std::unique_ptr<MeshReader>> opened = open(std::move(*source));
  if (!opened)
  {
    Require(!opened.GetError().message.empty(), "an error has a message");
    return false;
  }
  const std::unique_ptr<MeshReader> finite = WithFinitePoints(std::move(*opened), "hostile");
  MeshReader& reader = *finite;
  Mesh mesh;
  std::uint64_t points = 0, faces = 0;
  for (const bool vertices : { true, false })
  {
    for (std::size_t read = 1; read > 0;)
    {
      const Result<std::size_t> result =
        vertices ? reader.ReadVertices(mesh, limit) : reader.ReadTriangles(mesh, limit);
      Require(reader.Position() <= reader.FileSize(), "the position lies in the file");
      if (!result)
      {
        Require(!result.GetError().message.empty(), "an error has a message");
        return false;
      }
      Require(*result <= limit, "no more than asked for");
      read = *result;
      (vertices ? points : faces) += read;
    }
  }
  Require(points == reader.Info().vertices, "all vertices come");
  const std::uint64_t dropped = reader.Info().tolerance.Of(Lapse::PointNotFinite);
  Require(
    points - mesh.points.size() >= dropped && (points == mesh.points.size()) == (dropped == 0),
    "dropped vertices are counted");
  Require(faces == reader.Info().faces, "all faces come");
  for (const Vec3& point : mesh.points)
  {
    Require(std::isfinite(point[0]) && std::isfinite(point[1]) && std::isfinite(point[2]),
      "coordinates are finite");
  }
  for (const Triangle& triangle : mesh.triangles)
  {
    Require(triangle[0] < mesh.points.size() && triangle[1] < mesh.points.size() &&
              triangle[2] < mesh.points.size(),
      "indices are in range");
  }
  const Status checked =
    CheckAttributes(mesh.attributes, mesh.points.size(), mesh.triangles.size());
  Require(checked.HasValue(), "attributes have a tuple for each point or triangle");
  for (std::size_t k = 0; k < reader.Info().attributes.size(); ++k)
  {
    const AttributeInfo& info = reader.Info().attributes[k];
    Require(mesh.attributes.at(k).Info() == info, "attributes are those of the header");
    Require(IsAttributeName(info.name), "attributes have names that are texts");
  }
  Require(mesh.attributes.size() == reader.Info().attributes.size(), "all attributes come");
  return true;
}

// A libFuzzer target: reading all records in one call must give the same as many small calls.
inline void ReadHostileBothWays(OpenReader open, const std::uint8_t* data, std::size_t size)
{
  const MemoryFile file(std::string_view(reinterpret_cast<const char*>(data), size));
  const bool whole = ReadHostile(open, file, static_cast<std::size_t>(-1));
  const bool parts = ReadHostile(open, file, 3);
  Require(whole == parts, "the limit makes no difference");
}

}
