// SPDX-License-Identifier: BSD-3-Clause
// Bytes and speed of pieces of the original: our codec and, for only positions and triangles, its
// peers at the same grid step: the plain layout compressed by zstd -19, meshoptimizer, and Draco at
// speeds 0 and 5. Then the bytes of the levels (whole pieces), compared with Draco's for the same
// triangles on the level's own grid. Usage:
//   BenchCodec [--bits N] [--blobs FOLDER] MESH.ply …
// Every partition is coded separately, by all coders in one run on one thread. "Positions and
// triangles" are those of the whole piece, including ghosts, as a mesh. The bytes that ghosts,
// clusters and ids add are printed beside them. With --blobs, the blobs are kept for
// BenchCodecSpeed as FOLDER/MESH.blobs. Exit code 1 if a limit is missed.
#include "Testing/Benchmarks/CodecBlobs.h"
#include "Testing/Benchmarks/CodecPeers.h"
#include "filters/codec/ByteStream.h"
#include "filters/codec/PieceCodec.h"
#include "filters/core/Weld.h"
#include "filters/core/levels/GeometricErrorBins.h"
#include "filters/core/levels/Levels.h"
#include "filters/core/pieces/LeafOrder.h"
#include "filters/core/pieces/VertexTree.h"
#include "filters/meshio/MeshReader.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <iostream>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace
{

using namespace kdstream;
using namespace kdstream::bench;

using Bytes = std::vector<std::uint8_t>;

constexpr int zstdLevel = 19;
constexpr std::size_t mostPieces = 512; // of a mesh; if it has more, evenly spread ones

template <class T>
T Need(Result<T> result)
{
  if (!result)
  {
    std::cerr << "BenchCodec: error: " << result.GetError().message << "\n";
    std::exit(1);
  }
  return std::move(*result);
}

Mesh ReadWelded(const std::filesystem::path& file)
{
  const auto reader = Need(MeshReader::Open(file));
  Mesh mesh;
  constexpr std::size_t all = std::numeric_limits<std::size_t>::max();
  while (Need(reader->ReadVertices(mesh, all)) > 0)
  {
  }
  while (Need(reader->ReadTriangles(mesh, all)) > 0)
  {
  }
  mesh.attributes.clear();
  WeldVertices(mesh);
  return mesh;
}

struct Pieces
{
  TreeDepths depths;
  Box box;
  ScalarType scalarType = ScalarType::Float32;
  std::vector<Piece> pieces;
  // Number of all pieces; `pieces` are evenly spread.
  std::size_t all = 0;
  std::vector<std::vector<Piece>> levels;          // all pieces of each level
  std::vector<GeometricErrorBins> geometricErrors; // of each level
};

// Makes the partitions and levels of a mesh, with about 1,800 vertices in each piece, numbered as
// in a store.
Pieces Cut(const Mesh& mesh)
{
  const KdTree tree = Need(BuildKdTree(mesh.points, {}));
  const std::vector<std::uint32_t> partition = CellOfVertex(tree, tree.depths.partition);
  const TriangleBuckets buckets = BucketTriangles(mesh.triangles,
    std::size_t{ 1 } << tree.depths.partition, [&](VertexId v) { return partition[v]; });
  VertexTree numbered =
    NumberVertices(tree, Need(BuildLevels(mesh, tree, buckets, LevelOptions{})));
  OrderLeaves(numbered, mesh.points);
  Pieces cut{ tree.depths, {}, mesh.scalarType, {}, 0, {}, {} };
  for (const Vec3& point : mesh.points)
  {
    cut.box.Add(point);
  }
  const PieceCutter cutter(numbered, mesh, Resolution::Original());
  cut.all = cutter.PieceCount();
  const std::size_t every = (cutter.PieceCount() + mostPieces - 1) / mostPieces;
  for (std::size_t i = 0; i < cutter.PieceCount(); i += every)
  {
    cut.pieces.push_back(cutter.Cut(i));
  }
  for (unsigned depth = 0; depth < numbered.levels.size(); ++depth)
  {
    const PieceCutter ofLevel(numbered, mesh, Resolution::Level(depth));
    std::vector<Piece>& pieces = cut.levels.emplace_back();
    for (std::size_t i = 0; i < ofLevel.PieceCount(); ++i)
    {
      pieces.push_back(ofLevel.Cut(i));
    }
    GeometricErrorBins& bins = cut.geometricErrors.emplace_back();
    for (const double geometricError : numbered.levels[depth].geometricErrors)
    {
      bins.Add(geometricError);
    }
  }
  return cut;
}

GridMesh OnGrid(const Piece& piece, const CoordinateGrid& grid)
{
  GridMesh mesh{ {}, piece.triangles };
  for (const Vec3& position : piece.positions)
  {
    mesh.points.push_back(grid.Quantize(position));
  }
  return mesh;
}

// Positions and triangles in the layout of the plain codec: differences, as byte planes.
Bytes Plain(const GridMesh& mesh)
{
  ByteWriter writer;
  std::vector<std::uint64_t> values;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    values.clear();
    for (const auto& point : mesh.points)
    {
      values.push_back(point[axis]);
    }
    writer.Stream(values, 1);
  }
  for (std::size_t corner = 0; corner < 3; ++corner)
  {
    values.clear();
    for (const Triangle& triangle : mesh.triangles)
    {
      values.push_back(triangle[corner]);
    }
    writer.Stream(values);
  }
  return writer.Take();
}

