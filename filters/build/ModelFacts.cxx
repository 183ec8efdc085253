// SPDX-License-Identifier: BSD-3-Clause
#include "filters/build/ModelFacts.h"

#include <algorithm>

namespace kdstream
{

CoordinateGrid GridOf(const BuildOptions& options, const Box& box, ScalarType scalarType)
{
  return options.bits == 0 ? CoordinateGrid::Exact(scalarType)
                           : CoordinateGrid::Over(box, options.bits, scalarType);
}

ModelDescription DescribeModel(
  const BuildOptions& options, const ModelFacts& facts, const std::string& inputName)
{
  ModelDescription info;
  info.input = inputName;
  info.depths = facts.depths;
  info.grid = GridOf(options, facts.box, facts.scalarType);
  info.primitive = facts.triangles == 0 ? PrimitiveType::Points : PrimitiveType::Triangles;
  info.box = facts.box;
  info.vertices = facts.vertices;
  info.triangles = facts.triangles;
  if (facts.unused > 0)
  {
    info.unused.emplace().vertices = facts.unused;
  }
  info.partitions = facts.partitions;
  info.welded = facts.welded;
  info.inconsistentEdges = facts.inconsistentEdges;
  info.smallestPartition = facts.smallestPartition;
  info.largestPartition = facts.largestPartition;
  info.attributes = facts.attributes;
  if (options.textures)
  {
    std::erase_if(info.attributes, IsTextureArray);
    info.textures = options.textures->Describe();
    info.textures->levels = info.textures->levels && options.partitioner->HasLevels();
  }
  info.partitioner = options.partitioner->Name();
  info.weld = facts.weld;
  info.title = options.title;
  info.credit = options.credit;
  info.license = options.license;
  info.unit = options.unit;
  info.description = options.description;
  if (!options.partitioner->HasLevels())
  {
    return info;
  }
  info.levels.resize(facts.depths.finest + std::size_t{ 1 });
  for (std::size_t depth = 0; depth < facts.geometricErrors.size(); ++depth)
  {
    info.levels[depth].spacing = info.grid.SpacingFor(facts.geometricErrors[depth]);
  }
  info.levelMaker = options.levels.maker == LevelMaker::Collapse ? "collapse" : "cluster";
  info.representative =
    options.levels.representative == Representative::Quadric ? "quadric" : "mean";
  info.sheets = options.levels.byComponents;
  return info;
}

bool WeldingSeparates(bool weld, const std::vector<AttributeInfo>& attributes)
{
  return weld && std::none_of(attributes.begin(), attributes.end(),
                   [](const AttributeInfo& array)
                   { return array.association == AttributeAssociation::Point; });
}

}
