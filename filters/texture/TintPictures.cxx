// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. give triangles of one tint a material with it
// 2. find the charts of the others; triangles that cannot share their chart's texels get their own
// 3. give up if the charts have too many texels
// 4. pack charts into pages, the new pictures; copy and multiply their texels
// 5. place the corners.
#include "filters/texture/TintPictures.h"

#include "filters/texture/PackBoxes.h"
#include "filters/texture/TileCharts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace kdstream
{
namespace
{

constexpr std::int64_t gutter = 2;
constexpr std::int64_t longestPage = 4096, longestChart = longestPage - 2 * gutter;
constexpr std::int64_t texelsOfPage = longestPage * longestPage / 2; // leaves room for packing
constexpr std::size_t mostExactTints = 4096, mostMaterials = 1 << 16;
constexpr double mostTimesPictures = 4, fewTexels = 1 << 20;
constexpr double mostVisits = 16;      // of each texel, by triangles
constexpr double roundedTint = 64;     // steps of tints that stand for a whole triangle
constexpr double sameTint = 1.0 / 128; // the difference that one texel may have to hide
constexpr std::int64_t patchSide = 3;  // texels along a triangle that gets a patch
constexpr double steepTint = 0.04;     // of 1, as shown: the difference that needs a patch
constexpr std::uint32_t unclaimed = noChartBox;

using Place = std::array<double, 2>; // in texels: x from the left, y from above
using Corners = TexelCorners;

// The weights of a triangle's corners at a place; equal ones if the triangle has no area.
std::array<double, 3> WeightsAt(const Corners& at, const Place& place)
{
  const auto cross = [](const Place& a, const Place& b, const Place& c)
  { return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]); };
  const double area = cross(at[0], at[1], at[2]);
  if (std::abs(area) < 1e-9)
  {
    return { 1.0 / 3, 1.0 / 3, 1.0 / 3 };
  }
  return { cross(at[1], at[2], place) / area, cross(at[2], at[0], place) / area,
    cross(at[0], at[1], place) / area };
}

// The weights at the centre of a texel; beyond the triangle, those of a place near the nearest
// corner or edge.
std::array<double, 3> WithinTriangle(const Corners& at, std::int64_t x, std::int64_t y)
{
  auto weights = WeightsAt(at, { double(x) + 0.5, double(y) + 0.5 });
  double sum = 0;
  for (double& weight : weights)
  {
    weight = std::clamp(weight, 0.0, 1.0);
    sum += weight;
  }
  std::for_each(weights.begin(), weights.end(), [&](double& weight) { weight /= sum; });
  return weights;
}

TexelBox WithGutter(const TexelBox& box)
{
  return { { box.lo[0] - gutter, box.lo[1] - gutter }, { box.hi[0] + gutter, box.hi[1] + gutter } };
}

std::int64_t CostOf(const TexelBox& box)
{
  return (box.Width() + 2 * gutter) * (box.Height() + 2 * gutter);
}

// Calls visit(x, y) for each texel whose centre the triangle contains, and for the one at its
// middle. Stops when visit returns false, and returns whether none did.
template <class Visit>
bool VisitTexels(const Corners& at, const Visit& visit)
{
  constexpr double onEdge = -1e-9;
  const TexelBox box = BoxOf(at);
  for (std::int64_t y = box.lo[1]; y < box.hi[1]; ++y)
  {
    for (std::int64_t x = box.lo[0]; x < box.hi[0]; ++x)
    {
      const auto weights = WeightsAt(at, { double(x) + 0.5, double(y) + 0.5 });
      if (*std::min_element(weights.begin(), weights.end()) >= onEdge && !visit(x, y))
      {
        return false;
      }
    }
  }
  const auto middle = [&](std::size_t i)
  { return static_cast<std::int64_t>(std::floor((at[0][i] + at[1][i] + at[2][i]) / 3)); };
  return visit(middle(0), middle(1));
}

enum class ChartKind
{
  Copied, // texels of the picture
  Patch,  // one triangle, magnified
  Plain   // one triangle without a picture
};

