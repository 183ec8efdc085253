// SPDX-License-Identifier: BSD-3-Clause
// Textures as bytes: see TextureTile.h and doc/formats.md, "Textures". A blob has the head and the
// image as bytes, then everything else as symbols.
#include "filters/codec/TextureTile.h"

#include "filters/codec/ByteStream.h"
#include "filters/codec/Seal.h"
#include "filters/codec/SymbolCoder.h"
#include "filters/codec/TileCorners.h"
#include "filters/core/BitCast.h"
#include "filters/core/VectorMath.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace kdstream
{
namespace
{

constexpr std::string_view tileMagic = "KDX";
// In the byte that names the format.
constexpr std::uint8_t exactBit = 0x80, coarseBit = 0x40, planarBit = 0x20;
constexpr std::uint8_t mostHalvings = 14;
constexpr std::int64_t mostChartPlace = std::int64_t{ 1 } << 46;
constexpr std::uint64_t mostSourceSide = std::uint64_t{ 1 } << 31;

void WriteHead(ByteWriter& writer, const TextureTile& tile, std::size_t triangles)
{
  WriteBlobHead(writer, tileMagic);
  writer.Varint(triangles);
  writer.Varint(tile.width);
  writer.Varint(tile.height);
  writer.Byte(
    static_cast<std::uint8_t>(static_cast<std::uint8_t>(tile.format) | (tile.isExact     ? exactBit
                                                                         : tile.isCoarse ? coarseBit
                                                                         : tile.isPlanar ? planarBit
                                                                                         : 0)));
  writer.Varint(tile.image.size());
  writer.Raw(tile.image);
}

TextureTileHead ReadHead(ByteReader& reader)
{
  (void)reader.Raw(blobHeadSize);
  TextureTileHead head;
  head.triangles = static_cast<std::uint32_t>(reader.Varint(noVertex / 64));
  head.width = static_cast<std::uint32_t>(reader.Varint(longestTileSide));
  head.height = static_cast<std::uint32_t>(reader.Varint(longestTileSide));
  const std::uint8_t format = reader.Byte();
  head.exact = (format & exactBit) != 0;
  head.coarse = !head.exact && (format & coarseBit) != 0;
  head.planar = !head.exact && !head.coarse && (format & planarBit) != 0;
  head.format = static_cast<TileImage>(format & ~(head.exact    ? exactBit
                                                  : head.coarse ? coarseBit
                                                  : head.planar ? planarBit
                                                                : 0));
  if (head.format < TileImage::Jpeg || head.format > TileImage::Webp)
  {
    reader.Fail("unknown image format");
  }
  if (head.width == 0 || head.height == 0)
  {
    reader.Fail("the image has no texels");
  }
  head.image = reader.Raw(reader.Count(reader.Remaining()));
  return head;
}

// ---- the tables of an exact tile

void WriteDouble(SymbolWriter& symbols, double value)
{
  symbols.Number(TileContext::table, BitCast<std::uint64_t>(value));
}

void WriteTables(SymbolWriter& symbols, const ExactTile& exact)
{
  symbols.Number(TileContext::table, exact.halvings);
  symbols.Number(TileContext::table, exact.sources.size());
  for (const TileSource& source : exact.sources)
  {
    for (const std::uint32_t number : { source.picture, source.width, source.height })
    {
      symbols.Number(TileContext::table, number);
    }
    for (const auto& row : { source.u, source.v })
    {
      std::for_each(row.begin(), row.end(), [&](double value) { WriteDouble(symbols, value); });
    }
    symbols.Number(TileContext::table, source.wrap[0] + 3ULL * source.wrap[1]);
  }
  symbols.Number(TileContext::table, exact.charts.size());
  for (const TileChart& chart : exact.charts)
  {
    symbols.Number(
      TileContext::chartSource, chart.source == noTileSource ? 0 : chart.source + 1ULL);
    symbols.Signed(TileContext::chartPlace, chart.x);
    symbols.Signed(TileContext::chartPlace, chart.y);
  }
}

// Reads a number of the tables. Returns false if it is above `most` or missing.
bool ReadNumber(
  SymbolReader& symbols, TileContext::Numbers context, std::uint64_t most, std::uint64_t& number)
{
  number = symbols.Number(context);
  return !symbols.Failed() && number <= most;
}

bool ReadSource(SymbolReader& symbols, TileSource& source)
{
  std::uint64_t picture = 0, width = 0, height = 0;
  if (!ReadNumber(symbols, TileContext::table, noTileSource - 1, picture) ||
      !ReadNumber(symbols, TileContext::table, mostSourceSide, width) ||
      !ReadNumber(symbols, TileContext::table, mostSourceSide, height))
  {
    return false;
  }
  source.picture = static_cast<std::uint32_t>(picture);
  source.width = static_cast<std::uint32_t>(width);
  source.height = static_cast<std::uint32_t>(height);
  for (auto* row : { &source.u, &source.v })
  {
    for (double& value : *row)
    {
      value = BitCast<double>(symbols.Number(TileContext::table));
    }
  }
  std::uint64_t wrap = 0;
  const bool known = ReadNumber(symbols, TileContext::table, 8, wrap);
  source.wrap = { static_cast<std::uint8_t>(wrap % 3), static_cast<std::uint8_t>(wrap / 3) };
  return known;
}

// Returns null, or what is wrong.
const char* ReadTables(SymbolReader& symbols, std::size_t triangles, ExactTile& exact)
{
  std::uint64_t halvings = 0, sources = 0, charts = 0;
  if (!ReadNumber(symbols, TileContext::table, mostHalvings, halvings) ||
      !ReadNumber(symbols, TileContext::table, triangles, sources))
  {
    return "more pictures than triangles";
  }
  exact.halvings = static_cast<std::uint8_t>(halvings);
  for (; sources > 0; --sources)
  {
    if (!ReadSource(symbols, exact.sources.emplace_back()))
    {
      return "a chart's source is not one of the pictures";
    }
  }
  if (!ReadNumber(symbols, TileContext::table, triangles, charts))
  {
    return "more charts than triangles";
  }
  for (; charts > 0; --charts)
  {
    TileChart& chart = exact.charts.emplace_back();
    std::uint64_t source = 0;
    if (!ReadNumber(symbols, TileContext::chartSource, exact.sources.size(), source))
    {
      return "a chart has an unknown source";
    }
    chart.source = source == 0 ? noTileSource : static_cast<std::uint32_t>(source - 1);
    for (std::int64_t* const place : { &chart.x, &chart.y })
    {
      *place = symbols.Signed(TileContext::chartPlace);
      if (*place < -mostChartPlace || *place > mostChartPlace)
      {
        return "a chart's position is out of range";
      }
    }
  }
  return nullptr;
}

// ---- planar tiles: charts, and the chart of each triangle

void WritePlanar(
  SymbolWriter& symbols, const PlanarTile& planar, std::span<const Triangle> triangles)
{
  WriteDouble(symbols, planar.texels);
  symbols.Number(TileContext::table, planar.charts.size());
  for (const PlanarChart& chart : planar.charts)
  {
    for (const std::int64_t number : chart.turn)
    {
      symbols.Signed(TileContext::chartSource, number);
    }
    for (const std::int64_t number : chart.offset)
    {
      symbols.Signed(TileContext::chartPlace, number);
    }
  }
  TileCornerWriter corners(symbols, triangles, true);
  for (std::size_t t = 0; t < triangles.size(); ++t)
  {
    corners.Chart(t, planar.chartOf[t]);
    corners.Remember(t);
  }
}

// Reads a number of a planar chart. Returns false if it is too large or missing.
bool ReadPlanarNumber(
  SymbolReader& symbols, TileContext::Numbers context, std::int64_t most, std::int64_t& number)
{
  number = symbols.Signed(context);
  return !symbols.Failed() && number >= -most && number <= most;
}

// Returns null, or what is wrong.
const char* ReadPlanar(SymbolReader& symbols, std::span<const Triangle> triangles,
  std::span<const Vec3> positions, TextureTile& tile)
{
  PlanarTile& planar = tile.planar;
  planar.texels = BitCast<double>(symbols.Number(TileContext::table));
  std::uint64_t charts = 0;
  if (!ReadNumber(symbols, TileContext::table, triangles.size(), charts))
  {
    return "more charts than triangles";
  }
  std::vector<std::array<Vec3, 2>> axes;
  for (; charts > 0; --charts)
  {
    PlanarChart& chart = planar.charts.emplace_back();
    std::array<std::int64_t, 5> numbers{};
    for (std::size_t i = 0; i < 5; ++i)
    {
      if (!ReadPlanarNumber(symbols, i < 3 ? TileContext::chartSource : TileContext::chartPlace,
            i < 3 ? turnSteps : mostChartPlace, numbers[i]))
      {
        return "a chart's position is out of range";
      }
    }
    for (std::size_t k = 0; k < 3; ++k)
    {
      chart.turn[k] = static_cast<std::int32_t>(numbers[k]);
    }
    chart.offset = { numbers[3], numbers[4] };
    axes.push_back(AxesOf(chart));
  }
  planar.chartOf.resize(triangles.size());
  TileCornerReader reader(symbols, triangles, true);
  for (std::size_t t = 0; t < triangles.size(); ++t)
  {
    const std::uint64_t number = reader.Chart(t);
    reader.Remember(t);
    if (number >= planar.charts.size())
    {
      return "a triangle has an unknown chart";
    }
    planar.chartOf[t] = static_cast<std::uint32_t>(number);
    for (std::size_t k = 0; k < 3; ++k)
    {
      const VertexId vertex = triangles[t][k];
      if (vertex >= positions.size())
      {
        return "the positions of its piece are needed";
      }
      const Vec3 from = Minus(positions[vertex], positions[0]);
      const std::uint32_t chart = planar.chartOf[t];
      const TileCoordinate at = PlaceOfCorner(planar, planar.charts[chart], axes[chart], from);
      if (!(at[0] >= 0 && at[0] <= float(tile.width) && at[1] >= 0 && at[1] <= float(tile.height)))
      {
        return "a corner is outside the image";
      }
      tile.corners[t][k] = at;
    }
  }
  return symbols.AtEnd() ? nullptr : "extra bytes at the end";
}

// ---- corners

unsigned StepsOfTexel(const TextureTile& tile)
{
  return tile.isCoarse ? coarseTileSteps : tileSteps;
}

// A coordinate in steps: rounded, and clamped to the picture.
std::int64_t StepsOf(float place, std::uint32_t side, unsigned ofTexel)
{
  const double steps = std::nearbyint(double(place) * ofTexel);
  return steps > 0 ? static_cast<std::int64_t>(std::min(steps, double(side) * ofTexel)) : 0;
}

TileCorner CornerToWrite(const TextureTile& tile, std::size_t triangle, std::size_t corner)
{
  if (tile.isExact)
  {
    const auto& [u, v] = tile.exact.corners[triangle][corner];
    return { OrderedBits(u), OrderedBits(v) };
  }
  const TileCoordinate& place = tile.corners[triangle][corner];
  const unsigned steps = StepsOfTexel(tile);
  return { StepsOf(place[0], tile.width, steps), StepsOf(place[1], tile.height, steps) };
}

bool IsCorner(const TileCorner& corner, const TextureTile& tile)
{
  const std::int64_t most = std::numeric_limits<std::uint32_t>::max(), steps = StepsOfTexel(tile);
  const std::int64_t x = tile.isExact ? most : tile.width * steps;
  const std::int64_t y = tile.isExact ? most : tile.height * steps;
  return corner[0] >= 0 && corner[0] <= x && corner[1] >= 0 && corner[1] <= y;
}

// Sets a corner. Returns false if it lies outside the picture.
bool TakeCorner(TextureTile& tile, std::size_t triangle, std::size_t k, const TileCorner& corner)
{
  TileCoordinate& place = tile.corners[triangle][k];
  if (!tile.isExact)
  {
    const auto steps = float(StepsOfTexel(tile));
    place = { float(corner[0]) / steps, float(corner[1]) / steps };
    return true;
  }
  std::array<float, 2>& given = tile.exact.corners[triangle][k];
  given = { FloatOfOrderedBits(static_cast<std::uint32_t>(corner[0])),
    FloatOfOrderedBits(static_cast<std::uint32_t>(corner[1])) };
  place = PlaceOfCorner(tile.exact, tile.exact.chartOf[triangle], given);
  return place[0] >= 0 && place[0] <= float(tile.width) && place[1] >= 0 &&
         place[1] <= float(tile.height);
}

// Returns null, or what is wrong.
const char* ReadCorners(SymbolReader& symbols, std::span<const Triangle> triangles,
  std::span<const Vec3> positions, TextureTile& tile)
{
  tile.corners.resize(triangles.size());
  if (tile.isPlanar)
  {
    return ReadPlanar(symbols, triangles, positions, tile);
  }
  if (tile.isExact)
  {
    if (const char* wrong = ReadTables(symbols, triangles.size(), tile.exact))
    {
      return wrong;
    }
    tile.exact.chartOf.resize(triangles.size());
    tile.exact.corners.resize(triangles.size());
  }
  TileCornerReader reader(symbols, triangles, tile.isExact);
  for (std::size_t t = 0; t < triangles.size(); ++t)
  {
    if (tile.isExact)
    {
      const std::uint64_t chart = reader.Chart(t);
      if (chart >= tile.exact.charts.size())
      {
        return "a triangle has an unknown chart";
      }
      tile.exact.chartOf[t] = static_cast<std::uint32_t>(chart);
    }
    const std::array<TileCorner, 3> corners = reader.Corners(t);
    for (std::size_t k = 0; k < 3; ++k)
    {
      if (!IsCorner(corners[k], tile) || !TakeCorner(tile, t, k, corners[k]))
      {
        return "a corner is outside the image";
      }
    }
  }
  return symbols.AtEnd() ? nullptr : "extra bytes at the end";
}

// Writes what follows the image.
void WriteCorners(
  SymbolWriter& symbols, const TextureTile& tile, std::span<const Triangle> triangles)
{
  if (tile.isPlanar)
  {
    WritePlanar(symbols, tile.planar, triangles);
    return;
  }
  if (tile.isExact)
  {
    WriteTables(symbols, tile.exact);
  }
  TileCornerWriter corners(symbols, triangles, tile.isExact);
  for (std::size_t t = 0; t < triangles.size(); ++t)
  {
    if (tile.isExact)
    {
      corners.Chart(t, tile.exact.chartOf[t]);
    }
    corners.Corners(
      t, { CornerToWrite(tile, t, 0), CornerToWrite(tile, t, 1), CornerToWrite(tile, t, 2) });
  }
}

Error OfTile(Error error)
{
  error.message = "texture: " + error.message;
  return error;
}

}

std::string_view NameOf(TileImage format)
{
  return format == TileImage::Jpeg ? "jpeg" : format == TileImage::Png ? "png" : "webp";
}

TileCoordinate PlaceOfCorner(
  const ExactTile& exact, std::uint32_t chart, const std::array<float, 2>& corner)
{
  const TileChart& moved = exact.charts[chart];
  const double scale = std::ldexp(1.0, -int{ exact.halvings });
  if (moved.source == noTileSource)
  {
    return { float(double(moved.x) * scale), float(double(moved.y) * scale) };
  }
  const TileSource& source = exact.sources[moved.source];
  const auto along = [&](const std::array<double, 3>& row)
  { return row[0] * double(corner[0]) + row[1] * double(corner[1]) + row[2]; };
  return { float((along(source.u) * source.width + double(moved.x)) * scale),
    float((along(source.v) * source.height + double(moved.y)) * scale) };
}

std::array<Vec3, 2> AxesOf(const PlanarChart& chart)
{
  const double x = double(chart.turn[0]) / turnSteps, y = double(chart.turn[1]) / turnSteps;
  const double z = double(chart.turn[2]) / turnSteps;
  const double w = std::sqrt(std::max(0.0, 1 - x * x - y * y - z * z));
  return { Vec3{ 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y) },
    Vec3{ 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x) } };
}

