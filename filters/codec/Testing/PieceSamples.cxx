// SPDX-License-Identifier: BSD-3-Clause
// PieceSamples FILE writes pieces, textures, tree pages and boxes, as blobs and as their content,
// one JSON object a line. They are compared with the results of the decoder in JavaScript
// (Testing/Decoder). PieceSamples --seeds FOLDER writes the seeds from which FuzzCodec starts; run
// it again for each codec version.
#include "Testing/Fixtures/Meshes.h"
#include "Testing/Fixtures/Model.h"
#include "filters/codec/PartitionBoxes.h"
#include "filters/codec/PieceCodec.h"
#include "filters/codec/Testing/RandomPiece.h"
#include "filters/codec/Testing/RandomTile.h"
#include "filters/codec/TreePage.h"
#include "filters/core/BitCast.h"

#include <array>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string_view>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

std::string Hex(std::span<const std::uint8_t> bytes)
{
  constexpr const char* digits = "0123456789abcdef";
  std::string text = "\"";
  for (const std::uint8_t byte : bytes)
  {
    text += digits[byte >> 4];
    text += digits[byte & 15];
  }
  return text + "\"";
}

// The bits of doubles in hexadecimal, highest byte first, because decimal text can round.
std::string HexOfDoubles(std::span<const double> values)
{
  std::vector<std::uint8_t> bytes;
  for (const double value : values)
  {
    for (unsigned i = 8; i-- > 0;)
    {
      bytes.push_back(static_cast<std::uint8_t>(BitCast<std::uint64_t>(value) >> (8 * i)));
    }
  }
  return Hex(bytes);
}

template <class Items, class Text>
std::string List(const Items& items, const Text& text)
{
  std::string list = "[";
  for (const auto& item : items)
  {
    list += (list.size() > 1 ? "," : "") + text(item);
  }
  return list + "]";
}

std::string Number(std::uint64_t value)
{
  return std::to_string(value);
}

std::string Sample(const Piece& piece, const CodecContext& context)
{
  const CoordinateGrid grid = context.GridOf(piece.id.resolution);
  std::vector<double> positions, frame(grid.origin.begin(), grid.origin.end());
  frame.push_back(grid.step);
  for (const Vec3& position : piece.positions)
  {
    const Vec3 snapped = grid.Snap(position);
    positions.insert(positions.end(), snapped.begin(), snapped.end());
  }
  const bool original = piece.id.resolution.IsOriginal();
  return "{\"partition\":" + Number(context.depths.partition) +
         ",\"stitch\":" + Number(context.depths.stitch) +
         ",\"preview\":" + Number(PreviewLevel(context.depths)) + ",\"bits\":" + Number(grid.bits) +
         ",\"scalarType\":" + Number(static_cast<unsigned>(grid.scalarType)) +
         ",\"frame\":" + HexOfDoubles(frame) + ",\"spacing\":" + Number(grid.spacing) +
         ",\"level\":" + (original ? "null" : Number(piece.id.resolution.Depth())) +
         ",\"node\":" + Number(piece.id.node) + ",\"blob\":" + Hex(EncodePiece(piece, context)) +
         ",\"own\":" + Number(piece.ownVertices) + ",\"positions\":" + HexOfDoubles(positions) +
         ",\"keys\":" +
         List(piece.keys, [](VertexKey key)
           { return "[" + Number(PartitionOfKey(key)) + "," + Number(IndexOfKey(key)) + "]"; }) +
         ",\"ancestors\":" + List(piece.ancestors, Number) +
         ",\"reachBegin\":" + List(piece.childBegin, Number) +
         ",\"reachNodes\":" + List(piece.childNodes, Number) + ",\"triangles\":" +
         List(piece.triangles, [](const Triangle& t) { return List(t, Number); }) +
         ",\"attributes\":" +
         List(piece.attributes, [](const Attribute& attribute) { return Hex(attribute.values); }) +
         "}\n";
}

// The places of corners; for an exact tile also the original u and v.
std::string TextureSample(
  const TextureTile& tile, const std::vector<Triangle>& triangles, const std::vector<Vec3>& points)
{
  const std::vector<std::uint8_t> blob = EncodeTextureTile(tile, triangles);
  const TextureTile decoded = *DecodeTextureTile(blob, triangles, points);
  std::vector<double> positions;
  for (const Vec3& point : points)
  {
    positions.insert(positions.end(), point.begin(), point.end());
  }
  std::vector<double> places, given;
  for (std::size_t t = 0; t < triangles.size(); ++t)
  {
    for (std::size_t k = 0; k < 6; ++k)
    {
      places.push_back(decoded.corners[t][k / 2][k % 2]);
      if (tile.isExact)
      {
        given.push_back(tile.exact.corners[t][k / 2][k % 2]);
      }
    }
  }
  return "{\"kind\":\"texture\",\"triangles\":" +
         List(triangles, [](const Triangle& t) { return List(t, Number); }) +
         ",\"positions\":" + HexOfDoubles(positions) + ",\"width\":" + Number(tile.width) +
         ",\"height\":" + Number(tile.height) +
         ",\"format\":" + Number(static_cast<unsigned>(tile.format)) +
         ",\"image\":" + Hex(tile.image) + ",\"places\":" + HexOfDoubles(places) +
         ",\"given\":" + HexOfDoubles(given) + ",\"blob\":" + Hex(blob) + "}\n";
}