// Texels of one material, on one page.
struct TintedChart
{
  std::uint32_t material = 0;
  ChartKind kind = ChartKind::Copied;
  TexelBox box;
  std::vector<std::uint32_t> triangles; // numbers among the varying ones, ascending
  Corners from{};                       // of a patch: the triangle's corners in the picture
};

constexpr Corners patchCorners{ Place{ 0.5, 0.5 }, Place{ patchSide - 0.5, 0.5 },
  Place{ 0.5, patchSide - 0.5 } };
constexpr TexelBox patchBox{ { 0, 0 }, { patchSide, patchSide } };

// For each texel of a chart and its gutter: the triangle whose tint it gets.
class Claims
{
public:
  explicit Claims(const TexelBox& chart)
    : Box(WithGutter(chart))
    , Owners(static_cast<std::size_t>(CostOf(chart)), unclaimed)
  {
  }

  std::uint32_t& At(std::int64_t x, std::int64_t y)
  {
    return this->Owners[static_cast<std::size_t>(
      (y - this->Box.lo[1]) * this->Box.Width() + x - this->Box.lo[0])];
  }
  const TexelBox& Texels() const { return this->Box; }

  // Texels beside claimed ones are claimed, too: those of the gutter, which filters read.
  void Grow()
  {
    std::vector<std::pair<std::size_t, std::uint32_t>> grown;
    for (std::int64_t round = 0; round <= gutter; ++round)
    {
      grown.clear();
      for (std::size_t i = 0; i < this->Owners.size(); ++i)
      {
        if (this->Owners[i] == unclaimed && this->Beside(i) != unclaimed)
        {
          grown.emplace_back(i, this->Beside(i));
        }
      }
      for (const auto& [texel, owner] : grown)
      {
        this->Owners[texel] = owner;
      }
    }
  }

private:
  // The lowest owner of the texels around.
  std::uint32_t Beside(std::size_t texel) const
  {
    const auto width = static_cast<std::size_t>(this->Box.Width());
    const std::size_t column = texel % width, row = texel / width;
    const std::size_t rows = this->Owners.size() / width;
    std::uint32_t owner = unclaimed;
    for (std::size_t y = row - std::min<std::size_t>(row, 1); y < std::min(row + 2, rows); ++y)
    {
      for (std::size_t x = column - std::min<std::size_t>(column, 1);
           x < std::min(column + 2, width); ++x)
      {
        owner = std::min(owner, this->Owners[y * width + x]);
      }
    }
    return owner;
  }

  const TexelBox Box;
  std::vector<std::uint32_t> Owners;
};

class PictureTinter
{
public:
  PictureTinter(TexturedMesh& textured, std::span<const Color> tints, const TextureFolder& source,
    TextureFolderWriter& folder, const Execution& execution)
    : Textured(textured)
    , Tints(InRange(tints))
    , Source(source)
    , Folder(folder)
    , Run(execution)
    , Materials(textured.materials)
    , MaterialOf(textured.materialOf)
    , PictureCorners(textured.corners)
  {
    for (std::uint32_t i = 0; i < source.Content().pictures; ++i)
    {
      const auto [width, height] = source.SizeOf(i);
      this->MostTexels += mostTimesPictures * double(width) * double(height);
    }
  }

  Result<bool> Tint()
  {
    this->TintWholeTriangles();
    if (!this->FindCharts() || this->TexelsOfCharts() > this->MostTexels ||
        this->Materials.size() > mostMaterials)
    {
      return false;
    }
    for (std::size_t first = 0; first < this->Charts.size();)
    {
      KDSTREAM_TRY(this->Run.Report("textures", double(first) / double(this->Charts.size())));
      Result<std::size_t> end = this->MakePage(first);
      KDSTREAM_TRY(end);
      first = *end;
    }
    this->Textured.materials = std::move(this->Materials);
    this->Textured.materialOf = std::move(this->MaterialOf);
    this->Textured.corners = std::move(this->PictureCorners);
    return true;
  }

private:
  static std::vector<Color> InRange(std::span<const Color> tints)
  {
    std::vector<Color> clamped(tints.begin(), tints.end());
    for (Color& tint : clamped)
    {
      std::for_each(tint.begin(), tint.end(),
        [](double& part) { part = part > 0 ? std::min(part, 1.0) : 0; }); // NaN gives 0
    }
    return clamped;
  }

