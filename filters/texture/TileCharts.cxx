// SPDX-License-Identifier: BSD-3-Clause
#include "filters/texture/TileCharts.h"

#include "filters/core/BitCast.h"
#include "filters/core/DisjointSets.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

namespace kdstream
{
namespace
{

constexpr std::int64_t mostRepeats = 2; // of a picture, along a side of a chart
constexpr std::size_t neighboursOfBox = 64, mostRounds = 8;

// A side of a triangle: its two vertices, the lower one in the upper half of the number, and the
// corner of the triangle at which it begins.
struct Side
{
  std::uint64_t vertices;
  std::uint32_t triangle;
  std::uint32_t corner;
  bool operator<(const Side& other) const { return this->vertices < other.vertices; }
};

// The values that must agree for two sides of the same vertices, so that their triangles are in one
// chart.
struct SideTexture
{
  std::uint32_t material;
  std::array<std::uint64_t, 2> corners; // coordinates' bits at both vertices
  std::uint32_t triangle;
  auto Key() const { return std::tie(this->material, this->corners); }
};

class ChartFinder
{
public:
  ChartFinder(const TexturedTriangles& textured, const TextureSet& textures,
    const TexelSource& source, std::optional<std::int64_t> gutter)
    : Textured(textured)
    , Textures(textures)
    , Source(source)
    , Gutter(gutter)
  {
  }

  TileCharts Find()
  {
    this->PlaceTriangles();
    this->JoinSides();
    this->MakeBoxes();
    if (this->Gutter)
    {
      this->MergeBoxes();
    }
    return std::move(this->Charts);
  }

private:
  const TexturedMaterial& MaterialOf(std::size_t t) const
  {
    return this->Textures.materials[this->Textured.materialOf[t]];
  }

  std::array<std::uint32_t, 2> SizeOf(const TexturedMaterial& material) const
  {
    return material.picture < this->Textures.pictures ? this->Source.SizeOf(material.picture)
                                                      : std::array<std::uint32_t, 2>{};
  }

  // Computes where corners are, and which triangles show no picture.
  void PlaceTriangles()
  {
    const std::size_t count = this->Textured.triangles.size();
    this->Charts.ofTriangle.resize(count);
    this->Charts.texels.resize(count);
    for (std::size_t t = 0; t < count; ++t)
    {
      const TexturedMaterial& material = this->MaterialOf(t);
      const auto size = this->SizeOf(material);
      Untextured why = size[0] == 0 ? Untextured::NoPicture : Untextured::No;
      for (std::size_t k = 0; k < 3 && why == Untextured::No; ++k)
      {
        const PictureCoordinate& corner = this->Textured.corners[t][k];
        const auto along = [&](const std::array<double, 3>& row, double side)
        { return (row[0] * double(corner[0]) + row[1] * double(corner[1]) + row[2]) * side; };
        auto& at = this->Charts.texels[t][k];
        at = { along(material.transform.u, size[0]), along(material.transform.v, size[1]) };
        const bool placed = std::abs(at[0]) < mostChartTexels && std::abs(at[1]) < mostChartTexels;
        why = placed                                         ? Untextured::No
              : std::isfinite(at[0]) && std::isfinite(at[1]) ? Untextured::TooFar
                                                             : Untextured::NoCoordinates;
      }
      this->Charts.ofTriangle[t].why = why;
    }
  }

  bool IsTextured(std::size_t t) const { return this->Charts.ofTriangle[t].why == Untextured::No; }

  void JoinSides()
  {
    std::vector<Side> sides;
    const std::span<const Triangle> triangles = this->Textured.triangles;
    sides.reserve(3 * triangles.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
    {
      for (std::uint32_t k = 0; k < 3 && this->IsTextured(t); ++k)
      {
        const auto [low, high] = std::minmax(triangles[t][k], triangles[t][(k + 1) % 3]);
        sides.push_back({ (std::uint64_t{ low } << 32U) | high, t, k });
      }
    }
    std::sort(sides.begin(), sides.end());
    this->ChartOf.resize(triangles.size());
    std::iota(this->ChartOf.begin(), this->ChartOf.end(), VertexId{ 0 });
    std::vector<SideTexture> alike;
    for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end)
    {
      alike.clear();
      for (; end < sides.size() && sides[end].vertices == sides[begin].vertices; ++end)
      {
        alike.push_back(this->TextureOf(sides[end]));
      }
      this->JoinAlike(alike);
    }
    for (VertexId& chart : this->ChartOf)
    {
      chart = FindRoot(this->ChartOf, chart);
    }
  }

