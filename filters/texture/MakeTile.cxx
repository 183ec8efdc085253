// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. find the charts
// 2. make a patch for each colour
// 3. pack charts and patches, halved until they fit
// 4. copy the texels of each chart into the picture
// 5. place the corners
// 6. encode the picture.
#include "filters/texture/MakeTile.h"

#include "filters/texture/PackBoxes.h"
#include "filters/texture/WritePicture.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <optional>

namespace kdstream
{
namespace
{

constexpr std::int64_t gutter = 2; // in texels of the tile
// Sides of square patches. Lossy WebP mixes colours within its blocks; a large patch contains a
// whole block, wherever it lies.
constexpr std::int64_t smallPatch = 4, largePatch = 32, blockSide = 16;
constexpr std::size_t mostLargePatches = 64;
constexpr unsigned mostHalvings = 14;
constexpr std::int64_t texelsAtOnce = 1 << 20;  // of a picture, read into memory
constexpr std::int64_t texelsOfLarge = 1 << 21; // of a tile
constexpr std::uint8_t emptyTexel = 128;

using Rgba = std::array<std::uint8_t, 4>;

std::int64_t FloorHalved(std::int64_t value, unsigned halvings)
{
  return value >> halvings;
}

std::int64_t CeilHalved(std::int64_t value, unsigned halvings)
{
  return -(-value >> halvings);
}

// Applies a material to the colours of texels.
class MaterialLight
{
public:
  explicit MaterialLight(const TexturedMaterial& material)
    : Factor(material.factor)
    , Opaque(material.opaque)
    , Plain(material.factor == Color{ 1, 1, 1, 1 })
    , Linear(LinearOfBytes())
  {
    this->Factor[3] = std::clamp(this->Factor[3], 0.0, 1.0);
  }

  Rgba Of(const Rgba& texel) const
  {
    Rgba lit = texel;
    for (std::size_t k = 0; k < 3 && !this->Plain; ++k)
    {
      lit[k] = ByteOfLinear(this->Linear[texel[k]] * this->Factor[k]);
    }
    lit[3] = this->Opaque ? std::uint8_t{ 255 }
                          : static_cast<std::uint8_t>(texel[3] * this->Factor[3] + 0.5);
    return lit;
  }

  // Applies the material's factor and alpha to a row of texels, RGBA.
  void Light(std::uint8_t* rgba, std::int64_t texels) const
  {
    if (this->Plain && this->Opaque)
    {
      for (std::int64_t i = 0; i < texels; ++i)
      {
        rgba[4 * i + 3] = 255;
      }
      return;
    }
    for (std::int64_t i = 0; i < texels; ++i, rgba += 4)
    {
      const Rgba lit = this->Of({ rgba[0], rgba[1], rgba[2], rgba[3] });
      std::copy(lit.begin(), lit.end(), rgba);
    }
  }

private:
  Color Factor;
  const bool Opaque, Plain;
  const std::array<double, 256>& Linear;
};

// The means, in linear light, of 2^halvings × 2^halvings texels each. width: of the larger picture.
std::vector<std::uint8_t> Halve(
  std::vector<std::uint8_t> texels, std::size_t width, unsigned halvings)
{
  if (halvings == 0)
  {
    return texels;
  }
  const std::array<double, 256>& linear = LinearOfBytes();
  const std::size_t step = std::size_t{ 1 } << halvings;
  const std::size_t height = texels.size() / 4 / width;
  std::vector<std::uint8_t> smaller;
  for (std::size_t y = 0; y < height; y += step)
  {
    for (std::size_t x = 0; x < width; x += step)
    {
      Color sum{};
      for (std::size_t i = 0; i < step * step; ++i)
      {
        const std::uint8_t* const texel = &texels[4 * ((y + i / step) * width + x + i % step)];
        for (std::size_t k = 0; k < 4; ++k)
        {
          sum[k] += k < 3 ? linear[texel[k]] : texel[k];
        }
      }
      const double part = 1 / double(step * step);
      for (std::size_t k = 0; k < 3; ++k)
      {
        smaller.push_back(ByteOfLinear(sum[k] * part));
      }
      smaller.push_back(static_cast<std::uint8_t>(sum[3] * part + 0.5));
    }
  }
  return smaller;
}

class TileMaker
{
public:
  TileMaker(const TexturedTriangles& textured, const TextureSet& textures,
    const TexelSource& source, const TileOptions& options)
    : Textured(textured)
    , Textures(textures)
    , Source(source)
    , Options(options)
    , Charts(FindTileCharts(textured, textures, source, gutter))
  {
  }