TileCoordinate PlaceOfCorner(const PlanarTile& planar, const PlanarChart& chart,
  const std::array<Vec3, 2>& axes, const Vec3& from)
{
  const auto along = [&](std::size_t k)
  {
    return float(
      Dot(from, axes[k]) * planar.texels + double(chart.offset[k]) / double(coarseTileSteps));
  };
  return { along(0), along(1) };
}

std::vector<std::uint8_t> EncodeTextureTile(
  const TextureTile& tile, std::span<const Triangle> triangles)
{
  SymbolWriter symbols(TileContext::all);
  WriteCorners(symbols, tile, triangles);
  ByteWriter writer;
  WriteHead(writer, tile, triangles.size());
  symbols.Finish(writer, 0);
  std::vector<std::uint8_t> blob = writer.Take();
  SealBlob(blob);
  return blob;
}

Result<TextureTileHead> ReadTextureTileHead(std::span<const std::uint8_t> blob)
{
  const auto unsealed = UnsealBlob(blob, tileMagic);
  if (!unsealed)
  {
    return OfTile(unsealed.GetError());
  }
  ByteReader reader(*unsealed);
  const TextureTileHead head = ReadHead(reader);
  return reader.Failed() ? Result<TextureTileHead>(OfTile(reader.Why())) : head;
}

Result<TextureTile> DecodeTextureTile(std::span<const std::uint8_t> blob,
  std::span<const Triangle> triangles, std::span<const Vec3> positions)
{
  const auto unsealed = UnsealBlob(blob, tileMagic);
  if (!unsealed)
  {
    return OfTile(unsealed.GetError());
  }
  ByteReader reader(*unsealed);
  const TextureTileHead head = ReadHead(reader);
  if (!reader.Failed() && head.triangles != triangles.size())
  {
    reader.Fail("the number of triangles differs from the piece");
  }
  if (reader.Failed())
  {
    return OfTile(reader.Why());
  }
  TextureTile tile{ head.width, head.height, head.format, { head.image.begin(), head.image.end() },
    {}, head.exact, {}, head.coarse, head.planar, {} };
  SymbolReader symbols(unsealed->subspan(reader.Position()), TileContext::all);
  const char* wrong = symbols.Failed() ? "" : ReadCorners(symbols, triangles, positions, tile);
  if (wrong || symbols.Failed())
  {
    reader.Fail(symbols.Failed() ? "truncated symbols" : wrong);
    return OfTile(reader.Why());
  }
  return tile;
}

}