  const Triangle& TriangleAt(std::size_t triangle) const
  {
    return this->Textured.mesh.triangles[triangle];
  }

  Color TintOf(const Triangle& t, const std::array<double, 3>& weights) const
  {
    Color tint{};
    for (std::size_t c = 0; c < tint.size(); ++c)
    {
      for (std::size_t k = 0; k < 3; ++k)
      {
        tint[c] += weights[k] * this->Tints[t[k]][c];
      }
    }
    return tint;
  }

  // The tint of a varying triangle at the centre of a texel.
  Color TintAt(std::uint32_t number, std::int64_t x, std::int64_t y) const
  {
    return this->TintOf(this->Triangles[number], WithinTriangle(this->Texels[number], x, y));
  }

  // ---- 1. one tint

  void TintWholeTriangles()
  {
    for (std::uint32_t i = 0; i < this->Textured.mesh.triangles.size(); ++i)
    {
      const Triangle& t = this->TriangleAt(i);
      const Color& tint = this->Tints[t[0]];
      const bool isOne = tint == this->Tints[t[1]] && tint == this->Tints[t[2]];
      if (!isOne || !this->TintWhole(i, tint, mostExactTints))
      {
        this->Varying.push_back(i);
      }
    }
  }

  // Gives a triangle its material times the tint. False if there would be more than `most` such
  // materials.
  bool TintWhole(std::uint32_t triangle, const Color& tint, std::size_t most)
  {
    if (tint == Color{ 1, 1, 1, 1 })
    {
      return true;
    }
    const std::uint32_t own = this->Textured.materialOf[triangle];
    const std::pair key{ own, tint };
    const auto found = this->Whole.find(key);
    if (found == this->Whole.end() && this->Whole.size() >= most)
    {
      return false;
    }
    const auto number = static_cast<std::uint32_t>(this->Materials.size());
    const auto [entry, isNew] = this->Whole.try_emplace(key, number);
    if (isNew)
    {
      TexturedMaterial& material = this->Materials.emplace_back(this->Textured.materials[own]);
      for (std::size_t c = 0; c < tint.size(); ++c)
      {
        material.color[c] *= tint[c];
        material.factor[c] *= tint[c];
      }
    }
    this->MaterialOf[triangle] = entry->second;
    return true;
  }

  // For a triangle that no chart can have: the mean of its corners, in steps, so that such
  // triangles share materials.
  void TintByMean(std::uint32_t triangle)
  {
    Color tint = this->TintOf(this->TriangleAt(triangle), { 1.0 / 3, 1.0 / 3, 1.0 / 3 });
    std::for_each(tint.begin(), tint.end(),
      [](double& value) { value = std::round(value * roundedTint) / roundedTint; });
    this->TintWhole(triangle, tint, mostMaterials + 1);
  }

  // ---- 2. charts

  // False if triangles cover too many texels to look at.
  bool FindCharts()
  {
    TexturedTriangles varying;
    for (const std::uint32_t triangle : this->Varying)
    {
      this->Triangles.push_back(this->TriangleAt(triangle));
      varying.corners.push_back(this->Textured.corners[triangle]);
      varying.materialOf.push_back(this->Textured.materialOf[triangle]);
    }
    varying.triangles = this->Triangles;
    const TextureSet textures{ this->Textured.materials, this->Source.Content().pictures };
    const TileCharts found = FindTileCharts(varying, textures, this->Source, {});
    this->Texels = found.texels;
    std::vector<TintedChart> charts(found.boxes.size());
    double visits = 0;
    for (std::uint32_t i = 0; i < this->Varying.size(); ++i)
    {
      const TriangleChart& chart = found.ofTriangle[i];
      if (chart.box == noChartBox)
      {
        this->AddUntextured(i, chart.why);
        continue;
      }
      for (Place& at : this->Texels[i])
      {
        at = { at[0] - double(chart.shift[0]), at[1] - double(chart.shift[1]) };
      }
      visits += double(CostOf(BoxOf(this->Texels[i])));
      const ChartBox& box = found.boxes[chart.box];
      charts[chart.box].material = box.material;
      charts[chart.box].box = box.box;
      charts[chart.box].triangles.push_back(i);
    }
    if (visits > mostVisits * this->MostTexels)
    {
      return false;
    }
    for (TintedChart& chart : charts)
    {
      this->AddChart(std::move(chart));
    }
    return true;
  }

