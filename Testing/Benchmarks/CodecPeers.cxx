// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Benchmarks/CodecPeers.h"

#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>
#include <meshoptimizer.h>
#include <zstd.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <memory>

namespace kdstream::bench
{
namespace
{

class StopWatch
{
public:
  double Seconds() const
  {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - this->Start).count();
  }

private:
  std::chrono::steady_clock::time_point Start = std::chrono::steady_clock::now();
};

void Require(bool holds, const char* what)
{
  if (!holds)
  {
    std::cerr << "BenchCodec: error: " << what << "\n";
    std::exit(1);
  }
}

std::unique_ptr<draco::Mesh> DracoMesh(const GridMesh& mesh)
{
  auto made = std::make_unique<draco::Mesh>();
  made->set_num_points(static_cast<std::uint32_t>(mesh.points.size()));
  draco::GeometryAttribute description;
  description.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_INT32, false,
    3 * sizeof(std::int32_t), 0);
  const int id =
    made->AddAttribute(description, true, static_cast<std::uint32_t>(mesh.points.size()));
  for (std::uint32_t v = 0; v < mesh.points.size(); ++v)
  {
    const std::array<std::int32_t, 3> point{ static_cast<std::int32_t>(mesh.points[v][0]),
      static_cast<std::int32_t>(mesh.points[v][1]), static_cast<std::int32_t>(mesh.points[v][2]) };
    made->attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v), point.data());
  }
  for (const Triangle& t : mesh.triangles)
  {
    made->AddFace({ draco::PointIndex(t[0]), draco::PointIndex(t[1]), draco::PointIndex(t[2]) });
  }
  return made;
}

}

Coded CodeByDraco(const GridMesh& mesh, int speed)
{
  Coded coded;
  const auto made = DracoMesh(mesh);
  draco::EncoderBuffer buffer;
  {
    const StopWatch watch;
    draco::ExpertEncoder encoder(*made);
    encoder.SetSpeedOptions(speed, speed);
    encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
    Require(encoder.EncodeToBuffer(&buffer).ok(), "Draco does not encode");
    coded.encodeSeconds = watch.Seconds();
  }
  coded.bytes = buffer.size();
  const StopWatch watch;
  draco::DecoderBuffer input;
  input.Init(buffer.data(), buffer.size());
  draco::Decoder decoder;
  const auto decoded = decoder.DecodeMeshFromBuffer(&input);
  coded.decodeSeconds = watch.Seconds();
  Require(decoded.ok(), "Draco does not decode");
  coded.vertices = decoded.value()->num_points();
  coded.triangles = decoded.value()->num_faces();
  return coded;
}

Coded CodeByMeshoptimizer(const GridMesh& mesh)
{
  using Point = std::array<std::uint32_t, 3>;
  Coded coded{ 0, 0, 0, mesh.points.size(), mesh.triangles.size() };
  std::vector<unsigned> indices;
  for (const Triangle& t : mesh.triangles)
  {
    indices.insert(indices.end(), t.begin(), t.end());
  }
  std::vector<Point> points(mesh.points.size());
  std::vector<unsigned char> indexBytes, pointBytes;
  {
    const StopWatch watch;
    meshopt_optimizeVertexCacheStrip(indices.data(), indices.data(), indices.size(), points.size());
    const std::size_t used = meshopt_optimizeVertexFetch(points.data(), indices.data(),
      indices.size(), mesh.points.data(), mesh.points.size(), sizeof(Point));
    points.resize(used);
    indexBytes.resize(meshopt_encodeIndexBufferBound(indices.size(), points.size()));
    indexBytes.resize(meshopt_encodeIndexBuffer(
      indexBytes.data(), indexBytes.size(), indices.data(), indices.size()));
    pointBytes.resize(meshopt_encodeVertexBufferBound(points.size(), sizeof(Point)));
    pointBytes.resize(meshopt_encodeVertexBuffer(
      pointBytes.data(), pointBytes.size(), points.data(), points.size(), sizeof(Point)));
    coded.encodeSeconds = watch.Seconds();
  }
  coded.bytes = indexBytes.size() + pointBytes.size();
  const StopWatch watch;
  Require(meshopt_decodeIndexBuffer(
            indices.data(), indices.size(), indexBytes.data(), indexBytes.size()) == 0 &&
            meshopt_decodeVertexBuffer(points.data(), points.size(), sizeof(Point),
              pointBytes.data(), pointBytes.size()) == 0,
    "meshoptimizer does not decode");
  coded.decodeSeconds = watch.Seconds();
  return coded;
}

Coded CodeByZstd(std::span<const std::uint8_t> bytes, int level)
{
  Coded coded;
  std::vector<std::uint8_t> packed(ZSTD_compressBound(bytes.size())), back(bytes.size());
  {
    const StopWatch watch;
    coded.bytes = ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), level);
    coded.encodeSeconds = watch.Seconds();
  }
  Require(!ZSTD_isError(coded.bytes), "zstd does not encode");
  const StopWatch watch;
  Require(ZSTD_decompress(back.data(), back.size(), packed.data(), coded.bytes) == bytes.size(),
    "zstd does not decode");
  coded.decodeSeconds = watch.Seconds();
  return coded;
}

}
