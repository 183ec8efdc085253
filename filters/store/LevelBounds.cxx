// SPDX-License-Identifier: BSD-3-Clause
// Bounds of levels: see LevelBounds.h. A branch and bound, partition by partition:
//   1. Make a tree of balls over the triangles of a partition: divide them in halves along the
//      longest side, again and again.
//   2. For each level make a tree of boxes over its triangles: of the whole level if it is small,
//      else of the piece around the partition. The distance from any part of a level is an upper
//      bound.
//   3. The distance of a ball from the level is at most the distance of its centre plus its radius.
//      The search begins with balls of at most half the largest bound so far. Balls above that
//      bound wait in a queue; the farthest is taken first and divided.
//   4. If a ball cannot be divided, its triangles are put into the queue. A triangle is at most as
//      far from a triangle of the level as its farthest corner, because triangles are convex. If
//      this bound is far above the distances of its corners, the triangle is cut into four.
//   5. When the level's share of visits is used up, the farthest entry of the queue is the bound.
#include "filters/store/LevelBounds.h"

#include "filters/codec/PieceCodec.h"
#include "filters/core/TriangleDistance.h"
#include "filters/core/VectorMath.h"
#include "filters/core/tree/PieceDepth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <queue>
#include <utility>

namespace kdstream
{
namespace
{

using ReadBlob = std::function<Result<std::vector<std::uint8_t>>(PieceId)>;
using Corners = std::array<Vec3, 3>;

constexpr std::uint32_t trianglesOfBall = 8;    // maximum in a leaf
constexpr std::uint32_t trianglesOfBox = 4;     // maximum in a leaf
constexpr std::uint64_t visitsOfTriangle = 4;   // for each triangle of the original and each level
constexpr std::uint64_t visitsAtFirst = 400000; // more for each level
constexpr std::uint64_t visitsOfPoint = 256;    // maximum for one point
// Decoded at a time, with a tree of balls: about 180 bytes a vertex of a surface.
constexpr std::uint64_t batchPartitions = 16, batchVertices = std::uint64_t{ 1 } << 16;
constexpr unsigned mostHalvings = 6; // maximum for a triangle's edges

double FarthestCorner(const Corners& from, const Corners& to)
{
  double most = 0;
  for (const Vec3& p : from)
  {
    most = std::max(most, SquaredToTriangle(p, to[0], to[1], to[2]));
  }
  return std::sqrt(most);
}

struct Ball
{
  Vec3 centre{};
  double radius = 0;
};

// The triangles of a partition (for a cloud, each point as a triangle without extent), in a tree of
// balls. A node is divided along the longest side of the box of its triangles' centres.
class BallTree
{
public:
  explicit BallTree(Piece piece)
    : Part(std::move(piece))
  {
    const std::size_t count = this->Part.triangles.empty() ? std::size_t{ this->Part.ownVertices }
                                                           : this->Part.triangles.size();
    this->Order.reserve(count);
    for (std::uint32_t i = 0; i < count; ++i)
    {
      const auto [a, b, c] = this->CornersOf(i);
      this->Order.push_back({ Plus(Plus(a, b), c), i });
    }
    while ((std::size_t{ trianglesOfBall } << this->Depth) < count)
    {
      ++this->Depth;
    }
    this->Balls.resize(std::size_t{ 2 } << this->Depth);
    this->Build(1, 0);
  }

  std::uint32_t Count() const { return static_cast<std::uint32_t>(this->Order.size()); }
  const Ball& At(std::size_t node) const { return this->Balls[node]; }
  bool IsLeaf(std::size_t node) const { return node >= this->Balls.size() / 2; }

  // Calls visit(corners) for each triangle of a leaf.
  template <class Visit>
  void VisitLeaf(std::size_t node, const Visit& visit) const
  {
    const auto [begin, end] = this->RangeOf(node, this->Depth);
    for (std::uint32_t i = begin; i < end; ++i)
    {
      visit(this->CornersOf(this->Order[i].triangle));
    }
  }

private:
  struct Entry
  {
    Vec3 middle; // times three
    std::uint32_t triangle;
  };