  void AddUntextured(std::uint32_t number, Untextured why)
  {
    if (why != Untextured::NoPicture && why != Untextured::NoCoordinates)
    {
      this->TintByMean(this->Varying[number]); // is shown in the picture's mean colour
      return;
    }
    this->AddPatch(number, ChartKind::Plain);
  }

  void AddPatch(std::uint32_t number, ChartKind kind)
  {
    const std::uint32_t material = this->Textured.materialOf[this->Varying[number]];
    this->Charts.push_back({ material, kind, patchBox, { number }, this->Texels[number] });
    this->Texels[number] = patchCorners;
  }

  // Whether a triangle has too few texels to show how its tint changes.
  bool NeedsPatch(std::uint32_t number) const
  {
    const TexelBox box = BoxOf(this->Texels[number]);
    if (std::max(box.Width(), box.Height()) > patchSide)
    {
      return false;
    }
    const Triangle& t = this->Triangles[number];
    for (std::size_t c = 0; c < 3; ++c)
    {
      const auto [least, most] =
        std::minmax({ this->Tints[t[0]][c], this->Tints[t[1]][c], this->Tints[t[2]][c] });
      if (FromLinear(most) - FromLinear(least) > steepTint)
      {
        return true;
      }
    }
    return false;
  }

  // Adds a chart, without the triangles that need other tints for texels of earlier ones. Those,
  // and the triangles of a chart that is too long, become charts of their own.
  void AddChart(TintedChart chart)
  {
    std::vector<std::uint32_t> apart;
    std::erase_if(chart.triangles,
      [&](std::uint32_t i)
      {
        const bool isPatch = this->NeedsPatch(i);
        if (isPatch)
        {
          this->AddPatch(i, ChartKind::Patch);
        }
        return isPatch;
      });
    if (IsTooLong(chart.box))
    {
      std::swap(apart, chart.triangles);
    }
    else if (chart.triangles.size() > 1)
    {
      Claims claims(chart.box);
      apart = this->Claim(chart.triangles, claims);
      std::erase_if(chart.triangles,
        [&](std::uint32_t i) { return std::binary_search(apart.begin(), apart.end(), i); });
    }
    const std::uint32_t material = chart.material;
    if (!chart.triangles.empty())
    {
      this->Charts.push_back(std::move(chart));
    }
    for (const std::uint32_t i : apart)
    {
      const TexelBox box = BoxOf(this->Texels[i]);
      if (IsTooLong(box))
      {
        this->TintByMean(this->Varying[i]);
        continue;
      }
      this->Charts.push_back({ material, ChartKind::Copied, box, { i }, {} });
    }
  }

  static bool IsTooLong(const TexelBox& box)
  {
    return box.Width() > longestChart || box.Height() > longestChart;
  }

  // Each triangle claims its texels, if their owners so far give them nearly the same tint. Returns
  // those triangles that could not.
  std::vector<std::uint32_t> Claim(const std::vector<std::uint32_t>& triangles, Claims& claims)
  {
    std::vector<std::uint32_t> apart;
    for (const std::uint32_t i : triangles)
    {
      const bool fits = VisitTexels(this->Texels[i],
        [&](std::int64_t x, std::int64_t y)
        {
          const std::uint32_t owner = claims.At(x, y);
          return owner == unclaimed || IsNear(this->TintAt(owner, x, y), this->TintAt(i, x, y));
        });
      if (!fits)
      {
        apart.push_back(i);
        continue;
      }
      VisitTexels(this->Texels[i],
        [&](std::int64_t x, std::int64_t y)
        {
          std::uint32_t& owner = claims.At(x, y);
          owner = std::min(owner, i);
          return true;
        });
    }
    return apart;
  }