std::string HexOfBoxes(std::span<const Box> boxes)
{
  std::vector<double> sides;
  for (const Box& box : boxes)
  {
    sides.insert(sides.end(), box.lo.begin(), box.lo.end());
    sides.insert(sides.end(), box.hi.begin(), box.hi.end());
  }
  return HexOfDoubles(sides);
}

std::string TreeSample(const char* kind, NodeId node, const TreeDepths& depths, bool levels,
  const std::vector<std::uint8_t>& blob, const Box& around, std::span<const Box> boxes,
  std::span<const PieceFacts> facts)
{
  std::vector<double> numbers;
  for (const PieceFacts& piece : facts)
  {
    numbers.insert(numbers.end(), { piece.most99, piece.most, double(piece.bytes) });
  }
  return std::string("{\"kind\":\"") + kind + "\",\"node\":" + Number(node) +
         ",\"partition\":" + Number(depths.partition) + ",\"finest\":" + Number(depths.finest) +
         ",\"onePiece\":" + Number(depths.onePiece) + ",\"levels\":" + (levels ? "true" : "false") +
         ",\"blob\":" + Hex(blob) + ",\"around\":" + HexOfBoxes({ &around, 1 }) +
         ",\"boxes\":" + HexOfBoxes(boxes) + ",\"facts\":" + HexOfDoubles(numbers) + "}\n";
}

// Writes pages and boxes of a tree, with random facts of pieces.
void WriteTreeSamples(std::ostream& file, const Mesh& mesh, bool levels, std::mt19937& random)
{
  const KdTree tree = *BuildKdTree(mesh.points, { 1, {}, 1 });
  const TreeDepths& depths = tree.depths;
  for (const NodeId page : TreePages(depths))
  {
    PieceTable pieces(depths, levels);
    for (const PieceId piece : PiecesOfTreePage(page, depths, levels))
    {
      const auto most99 = float(random() % 1000) / 7;
      pieces.At(
        piece) = { most99, most99 * 2, static_cast<std::uint32_t>(random() >> random() % 32) };
    }
    const TreePage decoded = RoundTreePage(tree.boxes, page, depths, pieces);
    file << TreeSample("page", page, depths, levels, EncodeTreePage(decoded), decoded.boxes[1],
      std::span(decoded.boxes).subspan(1), decoded.facts);
  }
  for (const NodeId node : AllPartitionBoxes(depths))
  {
    const unsigned below = depths.partition - DepthOfNode(node);
    file << TreeSample("boxes", node, depths, levels,
      EncodePartitionBoxes(tree.boxes, node, depths), {},
      std::span(tree.boxes).subspan(node << below, std::size_t{ 1 } << below), {});
  }
}

// Writes a seed: the four bytes by which FuzzCodec chooses depths, grid and piece, then the blob.
bool WriteSeed(const std::filesystem::path& file, std::span<const std::uint8_t> head,
  std::span<const std::uint8_t> blob)
{
  std::ofstream seed(file, std::ios::binary);
  for (const std::span<const std::uint8_t> bytes : { head, blob })
  {
    seed.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
  }
  seed.close();
  return bool(seed);
}

// Writes seeds for each level and the original, on a grid and exact, without and with attributes.
bool WriteSeeds(const std::filesystem::path& folder)
{
  std::mt19937 random(5);
  constexpr std::uint8_t partition = 1, below = 10, onePiece = below % 4;
  const TreeDepths depths{ partition, partition + 4, partition + below, onePiece };
  for (const std::uint8_t grid : std::array<std::uint8_t, 2>{ 0, 2 }) // 20 bits, or exact doubles
  {
    const CodecContext context{ depths,
      grid == 0 ? CoordinateGrid::Over({ { 0, 0, 0 }, { 1, 1, 1 } }, 20, ScalarType::Float32)
                : CoordinateGrid::Exact(ScalarType::Float64),
      std::vector<std::uint32_t>(depths.finest + 1, 1U + grid * grid) };
    for (unsigned level = 0; level <= depths.finest + 1; ++level)
    {
      const bool original = level > depths.finest;
      const Resolution resolution = original ? Resolution::Original() : Resolution::Level(level);
      const PieceId wanted{ resolution, NodeId{ 1 } << PieceDepth(resolution, depths) };
      Piece piece = RandomPiece(random, depths);
      while (piece.id != wanted || piece.triangles.size() < 40)
      {
        piece = RandomPiece(random, depths);
      }
      const std::string name =
        (original ? "original" : "level" + Number(level)) + "-" + Number(grid);
      const std::uint8_t head[] = { partition, below, grid, static_cast<std::uint8_t>(level) };
      if (!WriteSeed(folder / name, head, EncodePiece(piece, context)) ||
          (level % 4 == 0 && !WriteSeed(folder / (name + "-attributes"), head,
                               EncodePiece(WithEveryAttribute(piece, random), context))))
      {
        return false;
      }
    }
  }
  const std::vector<Box> boxes(std::size_t{ 2 } << partition, Box{ { -1, 0, 1e9 }, { 1, 3, 1e9 } });
  const std::uint8_t head[] = { partition, below, 0, 0 };
  return WriteSeed(folder / "tree", head,
           EncodeTreePage(RoundTreePage(boxes, 1, depths, PieceTable(depths, true)))) &&
         WriteSeed(folder / "boxes", head, EncodePartitionBoxes(boxes, 1, depths));
}

}

