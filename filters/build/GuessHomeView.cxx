// SPDX-License-Identifier: BSD-3-Clause
#include "filters/build/GuessHomeView.h"

#include "filters/codec/PieceCodec.h"
#include "filters/core/VectorMath.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <utility>
#include <vector>

namespace kdstream
{
namespace
{

constexpr double flatPart = 0.2;      // flat: shorter than this part of the next longer side
constexpr double slabPart = 0.02;     // of the diagonal: a point this near to the floor touches it
constexpr double leastLead = 0.1;     // of the best axis over the next one
constexpr double unequalEnds = 0.5;   // weight of asymmetry between the ends of an axis
constexpr double detailAhead = 0.3;   // bonus for y if all detail is towards +z
constexpr double unlikelyAxis = 0.1;  // penalty for x, which is up in few files
constexpr double usualAxis = 0.1;     // bonus for y in formats in which y is usually up
constexpr double upsideDown = 0.3;    // the upper end is the floor if its support is larger by this
constexpr double widerSide = 1.2;     // times the other: then this side is seen
constexpr double longBody = 1.6;      // times its width: a longer body is seen from the side
constexpr double mirrored = 0.9;      // of the surface: then the shape is symmetric
constexpr double moreMirrored = 0.05; // than across the other horizontal axis
constexpr double mostMirrorSamples = 4e5;
constexpr int mirrorCells = 32;           // along the longest side
constexpr double moreRelief = 1.5;        // of the back: then it is taken for the front
constexpr double moreReliefOfFront = 1.2; // if left and right are mirror images
constexpr double lowPart = 0.5;           // of the narrower side: a lower shape is seen from above
constexpr double sineOfThirty = 0.5;
constexpr double facingCosine = 0.3;
constexpr double oneSided = 0.8; // of the area: facing one way more than the opposite way

using Point2 = std::array<double, 2>;

double CrossOf(const Point2& o, const Point2& a, const Point2& b)
{
  return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
}

// Anticlockwise, without points on its sides (Andrew's monotone chain, 1979).
std::vector<Point2> ConvexHull(std::vector<Point2> points)
{
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3)
  {
    return {};
  }
  std::vector<Point2> hull;
  const auto addAll = [&](auto begin, auto end)
  {
    const std::size_t before = hull.size();
    for (auto point = begin; point != end; ++point)
    {
      while (hull.size() >= before + 2 && CrossOf(hull[hull.size() - 2], hull.back(), *point) <= 0)
      {
        hull.pop_back();
      }
      hull.push_back(*point);
    }
    hull.pop_back(); // the other half of the hull begins with this point
  };
  addAll(points.begin(), points.end());
  addAll(points.rbegin(), points.rend());
  return hull;
}

double AreaOf(const std::vector<Point2>& hull)
{
  double doubled = 0;
  for (std::size_t i = 2; i < hull.size(); ++i)
  {
    doubled += CrossOf(hull[0], hull[i - 1], hull[i]);
  }
  return doubled / 2;
}

bool IsWithin(const std::vector<Point2>& hull, const Point2& point)
{
  for (std::size_t i = 0; i < hull.size(); ++i)
  {
    if (CrossOf(hull[i], hull[(i + 1) % hull.size()], point) < 0)
    {
      return false;
    }
  }
  return !hull.empty();
}

struct Axis
{
  std::size_t index = 1;
  double sign = 1;
  Vec3 Direction() const
  {
    Vec3 direction{};
    direction[this->index] = this->sign;
    return direction;
  }
};

class Shape
{
public:
  Shape(std::span<const Vec3> points, std::span<const Triangle> triangles)
    : Points(points)
    , Triangles(triangles)
  {
    for (const Vec3& point : points)
    {
      this->Around.Add(point);
    }
    for (std::size_t k = 0; k < 3 && !points.empty(); ++k)
    {
      this->Sides[k] = this->Around.hi[k] - this->Around.lo[k];
    }
    this->Middle = this->MiddleOfSurface();
  }