  Corners CornersOf(std::uint32_t i) const
  {
    const std::vector<Vec3>& at = this->Part.positions;
    if (this->Part.triangles.empty())
    {
      return { at[i], at[i], at[i] };
    }
    const Triangle& t = this->Part.triangles[i];
    return { at[t[0]], at[t[1]], at[t[2]] };
  }

  std::pair<std::uint32_t, std::uint32_t> RangeOf(std::size_t node, unsigned depth) const
  {
    const std::uint64_t place = node - (std::size_t{ 1 } << depth), all = this->Order.size();
    return { static_cast<std::uint32_t>(place * all >> depth),
      static_cast<std::uint32_t>((place + 1) * all >> depth) };
  }

  void Split(std::size_t node, unsigned depth)
  {
    const auto [begin, end] = this->RangeOf(node, depth);
    const auto first = this->Order.begin() + begin, last = this->Order.begin() + end;
    Box middles;
    std::for_each(first, last, [&](const Entry& entry) { middles.Add(entry.middle); });
    const Vec3 sides = Minus(middles.hi, middles.lo);
    const auto axis =
      static_cast<std::size_t>(std::max_element(sides.begin(), sides.end()) - sides.begin());
    std::nth_element(first, this->Order.begin() + this->RangeOf(2 * node, depth + 1).second, last,
      [&](const Entry& one, const Entry& other)
      {
        return std::pair(one.middle[axis], one.triangle) <
               std::pair(other.middle[axis], other.triangle);
      });
  }

  Box Build(std::size_t node, unsigned depth)
  {
    Box box;
    Ball& ball = this->Balls[node];
    if (depth < this->Depth)
    {
      this->Split(node, depth);
      box = this->Build(2 * node, depth + 1);
      box.Add(this->Build(2 * node + 1, depth + 1));
      ball = { Middle(box), 0 };
      for (std::size_t child = 2 * node; child < 2 * node + 2; ++child)
      {
        const Ball& inner = this->Balls[child];
        ball.radius =
          std::max(ball.radius, Length(Minus(inner.centre, ball.centre)) + inner.radius);
      }
      ball.radius = std::min(ball.radius, Length(Minus(box.hi, ball.centre)));
      return box;
    }
    this->VisitLeaf(node, [&](const Corners& corners)
      { std::for_each(corners.begin(), corners.end(), [&](const Vec3& p) { box.Add(p); }); });
    const Vec3 centre = Middle(box);
    ball = { centre, box.Empty() ? 0 : Length(Minus(box.hi, centre)) };
    return box;
  }

  static Vec3 Middle(const Box& box)
  {
    return box.Empty() ? Vec3{} : Times(Plus(box.lo, box.hi), 0.5);
  }

  Piece Part;
  std::vector<Entry> Order; // the entries of a node are adjacent
  unsigned Depth = 0;       // of the leaves
  std::vector<Ball> Balls;  // heap order; the first entry is unused
};

// The search structure of a level: triangles in a tree of boxes. The triangles are in the order of
// their lowest vertices, which follow the vertex tree. So consecutive triangles are near each
// other, and nothing has to be sorted.
class LevelSurface
{
public:
  // triangles: corners are numbers of points; if empty, each point counts as a triangle. REQUIRES:
  // points is not empty.
  LevelSurface(std::vector<Vec3> points, std::vector<Triangle> triangles)
    : Points(std::move(points))
    , Triangles(std::move(triangles))
  {
    const std::size_t count =
      this->Triangles.empty() ? this->Points.size() : this->Triangles.size();
    this->Count = static_cast<std::uint32_t>(count);
    while ((std::size_t{ trianglesOfBox } << this->Depth) < count)
    {
      ++this->Depth;
    }
    this->Boxes.resize(std::size_t{ 2 } << this->Depth);
    const std::size_t leaves = std::size_t{ 1 } << this->Depth;
    for (std::size_t node = 2 * leaves - 1; node > 0; --node)
    {
      Box& box = this->Boxes[node];
      if (node < leaves)
      {
        box.Add(this->Boxes[2 * node]);
        box.Add(this->Boxes[2 * node + 1]);
        continue;
      }
      for (std::uint32_t i = this->Begin(node - leaves); i < this->Begin(node + 1 - leaves); ++i)
      {
        const Corners corners = this->CornersOf(i);
        std::for_each(corners.begin(), corners.end(), [&](const Vec3& p) { box.Add(p); });
      }
    }
  }

