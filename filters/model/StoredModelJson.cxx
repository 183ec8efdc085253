// SPDX-License-Identifier: BSD-3-Clause
// The JSON in stores: the description as servers send it (ModelJson.cxx), and the facts of the
// build, which only stores have. Stores before version 13 have another form, which can only be
// read.
#include "filters/model/ModelJson.h"
#include "filters/model/ModelMembers.h"

#include <algorithm>
#include <limits>

namespace kdstream
{
namespace
{

// ---- the build

void PutBuild(JsonWriter& json, const ModelDescription& model)
{
  json.BeginObject().Member("input", model.input);
  PutUnlessEmpty(json, "input_digest", model.inputDigest);
  json.Member("welded", model.welded)
    .Member("inconsistent_edges", model.inconsistentEdges)
    .Member("smallest_partition", model.smallestPartition)
    .Member("largest_partition", model.largestPartition);
  PutUnused(json, model);
  json.Member("partitioner", model.partitioner)
    .Member("level_maker", model.levelMaker)
    .Member("representative", model.representative)
    .Member("sheets", model.sheets)
    .Member("weld", model.weld)
    .EndObject();
}

// The depths and the number of partitions must match the partitioner.
void ReadPartitioner(JsonReader& reader, const JsonValue& object, ModelDescription& model)
{
  model.partitioner = reader.Text(object, "partitioner", 16);
  const TreeDepths& depths = model.depths;
  const std::uint64_t most = std::uint64_t{ 1 } << depths.partition;
  if (model.partitioner == "kdtree")
  {
    if (depths.stitch != std::min(depths.finest, depths.partition + 4))
    {
      reader.Fail("\"stitch_depth\" does not fit the other depths");
    }
    if (model.partitions != most)
    {
      reader.Fail("\"partitions\" does not fit \"partition_depth\"");
    }
    if (model.levels.empty())
    {
      reader.Fail("\"levels\" is empty");
    }
    return;
  }
  if (model.partitioner != "octree" && model.partitioner != "kmeans")
  {
    reader.Fail("\"partitioner\" must be kdtree, octree or kmeans");
  }
  if (depths.finest != depths.partition || !model.levels.empty())
  {
    reader.Fail("\"levels\" must be empty for this partitioner");
  }
  if (model.partitions <= most / 2)
  {
    reader.Fail("\"partitions\" does not fit \"partition_depth\"");
  }
}

void ReadUnused(JsonReader& reader, const JsonValue& object, ModelDescription& model)
{
  const JsonValue* unused = reader.Find(object, "unused", false);
  if (!unused)
  {
    return;
  }
  UnusedDescription& reported = model.unused.emplace();
  reported.vertices = reader.Integer(*unused, "vertices", 1, mostCount);
  reported.bytes = reader.Integer(*unused, "bytes", 0, mostCount);
  reported.farthest = reader.Vector(*unused, "farthest");
}

void ReadBuild(
  JsonReader& reader, const JsonValue& object, std::size_t mostText, ModelDescription& model)
{
  ReadPartitioner(reader, object, model);
  model.input = reader.Text(object, "input", mostText);
  model.inputDigest = reader.Text(object, "input_digest", mostText, false);
  if (!model.inputDigest.empty() && !IsDigest(model.inputDigest))
  {
    reader.Fail("\"input_digest\" must have 32 hexadecimal digits");
  }
  model.welded = reader.Integer(object, "welded", 0, mostCount);
  model.inconsistentEdges = reader.Integer(object, "inconsistent_edges", 0, mostCount);
  model.smallestPartition = reader.Integer(object, "smallest_partition", 0, mostCount);
  model.largestPartition = reader.Integer(object, "largest_partition", 0, mostCount);
  ReadUnused(reader, object, model);
  model.levelMaker = reader.Text(object, "level_maker", mostText);
  model.representative = reader.Text(object, "representative", mostText);
  model.sheets = reader.Boolean(object, "sheets");
  model.weld = reader.Boolean(object, "weld");
}

// ---- before version 13: enumerations are numbers

void ReadGrid(JsonReader& reader, const JsonValue& object, CoordinateGrid& grid)
{
  grid.bits = reader.Small<std::uint8_t>(object, "bits", 0, 24);
  if (grid.bits != 0 && grid.bits < 8)
  {
    reader.Fail("\"bits\" is below 8");
  }
  grid.scalarType = static_cast<ScalarType>(reader.Integer(object, "scalar_type", 0, 1));
  grid.origin = reader.Vector(object, "origin");
  grid.step = reader.Number(object, "step", std::numeric_limits<double>::denorm_min());
}

AttributeInfo ReadNumberedAttribute(JsonReader& reader, const JsonValue& object)
{
  AttributeInfo attribute;
  attribute.name = reader.Text(object, "name", longestAttributeName);
  attribute.type = static_cast<AttributeType>(
    reader.Integer(object, "type", 0, static_cast<std::uint64_t>(AttributeType::Float64)));
  attribute.association =
    static_cast<AttributeAssociation>(reader.Integer(object, "association", 0, 1));
  attribute.components = reader.Small<std::uint8_t>(object, "components", 1, 255);
  return attribute;
}

void ReadEarlierDescription(
  JsonReader& reader, const JsonValue& json, std::size_t mostText, ModelDescription& model)
{
  model.digest = reader.Text(json, "digest", mostText);
  ReadShared(reader, json, model);
  if (const JsonValue* grid = reader.Find(json, "grid"))
  {
    ReadGrid(reader, *grid, model.grid);
  }
  model.primitive = static_cast<PrimitiveType>(reader.Integer(json, "primitive", 0, 1));
  if (const JsonValue* attributes = reader.Array(json, "attributes", mostAttributes))
  {
    for (const JsonValue& attribute : attributes->GetArray())
    {
      model.attributes.push_back(ReadNumberedAttribute(reader, attribute));
    }
  }
  ReadScalars(reader, json, model);
  ReadTexts(reader, json, mostText, model);
}

}

std::string WriteStoredModel(const ModelDescription& model)
{
  JsonWriter json;
  json.BeginObject();
  PutDescription(json, model);
  json.Key("build");
  PutBuild(json, model);
  json.EndObject();
  return json.Text();
}

Result<ModelDescription> ParseStoredModel(std::string_view text, StoredForm form)
{
  const Result<JsonDocument> parsed = ParseJson(text);
  if (!parsed)
  {
    return Error{ ErrorCode::Damaged, "the metadata: " + parsed.GetError().message };
  }
  const JsonValue& json = *parsed;
  JsonReader reader("the metadata");
  ModelDescription model;
  if (form == StoredForm::Earlier)
  {
    ReadEarlierDescription(reader, json, text.size(), model);
    ReadBuild(reader, json, text.size(), model);
  }
  else
  {
    ReadDescription(reader, json, text.size(), model);
    if (const JsonValue* build = reader.Find(json, "build"))
    {
      ReadBuild(reader, *build, text.size(), model);
    }
  }
  for (const AttributeInfo& attribute : model.attributes)
  {
    if (!IsAttributeName(attribute.name))
    {
      reader.Fail("\"name\" of an attribute is not a string");
    }
  }
  if (!reader.Good())
  {
    return Error{ ErrorCode::Damaged, reader.Fault() };
  }
  return model;
}

}
