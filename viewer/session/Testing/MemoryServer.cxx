// SPDX-License-Identifier: BSD-3-Clause
// A server in memory for tests: see MemoryServer.h.
#include "viewer/session/Testing/MemoryServer.h"

#include "filters/codec/PartitionBoxes.h"
#include "filters/core/levels/ClusterLevels.h"
#include "filters/core/levels/LevelAttributes.h"
#include "filters/core/pieces/VertexTree.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace kdstream::testing
{

Mesh MakeTorus(std::uint32_t n, std::uint32_t m)
{
  Mesh mesh;
  for (std::uint32_t i = 0; i < n; ++i)
  {
    for (std::uint32_t j = 0; j < m; ++j)
    {
      const double u = 2 * M_PI * i / n, v = 2 * M_PI * j / m;
      const double r = 0.35 + 0.02 * std::sin(9 * u) * std::sin(7 * v);
      mesh.points.push_back({ (1 + r * std::cos(v)) * std::cos(u),
        (1 + r * std::cos(v)) * std::sin(u), r * std::sin(v) });
      const auto at = [n, m](std::uint32_t a, std::uint32_t b) { return (a % n) * m + b % m; };
      mesh.triangles.push_back({ at(i, j), at(i + 1, j), at(i + 1, j + 1) });
      mesh.triangles.push_back({ at(i, j), at(i + 1, j + 1), at(i, j + 1) });
    }
  }
  return mesh;
}

void AddVertexColors(Mesh& mesh)
{
  Attribute colors{ { "RGB", AttributeType::UInt8, AttributeAssociation::Point, 3 }, {} };
  Attribute normals{ { "Normals", AttributeType::Float32, AttributeAssociation::Point, 3 }, {} };
  colors.values.resize(mesh.points.size() * colors.TupleSize());
  normals.values.resize(mesh.points.size() * normals.TupleSize());
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
  {
    const Vec3& p = mesh.points[i];
    const double onRing = std::hypot(p[0], p[1]);
    const bool stripe = std::lround(std::floor(6 * std::atan2(p[1], p[0]))) % 2 == 0;
    colors.Set(i, 0, stripe ? 200 : 40);
    colors.Set(i, 1, 120 + 250 * p[2]);
    colors.Set(i, 2, 255 * (onRing - 0.6) / 0.8);
    const Vec3 outward{ p[0] - p[0] / onRing, p[1] - p[1] / onRing, p[2] };
    for (std::size_t k = 0; k < 3; ++k)
    {
      normals.Set(i, k, outward[k] / 0.35);
    }
  }
  mesh.attributes = { std::move(colors), std::move(normals) };
}

std::size_t CountBoundaryEdges(const std::vector<Triangle>& triangles)
{
  std::vector<std::pair<VertexId, VertexId>> edges;
  for (const Triangle& t : triangles)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      edges.push_back(std::minmax(t[k], t[(k + 1) % 3]));
    }
  }
  std::sort(edges.begin(), edges.end());
  std::size_t count = 0;
  for (std::size_t i = 0, end = 0; i < edges.size(); i = end)
  {
    while (end < edges.size() && edges[end] == edges[i])
    {
      ++end;
    }
    count += end - i == 1 ? 1 : 0;
  }
  return count;
}

