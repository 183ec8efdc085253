// SPDX-License-Identifier: BSD-3-Clause
// The ranges of arrays: see ScalarStatistics.h.
#include "filters/store/ScalarStatistics.h"

#include "filters/core/MixBits.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace kdstream
{
namespace
{

constexpr std::size_t mostSampled = 65536;                 // vertices
constexpr std::size_t mostSampledValues = 8 * mostSampled; // of all arrays

}

std::vector<AttributeInfo> ScalarStatistics::ArraysOf(std::span<const AttributeInfo> attributes)
{
  std::vector<AttributeInfo> arrays = ArraysOfLevels(attributes);
  std::erase_if(arrays, [](const AttributeInfo& array) { return !IsScalar(array); });
  return arrays;
}

ScalarStatistics::ScalarStatistics(std::span<const AttributeInfo> attributes)
  : Infos(ArraysOf(attributes))
{
  for (const AttributeInfo& array : this->Infos)
  {
    this->Columns.emplace_back().hasClasses = HoldsClasses(array);
  }
}

std::size_t ScalarStatistics::SampleSize() const
{
  return std::min(mostSampled, mostSampledValues / std::max<std::size_t>(1, this->Infos.size()));
}

void ScalarStatistics::Count(Column& column, double value) const
{
  if (!std::isfinite(value))
  {
    return;
  }
  column.least = column.finite == 0 ? value : std::min(column.least, value);
  column.most = column.finite == 0 ? value : std::max(column.most, value);
  ++column.finite;
  if (column.hasClasses)
  {
    ++column.classes[value];
    column.hasClasses = column.classes.size() <= ScalarDescription::mostClasses;
  }
}

void ScalarStatistics::Add(const Piece& piece)
{
  if (this->Infos.empty())
  {
    return;
  }
  std::vector<const Attribute*> arrays;
  for (std::size_t k = 0; k < this->Infos.size(); ++k)
  {
    arrays.push_back(FindAttribute(piece.attributes, this->Infos[k]));
    for (std::size_t v = 0; v < piece.ownVertices; ++v)
    {
      this->Count(this->Columns[k], arrays[k]->Get(v, 0));
    }
  }
  for (std::size_t v = 0; v < piece.ownVertices; ++v)
  {
    const std::uint64_t hash =
      MixBits((std::uint64_t{ piece.id.node } << 32 | v) + 0x9E3779B97F4A7C15U);
    if (hash > this->Limit)
    {
      continue;
    }
    this->Hashes.push_back(hash);
    for (const Attribute* array : arrays)
    {
      this->Values.push_back(array->Get(v, 0));
    }
    if (this->Hashes.size() >= 2 * this->SampleSize())
    {
      this->KeepLowest(this->SampleSize());
    }
  }
}

// Of equal hashes (there are hardly any) the first are kept.
void ScalarStatistics::KeepLowest(std::size_t count)
{
  const std::size_t columns = this->Infos.size();
  std::vector<std::size_t> order(this->Hashes.size());
  std::iota(order.begin(), order.end(), std::size_t{ 0 });
  const auto end = order.begin() + static_cast<std::ptrdiff_t>(count);
  std::nth_element(order.begin(), end - 1, order.end(),
    [this](std::size_t a, std::size_t b)
    { return std::pair(this->Hashes[a], a) < std::pair(this->Hashes[b], b); });
  this->Limit = this->Hashes[*(end - 1)];
  order.erase(end, order.end());
  std::sort(order.begin(), order.end());
  for (std::size_t i = 0; i < count; ++i)
  {
    this->Hashes[i] = this->Hashes[order[i]];
    std::copy_n(this->Values.begin() + static_cast<std::ptrdiff_t>(order[i] * columns), columns,
      this->Values.begin() + static_cast<std::ptrdiff_t>(i * columns));
  }
  this->Hashes.resize(count);
  this->Values.resize(count * columns);
}

std::vector<ScalarDescription> ScalarStatistics::Describe() const
{
  ScalarStatistics sample = *this;
  if (sample.Hashes.size() > sample.SampleSize())
  {
    sample.KeepLowest(sample.SampleSize());
  }
  std::vector<ScalarDescription> scalars;
  for (std::size_t k = 0; k < this->Infos.size(); ++k)
  {
    const Column& column = this->Columns[k];
    ScalarDescription& scalar = scalars.emplace_back();
    scalar.name = this->Infos[k].name;
    scalar.least = scalar.low = column.least;
    scalar.most = scalar.high = column.most;
    std::vector<double> values;
    for (std::size_t i = k; i < sample.Values.size(); i += this->Infos.size())
    {
      if (std::isfinite(sample.Values[i]))
      {
        values.push_back(sample.Values[i]);
      }
    }
    std::sort(values.begin(), values.end());
    if (!values.empty())
    {
      const std::size_t off = (values.size() - 1) * 2 / 100;
      scalar.low = values[off];
      scalar.high = values[values.size() - 1 - off];
    }
    if (column.hasClasses)
    {
      for (const auto& [value, vertices] : column.classes)
      {
        scalar.classes.push_back({ value, vertices });
      }
    }
  }
  return scalars;
}

}