  SideTexture TextureOf(const Side& side) const
  {
    const std::uint32_t t = side.triangle;
    std::size_t a = side.corner, b = (a + 1) % 3;
    if (this->Textured.triangles[t][b] < this->Textured.triangles[t][a])
    {
      std::swap(a, b);
    }
    const auto& corners = this->Textured.corners[t];
    return { this->Textured.materialOf[t],
      { BitCast<std::uint64_t>(corners[a]), BitCast<std::uint64_t>(corners[b]) }, t };
  }

  // Joins triangles whose sides have the same vertices and the same texture.
  void JoinAlike(std::vector<SideTexture>& sides)
  {
    std::sort(sides.begin(), sides.end(),
      [](const SideTexture& a, const SideTexture& b) { return a.Key() < b.Key(); });
    for (std::size_t i = 1; i < sides.size(); ++i)
    {
      if (sides[i].Key() == sides[i - 1].Key())
      {
        Join(this->ChartOf, sides[i].triangle, sides[i - 1].triangle);
      }
    }
  }

  static TexelBox Union(const TexelBox& a, const TexelBox& b)
  {
    return { { std::min(a.lo[0], b.lo[0]), std::min(a.lo[1], b.lo[1]) },
      { std::max(a.hi[0], b.hi[0]), std::max(a.hi[1], b.hi[1]) } };
  }

  bool RepeatsTooOften(const TexelBox& box, const TexturedMaterial& material) const
  {
    const auto size = this->SizeOf(material);
    return box.Width() > mostRepeats * size[0] + 1 || box.Height() > mostRepeats * size[1] + 1;
  }

  // Makes a box for each chart, in the order of their first triangles.
  void MakeBoxes()
  {
    const std::size_t count = this->ChartOf.size();
    std::vector<TexelBox> charts(count); // by the chart's number; empty: no texel so far
    for (std::size_t t = 0; t < count; ++t)
    {
      if (this->IsTextured(t))
      {
        TexelBox& chart = charts[this->ChartOf[t]];
        chart = chart.Width() == 0 ? BoxOf(this->Charts.texels[t])
                                   : Union(chart, BoxOf(this->Charts.texels[t]));
      }
    }
    std::vector<std::uint32_t> boxOf(count, noChartBox); // the box of each chart
    for (std::size_t t = 0; t < count; ++t)
    {
      if (!this->IsTextured(t))
      {
        continue;
      }
      const std::uint32_t chart = this->ChartOf[t];
      if (this->RepeatsTooOften(charts[chart], this->MaterialOf(t)))
      {
        this->AddTriangle(t);
        continue;
      }
      if (boxOf[chart] == noChartBox)
      {
        boxOf[chart] = this->AddBox(t, charts[chart]);
      }
      this->Charts.ofTriangle[t].box = boxOf[chart];
      this->Charts.ofTriangle[t].shift = this->ShiftOf(charts[chart], this->MaterialOf(t));
    }
  }

  // Adds a triangle of a chart that is split.
  void AddTriangle(std::size_t t)
  {
    const TexelBox box = BoxOf(this->Charts.texels[t]);
    TriangleChart& chart = this->Charts.ofTriangle[t];
    if (this->RepeatsTooOften(box, this->MaterialOf(t)))
    {
      chart.why = Untextured::Repeats;
      return;
    }
    chart.box = this->AddBox(t, box);
    chart.shift = this->ShiftOf(box, this->MaterialOf(t));
  }

  std::uint32_t AddBox(std::size_t t, const TexelBox& box)
  {
    const auto shift = this->ShiftOf(box, this->MaterialOf(t));
    this->Charts.boxes.push_back(
      { this->Textured.materialOf[t], { { box.lo[0] - shift[0], box.lo[1] - shift[1] },
                                        { box.hi[0] - shift[0], box.hi[1] - shift[1] } } });
    return static_cast<std::uint32_t>(this->Charts.boxes.size() - 1);
  }

  // The shift by whole periods that moves the beginning of the box into the first period.
  std::array<std::int64_t, 2> ShiftOf(const TexelBox& box, const TexturedMaterial& material) const
  {
    const auto size = this->SizeOf(material);
    const auto shift = [](std::int64_t begin, std::int64_t side, TextureWrap wrap)
    {
      if (wrap == TextureWrap::Clamp)
      {
        return std::int64_t{ 0 };
      }
      const std::int64_t period = wrap == TextureWrap::Mirror ? 2 * side : side;
      return (begin / period - (begin % period < 0 ? 1 : 0)) * period;
    };
    return { shift(box.lo[0], size[0], material.wrapU), shift(box.lo[1], size[1], material.wrapV) };
  }