MemoryServer::MemoryServer(
  const Mesh& mesh, std::uint32_t verticesPerPartition, std::uint32_t cellVertices)
{
  KdTreeOptions options;
  options.verticesPerPartition = verticesPerPartition;
  options.cellVertices = cellVertices;
  const KdTree tree = std::move(*BuildKdTree(mesh.points, options));
  const auto partitionOf = CellOfVertex(tree, tree.depths.partition);
  const auto buckets = BucketTriangles(std::span<const Triangle>(mesh.triangles),
    std::size_t{ 1 } << tree.depths.partition,
    [&partitionOf](VertexId v) { return partitionOf[v]; });
  ClusterLevels levels =
    std::move(*BuildClusterLevels(mesh.points, mesh.triangles, tree, buckets, {}));
  AddLevelAttributes(mesh, levels);
  const VertexTree vertices = NumberVertices(tree, std::move(levels));

  this->Boxes = tree.boxes;
  this->Context = { tree.depths, CoordinateGrid::Over(tree.boxes[1], 20, ScalarType::Float32), {} };
  this->Model.id = "torus";
  this->Model.digest = std::string(32, 'a');
  this->Model.vertices = mesh.points.size();
  this->Model.triangles = mesh.triangles.size();
  this->Model.partitions = std::uint64_t{ 1 } << tree.depths.partition;
  this->Model.box = tree.boxes[1];
  this->Model.depths = tree.depths;
  this->Model.grid = this->Context.grid;
  for (const Attribute& array : mesh.attributes)
  {
    this->Model.attributes.push_back(array.Info());
  }

  PieceTable pieces(tree.depths, true);
  for (unsigned d = 0; d <= tree.depths.finest + 1; ++d)
  {
    const bool level = d <= tree.depths.finest;
    const Resolution resolution = level ? Resolution::Level(d) : Resolution::Original();
    const PieceCutter cutter(vertices, mesh, resolution);
    ResolutionDescription counts{ cutter.VertexCount(), cutter.TriangleCount(), cutter.PieceCount(),
      0, 0, 0, 1 };
    std::vector<float> geometricErrors;
    for (std::size_t i = 0; i < cutter.PieceCount(); ++i)
    {
      const Piece piece = cutter.Cut(i);
      geometricErrors.insert(
        geometricErrors.end(), piece.geometricErrors.begin(), piece.geometricErrors.end());
      if (level && !piece.geometricErrors.empty())
      {
        std::vector<float> own = piece.geometricErrors;
        std::sort(own.begin(), own.end());
        pieces.At(piece.id).most99 = own[(own.size() - 1) * 99 / 100];
        pieces.At(piece.id).most = own.back();
      }
      auto& blob = this->Blobs[BlobOfPiece(piece.id, tree.depths)];
      blob = EncodePiece(piece, this->Context);
      pieces.At(piece.id).bytes = static_cast<std::uint32_t>(blob.size());
    }
    if (level)
    {
      std::sort(geometricErrors.begin(), geometricErrors.end());
      counts.geometricError = geometricErrors.back();
      counts.geometricError99 = geometricErrors[(geometricErrors.size() - 1) * 99 / 100];
      this->Model.levels.push_back(counts);
    }
    else
    {
      this->Model.original = counts;
    }
  }
  for (const NodeId node : AllPartitionBoxes(tree.depths))
  {
    this->Blobs[protocol::BlobId::PartitionBoxes(node)] =
      EncodePartitionBoxes(tree.boxes, node, tree.depths);
  }
  this->TellOfPieces(pieces);
}

void MemoryServer::TellOfPieces(const PieceTable& pieces)
{
  for (const NodeId page : TreePages(this->Model.depths))
  {
    this->Blobs[protocol::BlobId::TreePage(page)] =
      EncodeTreePage(RoundTreePage(this->Boxes, page, this->Model.depths, pieces));
  }
  this->Reported = pieces;
}

TileCoordinate TilePlaceOf(const Vec3& point)
{
  const auto at = [](double x)
  { return static_cast<float>(std::nearbyint((x + 2) * 20 * tileSteps) / tileSteps); };
  return { at(point[0]), at(point[1] + 0.1 * point[2]) };
}

void MemoryServer::AddTiles(std::uint32_t side)
{
  this->Model.textures = TextureDescription{ "png", false, 0, 0 };
  for (std::uint32_t p = 0; p < this->Model.partitions; ++p)
  {
    this->Model.textures->bytes +=
      this->AddTile({ Resolution::Original(), NodeOfPartition(p, this->Model.depths) }, side);
    this->Model.textures->texels += std::uint64_t{ side } * side;
  }
}