  Result<MadeTile> Make()
  {
    KDSTREAM_TRY(this->FindPatches());
    KDSTREAM_TRY(this->Pack());
    const std::int64_t size = this->Packed.width * this->Packed.height;
    std::unique_lock<std::mutex> alone;
    if (this->Options.oneLarge && size > texelsOfLarge)
    {
      alone = std::unique_lock(*this->Options.oneLarge);
    }
    this->Texels.assign(static_cast<std::size_t>(4 * size), emptyTexel);
    for (std::size_t alpha = 3; alpha < this->Texels.size(); alpha += 4)
    {
      this->Texels[alpha] = 255;
    }
    for (std::size_t i = 0; i < this->Charts.boxes.size(); ++i)
    {
      KDSTREAM_TRY(this->Crop(i));
    }
    this->FillPatches();
    this->PlaceCorners();
    KDSTREAM_TRY(this->EncodeImage());
    this->Counts.tiles = 1;
    this->Counts.halved = this->Halvings > 0 ? 1 : 0;
    this->Counts.texels = static_cast<std::uint64_t>(size);
    this->Counts.triangles = this->Textured.triangles.size();
    return MadeTile{ std::move(this->Tile), this->Counts };
  }

private:
  const TexturedMaterial& MaterialOf(std::size_t t) const
  {
    return this->Textures.materials[this->Textured.materialOf[t]];
  }

  static Rgba ColorOf(const TexturedMaterial& material)
  {
    const double alpha = material.opaque ? 1 : std::clamp(material.color[3], 0.0, 1.0);
    return { ByteOfLinear(material.color[0]), ByteOfLinear(material.color[1]),
      ByteOfLinear(material.color[2]), static_cast<std::uint8_t>(255 * alpha + 0.5) };
  }

  // The mean colour of a picture, from a few of its texels.
  Result<Rgba> MeanOf(const TexturedMaterial& material) const
  {
    constexpr std::int64_t samples = 16;
    const auto size = this->Source.SizeOf(material.picture);
    std::vector<std::uint8_t> texels(4 * samples * samples);
    for (std::int64_t i = 0; i < samples * samples; ++i)
    {
      const std::int64_t x = (2 * (i % samples) + 1) * size[0] / (2 * samples);
      const std::int64_t y = (2 * (i / samples) + 1) * size[1] / (2 * samples);
      KDSTREAM_TRY(this->Source.Read(
        material.picture, { { x, y }, { x + 1, y + 1 } }, &texels[std::size_t(4 * i)]));
    }
    const std::vector<std::uint8_t> mean = Halve(std::move(texels), samples, 4);
    return MaterialLight(material).Of({ mean[0], mean[1], mean[2], mean[3] });
  }

  // Finds the colours of the patches, and the patch of each triangle that shows no picture.
  Status FindPatches()
  {
    std::map<std::pair<std::uint32_t, bool>, Rgba> known; // by material, and whether a mean
    std::map<Rgba, std::uint32_t> numbers;
    this->PatchOf.assign(this->Textured.triangles.size(), noChartBox);
    for (std::size_t t = 0; t < this->PatchOf.size(); ++t)
    {
      const Untextured why = this->Charts.ofTriangle[t].why;
      if (why == Untextured::No)
      {
        continue;
      }
      const bool mean = why == Untextured::Repeats || why == Untextured::TooFar;
      this->Counts.repeating += why == Untextured::Repeats ? 1 : 0;
      const auto [entry, isNew] = known.try_emplace({ this->Textured.materialOf[t], mean });
      if (isNew)
      {
        Result<Rgba> color =
          mean ? this->MeanOf(this->MaterialOf(t)) : Result<Rgba>(ColorOf(this->MaterialOf(t)));
        KDSTREAM_TRY(color);
        entry->second = *color;
      }
      const auto number = static_cast<std::uint32_t>(this->Patches.size());
      const auto [patch, isNewColor] = numbers.try_emplace(entry->second, number);
      if (isNewColor)
      {
        this->Patches.push_back(entry->second);
      }
      this->PatchOf[t] = patch->second;
    }
    return {};
  }

  // The box of a chart with its gutter, in texels of the tile.
  TexelBox Halved(const TexelBox& box) const
  {
    const unsigned h = this->Halvings;
    return { { FloorHalved(box.lo[0], h) - gutter, FloorHalved(box.lo[1], h) - gutter },
      { CeilHalved(box.hi[0], h) + gutter, CeilHalved(box.hi[1], h) + gutter } };
  }

