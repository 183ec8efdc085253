// Normals and colours of the levels: see LevelAttributes.h.
//   1. The sums of the finest level's clusters over their original vertices, ascending.
//   2. Level by level: the mean of each cluster, and its sum added to its parent's, children by
//   lowest vertex.
#include "filters/core/LevelAttributes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

namespace kdstream
{
namespace
{

class ColorSum
{
public:
  void Add(const Attribute& colors, std::size_t tuple)
  {
    for (std::size_t k = 0; k < colors.components; ++k)
    {
      this->Sum[k] += colors.values[tuple * colors.components + k];
    }
    ++this->Count;
  }
  void Add(const ColorSum& child)
  {
    for (std::size_t k = 0; k < this->Sum.size(); ++k)
    {
      this->Sum[k] += child.Sum[k];
    }
    this->Count += child.Count;
  }
  void AppendMean(Attribute& means) const
  {
    for (std::size_t k = 0; k < means.components; ++k)
    {
      means.values.push_back(static_cast<std::uint8_t>(
        this->Count == 0 ? 0 : (2 * this->Sum[k] + this->Count) / (2 * this->Count)));
    }
  }

private:
  std::array<std::uint64_t, 4> Sum{};
  std::uint64_t Count = 0;
};

// The vector of length 1 that points the same way, if there is one. Scaled first, so that neither
// huge nor tiny vectors lose theirs.
std::optional<Vec3> DirectionOf(const Vec3& v)
{
  const double largest = std::max({ std::abs(v[0]), std::abs(v[1]), std::abs(v[2]) });
  if (!std::isfinite(v[0]) || !std::isfinite(v[1]) || !std::isfinite(v[2]) || largest == 0)
  {
    return std::nullopt;
  }
  const Vec3 scaled{ v[0] / largest, v[1] / largest, v[2] / largest };
  const double length =
    std::sqrt(scaled[0] * scaled[0] + scaled[1] * scaled[1] + scaled[2] * scaled[2]);
  return Vec3{ scaled[0] / length, scaled[1] / length, scaled[2] / length };
}

class NormalSum
{
public:
  void Add(const Attribute& normals, std::size_t tuple)
  {
    if (const auto direction =
          DirectionOf({ normals.Get(tuple, 0), normals.Get(tuple, 1), normals.Get(tuple, 2) }))
    {
      this->Add({ *direction, *direction, 1 });
    }
  }
  void Add(const NormalSum& child)
  {
    this->First = this->Count == 0 ? child.First : this->First;
    for (std::size_t k = 0; k < 3; ++k)
    {
      this->Sum[k] += child.Sum[k];
    }
    this->Count += child.Count;
  }
  void AppendMean(Attribute& means) const
  {
    constexpr double cancelled = 1e-9;
    const Vec3& s = this->Sum;
    const double length = std::sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
    const std::optional<Vec3> direction = DirectionOf(s);
    const Vec3 mean = direction && length > cancelled * this->Count ? *direction : this->First;
    const std::size_t tuple = means.TupleCount();
    means.values.resize(means.values.size() + means.TupleSize());
    for (std::size_t k = 0; k < 3; ++k)
    {
      means.Set(tuple, k, mean[k]);
    }
  }

  NormalSum() = default;

private:
  NormalSum(const Vec3& sum, const Vec3& first, double count)
    : Sum(sum)
    , First(first)
    , Count(count)
  {
  }

  Vec3 Sum{};
  Vec3 First{}; // of the lowest vertex that has one
  double Count = 0;
};

template <class Sum>
void AddMeans(const Mesh& mesh, const Attribute& attribute, ClusterLevels& levels)
{
  std::vector<Sum> sums(levels.levels.back().lowest.size());
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
  {
    sums[levels.finest[v]].Add(attribute, v);
  }
  for (std::size_t d = levels.levels.size(); d-- > 0;)
  {
    ClusterLevel& level = levels.levels[d];
    Attribute means{ attribute.Info(), {} };
    means.values.reserve(sums.size() * means.TupleSize());
    for (const Sum& sum : sums)
    {
      sum.AppendMean(means);
    }
    level.attributes.push_back(std::move(means));
    if (level.parents.empty())
    {
      return; // the coarsest
    }
    std::vector<VertexId> order(sums.size());
    std::iota(order.begin(), order.end(), VertexId{ 0 });
    std::sort(order.begin(), order.end(),
      [&](VertexId a, VertexId b) { return level.lowest[a] < level.lowest[b]; });
    std::vector<Sum> above(levels.levels[d - 1].lowest.size());
    for (const VertexId cluster : order)
    {
      above[level.parents[cluster]].Add(sums[cluster]);
    }
    sums = std::move(above);
  }
}

}

void AddLevelAttributes(const Mesh& mesh, ClusterLevels& levels)
{
  if (levels.levels.empty())
  {
    return;
  }
  for (const Attribute& attribute : mesh.attributes)
  {
    switch (RoleOf(attribute))
    {
      case AttributeRole::Colors:
        AddMeans<ColorSum>(mesh, attribute, levels);
        break;
      case AttributeRole::Normals:
        AddMeans<NormalSum>(mesh, attribute, levels);
        break;
      case AttributeRole::TextureCoordinates:
      case AttributeRole::Other:
        break;
    }
  }
}

}