int main(int argc, char** argv)
{
  if (argc == 3 && std::string_view(argv[1]) == "--seeds")
  {
    return WriteSeeds(argv[2]) ? 0 : 1;
  }
  if (argc != 2)
  {
    std::cerr << "usage: PieceSamples FILE | --seeds FOLDER\n";
    return 2;
  }
  std::ofstream file(argv[1]);
  std::mt19937 random(11);
  for (unsigned i = 0; i < 200; ++i)
  {
    const auto partition = static_cast<unsigned>(random() % 4);
    const unsigned stitch = partition + static_cast<unsigned>(random() % 5);
    const TreeDepths depths{ partition, stitch, stitch + 3, static_cast<unsigned>(random() % 5) };
    const Piece piece = WithEveryAttribute(RandomPiece(random, depths), random);
    for (const CoordinateGrid& grid :
      { CoordinateGrid::Exact(ScalarType::Float64), CoordinateGrid::Exact(ScalarType::Float32),
        CoordinateGrid::Over({ { 0, 0, 0 }, { 1, 1, 1 } }, 12, ScalarType::Float32) })
    {
      const std::vector<std::uint32_t> spacings(depths.finest + 1, i % 2 == 0 ? 1 : 37);
      file << Sample(piece, { depths, grid, spacings });
    }
    Piece colored = RandomPiece(random, depths);
    Attribute colors{ "RGBA", AttributeType::UInt8, AttributeAssociation::Point, 4, {} };
    for (std::size_t v = 0; v < 4 * colored.positions.size(); ++v)
    {
      colors.values.push_back(static_cast<std::uint8_t>(100 + 30 * (v % 4) + random() % 50));
    }
    colored.attributes = { std::move(colors) };
    const CodecContext coarse{ depths, CoordinateGrid::Exact(ScalarType::Float64), {}, {}, true };
    file << Sample(*DecodePiece(EncodePiece(colored, coarse), colored.id, coarse), coarse);
  }
  for (std::uint32_t side = 2; side < 20; ++side)
  {
    const std::vector<Triangle> triangles = TileGrid(side);
    const std::vector<Vec3> points = TileGridPoints(side);
    file << TextureSample(RandomTile(random, triangles), triangles, points);
    file << TextureSample(RandomExactTile(random, triangles), triangles, points);
    file << TextureSample(RandomPlanarTile(random, triangles), triangles, points);
    TextureTile coarse = RandomTile(random, triangles);
    coarse.isCoarse = true;
    file << TextureSample(coarse, triangles, points);
  }
  for (const Mesh& mesh : { Torus(40, 20), DisplacedSphere(3), Cloud(3), Soup(300, 5) })
  {
    const auto model = MakeModel(mesh, { 150, {}, 8 }, {}, {}, 3);
    Box box;
    for (const Vec3& point : mesh.points)
    {
      box.Add(point);
    }
    for (const auto& [id, piece] : model->pieces)
    {
      const TreeDepths& depths = model->tree.depths;
      file << Sample(
        piece, { depths, CoordinateGrid::Over(box, 20, mesh.scalarType), { 1, 2000, 300, 77, 2 } });
      file << Sample(piece, { depths, CoordinateGrid::Exact(mesh.scalarType), { 5 } });
    }
  }
  // Smooth enough that planes predict positions, and with several levels coarser than S.
  const Mesh smooth = DisplacedSphere(5);
  const auto model = MakeModel(smooth, { 600, {}, 8 }, {}, {}, 5);
  Box box;
  for (const Vec3& point : smooth.points)
  {
    box.Add(point);
  }
  for (const auto& [id, piece] : model->pieces)
  {
    file << Sample(
      piece, { model->tree.depths, CoordinateGrid::Over(box, 16, smooth.scalarType), { 1, 5, 3 } });
  }
  for (const Mesh& mesh : { Torus(40, 25), Cloud(3), Soup(30, 5) })
  {
    WriteTreeSamples(file, mesh, true, random);
    WriteTreeSamples(file, mesh, false, random);
  }
  file.close();
  return file ? 0 : 1;
}