void MemoryServer::AddTilesOfLevels(std::uint32_t side)
{
  this->Model.textures->levels = true;
  for (unsigned depth = 0; depth < this->Model.levels.size(); ++depth)
  {
    const Resolution level = Resolution::Level(depth);
    const NodeId first = NodeId{ 1 } << PieceDepth(level, this->Model.depths);
    for (NodeId node = first; node < 2 * first; ++node)
    {
      this->Model.levels[depth].tileBytes += this->AddTile({ level, node }, side);
      this->Model.levels[depth].texels += std::uint64_t{ side } * side;
    }
  }
}

std::size_t MemoryServer::AddTile(PieceId id, std::uint32_t side)
{
  const TreeDepths& depths = this->Model.depths;
  const Piece piece = *DecodePiece(this->Blob(BlobOfPiece(id, depths)), id, this->Context);
  TextureTile tile{ side, side, TileImage::Png, { 1, 2, 3 }, {} };
  for (const Triangle& t : piece.triangles)
  {
    tile.corners.push_back({ TilePlaceOf(piece.positions[t[0]]), TilePlaceOf(piece.positions[t[1]]),
      TilePlaceOf(piece.positions[t[2]]) });
  }
  auto& blob = this->Blobs[TextureOfPiece(id, depths)];
  blob = EncodeTextureTile(tile, piece.triangles);
  return blob.size();
}

void MemoryServer::Take(ViewerSession& session)
{
  for (const SessionRequest& request : session.TakeRequests())
  {
    this->log.push_back(FormatRequest(request));
    if (request.kind == SessionRequest::Kind::Cancel)
    {
      std::erase_if(this->Queue, [&request](const Pending& p) { return p.request == request.id; });
    }
    if (request.kind == SessionRequest::Kind::Open)
    {
      this->Queue.push_back({ request.id, true, request.model, {} });
    }
    for (const protocol::BlobId& blob : request.blobs)
    {
      this->Queue.push_back({ request.id, false, {}, blob });
    }
  }
}

std::vector<protocol::BlobId> MemoryServer::Outstanding() const
{
  std::vector<protocol::BlobId> blobs;
  for (const Pending& pending : this->Queue)
  {
    if (!pending.open)
    {
      blobs.push_back(pending.blob);
    }
  }
  return blobs;
}

std::vector<protocol::BlobId> MemoryServer::AllBlobs() const
{
  std::vector<protocol::BlobId> all;
  for (const auto& [blob, bytes] : this->Blobs)
  {
    all.push_back(blob);
  }
  return all;
}

bool MemoryServer::Answer(ViewerSession& session, std::mt19937* random)
{
  this->Take(session);
  if (this->Queue.empty())
  {
    return false;
  }
  const std::size_t i = random ? (*random)() % this->Queue.size() : 0;
  const Pending next = this->Queue[i];
  this->Queue.erase(this->Queue.begin() + static_cast<std::ptrdiff_t>(i));
  if (next.open && next.model == this->Model.id)
  {
    session.Opened(next.request, this->Model);
  }
  else if (next.open)
  {
    session.RequestFailed(next.request, "no such model");
  }
  else if (this->refused.count(next.blob) != 0 || !this->Has(next.blob))
  {
    session.BlobFailed(next.request, next.blob, "it is damaged");
  }
  else
  {
    std::vector<std::uint8_t> bytes = this->Blobs.at(next.blob);
    if (this->lie && !this->lie(next.blob, bytes))
    {
      session.BlobFailed(next.request, next.blob, "it is damaged");
      return true;
    }
    this->sent.insert(next.blob);
    session.BlobArrived(next.request, next.blob, bytes, 0.25, false);
  }
  this->Take(session);
  return true;
}

void MemoryServer::Serve(
  ViewerSession& session, std::mt19937* random, const std::function<void()>& eachFrame)
{
  do
  {
    session.BeginFrame();
    eachFrame();
    session.EndFrame(0.5);
  } while (this->Answer(session, random));
}

}
