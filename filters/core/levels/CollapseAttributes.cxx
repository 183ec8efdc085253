// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/levels/CollapseAttributes.h"

#include "filters/core/VectorMath.h"

#include <algorithm>
#include <cmath>

namespace kdstream
{
namespace
{

// Adds up values with weights, and divides.
class WeightedMeans
{
public:
  WeightedMeans(std::size_t count, std::size_t components)
    : Components(components)
    , Sums(count * components, 0)
    , Weights(components == 0 ? 0 : count, 0)
  {
  }

  template <class Value>
  void Add(std::size_t place, double weight, const Value& value)
  {
    for (std::size_t k = 0; k < this->Components; ++k)
    {
      this->Sums[place * this->Components + k] += weight * value(k);
    }
    this->Weights[place] += weight;
  }

  CollapseAttributes Divide() const
  {
    CollapseAttributes means{ this->Components, std::vector<float>(this->Sums.size(), 0) };
    for (std::size_t i = 0; i < this->Sums.size(); ++i)
    {
      const double weight = this->Weights[i / this->Components];
      means.values[i] = weight > 0 ? static_cast<float>(this->Sums[i] / weight) : 0;
    }
    return means;
  }

private:
  std::size_t Components;
  std::vector<double> Sums;
  std::vector<double> Weights;
};

}

double DiagonalOf(const Box& box)
{
  return Length(Minus(box.hi, box.lo));
}

CollapseAttributes MeanAttributes(const Mesh& mesh, std::span<const VertexId> clusterOf,
  std::span<const ClusterSum> clusters, double diagonal)
{
  struct Column
  {
    const Attribute* attribute;
    std::size_t component;
    double scale;
    double most; // of a value's magnitude
  };
  std::vector<Column> columns;
  for (const Attribute& attribute : mesh.attributes)
  {
    if (IsInLevels(attribute))
    {
      const bool colors = RoleOf(attribute) == AttributeRole::Colors;
      const double scale = diagonal * (colors ? colorScale / 255 : normalScale);
      for (std::size_t k = 0; k < attribute.components; ++k)
      {
        columns.push_back({ &attribute, k, scale, colors ? 255.0 : 1.0 });
      }
    }
  }
  WeightedMeans means(clusters.size(), columns.size());
  for (std::size_t v = 0; !columns.empty() && v < clusterOf.size(); ++v)
  {
    if (clusterOf[v] == noVertex)
    {
      continue; // a ghost of a block
    }
    means.Add(clusterOf[v], 1,
      [&](std::size_t k)
      {
        const double value = columns[k].attribute->Get(v, columns[k].component);
        return std::isnan(value)
                 ? 0
                 : columns[k].scale * std::clamp(value, -columns[k].most, columns[k].most);
      });
  }
  return means.Divide();
}

CollapseAttributes MeanOverChildren(const CollapseAttributes& children,
  std::span<const ClusterSum> clusters, std::span<const VertexId> parents, std::size_t count)
{
  WeightedMeans means(count, children.components);
  for (std::size_t c = 0; children.components > 0 && c < parents.size(); ++c)
  {
    means.Add(parents[c], clusters[c].quadric.Trace(),
      [&](std::size_t k) { return double(children.values[c * children.components + k]); });
  }
  return means.Divide();
}

}