  static bool IsNear(const Color& a, const Color& b)
  {
    return std::equal(a.begin(), a.end(), b.begin(),
      [](double x, double y) { return std::abs(x - y) <= sameTint; });
  }

  double TexelsOfCharts() const
  {
    double texels = 0;
    for (const TintedChart& chart : this->Charts)
    {
      texels += double(CostOf(chart.box));
    }
    return texels;
  }

  // ---- 4. pages

  // Makes a picture of charts from `first` on. Returns the first chart that is not on it.
  Result<std::size_t> MakePage(std::size_t first)
  {
    std::size_t end = first;
    std::vector<std::array<std::int64_t, 2>> sizes;
    for (std::int64_t texels = 0; end < this->Charts.size(); ++end)
    {
      const TexelBox box = WithGutter(this->Charts[end].box);
      texels += box.Width() * box.Height();
      if (end > first && texels > texelsOfPage)
      {
        break;
      }
      sizes.push_back({ box.Width(), box.Height() });
    }
    std::optional<PackedBoxes> packed = PackBoxes(sizes, longestPage);
    for (; !packed; packed = PackBoxes(sizes, longestPage)) // one chart always fits
    {
      sizes.resize((sizes.size() + 1) / 2);
    }
    Picture page{ static_cast<std::size_t>(packed->width), static_cast<std::size_t>(packed->height),
      4, {} };
    page.texels.resize(4 * page.width * page.height);
    std::vector<Status> copied(sizes.size());
    this->Run.parallelFor(sizes.size(), 1,
      [&](std::size_t begin, std::size_t stop)
      {
        for (std::size_t i = begin; i < stop; ++i)
        {
          copied[i] = this->Copy(this->Charts[first + i], packed->places[i], page);
        }
      });
    for (const Status& status : copied)
    {
      KDSTREAM_TRY(status);
    }
    const Result<std::uint32_t> number = this->Folder.AddTexels(page);
    KDSTREAM_TRY(number);
    for (std::size_t i = 0; i < sizes.size(); ++i)
    {
      this->PlaceCorners(this->Charts[first + i], packed->places[i], page, *number);
    }
    return first + sizes.size();
  }

  // The texels of a chart and its gutter, before they are multiplied.
  Result<std::vector<std::uint8_t>> TexelsOf(const TintedChart& chart, const TexelBox& box) const
  {
    const TexturedMaterial& material = this->Textured.materials[chart.material];
    if (chart.kind == ChartKind::Copied)
    {
      return ReadWrapped(this->Source, material.picture, box, material.wrapU, material.wrapV);
    }
    std::vector<std::uint8_t> texels(static_cast<std::size_t>(4 * box.Width() * box.Height()), 255);
    if (chart.kind == ChartKind::Patch)
    {
      KDSTREAM_TRY(this->Magnify(chart, box, texels.data()));
    }
    return texels;
  }

  // Fills a patch with the nearest texels of the picture.
  Status Magnify(const TintedChart& chart, const TexelBox& patch, std::uint8_t* to) const
  {
    const TexturedMaterial& material = this->Textured.materials[chart.material];
    const TexelBox box = WithGutter(BoxOf(chart.from));
    const Result<std::vector<std::uint8_t>> texels =
      ReadWrapped(this->Source, material.picture, box, material.wrapU, material.wrapV);
    KDSTREAM_TRY(texels);
    for (std::int64_t y = patch.lo[1]; y < patch.hi[1]; ++y)
    {
      for (std::int64_t x = patch.lo[0]; x < patch.hi[0]; ++x, to += 4)
      {
        const auto weights = WithinTriangle(patchCorners, x, y);
        const auto at = [&](std::size_t i)
        {
          const double mixed = weights[0] * chart.from[0][i] + weights[1] * chart.from[1][i] +
                               weights[2] * chart.from[2][i];
          return static_cast<std::int64_t>(std::floor(mixed)) - box.lo[i];
        };
        std::copy_n(&(*texels)[static_cast<std::size_t>(4 * (at(1) * box.Width() + at(0)))], 4, to);
      }
    }
    return {};
  }