  Corners CornersOf(std::uint32_t i) const
  {
    if (this->Triangles.empty())
    {
      return { this->Points[i], this->Points[i], this->Points[i] };
    }
    const Triangle& t = this->Triangles[i];
    return { this->Points[t[0]], this->Points[t[1]], this->Points[t[2]] };
  }

  // Returns the distance to a triangle near `p`: one at a distance of at most `enough`; if there is
  // none, the nearest, or the nearest found in about `mostVisits` visits of boxes and triangles.
  // found: where to begin; set to the triangle found. visits: increased by the number of visits.
  double FindNear(const Vec3& p, double enough, std::uint32_t& found, std::uint64_t& visits,
    std::uint64_t mostVisits) const
  {
    Walk walk{ p, enough > 0 ? enough * enough : 0, this->SquaredFrom(p, found), found, mostVisits,
      1 };
    if (walk.best > walk.ends)
    {
      this->Search(1, walk);
    }
    found = walk.found;
    visits += walk.visits;
    return std::sqrt(walk.best);
  }

private:
  struct Walk
  {
    const Vec3& from;
    double ends, best; // squared; the search ends when `best` is at most `ends`
    std::uint32_t found;
    std::uint64_t mostVisits, visits;
  };

  void Search(std::size_t node, Walk& walk) const
  {
    const std::size_t leaves = this->Boxes.size() / 2;
    ++walk.visits;
    if (node >= leaves)
    {
      const std::uint32_t end = this->Begin(node + 1 - leaves);
      for (std::uint32_t i = this->Begin(node - leaves); i < end; ++i)
      {
        ++walk.visits;
        const double squared = this->SquaredFrom(walk.from, i);
        if (squared < walk.best)
        {
          walk.best = squared;
          walk.found = i;
        }
      }
      return;
    }
    std::size_t near = 2 * node, far = 2 * node + 1;
    double nearest = this->SquaredFromBox(walk.from, near);
    double next = this->SquaredFromBox(walk.from, far);
    if (next < nearest)
    {
      std::swap(near, far);
      std::swap(nearest, next);
    }
    if (nearest < walk.best)
    {
      this->Search(near, walk);
    }
    if (next < walk.best && walk.best > walk.ends && walk.visits < walk.mostVisits)
    {
      this->Search(far, walk);
    }
  }

  double SquaredFromBox(const Vec3& p, std::size_t node) const
  {
    const Box& box = this->Boxes[node];
    double squared = 0;
    for (std::size_t k = 0; k < 3; ++k)
    {
      const double outside = std::max({ box.lo[k] - p[k], p[k] - box.hi[k], 0.0 });
      squared += outside * outside;
    }
    return squared;
  }

  double SquaredFrom(const Vec3& p, std::uint32_t i) const
  {
    const Corners c = this->CornersOf(i);
    return SquaredToTriangle(p, c[0], c[1], c[2]);
  }

  std::uint32_t Begin(std::size_t leaf) const
  {
    return static_cast<std::uint32_t>(std::uint64_t{ leaf } * this->Count >> this->Depth);
  }