  double Side(std::size_t axis) const { return this->Sides[axis]; }
  bool HasSurface() const { return !this->Triangles.empty() && this->LongestSide() > 0; }
  double LongestSide() const { return *std::max_element(this->Sides.begin(), this->Sides.end()); }

  // The axis along which the shape is flat, if that is y or z.
  std::optional<Axis> Flat() const
  {
    std::array<std::size_t, 3> order{ 0, 1, 2 };
    std::sort(order.begin(), order.end(),
      [this](std::size_t a, std::size_t b) { return this->Sides[a] < this->Sides[b]; });
    const bool isFlat = this->Sides[order[0]] < flatPart * this->Sides[order[1]];
    return isFlat && order[0] != 0 ? std::optional<Axis>({ order[0], 1 }) : std::nullopt;
  }

  // Whether the shape is flat along y and nearly all of it faces -y: then it is a wall, and z is
  // up.
  bool IsWall() const
  {
    const std::optional<Axis> flat = this->Flat();
    double towards = 0, all = 0;
    for (const Triangle& t : this->Triangles)
    {
      const Vec3 normal = this->DoubledNormal(t);
      towards -= normal[1];
      all += Length(normal);
    }
    return flat && flat->index == 1 && towards > oneSided * all;
  }

  // If the shape stood with this axis up: the part of the floor that the points touching it span,
  // 0-1. 0 if it would fall over.
  double StandsWith(const Axis& up) const
  {
    const std::size_t a = (up.index + 1) % 3, b = (up.index + 2) % 3;
    const double floor = this->Sides[a] * this->Sides[b];
    const std::vector<Point2> touching = this->TouchedAt(up.index, up.sign > 0);
    const bool stands = floor > 0 && IsWithin(touching, { this->Middle[a], this->Middle[b] });
    return stands ? AreaOf(touching) / floor : 0;
  }

  // The part of the surface, 0-1, that is within a cell of the surface's mirror image across this
  // axis. The mirror is in the middle of the box or of the surface, whichever fits better. 0
  // without a surface.
  double MirroredAcross(std::size_t axis) const;

  // Relief of the triangles that face this direction: the bends of edges times their lengths, by
  // area.
  double ReliefTowards(const Vec3& direction) const;

private:
  Vec3 MiddleOfSurface() const
  {
    Vec3 sum{};
    double weights = 0;
    const auto add = [&](const Vec3& point, double weight)
    {
      sum = Plus(sum, Times(Minus(point, this->Around.lo), weight));
      weights += weight;
    };
    for (const Triangle& t : this->Triangles)
    {
      const double area = Length(this->DoubledNormal(t));
      for (const VertexId corner : t)
      {
        add(this->Points[corner], area);
      }
    }
    if (!(weights > 0))
    {
      std::for_each(
        this->Points.begin(), this->Points.end(), [&](const Vec3& point) { add(point, 1); });
    }
    return weights > 0 ? Plus(this->Around.lo, Times(sum, 1 / weights)) : Vec3{};
  }

  Vec3 DoubledNormal(const Triangle& t) const
  {
    const Vec3& a = this->Points[t[0]];
    return Cross(Minus(this->Points[t[1]], a), Minus(this->Points[t[2]], a));
  }

  // The hull of the points that touch the lower or the upper end of the box.
  std::vector<Point2> TouchedAt(std::size_t axis, bool lower) const
  {
    const std::size_t a = (axis + 1) % 3, b = (axis + 2) % 3;
    const double slab = slabPart * Length(this->Sides);
    std::vector<Point2> touching;
    for (const Vec3& point : this->Points)
    {
      const double away =
        lower ? point[axis] - this->Around.lo[axis] : this->Around.hi[axis] - point[axis];
      if (away <= slab)
      {
        touching.push_back({ point[a], point[b] });
      }
    }
    return ConvexHull(std::move(touching));
  }