// Positions as floats or doubles, and triangles as 32-bit indices, as in memory.
Bytes RawArrays(const Piece& piece, ScalarType type)
{
  Bytes raw;
  const auto append = [&raw](const auto& value)
  {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(&value);
    raw.insert(raw.end(), bytes, bytes + sizeof(value));
  };
  for (const Vec3& position : piece.positions)
  {
    for (const double value : position)
    {
      type == ScalarType::Float32 ? append(static_cast<float>(value)) : append(value);
    }
  }
  for (const Triangle& triangle : piece.triangles)
  {
    append(triangle);
  }
  return raw;
}

// parts: the sizes of the blob's parts are added to these.
Coded CodeByUs(const Piece& piece, const CodecContext& context, EncodedBytes* parts = nullptr)
{
  Coded coded;
  const auto seconds = [start = std::chrono::steady_clock::now()]
  { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
  const Bytes blob = EncodePiece(piece, context);
  coded.encodeSeconds = seconds();
  if (parts)
  {
    EncodedBytes spent;
    (void)EncodePiece(piece, context, &spent);
    parts->all += spent.all;
    parts->triangles += spent.triangles;
    parts->positions += spent.positions;
    parts->numbers += spent.numbers;
    parts->ownKeys += spent.ownKeys;
    parts->ghostKeys += spent.ghostKeys;
    parts->ancestors += spent.ancestors;
  }
  const auto decodeStart = std::chrono::steady_clock::now();
  const Piece decoded = Need(DecodePiece(blob, piece.id, context));
  coded.decodeSeconds =
    std::chrono::duration<double>(std::chrono::steady_clock::now() - decodeStart).count();
  coded.bytes = blob.size();
  coded.vertices = decoded.VertexCount();
  coded.triangles = decoded.triangles.size();
  return coded;
}

// The result of one coder for all pieces of a mesh.
struct Row
{
  std::string name;
  std::size_t bytes = 0, lostTriangles = 0;
  double encodeSeconds = 0, decodeSeconds = 0;

  void Add(const Coded& coded, std::size_t triangles)
  {
    this->bytes += coded.bytes;
    this->lostTriangles += triangles - coded.triangles;
    this->encodeSeconds += coded.encodeSeconds;
    this->decodeSeconds += coded.decodeSeconds;
  }
};

struct Sums
{
  std::size_t pieces = 0, vertices = 0, own = 0, triangles = 0;
};

void Print(const Row& row, const Sums& sums)
{
  const double bits = 8.0 * double(row.bytes);
  std::printf("%-34s %11zu %10.0f %8.2f %8.2f", row.name.c_str(), row.bytes,
    double(row.bytes) / double(sums.pieces), bits / double(sums.vertices),
    bits / double(sums.triangles));
  if (row.encodeSeconds > 0)
  {
    std::printf(" %9.1f %9.1f", double(sums.triangles) / row.encodeSeconds * 1e-6,
      double(sums.triangles) / row.decodeSeconds * 1e-6);
  }
  std::printf(row.lostTriangles == 0 ? "\n" : "  (drops %zu triangles)\n", row.lostTriangles);
}

// Prints a limit, and whether it is met. Returns whether it is.
bool Bar(const char* what, double value, double most)
{
  std::printf(
    "  %-58s %.3f (at most %.2f)%s\n", what, value, most, value <= most ? "" : "  MISSED");
  return value <= most;
}

// Writes every piece of the mesh in the form that BenchCodecSpeed reads.
void KeepBlobs(const std::filesystem::path& file, const Pieces& cut, std::uint8_t bits)
{
  BlobFile blobs{ { cut.depths, CoordinateGrid::Over(cut.box, bits, cut.scalarType), {} }, {} };
  for (const Piece& piece : cut.pieces)
  {
    blobs.blobs.push_back({ piece.id, EncodePiece(piece, blobs.context) });
  }
  if (!WriteBlobFile(file.c_str(), blobs))
  {
    std::cerr << "BenchCodec: error: cannot write " << file.string() << "\n";
    std::exit(1);
  }
}

// Compares the bytes of each level from `first` on with Draco's. Coarser levels are hardly ever
// fetched.
bool MeasureLevels(const Pieces& cut, std::uint8_t bits)
{
  constexpr unsigned first = 9;
  CodecContext context{ cut.depths, CoordinateGrid::Over(cut.box, bits, cut.scalarType), {} };
  for (const GeometricErrorBins& geometricErrors : cut.geometricErrors)
  {
    context.spacings.push_back(context.grid.SpacingFor(geometricErrors.Most99()));
  }
  std::printf("\nlevel  vertices     bits    bytes  positions  triangles  numbers  own keys  "
              "ghosts' keys  ancestors  Draco 5  ratio\n");
  double ours = 0, dracos = 0, largest = 0;
  for (unsigned depth = std::min(first, cut.depths.finest); depth < cut.levels.size(); ++depth)
  {
    const CoordinateGrid grid = context.GridOf(Resolution::Level(depth));
    EncodedBytes parts;
    std::size_t draco = 0, vertices = 0;
    for (const Piece& piece : cut.levels[depth])
    {
      (void)CodeByUs(piece, context, &parts);
      draco += CodeByDraco(OnGrid(piece, grid), 5).bytes;
      vertices += piece.ownVertices;
    }
    const double ratio = parts.all / double(draco);
    std::printf("%5u %9zu %8.2f %8.0f %10.0f %10.0f %8.0f %9.0f %13.0f %10.0f %8zu %6.2f\n", depth,
      vertices, bits - std::log2(double(grid.spacing)), parts.all, parts.positions, parts.triangles,
      parts.numbers, parts.ownKeys, parts.ghostKeys, parts.ancestors, draco, ratio);
    ours += parts.all;
    dracos += double(draco);
    largest = std::max(largest, ratio);
  }
  bool met = Bar("levels, whole, to Draco, speed 5", ours / dracos, 1.6);
  return Bar("the largest of a level", largest, 1.6) && met;
}

// Returns whether all limits are met.
bool Measure(const std::string& name, const Pieces& cut, std::uint8_t bits)
{
  const CodecContext grid{ cut.depths, CoordinateGrid::Over(cut.box, bits, cut.scalarType), {} };
  const CodecContext lossless{ cut.depths, CoordinateGrid::Exact(cut.scalarType), {} };
  Row whole{ "ours, whole pieces" }, plain{ "plain" }, plainZstd{ "plain + zstd -19" },
    meshoptimizer{ "meshoptimizer" }, draco0{ "Draco, speed 0" }, draco5{ "Draco, speed 5" },
    exact{ "ours, lossless, whole pieces" }, raw{ "raw arrays + zstd -19" };
  EncodedBytes parts;
  Sums sums;
  for (const Piece& piece : cut.pieces)
  {
    const GridMesh mesh = OnGrid(piece, grid.grid);
    const std::size_t triangles = mesh.triangles.size();
    ++sums.pieces;
    sums.vertices += mesh.points.size();
    sums.own += piece.ownVertices;
    sums.triangles += triangles;
    whole.Add(CodeByUs(piece, grid, &parts), triangles);
    const Bytes planes = Plain(mesh);
    plain.bytes += planes.size();
    plainZstd.bytes += CodeByZstd(planes, zstdLevel).bytes;
    meshoptimizer.Add(CodeByMeshoptimizer(mesh), triangles);
    draco0.Add(CodeByDraco(mesh, 0), triangles);
    draco5.Add(CodeByDraco(mesh, 5), triangles);
    exact.Add(CodeByUs(piece, lossless), triangles);
    raw.bytes += CodeByZstd(RawArrays(piece, cut.scalarType), zstdLevel).bytes;
  }
  std::printf(
    "\n%s: %zu of %zu pieces, mean %.0f own vertices, %.0f with ghosts, %.0f triangles; %u bits\n",
    name.c_str(), sums.pieces, cut.all, double(sums.own) / double(sums.pieces),
    double(sums.vertices) / double(sums.pieces), double(sums.triangles) / double(sums.pieces),
    unsigned{ bits });
  std::printf("%-34s %11s %10s %8s %8s %9s %9s\n", "", "bytes", "a piece", "b/vertex", "b/tri",
    "enc Mt/s", "dec Mt/s");
  const auto rowOf = [](const char* what, double bytes)
  {
    Row row{ what };
    row.bytes = static_cast<std::size_t>(bytes + 0.5);
    return row;
  };
  const Row alone = rowOf("ours, positions and triangles", parts.positions + parts.triangles);
  for (const Row& row :
    { whole, alone, rowOf("  positions", parts.positions), rowOf("  triangles", parts.triangles),
      rowOf("  numbers", parts.numbers), rowOf("  keys of ghosts", parts.ghostKeys),
      rowOf("  ancestors of ghosts", parts.ancestors), plain, plainZstd, meshoptimizer, draco0,
      draco5, exact, raw })
  {
    Print(row, sums);
  }
  const auto ratio = [](const Row& ours, const Row& theirs)
  { return double(ours.bytes) / double(theirs.bytes); };
  bool met = Bar("positions and triangles to Draco, speed 5", ratio(alone, draco5), 1.0);
  met = Bar("positions and triangles to plain + zstd -19", ratio(alone, plainZstd), 0.75) && met;
  met = Bar("what ghosts, clusters and ids add", ratio(whole, alone) - 1, 0.35) && met;
  met = Bar("lossless, whole, to raw arrays + zstd -19", ratio(exact, raw), 0.8) && met;
  return MeasureLevels(cut, bits) && met;
}

}

int main(int argc, char** argv)
{
  unsigned bits = 20;
  std::vector<std::filesystem::path> meshes;
  std::filesystem::path blobs;
  for (int i = 1; i < argc; ++i)
  {
    if (std::string_view(argv[i]) == "--bits" && i + 1 < argc)
    {
      bits = static_cast<unsigned>(std::atoi(argv[++i]));
    }
    else if (std::string_view(argv[i]) == "--blobs" && i + 1 < argc)
    {
      blobs = argv[++i];
    }
    else
    {
      meshes.emplace_back(argv[i]);
    }
  }
  if (meshes.empty() || bits < 8 || bits > 24)
  {
    std::cerr << "usage: BenchCodec [--bits N] [--blobs FOLDER] MESH.ply …\n";
    return 2;
  }
  bool met = true;
  for (const std::filesystem::path& mesh : meshes)
  {
    const Pieces cut = Cut(ReadWelded(mesh));
    if (!blobs.empty())
    {
      KeepBlobs(blobs / mesh.stem().concat(".blobs"), cut, static_cast<std::uint8_t>(bits));
    }
    met = Measure(mesh.stem().string(), cut, static_cast<std::uint8_t>(bits)) && met;
  }
  return met ? 0 : 1;
}