  std::vector<Vec3> Points;
  std::vector<Triangle> Triangles;
  std::uint32_t Count = 0;
  unsigned Depth = 0;     // of the leaves
  std::vector<Box> Boxes; // heap order; the first entry is unused
};

// No bound is below this: about the radius of a ball of 16 vertices, if the vertices were spread
// over half the surface of the model's box. Parts of the original that are nearer to a level are
// not searched.
double LeastBound(const ModelDescription& model)
{
  const Vec3 sides = Minus(model.box.hi, model.box.lo);
  const double area = sides[0] * sides[1] + sides[1] * sides[2] + sides[2] * sides[0];
  return 4 * std::sqrt(area / double(std::max<std::uint64_t>(1, model.vertices)));
}

// The bound of one level over the partitions added so far.
class LevelBound
{
public:
  LevelBound(const ModelDescription& model, const ReadBlob& read, unsigned depth,
    std::uint64_t wholeVertices)
    : Model(model)
    , Read(read)
    , Depth(depth)
    , PiecesAt(model.levels[depth].vertices > wholeVertices
                 ? PieceDepth(Resolution::Level(depth), model.depths)
                 : 0)
    , Most(std::max(LeastBound(model), model.levels[depth].geometricError))
  {
  }

  double Bound() const { return this->Most; }

  Status Add(const BallTree& balls, std::uint32_t partition)
  {
    if (balls.Count() == 0)
    {
      return {};
    }
    const NodeId node = NodeOfPartition(partition, this->Model.depths) >>
                        (this->Model.depths.partition - this->PiecesAt);
    if (this->Loaded != node)
    {
      KDSTREAM_TRY(this->Load(node));
    }
    // Each partition gets its share in any case: if earlier partitions used it up, its whole ball
    // would be the bound, which may be far too large.
    this->MostVisits = std::max(this->MostVisits, this->Visits) + visitsOfTriangle * balls.Count();
    this->Search(balls);
    return {};
  }

private:
  // Loads the triangles around a node. If it has none, loads those of its nearest ancestor that has
  // some.
  Status Load(NodeId node)
  {
    this->Loaded = node;
    for (;; node /= 2)
    {
      Mesh mesh;
      KDSTREAM_TRY(this->Gather(node, mesh));
      if (this->IsPoints() ? !mesh.points.empty() : !mesh.triangles.empty())
      {
        this->Level.emplace(std::move(mesh.points), std::move(mesh.triangles));
        this->Last = 0;
        return {};
      }
      if (node == 1)
      {
        return Error{ ErrorCode::InvalidInput,
          "level " + std::to_string(this->Depth) + " has neither triangles nor vertices" };
      }
    }
  }

  bool IsPoints() const { return this->Model.levels[this->Depth].triangles == 0; }

  // Collects the level's pieces in a node.
  Status Gather(NodeId node, Mesh& mesh) const
  {
    const Resolution resolution = Resolution::Level(this->Depth);
    const unsigned down = PieceDepth(resolution, this->Model.depths) - DepthOfNode(node);
    for (std::uint32_t i = 0; i < (std::uint32_t{ 1 } << down); ++i)
    {
      const PieceId id{ resolution, (node << down) + i };
      const Result<std::vector<std::uint8_t>> blob = this->Read(id);
      KDSTREAM_TRY(blob);
      const Result<Piece> piece = DecodePiece(*blob, id, this->Model.Codec());
      KDSTREAM_TRY(piece);
      const auto first = static_cast<VertexId>(mesh.points.size());
      if (this->IsPoints() || !piece->triangles.empty())
      {
        mesh.points.insert(mesh.points.end(), piece->positions.begin(), piece->positions.end());
      }
      for (const Triangle& t : piece->triangles)
      {
        mesh.triangles.push_back({ first + t[0], first + t[1], first + t[2] });
      }
    }
    return {};
  }

  // A ball or a part of a triangle that may be farther from the level than the bound so far.
  struct Suspect
  {
    double most = 0; // an upper bound of its distance from the level
    std::size_t ball = 0;
    Corners corners{}; // of the part of a triangle; `ball` is 0 then
    unsigned halvings = 0;

