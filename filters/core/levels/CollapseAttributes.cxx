// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/levels/CollapseAttributes.h"

#include "filters/core/VectorMath.h"
#include "filters/core/levels/LevelAttributes.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace kdstream
{
namespace
{

bool IsNormals(const AttributeInfo& attribute)
{
  return RoleOf(attribute) == AttributeRole::Normals;
}

bool IsVertexColors(const AttributeInfo& attribute)
{
  return RoleOf(attribute) == AttributeRole::Colors;
}

// Weighted means: adds up weighted values, then divides.
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
  };
  std::vector<Column> columns;
  for (const Attribute& attribute : mesh.attributes)
  {
    for (std::size_t k = 0; IsNormals(attribute) && k < attribute.components; ++k)
    {
      columns.push_back({ &attribute, k });
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
        return std::isnan(value) ? 0 : diagonal * normalScale * std::clamp(value, -1.0, 1.0);
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

const Attribute* FindVertexColors(std::span<const Attribute> attributes)
{
  const auto found = std::find_if(attributes.begin(), attributes.end(), IsVertexColors);
  return found == attributes.end() ? nullptr : &*found;
}

std::optional<std::size_t> PlaceOfVertexColors(std::span<const AttributeInfo> attributes)
{
  std::size_t place = 0;
  for (const AttributeInfo& attribute : attributes)
  {
    if (IsVertexColors(attribute))
    {
      return place;
    }
    place += attribute.TupleSize();
  }
  return std::nullopt;
}

bool IsColorEdge(const Attribute& vertexColors, std::size_t a, std::size_t b)
{
  const std::uint8_t *const ofA = &vertexColors.values[a * vertexColors.components],
                            *const ofB = &vertexColors.values[b * vertexColors.components];
  return std::abs(ofA[0] - ofB[0]) > colorEdge || std::abs(ofA[1] - ofB[1]) > colorEdge ||
         std::abs(ofA[2] - ofB[2]) > colorEdge;
}

std::vector<VertexColor> MeanVertexColors(
  const Mesh& mesh, std::span<const VertexId> clusterOf, std::size_t clusters)
{
  const Attribute* const vertexColors = FindVertexColors(mesh.attributes);
  if (!vertexColors)
  {
    return {};
  }
  AttributeSums sums(std::span(&vertexColors->Info(), 1), clusters);
  sums.AddVertices(mesh.attributes, clusterOf);
  const Attribute means = std::move(sums.Means().front());
  std::vector<VertexColor> colors(clusters);
  for (std::size_t c = 0; c < clusters; ++c)
  {
    std::copy_n(&means.values[c * means.components], colors[c].size(), colors[c].begin());
  }
  return colors;
}

void PutVertexColors(std::span<const VertexColor> vertexColors, std::span<Attribute> means)
{
  const auto colored = std::find_if(means.begin(), means.end(), IsVertexColors);
  for (std::size_t c = 0; c < vertexColors.size() && colored != means.end(); ++c)
  {
    std::copy(
      vertexColors[c].begin(), vertexColors[c].end(), &colored->values[c * colored->components]);
  }
}

double GreyValue(double diagonal)
{
  return diagonal * colorScale / 255;
}

bool IsOfOneColor(std::span<const Triangle> triangles, std::span<const VertexColor> colors)
{
  return std::all_of(triangles.begin(), triangles.end(),
    [&](const Triangle& t)
    {
      const VertexColor& one = colors[triangles.front()[0]];
      return colors[t[0]] == one && colors[t[1]] == one && colors[t[2]] == one;
    });
}

ColorQuadric ColorQuadricOf(const Triangle& t, const std::array<Vec3, 3>& corners,
  std::span<const VertexColor> colors, double greyValue)
{
  const auto scaled = [&](VertexId v) -> Vec3
  {
    const VertexColor& color = colors[v];
    return { color[0] * greyValue, color[1] * greyValue, color[2] * greyValue };
  };
  return ColorQuadric::OfTriangle(corners, { scaled(t[0]), scaled(t[1]), scaled(t[2]) });
}

void AddColorQuadrics(
  std::span<const VertexColor> colors, std::size_t own, double greyValue, CollapsePart& part)
{
  if (colors.empty() || IsOfOneColor(part.triangles, colors))
  {
    return;
  }
  part.colorQuadrics.resize(part.positions.size());
  for (const Triangle& t : part.triangles)
  {
    const ColorQuadric quadric = ColorQuadricOf(
      t, { part.positions[t[0]], part.positions[t[1]], part.positions[t[2]] }, colors, greyValue);
    for (const VertexId v : t)
    {
      if (v < own)
      {
        part.colorQuadrics[v].Add(quadric);
      }
    }
  }
}

}