  // Copies the texels of a chart, times its material and tints, to a place on the page.
  Status Copy(const TintedChart& chart, const std::array<std::int64_t, 2>& place, Picture& page)
  {
    Claims claims(chart.box);
    this->Claim(chart.triangles, claims);
    claims.Grow();
    const TexelBox& box = claims.Texels();
    const Result<std::vector<std::uint8_t>> texels = this->TexelsOf(chart, box);
    KDSTREAM_TRY(texels);
    const TexturedMaterial& material = this->Textured.materials[chart.material];
    const Color& light = chart.kind == ChartKind::Plain ? material.color : material.factor;
    const std::array<double, 256>& linear = LinearOfBytes();
    const std::uint8_t* from = texels->data();
    for (std::int64_t y = box.lo[1]; y < box.hi[1]; ++y)
    {
      const std::int64_t row = place[1] + y - box.lo[1];
      std::uint8_t* to = &page.texels[static_cast<std::size_t>(
        4 * (row * static_cast<std::int64_t>(page.width) + place[0]))];
      for (std::int64_t x = box.lo[0]; x < box.hi[0]; ++x, from += 4, to += 4)
      {
        const std::uint32_t owner = claims.At(x, y);
        const Color tint = owner == unclaimed ? Color{ 1, 1, 1, 1 } : this->TintAt(owner, x, y);
        for (std::size_t c = 0; c < 3; ++c)
        {
          to[c] = ByteOfLinear(linear[from[c]] * light[c] * tint[c]);
        }
        to[3] = static_cast<std::uint8_t>(from[3] * std::clamp(light[3] * tint[3], 0.0, 1.0) + 0.5);
      }
    }
    return {};
  }

  void PlaceCorners(const TintedChart& chart, const std::array<std::int64_t, 2>& place,
    const Picture& page, std::uint32_t picture)
  {
    const bool opaque = this->Textured.materials[chart.material].opaque;
    const auto number = static_cast<std::uint32_t>(this->Materials.size());
    const auto [entry, isNew] = this->OfPages.try_emplace({ picture, opaque }, number);
    if (isNew)
    {
      TexturedMaterial& material = this->Materials.emplace_back();
      material.picture = picture;
      material.wrapU = material.wrapV = TextureWrap::Clamp;
      material.opaque = opaque;
    }
    const TexelBox box = WithGutter(chart.box);
    for (const std::uint32_t i : chart.triangles)
    {
      this->MaterialOf[this->Varying[i]] = entry->second;
      for (std::size_t k = 0; k < 3; ++k)
      {
        const Place& at = this->Texels[i][k];
        this->PictureCorners[this->Varying[i]][k] = {
          static_cast<float>((at[0] - double(box.lo[0] - place[0])) / double(page.width)),
          static_cast<float>((at[1] - double(box.lo[1] - place[1])) / double(page.height))
        };
      }
    }
  }

  TexturedMesh& Textured;
  const std::vector<Color> Tints;
  const TextureFolder& Source;
  TextureFolderWriter& Folder;
  const Execution& Run;
  double MostTexels = fewTexels;
  // What the mesh gets in the end.
  std::vector<TexturedMaterial> Materials;
  std::vector<std::uint32_t> MaterialOf;
  std::vector<std::array<PictureCoordinate, 3>> PictureCorners;

  std::map<std::pair<std::uint32_t, Color>, std::uint32_t> Whole;  // by material and tint
  std::map<std::pair<std::uint32_t, bool>, std::uint32_t> OfPages; // by picture, opaque or not
  std::vector<std::uint32_t> Varying; // triangles whose corners have different tints
  std::vector<Triangle> Triangles;    // those
  std::vector<Corners> Texels;        // where their corners are, in texels, as in the chart's box
  std::vector<TintedChart> Charts;
};

}

Result<bool> TintPictures(TexturedMesh& textured, std::span<const Color> tints,
  const TextureFolder& source, TextureFolderWriter& folder, const Execution& execution)
{
  return PictureTinter(textured, tints, source, folder, execution).Tint();
}

}