  struct Sample
  {
    Vec3 place{};
    double weight = 0;
  };
  static constexpr std::size_t gridSide = mirrorCells + 3; // one more cell around all

  // Points on the triangles, about a cell apart.
  std::vector<Sample> Samples() const;
  // Nothing for places outside the grid.
  std::optional<std::size_t> CellOf(const Vec3& place) const;
  Vec3 Mirrors() const;

  std::span<const Vec3> Points;
  std::span<const Triangle> Triangles;
  Box Around;
  Vec3 Sides{}, Middle{};
  mutable std::optional<Vec3> Mirrored; // computed at the first use
};

std::vector<Shape::Sample> Shape::Samples() const
{
  const double cell = this->LongestSide() / mirrorCells;
  // Limits the samples of one triangle, for meshes with many long triangles.
  const double mostRows =
    std::sqrt(mostMirrorSamples / std::max(1.0, static_cast<double>(this->Triangles.size())));
  std::vector<Sample> samples;
  for (const Triangle& t : this->Triangles)
  {
    const Vec3& a = this->Points[t[0]];
    const Vec3 b = Minus(this->Points[t[1]], a), c = Minus(this->Points[t[2]], a);
    const double longest = std::max({ Length(b), Length(c), Length(Minus(b, c)) });
    const double rows = 1 + std::floor(std::min(mostRows, longest / cell));
    const double weight = Length(Cross(b, c)) / (rows * (rows + 1));
    for (double i = 1.0 / 3; i < rows; ++i)
    {
      for (double j = 1.0 / 3; i + j < rows; ++j)
      {
        samples.push_back({ Plus(a, Plus(Times(b, i / rows), Times(c, j / rows))), weight });
      }
    }
  }
  return samples;
}

std::optional<std::size_t> Shape::CellOf(const Vec3& place) const
{
  const double cell = this->LongestSide() / mirrorCells;
  std::size_t found = 0;
  for (std::size_t k = 0; k < 3; ++k)
  {
    const double steps = (place[k] - this->Around.lo[k]) / cell;
    if (!(steps >= 0 && steps < mirrorCells + 1))
    {
      return std::nullopt;
    }
    found = found * gridSide + static_cast<std::size_t>(steps) + 1; // plus the cell around the grid
  }
  return found;
}

Vec3 Shape::Mirrors() const
{
  Vec3 shares{};
  if (!this->HasSurface())
  {
    return shares;
  }
  const std::vector<Sample> samples = this->Samples();
  std::vector<bool> has(gridSide * gridSide * gridSide), isNear(has.size());
  for (const Sample& sample : samples)
  {
    if (const auto cell = this->CellOf(sample.place))
    {
      has[*cell] = true;
    }
  }
  for (std::size_t cell = 0; cell < has.size(); ++cell)
  {
    for (std::size_t beside = 0; has[cell] && beside < 27; ++beside)
    {
      const std::size_t x = beside / 9, y = beside / 3 % 3, z = beside % 3;
      isNear[cell + (x * gridSide + y) * gridSide + z - (gridSide + 1) * gridSide - 1] = true;
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const double middleOfBox = this->Around.lo[axis] + this->Sides[axis] / 2;
    for (const double middle : { middleOfBox, this->Middle[axis] })
    {
      double all = 0, found = 0;
      for (const Sample& sample : samples)
      {
        Vec3 image = sample.place;
        image[axis] = 2 * middle - image[axis];
        const auto cell = this->CellOf(image);
        all += sample.weight;
        found += cell && isNear[*cell] ? sample.weight : 0;
      }
      shares[axis] = std::max(shares[axis], all > 0 ? found / all : 0);
    }
  }
  return shares;
}

double Shape::MirroredAcross(std::size_t axis) const
{
  if (!this->Mirrored)
  {
    this->Mirrored = this->Mirrors();
  }
  return (*this->Mirrored)[axis];
}

double Shape::ReliefTowards(const Vec3& direction) const
{
  struct Edge
  {
    VertexId low, high;
    Vec3 normal;
    auto operator<=>(const Edge&) const = default;
  };
  std::vector<Edge> edges;
  double area = 0;
  for (const Triangle& t : this->Triangles)
  {
    const Vec3 normal = this->DoubledNormal(t);
    const double doubled = Length(normal);
    if (doubled > 0 && Dot(normal, direction) > facingCosine * doubled)
    {
      area += doubled;
      for (std::size_t k = 0; k < 3; ++k)
      {
        const auto [low, high] = std::minmax(t[k], t[(k + 1) % 3]);
        edges.push_back({ low, high, Times(normal, 1 / doubled) });
      }
    }
  }
  std::sort(edges.begin(), edges.end());
  double bends = 0;
  for (std::size_t i = 1; i < edges.size(); ++i)
  {
    const Edge &a = edges[i - 1], &b = edges[i];
    if (a.low == b.low && a.high == b.high)
    {
      bends += Length(Minus(this->Points[a.low], this->Points[a.high])) *
               std::max(0.0, 1 - Dot(a.normal, b.normal));
    }
  }
  return area > 0 ? bends * Length(this->Sides) / area : 0;
}

// 1 if only +z has relief, -1 if only -z has.
double DetailAhead(const Shape& shape)
{
  const double ahead = shape.ReliefTowards({ 0, 0, 1 }), behind = shape.ReliefTowards({ 0, 0, -1 });
  return ahead + behind > 0 ? (ahead - behind) / (ahead + behind) : 0;
}

// How different the two ends of an axis are. support: the difference of their supports, which is
// all that counts for points without triangles.
double DifferenceOfEnds(const Shape& shape, std::size_t index, double support)
{
  return shape.HasSurface() ? support * shape.Side(index) / shape.LongestSide() +
                                unequalEnds * (1 - shape.MirroredAcross(index)) +
                                (index == 1 ? detailAhead * DetailAhead(shape) : 0)
                            : support;
}

// Which axis is up by its shape, if that is clear. A vase may be wider at its rim than at its foot.
// So a shape is taken to be upside down only if it could hardly stand otherwise.
std::optional<Axis> UpByShape(const Shape& shape, bool oftenY)
{
  std::optional<Axis> best;
  double score = 0, next = 0;
  for (const std::size_t index : { std::size_t{ 1 }, std::size_t{ 2 }, std::size_t{ 0 } })
  {
    const double upwards = shape.StandsWith({ index, 1 });
    const double downwards = shape.StandsWith({ index, -1 });
    const double most = DifferenceOfEnds(shape, index, std::abs(upwards - downwards)) +
                        (index == 1 && oftenY ? usualAxis : 0) - (index == 0 ? unlikelyAxis : 0);
    if (!best || most > score)
    {
      next = std::max(next, score);
      score = most;
      best = Axis{ index, downwards > upwards + upsideDown ? -1.0 : 1.0 };
    }
    else
    {
      next = std::max(next, most);
    }
  }
  return score >= next + leastLead ? best : std::nullopt;
}

Vec3 GuessUp(const Shape& shape, std::string_view ending)
{
  if (ending == ".gltf" || ending == ".glb" || ending == ".wrl")
  {
    return { 0, 1, 0 };
  }
  if (ending == ".json") // a tileset
  {
    return { 0, 0, 1 };
  }
  if (const std::optional<Axis> flat = shape.Flat())
  {
    return shape.IsWall() ? Vec3{ 0, 0, 1 } : flat->Direction();
  }
  const bool oftenY = ending == ".obj" || ending == ".off";
  if (const std::optional<Axis> up = UpByShape(shape, oftenY))
  {
    return up->Direction();
  }
  return oftenY ? Vec3{ 0, 1, 0 } : Vec3{ 0, 0, 1 };
}

std::size_t LongestComponent(const Vec3& direction)
{
  std::size_t longest = 0;
  for (std::size_t k = 1; k < 3; ++k)
  {
    longest = std::abs(direction[k]) > std::abs(direction[longest]) ? k : longest;
  }
  return longest;
}

// The horizontal axis along which the shape is seen.
struct SeenAlong
{
  std::size_t axis = 0;
  bool showsFront = false; // left and right are mirror images, so it shows its front
};

// A shape that is symmetric across one axis, such as a head, has its front along the other axis,
// unless the shape is long.
SeenAlong ChooseSide(const Shape& shape, std::size_t ahead, std::size_t aside)
{
  const double lead = shape.MirroredAcross(ahead) - shape.MirroredAcross(aside);
  const std::size_t across = lead > 0 ? ahead : aside, along = lead > 0 ? aside : ahead;
  if (std::abs(lead) > moreMirrored && shape.MirroredAcross(across) >= mirrored)
  {
    const bool isLong = shape.Side(along) > longBody * shape.Side(across);
    return { isLong ? across : along, !isLong };
  }
  return { shape.Side(ahead) > widerSide * shape.Side(aside) ? aside : ahead, false };
}

Vec3 GuessView(const Shape& shape, const Vec3& up, std::string_view ending)
{
  Vec3 front = FrontOf(up);
  if (ending == ".gltf" || ending == ".glb")
  {
    return front;
  }
  if (const auto flat = shape.Flat(); flat && flat->Direction() == up)
  {
    return up;
  }
  if (LongestComponent(up) != 1 && shape.IsWall())
  {
    return { 0, -1, 0 };
  }
  const std::size_t upward = LongestComponent(up), ahead = LongestComponent(front);
  const std::size_t aside = 3 - upward - ahead;
  const SeenAlong seen =
    upward != ahead ? ChooseSide(shape, ahead, aside) : SeenAlong{ ahead, false };
  if (upward != ahead && seen.axis == aside)
  {
    const double towards = up[aside];
    front = {};
    front[aside] = 1;
    front = DirectionOf(Minus(front, Times(up, towards))).value_or(front);
  }
  const double more = seen.showsFront ? moreReliefOfFront : moreRelief;
  if (shape.ReliefTowards(Times(front, -1)) > more * shape.ReliefTowards(front))
  {
    front = Times(front, -1);
  }
  const double narrower = std::min(shape.Side(ahead), shape.Side(aside));
  if (upward != ahead && shape.Side(upward) < lowPart * narrower)
  {
    const double level = std::sqrt(1 - sineOfThirty * sineOfThirty);
    front = DirectionOf(Plus(Times(front, level), Times(up, sineOfThirty))).value_or(front);
  }
  return front;
}

}

HomeView GuessHomeView(std::span<const Vec3> points, std::span<const Triangle> triangles,
  std::string_view ending, const std::optional<Vec3>& up, const std::optional<Vec3>& view)
{
  const Shape shape(points, triangles);
  HomeView homeView;
  homeView.guessed = !up || !view;
  homeView.up = up ? *up : GuessUp(shape, ending);
  homeView.view = view ? *view : GuessView(shape, homeView.up, ending);
  return homeView;
}

Status TellHomeView(
  const BuildOptions& options, const ModelDescription& description, StoreWriter& writer)
{
  std::vector<Vec3> points;
  std::vector<Triangle> triangles;
  if (!writer.Preview().empty())
  {
    const PieceId preview{ Resolution::Level(PreviewLevel(description)), 1 };
    CodecContext codec = description.Codec();
    codec.clusters.clear(); // counts are known only after all pieces are written
    Result<Piece> piece = DecodePiece(writer.Preview(), preview, codec);
    KDSTREAM_TRY(piece);
    points = std::move(piece->positions);
    triangles = std::move(piece->triangles);
  }
  else if (!options.up && !options.view)
  {
    return {};
  }
  std::string ending = std::filesystem::path(description.input).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
    [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  writer.SetHomeView(GuessHomeView(points, triangles, ending, options.up, options.view));
  return {};
}

}
