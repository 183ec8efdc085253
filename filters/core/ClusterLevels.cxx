// Levels by clustering: see ClusterLevels.h.
//   1. The finest level: FinestClusters.h.
//   2. The pairs of clusters that only collapsed triangles link.
//   3. Each coarser level the same way from the level below it: clusters in the place of vertices.
#include "filters/core/ClusterLevels.h"

#include "filters/core/CellSheets.h"
#include "filters/core/DisjointSets.h"
#include "filters/core/FinestClusters.h"

#include <algorithm>
#include <numeric>

namespace kdstream
{
namespace
{

// What is kept of the level last made, beside the level.
struct Workspace
{
  std::vector<ClusterSum> clusters;
  std::vector<std::uint32_t> cellOf; // of each cluster
  std::vector<Link> collapsed; // pairs linked by collapsed triangles or by coincidence, sorted
};

class LevelBuilder
{
public:
  LevelBuilder(const ClusterOptions& options, const Execution& execution)
    : Options(options)
    , Exec(execution)
  {
  }

  Result<ClusterLevels> Build(
    FinestClusters&& clusters, unsigned finest, std::span<const Triangle> triangles)
  {
    this->Origin = clusters.origin;
    this->Output.levels.resize(finest + 1);
    this->Output.levels[finest] = std::move(clusters.level);
    this->Output.finest = std::move(clusters.clusterOf);
    this->Work.clusters = std::move(clusters.clusters);
    this->Work.cellOf = std::move(clusters.cellOf);
    this->CollectLinks(triangles, clusters.coincident, this->Output.finest);
    for (unsigned depth = finest; depth-- > this->Options.coarsestDepth;)
    {
      const double done = 1.0 - double(depth + 1) / double(finest + 1);
      if (Status status = this->Exec.Report("levels", 0.5 + 0.5 * done); !status)
      {
        return status.GetError();
      }
      this->BuildCoarser(depth);
    }
    return std::move(this->Output);
  }

private:
  // Makes level `depth` from level depth + 1.
  void BuildCoarser(unsigned depth)
  {
    ClusterLevel& below = this->Output.levels[depth + 1];
    const Workspace children = std::move(this->Work);
    this->Work = {};
    std::vector<VertexId> root(children.clusters.size());
    std::iota(root.begin(), root.end(), VertexId{ 0 });
    const auto join = [&](VertexId a, VertexId b)
    {
      if (children.cellOf[a] >> 1 == children.cellOf[b] >> 1)
      {
        Join(root, a, b);
      }
    };
    for (const Triangle& t : below.triangles)
    {
      join(t[0], t[1]);
      join(t[1], t[2]);
      join(t[2], t[0]);
    }
    for (const Link& link : children.collapsed)
    {
      join(link.first, link.second);
    }
    this->NumberCoarser(depth, children, root, below.parents);
    ClusterLevel& level = this->Output.levels[depth];
    RepresentClusters(
      this->Work.clusters, this->Options.representative, this->Origin, level, this->Exec);
    level.triangles = ImageOfTriangles(below.triangles, below.parents, this->Exec);
    this->CollectLinks(below.triangles, children.collapsed, below.parents);
  }

  // Groups the children of each cell at `depth` and adds them up, by lowest id.
  void NumberCoarser(unsigned depth, const Workspace& children, std::vector<VertexId>& root,
    std::vector<VertexId>& parents)
  {
    parents.resize(children.clusters.size());
    const std::size_t most =
      std::min(children.clusters.size(), (this->Options.sheets ? mostSheets : 1) << depth);
    this->Work.clusters.reserve(most);
    this->Work.cellOf.reserve(most);
    std::vector<VertexId> members;
    for (std::size_t first = 0; first < children.clusters.size();)
    {
      const std::uint32_t cell = children.cellOf[first] >> 1;
      std::size_t end = first;
      members.clear();
      while (end < children.clusters.size() && children.cellOf[end] >> 1 == cell)
      {
        members.push_back(static_cast<VertexId>(end++));
      }
      std::sort(members.begin(), members.end(),
        [&](VertexId a, VertexId b)
        { return children.clusters[a].lowest < children.clusters[b].lowest; });
      const std::size_t offset = this->Work.clusters.size();
      const std::size_t count = GroupCell(
        members, this->Options.sheets, [&](VertexId m) { return FindRoot(root, m); },
        [&](VertexId m)
        {
          const ClusterSum& c = children.clusters[m];
          return Sheet{ c.count, c.sum, c.surface, 0 };
        },
        [&](VertexId m, std::size_t local) { parents[m] = static_cast<VertexId>(offset + local); });
      this->Work.clusters.resize(offset + count);
      this->Work.cellOf.resize(offset + count, cell);
      for (const VertexId m : members)
      {
        this->Work.clusters[parents[m]].Add(children.clusters[m]);
      }
      first = end;
    }
  }