    bool operator<(const Suspect& other) const { return this->most < other.most; }
  };

  // Searches small balls first, then always the farthest suspect: so no large suspect is left when
  // the visits are used up.
  void Search(const BallTree& balls)
  {
    this->Suspects = {};
    this->Descend(balls, 1);
    while (!this->Suspects.empty() && this->Suspects.top().most > this->Most)
    {
      const Suspect suspect = this->Suspects.top();
      if (this->IsSpent())
      {
        this->Most = suspect.most;
        return;
      }
      this->Suspects.pop();
      if (suspect.ball == 0)
      {
        this->Refine(suspect);
      }
      else if (balls.IsLeaf(suspect.ball))
      {
        balls.VisitLeaf(suspect.ball,
          [&](const Corners& corners) { this->Push(corners, suspect.most, mostHalvings); });
      }
      else
      {
        this->Push(balls, 2 * suspect.ball, suspect.most);
        this->Push(balls, 2 * suspect.ball + 1, suspect.most);
      }
    }
  }

  // Visits balls in the order of the vertices, down to balls with a radius of at most half the
  // bound.
  void Descend(const BallTree& balls, std::size_t node)
  {
    if (balls.At(node).radius <= this->Most / 2 || balls.IsLeaf(node))
    {
      this->Push(balls, node, std::numeric_limits<double>::infinity());
      return;
    }
    this->Descend(balls, 2 * node);
    this->Descend(balls, 2 * node + 1);
  }

  void Push(const BallTree& balls, std::size_t node, double most)
  {
    const Ball& ball = balls.At(node);
    most = std::min(most, this->FindNear(ball.centre, this->Most - ball.radius) + ball.radius);
    if (most > this->Most)
    {
      this->Suspects.push({ most, node, {}, 0 });
    }
  }

  void Push(const Corners& corners, double most, unsigned halvings)
  {
    most = std::min(most, FarthestCorner(corners, this->Level->CornersOf(this->Last)));
    if (most <= this->Most)
    {
      return;
    }
    const Vec3 middle = Times(Plus(Plus(corners[0], corners[1]), corners[2]), 1.0 / 3);
    double radius = 0;
    for (const Vec3& p : corners)
    {
      radius = std::max(radius, SquaredDistance(p, middle));
    }
    radius = std::sqrt(radius);
    const double from = this->FindNear(middle, this->Most - radius);
    most = std::min(
      { most, from + radius, FarthestCorner(corners, this->Level->CornersOf(this->Last)) });
    if (most > this->Most)
    {
      this->Suspects.push({ most, 0, corners, halvings });
    }
  }

  // If the bound of a part is hardly above the distance of its farthest corner, the part is
  // finished. Otherwise it is cut into four.
  void Refine(const Suspect& part)
  {
    const auto& [a, b, c] = part.corners;
    double most = part.most, least = 0;
    for (std::size_t k = 0; k < 3 && most > this->Most; ++k)
    {
      least = std::max(least, this->FindNear(part.corners[k], 0));
      most = std::min(most, FarthestCorner(part.corners, this->Level->CornersOf(this->Last)));
    }
    if (most <= std::max(this->Most, 1.05 * least) || part.halvings == 0)
    {
      this->Most = std::max(this->Most, most);
      return;
    }
    const Vec3 ab = Times(Plus(a, b), 0.5), bc = Times(Plus(b, c), 0.5),
               ca = Times(Plus(c, a), 0.5);
    for (const Corners& quarter :
      { Corners{ a, ab, ca }, Corners{ ab, b, bc }, Corners{ ca, bc, c }, Corners{ ab, bc, ca } })
    {
      this->Push(quarter, most, part.halvings - 1);
    }
  }

  bool IsSpent() const { return this->Visits >= this->MostVisits; }