  std::int64_t PatchSide() const
  {
    const bool lossy = this->Options.quality != 0;
    return lossy && this->Patches.size() <= mostLargePatches ? largePatch : smallPatch;
  }

  // Where corners lie that have this colour: at the centre of the patch, or of the whole block in
  // it.
  std::array<std::int64_t, 2> MiddleOfPatch(std::size_t patch) const
  {
    std::array<std::int64_t, 2> place = this->Packed.places[this->Charts.boxes.size() + patch];
    for (std::int64_t& at : place)
    {
      at = this->PatchSide() == smallPatch
             ? at + smallPatch / 2
             : (at + blockSide - 1) / blockSide * blockSide + blockSide / 2;
    }
    return place;
  }

  Status Pack()
  {
    const std::int64_t mostSide =
      this->Options.quality == 0 ? std::int64_t{ longestTileSide } : this->Options.mostSide;
    for (; this->Halvings <= mostHalvings; ++this->Halvings)
    {
      std::vector<std::array<std::int64_t, 2>> sizes;
      for (const ChartBox& chart : this->Charts.boxes)
      {
        const TexelBox box = this->Halved(chart.box);
        sizes.push_back({ box.Width(), box.Height() });
      }
      sizes.insert(sizes.end(), this->Patches.size(), { this->PatchSide(), this->PatchSide() });
      if (auto packed = PackBoxes(sizes, mostSide))
      {
        this->Packed = std::move(*packed);
        return {};
      }
    }
    return Error{ ErrorCode::LimitExceeded,
      "the charts of a partition do not fit a picture: make partitions of fewer vertices" };
  }

  void PutRow(std::int64_t x, std::int64_t y, const std::uint8_t* rgba, std::int64_t texels)
  {
    std::copy_n(rgba, 4 * texels,
      this->Texels.begin() + static_cast<std::ptrdiff_t>(4 * (y * this->Packed.width + x)));
    std::uint8_t leastAlpha = 255;
    for (std::int64_t i = 0; i < texels; ++i)
    {
      leastAlpha = std::min(leastAlpha, rgba[4 * i + 3]);
    }
    this->HasAlpha = this->HasAlpha || leastAlpha != 255;
  }

  // Copies a chart in bands, because the chart may be much larger before it is halved.
  Status Crop(std::size_t number)
  {
    const TexelBox halved = this->Halved(this->Charts.boxes[number].box);
    const std::int64_t step = std::int64_t{ 1 } << this->Halvings;
    const TexelBox box{ { halved.lo[0] * step, halved.lo[1] * step },
      { halved.hi[0] * step, halved.hi[1] * step } };
    const std::int64_t rows = std::max<std::int64_t>(1, texelsAtOnce / (box.Width() * step));
    for (std::int64_t row = 0; row < halved.Height(); row += rows)
    {
      KDSTREAM_TRY(this->CropRows(number, row, std::min(rows, halved.Height() - row), box));
    }
    return {};
  }

  // Copies some rows of a chart. box: the whole chart, in texels of the picture.
  Status CropRows(std::size_t number, std::int64_t first, std::int64_t rows, const TexelBox& box)
  {
    const TexturedMaterial& material =
      this->Textures.materials[this->Charts.boxes[number].material];
    const std::int64_t step = std::int64_t{ 1 } << this->Halvings;
    const std::int64_t above = box.lo[1] + first * step;
    Result<std::vector<std::uint8_t>> read = ReadWrapped(this->Source, material.picture,
      { { box.lo[0], above }, { box.hi[0], above + rows * step } }, material.wrapU, material.wrapV);
    KDSTREAM_TRY(read);
    std::vector<std::uint8_t> texels =
      Halve(std::move(*read), static_cast<std::size_t>(box.Width()), this->Halvings);
    const MaterialLight light(material);
    const auto [x, y] = this->Packed.places[number];
    const std::int64_t width = box.Width() / step;
    for (std::int64_t j = 0; j < rows; ++j)
    {
      std::uint8_t* const row = texels.data() + 4 * j * width;
      light.Light(row, width);
      this->PutRow(x, y + first + j, row, width);
    }
    return {};
  }

  void FillPatches()
  {
    for (std::size_t p = 0; p < this->Patches.size(); ++p)
    {
      const auto [x, y] = this->Packed.places[this->Charts.boxes.size() + p];
      const std::int64_t side = this->PatchSide();
      for (std::int64_t i = 0; i < side * side; ++i)
      {
        this->PutRow(x + i % side, y + i / side, this->Patches[p].data(), 1);
      }
    }
  }