  // The pairs of clusters that are linked but share no triangle of the level: images of collapsed
  // triangles, and of pairs that were linked so below.
  void CollectLinks(
    std::span<const Triangle> triangles, std::span<const Link> links, std::span<const VertexId> map)
  {
    std::vector<Link>& collapsed = this->Work.collapsed;
    const auto add = [&](VertexId a, VertexId b)
    {
      if (a != b)
      {
        collapsed.emplace_back(std::min(a, b), std::max(a, b));
      }
    };
    for (const Triangle& t : triangles)
    {
      const VertexId a = map[t[0]], b = map[t[1]], c = map[t[2]];
      if (a == b || b == c || c == a)
      {
        add(a, a == b ? c : b);
      }
    }
    for (const Link& link : links)
    {
      add(map[link.first], map[link.second]);
    }
    std::sort(collapsed.begin(), collapsed.end());
    collapsed.erase(std::unique(collapsed.begin(), collapsed.end()), collapsed.end());
  }

  const ClusterOptions& Options;
  const Execution& Exec;
  Vec3 Origin{};
  Workspace Work;
  ClusterLevels Output;
};

}

Result<ClusterLevels> BuildClusterLevels(std::span<const Vec3> points,
  std::span<const Triangle> triangles, const KdTree& tree,
  const TriangleBuckets& partitionTriangles, const ClusterOptions& options,
  const Execution& execution)
{
  Result<FinestClusters> finest =
    BuildFinestClusters(points, triangles, tree, partitionTriangles, options, execution);
  if (!finest)
  {
    return finest.GetError();
  }
  return LevelBuilder(options, execution).Build(std::move(*finest), tree.depths.finest, triangles);
}

std::vector<Triangle> ImageInPartitions(std::span<const Triangle> triangles,
  const TriangleBuckets& buckets, std::span<const VertexId> map, std::span<const VertexId> mapBegin,
  const Execution& execution)
{
  // A triangle of the image is made where its lowest vertex is; one partition's come after those of
  // the one before.
  const std::size_t partitions = buckets.begin.size() - 1;
  std::vector<std::vector<Triangle>> images(partitions);
  execution.parallelFor(partitions, 1,
    [&](std::size_t begin, std::size_t end)
    {
      std::vector<Triangle> image;
      std::vector<std::uint32_t> next;
      for (std::size_t p = begin; p < end; ++p)
      {
        image.clear();
        for (const std::uint32_t t : buckets.Of(p))
        {
          const Triangle mapped{ map[triangles[t][0]], map[triangles[t][1]], map[triangles[t][2]] };
          const VertexId lowest = std::min({ mapped[0], mapped[1], mapped[2] });
          if (mapped[0] != mapped[1] && mapped[1] != mapped[2] && mapped[2] != mapped[0] &&
              lowest >= mapBegin[p] && lowest < mapBegin[p + 1])
          {
            image.push_back(RotateLowestFirst(mapped));
          }
        }
        std::vector<Triangle>& sorted = images[p];
        sorted.resize(image.size());
        SortByTriangle(std::span<const Triangle>(image), mapBegin[p], mapBegin[p + 1] - mapBegin[p],
          std::span(sorted), next);
        sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
        sorted.shrink_to_fit();
      }
    });
  std::size_t size = 0;
  for (const std::vector<Triangle>& image : images)
  {
    size += image.size();
  }
  std::vector<Triangle> all;
  all.reserve(size);
  for (std::vector<Triangle>& image : images)
  {
    all.insert(all.end(), image.begin(), image.end());
    image = {};
  }
  return all;
}

std::vector<Triangle> ImageOfTriangles(
  std::span<const Triangle> triangles, std::span<const VertexId> map, const Execution& execution)
{
  // Each chunk maps its own; then all are sorted.
  constexpr std::size_t chunk = std::size_t{ 1 } << 16;
  const std::size_t chunks = (triangles.size() + chunk - 1) / chunk;
  std::vector<std::vector<Triangle>> images(chunks);
  std::vector<VertexId> highest(chunks, 0);
  execution.parallelFor(chunks, 1,
    [&](std::size_t begin, std::size_t end)
    {
      for (std::size_t i = begin; i < end; ++i)
      {
        for (const Triangle& t :
          triangles.subspan(i * chunk, std::min(chunk, triangles.size() - i * chunk)))
        {
          const Triangle mapped{ map[t[0]], map[t[1]], map[t[2]] };
          if (mapped[0] != mapped[1] && mapped[1] != mapped[2] && mapped[2] != mapped[0])
          {
            images[i].push_back(RotateLowestFirst(mapped));
            highest[i] = std::max(highest[i], images[i].back()[0]);
          }
        }
      }
    });
  std::vector<Triangle> all;
  for (std::vector<Triangle>& image : images)
  {
    all.insert(all.end(), image.begin(), image.end());
    image = {};
  }
  const VertexId most = chunks == 0 ? 0 : *std::max_element(highest.begin(), highest.end());
  SortTriangles(all, std::size_t{ most } + 1, true, execution);
  return all;
}

}