  double FindNear(const Vec3& p, double enough)
  {
    return this->Level->FindNear(p, enough, this->Last, this->Visits, visitsOfPoint);
  }

  const ModelDescription& Model;
  const ReadBlob& Read;
  unsigned Depth, PiecesAt; // PiecesAt: depth of the nodes that are searched as a whole
  NodeId Loaded = 0;
  std::optional<LevelSurface> Level;
  std::uint32_t Last = 0; // the last result; the next point is often near it
  std::uint64_t Visits = 0, MostVisits = visitsAtFirst;
  double Most;
  std::priority_queue<Suspect> Suspects; // of one partition, farthest first
};

}

Result<std::vector<double>> BoundLevels(const ModelDescription& model, const ReadBlob& read,
  const Execution& execution, std::uint64_t wholeVertices)
{
  std::vector<LevelBound> levels;
  levels.reserve(model.levels.size());
  for (unsigned depth = 0; depth < model.levels.size(); ++depth)
  {
    levels.emplace_back(model, read, depth, wholeVertices);
  }
  const CodecContext codec = model.Codec();
  const std::uint64_t inPartition =
    model.vertices / std::max<std::uint64_t>(1, model.partitions) + 1;
  const std::uint64_t inBatch =
    std::clamp<std::uint64_t>(batchVertices / inPartition, 1, batchPartitions);
  for (std::uint32_t partition = 0; partition < model.partitions && !levels.empty();)
  {
    const std::uint32_t first = partition;
    std::vector<std::vector<std::uint8_t>> blobs;
    for (; partition < model.partitions && blobs.size() < inBatch; ++partition)
    {
      Result<std::vector<std::uint8_t>> blob =
        read({ Resolution::Original(), NodeOfPartition(partition, model.depths) });
      KDSTREAM_TRY(blob);
      blobs.push_back(std::move(*blob));
    }
    std::vector<std::optional<BallTree>> balls(blobs.size());
    std::vector<Status> statuses(std::max(blobs.size(), levels.size()));
    const auto forAll = [&](std::size_t count, const std::function<Status(std::size_t)>& work)
    {
      execution.parallelFor(count, 1,
        [&](std::size_t begin, std::size_t end)
        {
          for (std::size_t i = begin; i < end; ++i)
          {
            statuses[i] = work(i);
          }
        });
      const auto failed = std::find_if(statuses.begin(), statuses.begin() + std::ptrdiff_t(count),
        [](const Status& status) { return !status; });
      return failed == statuses.begin() + std::ptrdiff_t(count) ? Status{} : *failed;
    };
    KDSTREAM_TRY(forAll(blobs.size(),
      [&](std::size_t i) -> Status
      {
        const auto node = NodeOfPartition(first + static_cast<std::uint32_t>(i), model.depths);
        Result<Piece> piece = DecodePiece(blobs[i], { Resolution::Original(), node }, codec);
        KDSTREAM_TRY(piece);
        balls[i].emplace(std::move(*piece));
        return {};
      }));
    // The finest levels first, because they take longest.
    KDSTREAM_TRY(forAll(levels.size(),
      [&](std::size_t i) -> Status
      {
        for (std::size_t k = 0; k < balls.size(); ++k)
        {
          KDSTREAM_TRY(
            levels[levels.size() - 1 - i].Add(*balls[k], first + static_cast<std::uint32_t>(k)));
        }
        return {};
      }));
    KDSTREAM_TRY(execution.Report("encode", 1));
  }
  // For an upper bound of the rounding errors in sums of a few products.
  double scale = 0;
  for (std::size_t k = 0; k < 3; ++k)
  {
    scale = std::max({ scale, std::abs(model.box.lo[k]), std::abs(model.box.hi[k]) });
  }
  std::vector<double> bounds;
  for (const LevelBound& level : levels)
  {
    bounds.push_back(level.Bound() * (1 + 1e-9) + 1e-14 * scale);
  }
  return bounds;
}

}
