// SPDX-License-Identifier: BSD-3-Clause
#include "filters/build/PhaseValues.h"

#include "filters/model/JsonWriter.h"

#include <array>
#include <optional>
#include <utility>

namespace kdstream
{
namespace
{

void Save(BlobWriter& blob, const AttributeInfo& attribute)
{
  blob.AddText(attribute.name);
  blob.Add(attribute.type);
  blob.Add(attribute.association);
  blob.Add(attribute.components);
}

AttributeInfo LoadAttribute(BlobReader& blob)
{
  AttributeInfo attribute;
  attribute.name = blob.ReadText();
  attribute.type = blob.Read<AttributeType>();
  attribute.association = blob.Read<AttributeAssociation>();
  attribute.components = blob.Read<std::uint8_t>();
  return attribute;
}

void Save(BlobWriter& blob, const ClusterLevel& level)
{
  blob.AddList(level.positions);
  blob.AddList(level.geometricErrors);
  blob.AddList(level.lowest);
  blob.AddList(level.parents);
  blob.AddList(level.triangles);
  blob.Add(level.attributes.size());
  for (const Attribute& attribute : level.attributes)
  {
    Save(blob, attribute.Info());
    blob.AddList(attribute.values);
  }
}

ClusterLevel LoadClusterLevel(BlobReader& blob)
{
  ClusterLevel level;
  level.positions = blob.ReadList<Vec3>();
  level.geometricErrors = blob.ReadList<double>();
  level.lowest = blob.ReadList<VertexId>();
  level.parents = blob.ReadList<VertexId>();
  level.triangles = blob.ReadList<Triangle>();
  const auto attributes = blob.Read<std::size_t>();
  for (std::size_t i = 0; i < attributes && blob.Good(); ++i)
  {
    Attribute attribute{ LoadAttribute(blob), {} };
    attribute.values = blob.ReadList<std::uint8_t>();
    level.attributes.push_back(std::move(attribute));
  }
  return level;
}

// The files of a level, by the names that they have in a phase.
std::array<std::pair<std::string, SpillFile LevelFile::*>, 4> FilesOf(unsigned depth)
{
  const std::string level = std::to_string(depth);
  return { { { "clusters" + level, &LevelFile::clusters },
    { "triangles" + level, &LevelFile::triangles }, { "parents" + level, &LevelFile::parents },
    { "tuples" + level, &LevelFile::tuples } } };
}

// The files of all numbers, by their names.
std::vector<std::pair<std::string, SpillFile*>> FilesOf(ExternalNumbers& numbers)
{
  std::vector<std::pair<std::string, SpillFile*>> files{ { "numbers", &numbers.numberOfRank } };
  for (std::size_t d = 0; d < numbers.first.size(); ++d)
  {
    files.emplace_back("first" + std::to_string(d), &numbers.first[d]);
  }
  for (std::size_t d = 0; d < numbers.ranks.size(); ++d)
  {
    files.emplace_back("ranks" + std::to_string(d), &numbers.ranks[d]);
    files.emplace_back("ranked" + std::to_string(d), &numbers.ranked[d]);
    files.emplace_back("reach" + std::to_string(d), &numbers.childNodes[d].nodes);
  }
  return files;
}

}

void Save(BlobWriter& blob, const MeshFacts& facts)
{
  blob.Add(facts.vertices);
  blob.Add(facts.triangles);
  blob.Add(facts.unused);
  blob.Add(facts.welded);
  blob.Add(facts.pointTupleBytes);
  blob.Add(facts.cellTupleBytes);
  blob.Add(facts.scalarType);
  blob.Add(facts.floats);
  blob.Add(facts.weld);
  blob.Add(facts.attributes.size());
  for (const AttributeInfo& attribute : facts.attributes)
  {
    Save(blob, attribute);
  }
  blob.Add(facts.ignored.size());
  for (const std::string& name : facts.ignored)
  {
    blob.AddText(name);
  }
  blob.AddText(facts.tolerance.ToLines());
}

MeshFacts LoadMeshFacts(BlobReader& blob)
{
  MeshFacts facts;
  facts.vertices = blob.Read<std::uint32_t>();
  facts.triangles = blob.Read<std::uint32_t>();
  facts.unused = blob.Read<std::uint32_t>();
  facts.welded = blob.Read<std::uint64_t>();
  facts.pointTupleBytes = blob.Read<std::size_t>();
  facts.cellTupleBytes = blob.Read<std::size_t>();
  facts.scalarType = blob.Read<ScalarType>();
  facts.floats = blob.Read<bool>();
  facts.weld = blob.Read<bool>();
  const auto attributes = blob.Read<std::size_t>();
  for (std::size_t i = 0; i < attributes && blob.Good(); ++i)
  {
    facts.attributes.push_back(LoadAttribute(blob));
  }
  const auto ignored = blob.Read<std::size_t>();
  for (std::size_t i = 0; i < ignored && blob.Good(); ++i)
  {
    facts.ignored.push_back(blob.ReadText());
  }
  facts.tolerance = Tolerance::FromLines(blob.ReadText());
  return facts;
}

void Save(BlobWriter& blob, std::vector<PhaseFile>& files, ExternalLevels&& levels)
{
  blob.Add(levels.firstInFiles);
  blob.Add(levels.files.size());
  for (unsigned d = levels.firstInFiles; d < levels.files.size(); ++d)
  {
    LevelFile& level = levels.files[d];
    blob.Add(level.blockDepth);
    blob.AddList(level.begin);
    blob.AddList(level.triangleBegin);
    for (const auto& [name, member] : FilesOf(d))
    {
      files.push_back({ name, std::move(level.*member) });
    }
  }
  for (const ClusterLevel& level : levels.coarse)
  {
    Save(blob, level);
  }
  blob.Add(levels.attributes.size());
  for (const AttributeInfo& attribute : levels.attributes)
  {
    Save(blob, attribute);
  }
  files.push_back({ "clusterOfRank", std::move(levels.clusterOfRank) });
}

Result<ExternalLevels> LoadExternalLevels(
  BlobReader& blob, const BuildFolder& folder, std::string_view phase)
{
  ExternalLevels levels;
  levels.firstInFiles = blob.Read<unsigned>();
  const auto count = blob.Read<std::size_t>();
  if (count > Resolution::maximumLevel || levels.firstInFiles >= count)
  {
    return Error{ ErrorCode::Damaged, "the levels are not those of a build" };
  }
  const auto take = [&](const std::string& name, SpillFile& file) -> Status
  {
    Result<SpillFile> taken = folder.TakeFile(phase, name);
    KDSTREAM_TRY(taken);
    file = std::move(*taken);
    return {};
  };
  levels.files.resize(count);
  for (unsigned d = levels.firstInFiles; d < count; ++d)
  {
    LevelFile& level = levels.files[d];
    level.depth = d;
    level.blockDepth = blob.Read<unsigned>();
    level.begin = blob.ReadList<VertexId>();
    level.triangleBegin = blob.ReadList<std::uint64_t>();
    for (const auto& [name, member] : FilesOf(d))
    {
      KDSTREAM_TRY(take(name, level.*member));
    }
  }
  for (unsigned d = 0; d < levels.firstInFiles; ++d)
  {
    levels.coarse.push_back(LoadClusterLevel(blob));
  }
  const auto attributes = blob.Read<std::size_t>();
  for (std::size_t i = 0; i < attributes && blob.Good(); ++i)
  {
    levels.attributes.push_back(LoadAttribute(blob));
  }
  KDSTREAM_TRY(blob.Finish());
  KDSTREAM_TRY(take("clusterOfRank", levels.clusterOfRank));
  return levels;
}

void Save(BlobWriter& blob, std::vector<PhaseFile>& files, ExternalNumbers&& numbers)
{
  blob.Add(numbers.first.size());
  blob.Add(numbers.ranks.size());
  for (const ChildNodeFile& childNodes : numbers.childNodes)
  {
    blob.AddList(childNodes.begin);
  }
  for (const auto& [name, file] : FilesOf(numbers))
  {
    files.push_back({ name, std::move(*file) });
  }
}

Result<ExternalNumbers> LoadExternalNumbers(
  BlobReader& blob, const BuildFolder& folder, std::string_view phase)
{
  ExternalNumbers numbers;
  const auto levels = blob.Read<std::size_t>(), coarse = blob.Read<std::size_t>();
  if (levels > Resolution::maximumLevel || coarse > levels)
  {
    return Error{ ErrorCode::Damaged, "the numbers of levels are not those of a build" };
  }
  numbers.first.resize(levels);
  numbers.ranks.resize(coarse);
  numbers.ranked.resize(coarse);
  numbers.childNodes.resize(coarse);
  for (ChildNodeFile& childNodes : numbers.childNodes)
  {
    childNodes.begin = blob.ReadList<std::uint64_t>();
  }
  KDSTREAM_TRY(blob.Finish());
  for (const auto& [name, file] : FilesOf(numbers))
  {
    Result<SpillFile> taken = folder.TakeFile(phase, name);
    KDSTREAM_TRY(taken);
    *file = std::move(*taken);
  }
  return numbers;
}

std::vector<std::pair<std::string, std::string>> DescribeOptions(const BuildOptions& options)
{
  const auto onOff = [](bool on) { return std::string(on ? "on" : "off"); };
  const auto direction = [](const std::optional<Vec3>& given)
  {
    JsonWriter text;
    text.Put(given.value_or(Vec3{}));
    return given ? text.Text() : std::string();
  };
  const std::optional<std::uint32_t> partitions = options.tree.partitions;
  return { { "--vertices-per-partition", std::to_string(options.tree.verticesPerPartition) },
    { "--partitions", partitions ? std::to_string(*partitions) : "" },
    { "--cell-vertices", std::to_string(options.tree.cellVertices) },
    { "--partitioner", std::string(options.partitioner->Name()) },
    { "--levels", options.levels.maker == LevelMaker::Collapse ? "collapse" : "cluster" },
    { "--representative",
      options.levels.representative == Representative::Quadric ? "quadric" : "mean" },
    { "--sheets", onOff(options.levels.byComponents) }, { "--weld", onOff(options.weld) },
    { "--precision", options.bits == 0 ? "lossless" : std::to_string(options.bits) },
    { "--title", options.title }, { "--credit", options.credit }, { "--license", options.license },
    { "--unit", options.unit }, { "--description", options.description },
    { "--up", direction(options.up) }, { "--view", direction(options.view) },
    { "the name of the input", options.inputName }, { "kdstream-convert", options.convertedBy } };
}

}