  // The position of a triangle's chart, for an exact tile, with the source of its material.
  TileChart PlaceOfChart(std::size_t t)
  {
    const std::int64_t step = std::int64_t{ 1 } << this->Halvings;
    if (this->PatchOf[t] != noChartBox)
    {
      const auto [x, y] = this->MiddleOfPatch(this->PatchOf[t]);
      return { noTileSource, x * step, y * step };
    }
    const TriangleChart& chart = this->Charts.ofTriangle[t];
    const ChartBox& box = this->Charts.boxes[chart.box];
    const TexelBox halved = this->Halved(box.box);
    const auto [x, y] = this->Packed.places[chart.box];
    return { this->SourceOf(box.material), (x - halved.lo[0]) * step - chart.shift[0],
      (y - halved.lo[1]) * step - chart.shift[1] };
  }

  std::uint32_t SourceOf(std::uint32_t number)
  {
    const auto next = static_cast<std::uint32_t>(this->Tile.exact.sources.size());
    const auto [source, isNew] = this->Sources.try_emplace(number, next);
    if (isNew)
    {
      const TexturedMaterial& material = this->Textures.materials[number];
      const auto size = this->Source.SizeOf(material.picture);
      this->Tile.exact.sources.push_back({ this->Textures.shown.empty()
                                             ? material.picture
                                             : this->Textures.shown[number],
        size[0], size[1], material.transform.u, material.transform.v,
        { static_cast<std::uint8_t>(material.wrapU), static_cast<std::uint8_t>(material.wrapV) } });
    }
    return source->second;
  }

  void PlaceCorners()
  {
    ExactTile& exact = this->Tile.exact;
    exact.halvings = static_cast<std::uint8_t>(this->Halvings);
    std::map<std::array<std::int64_t, 3>, std::uint32_t> numbers; // numbers of the charts
    for (std::size_t t = 0; t < this->Textured.triangles.size(); ++t)
    {
      const TileChart chart = this->PlaceOfChart(t);
      const auto next = static_cast<std::uint32_t>(exact.charts.size());
      const auto [entry, isNew] =
        numbers.try_emplace({ std::int64_t{ chart.source }, chart.x, chart.y }, next);
      if (isNew)
      {
        exact.charts.push_back(chart);
      }
      exact.chartOf.push_back(entry->second);
      auto& corners = this->Tile.corners.emplace_back();
      for (std::size_t k = 0; k < 3; ++k)
      {
        corners[k] = PlaceOfCorner(exact, entry->second, this->Textured.corners[t][k]);
      }
    }
    this->Tile.isExact = this->Options.quality == 0;
    if (this->Tile.isExact)
    {
      exact.corners = this->Textured.corners;
      return;
    }
    exact = {};
  }

  Status EncodeImage()
  {
    this->Tile.width = static_cast<std::uint32_t>(this->Packed.width);
    this->Tile.height = static_cast<std::uint32_t>(this->Packed.height);
    this->Tile.format = TileImage::Webp;
    Picture picture{ this->Tile.width, this->Tile.height, 4, std::move(this->Texels) };
    Result<std::vector<std::uint8_t>> image =
      EncodeWebp(std::move(picture), this->Options.quality, this->HasAlpha);
    KDSTREAM_TRY(image);
    this->Tile.image = std::move(*image);
    return {};
  }

  const TexturedTriangles& Textured;
  const TextureSet& Textures;
  const TexelSource& Source;
  const TileOptions& Options;
  const TileCharts Charts;
  std::vector<Rgba> Patches;
  std::vector<std::uint32_t> PatchOf; // noChartBox: no patch
  unsigned Halvings = 0;
  PackedBoxes Packed;               // first boxes, then patches
  std::vector<std::uint8_t> Texels; // RGBA, of the whole tile
  bool HasAlpha = false;
  std::map<std::uint32_t, std::uint32_t> Sources; // by material
  TextureTile Tile;
  TileCounts Counts;
};

}

void TileCounts::Add(const TileCounts& more)
{
  this->tiles += more.tiles;
  this->halved += more.halved;
  this->texels += more.texels;
  this->triangles += more.triangles;
  this->repeating += more.repeating;
}

Result<MadeTile> MakeTile(const TexturedTriangles& textured, const TextureSet& textures,
  const TexelSource& source, const TileOptions& options)
{
  return TileMaker(textured, textures, source, options).Make();
}

}
