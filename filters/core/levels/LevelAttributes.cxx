// SPDX-License-Identifier: BSD-3-Clause
// Normals, colours and numbers of the levels: see LevelAttributes.h.
//   1. Sum up the finest level's clusters over their original vertices, ascending.
//   2. Level by level: compute the mean of each cluster, and add its sum to its parent's, children
//      by lowest vertex.
#include "filters/core/levels/LevelAttributes.h"

#include "filters/core/Light.h"
#include "filters/core/ScalarSums.h"
#include "filters/core/UnitVector.h"
#include "filters/core/VectorMath.h"
#include "filters/core/levels/CollapseAttributes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <new>
#include <numeric>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

namespace kdstream
{
namespace
{

// Sums red, green and blue as linear light, in integers, so that sums are the same in any order;
// alpha as it is.
class ColorSum
{
public:
  void Add(const Attribute& colors, std::size_t tuple)
  {
    for (std::size_t k = 0; k < colors.components; ++k)
    {
      const std::uint8_t value = colors.values[tuple * colors.components + k];
      this->Sum[k] += k < alpha ? WholeLightOfBytes()[value] : value;
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
  // Whether the bytes can be sums of colours: the means are in range.
  bool IsPossible() const
  {
    const auto mean = [&](std::uint64_t sum, std::uint64_t most)
    { return sum <= most * this->Count; };
    return this->Count < noVertex && mean(this->Sum[alpha], 255) &&
           std::all_of(this->Sum.begin(), this->Sum.begin() + alpha,
             [&](std::uint64_t sum) { return mean(sum, wholeLight); });
  }
  void AppendMean(Attribute& means) const
  {
    for (std::size_t k = 0; k < means.components; ++k)
    {
      means.values.push_back(this->Count == 0 ? std::uint8_t{ 0 } : this->MeanOf(k));
    }
  }

private:
  static constexpr std::size_t alpha = 3;

  std::uint8_t MeanOf(std::size_t k) const
  {
    return k < alpha
             ? ByteOfLinear(double(this->Sum[k]) / (double(this->Count) * wholeLight))
             : static_cast<std::uint8_t>((2 * this->Sum[k] + this->Count) / (2 * this->Count));
  }

  std::array<std::uint64_t, 4> Sum{};
  std::uint64_t Count = 0;
};

class NormalSum
{
public:
  void Add(const Attribute& normals, std::size_t tuple)
  {
    if (const auto direction =
          ScaledUnitVector({ normals.Get(tuple, 0), normals.Get(tuple, 1), normals.Get(tuple, 2) }))
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
  bool IsPossible() const
  {
    const auto isFinite = [](double x) { return std::isfinite(x); };
    return this->Count >= 0 && this->Count < noVertex &&
           std::all_of(this->Sum.begin(), this->Sum.end(), isFinite) &&
           std::all_of(this->First.begin(), this->First.end(), isFinite);
  }
  void AppendMean(Attribute& means) const
  {
    constexpr double cancelled = 1e-9;
    const Vec3& s = this->Sum;
    const double length = Length(s);
    const std::optional<Vec3> direction = ScaledUnitVector(s);
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
  Vec3 First{}; // the normal of the lowest vertex that has one
  double Count = 0;
};

static_assert(std::is_trivially_copyable_v<ColorSum> && sizeof(ColorSum) == 40);
static_assert(std::is_trivially_copyable_v<NormalSum> && sizeof(NormalSum) == 56);
static_assert(std::is_trivially_copyable_v<ScalarSum> && sizeof(ScalarSum) == 16);
static_assert(std::is_trivially_copyable_v<ClassVotes> && sizeof(ClassVotes) == 64);

// The sum at a place in a record. Records are multiples of the sum's alignment, and start at the
// beginning of an allocation.
template <class Sum>
Sum& SumAt(std::byte* record)
{
  return *std::launder(reinterpret_cast<Sum*>(record));
}

template <class Sum>
const Sum& SumAt(const std::byte* record)
{
  return *std::launder(reinterpret_cast<const Sum*>(record));
}

// Calls visit(sum) with an empty sum of the kind that the array has in levels.
template <class Visit>
void WithSumOf(const AttributeInfo& attribute, const Visit& visit)
{
  const AttributeRole role = RoleOf(attribute);
  if (role == AttributeRole::Normals)
  {
    visit(NormalSum{});
  }
  else if (role == AttributeRole::Colors)
  {
    visit(ColorSum{});
  }
  else if (HoldsClasses(attribute))
  {
    visit(ClassVotes{});
  }
  else
  {
    visit(ScalarSum{});
  }
}

}

AttributeSums::AttributeSums(std::span<const AttributeInfo> attributes, std::size_t clusters)
  : Clusters(clusters)
{
  for (const AttributeInfo& attribute : ArraysOfLevels(attributes))
  {
    this->Columns.push_back({ attribute, this->Record });
    WithSumOf(attribute, [&](const auto& sum) { this->Record += sizeof(sum); });
  }
  this->Records.resize(clusters * this->Record); // all zero: empty sums
}

// Calls visit(column, sum) with an empty sum of the column's kind.
template <class Visit>
void AttributeSums::ForEachColumn(const Visit& visit) const
{
  for (const Column& column : this->Columns)
  {
    WithSumOf(column.attribute, [&](const auto& sum) { visit(column, sum); });
  }
}

Result<AttributeSums> AttributeSums::FromBytes(
  std::span<const AttributeInfo> attributes, std::vector<std::byte> bytes)
{
  AttributeSums sums(attributes, 0);
  if (sums.Record == 0 ? !bytes.empty() : bytes.size() % sums.Record != 0)
  {
    return Error{ ErrorCode::InvalidInput, "sums of attributes: " + std::to_string(bytes.size()) +
                                             " bytes are not records of " +
                                             std::to_string(sums.Record) };
  }
  sums.Clusters = sums.Record == 0 ? 0 : bytes.size() / sums.Record;
  sums.Records = std::move(bytes);
  KDSTREAM_TRY(sums.Check());
  return sums;
}

Status AttributeSums::Check() const
{
  std::size_t wrong = this->Clusters;
  this->ForEachColumn(
    [&](const Column& column, auto sum)
    {
      for (std::size_t c = 0; c < wrong; ++c)
      {
        if (!SumAt<decltype(sum)>(&this->Records[c * this->Record + column.offset]).IsPossible())
        {
          wrong = c;
        }
      }
    });
  if (wrong < this->Clusters)
  {
    return Error{ ErrorCode::InvalidInput,
      "sums of attributes: no tuples add up to those of cluster " + std::to_string(wrong) };
  }
  return {};
}

void AttributeSums::AddVertices(
  std::span<const Attribute> attributes, std::span<const VertexId> clusterOf)
{
  this->ForEachColumn(
    [&](const Column& column, auto sum)
    {
      const Attribute& tuples = *FindAttribute(attributes, column.attribute);
      for (std::size_t v = 0; v < clusterOf.size(); ++v)
      {
        if (clusterOf[v] != noVertex)
        {
          SumAt<decltype(sum)>(&this->Records[clusterOf[v] * this->Record + column.offset])
            .Add(tuples, v);
        }
      }
    });
}

AttributeSums AttributeSums::MakeCoarser(
  std::span<const VertexId> parents, std::span<const VertexId> lowest, std::size_t count) const
{
  AttributeSums above;
  above.Columns = this->Columns;
  above.Clusters = count;
  above.Record = this->Record;
  above.Records.resize(count * this->Record);
  if (this->Empty())
  {
    return above;
  }
  std::vector<VertexId> order(this->Clusters);
  std::iota(order.begin(), order.end(), VertexId{ 0 });
  std::sort(
    order.begin(), order.end(), [&](VertexId a, VertexId b) { return lowest[a] < lowest[b]; });
  this->ForEachColumn(
    [&](const Column& column, auto sum)
    {
      for (const VertexId cluster : order)
      {
        SumAt<decltype(sum)>(&above.Records[parents[cluster] * this->Record + column.offset])
          .Add(SumAt<decltype(sum)>(&this->Records[cluster * this->Record + column.offset]));
      }
    });
  return above;
}

std::vector<Attribute> AttributeSums::Means() const
{
  std::vector<Attribute> means;
  this->ForEachColumn(
    [&](const Column& column, auto sum)
    {
      Attribute& mean = means.emplace_back(Attribute{ column.attribute, {} });
      mean.values.reserve(this->Clusters * mean.TupleSize());
      for (std::size_t c = 0; c < this->Clusters; ++c)
      {
        SumAt<decltype(sum)>(&this->Records[c * this->Record + column.offset]).AppendMean(mean);
      }
    });
  return means;
}

void AddLevelAttributes(const Mesh& mesh, ClusterLevels& levels)
{
  if (levels.levels.empty())
  {
    return;
  }
  const std::vector<AttributeInfo> attributes(mesh.attributes.begin(), mesh.attributes.end());
  AttributeSums sums(attributes, levels.levels.back().lowest.size());
  if (sums.Empty())
  {
    return;
  }
  sums.AddVertices(mesh.attributes, levels.finest);
  for (std::size_t d = levels.levels.size(); d-- > 0;)
  {
    ClusterLevel& level = levels.levels[d];
    std::vector<Attribute> means = sums.Means();
    PutVertexColors(std::exchange(level.vertexColors, {}), means);
    std::move(means.begin(), means.end(), std::back_inserter(level.attributes));
    if (level.parents.empty())
    {
      return; // the coarsest
    }
    sums = sums.MakeCoarser(level.parents, level.lowest, levels.levels[d - 1].lowest.size());
  }
}

}