  std::int64_t Cost(const TexelBox& box) const
  {
    return (box.Width() + 2 * *this->Gutter) * (box.Height() + 2 * *this->Gutter);
  }

  void MergeBoxes()
  {
    std::vector<ChartBox>& boxes = this->Charts.boxes;
    std::vector<std::uint32_t> into(boxes.size()); // the box into which each was merged
    std::iota(into.begin(), into.end(), 0U);
    std::vector<std::uint32_t> order = into; // boxes that are left
    bool merged = true;
    for (std::size_t round = 0; merged && round < mostRounds; ++round)
    {
      merged = this->MergeRound(order, into, round % 2);
    }
    std::sort(order.begin(), order.end());
    std::vector<std::uint32_t> number(boxes.size());
    std::vector<ChartBox> left;
    for (const std::uint32_t box : order)
    {
      number[box] = static_cast<std::uint32_t>(left.size());
      left.push_back(boxes[box]);
    }
    for (TriangleChart& chart : this->Charts.ofTriangle)
    {
      while (chart.box != noChartBox && into[chart.box] != chart.box)
      {
        chart.box = into[chart.box];
      }
      chart.box = chart.box == noChartBox ? noChartBox : number[chart.box];
    }
    boxes = std::move(left);
  }

  // Compares each box with a few boxes that begin after it along an axis. False if nothing was
  // merged.
  bool MergeRound(
    std::vector<std::uint32_t>& order, std::vector<std::uint32_t>& into, std::size_t axis)
  {
    std::vector<ChartBox>& boxes = this->Charts.boxes;
    const auto key = [&](std::uint32_t i)
    { return std::tuple(boxes[i].material, boxes[i].box.lo[axis], boxes[i].box.lo[1 - axis], i); };
    std::sort(order.begin(), order.end(),
      [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
    bool merged = false;
    for (std::size_t i = 0; i < order.size(); ++i)
    {
      ChartBox& box = boxes[order[i]];
      const std::size_t end = std::min(order.size(), i + neighboursOfBox);
      for (std::size_t j = i + 1; j < end && into[order[i]] == order[i]; ++j)
      {
        ChartBox& other = boxes[order[j]];
        if (other.material != box.material || into[order[j]] != order[j])
        {
          continue;
        }
        const TexelBox both = Union(box.box, other.box);
        if (this->Cost(both) <= this->Cost(box.box) + this->Cost(other.box))
        {
          box.box = both;
          into[order[j]] = order[i];
          merged = true;
        }
      }
    }
    std::erase_if(order, [&](std::uint32_t i) { return into[i] != i; });
    return merged;
  }

  const TexturedTriangles& Textured;
  const TextureSet& Textures;
  const TexelSource& Source;
  const std::optional<std::int64_t> Gutter;
  TileCharts Charts;
  std::vector<VertexId> ChartOf; // of each triangle, before boxes: lowest triangle of its chart
};

}

TexelBox BoxOf(const TexelCorners& at)
{
  TexelBox box;
  for (std::size_t i = 0; i < 2; ++i)
  {
    const auto [least, most] = std::minmax({ at[0][i], at[1][i], at[2][i] });
    box.lo[i] = static_cast<std::int64_t>(std::floor(least));
    box.hi[i] = std::max(static_cast<std::int64_t>(std::ceil(most)), box.lo[i] + 1);
  }
  return box;
}

std::vector<std::uint32_t> NumberShownPictures(const TextureSet& textures)
{
  std::vector<std::uint32_t> numbers;
  std::map<std::tuple<std::uint32_t, Color, bool>, std::uint32_t> known;
  std::vector<bool> taken(textures.pictures); // a material has the picture's own number
  auto next = static_cast<std::uint32_t>(textures.pictures);
  for (const TexturedMaterial& material : textures.materials)
  {
    if (material.picture >= textures.pictures)
    {
      numbers.push_back(noPicture);
      continue;
    }
    Color factor = material.factor;
    factor[3] = material.opaque ? 1 : factor[3];
    const auto [entry, isNew] = known.try_emplace({ material.picture, factor, material.opaque }, 0);
    if (isNew)
    {
      entry->second = taken[material.picture] ? next++ : material.picture;
      taken[material.picture] = true;
    }
    numbers.push_back(entry->second);
  }
  return numbers;
}

TileCharts FindTileCharts(const TexturedTriangles& textured, const TextureSet& textures,
  const TexelSource& source, std::optional<std::int64_t> gutter)
{
  return ChartFinder(textured, textures, source, gutter).Find();
}

}
