// SPDX-License-Identifier: BSD-3-Clause
// The form that stores keep, whose bytes never change within a version of stores (members in the
// order of the alphabet, enumerations as numbers); and statistics, for people and scripts.
#include "filters/model/ModelJson.h"
#include "filters/model/ModelMembers.h"

#include <algorithm>
#include <limits>

namespace kdstream
{
namespace
{

// The depths and the number of partitions have to fit the partitioner.
void ReadPartitioner(JsonReader& reader, const JsonValue& object, ModelDescription& model)
{
  model.partitioner = reader.Text(object, "partitioner", 16);
  const TreeDepths& depths = model.depths;
  const std::uint64_t most = std::uint64_t{ 1 } << depths.partition;
  if (model.partitioner == "kdtree")
  {
    if (depths.stitch != std::min(depths.finest, depths.partition + 4))
    {
      reader.Fail("\"stitch_depth\" does not fit the others");
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
    reader.Fail("\"partitioner\" is none of kdtree, octree and kmeans");
  }
  if (depths.finest != depths.partition || !model.levels.empty())
  {
    reader.Fail("\"levels\" are none of this partitioner's");
  }
  if (model.partitions <= most / 2)
  {
    reader.Fail("\"partitions\" does not fit \"partition_depth\"");
  }
}

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

void ReadUnused(JsonReader& reader, const JsonValue& object, ModelDescription& model)
{
  const JsonValue* unused = reader.Find(object, "unused", false);
  if (!unused)
  {
    return;
  }
  UnusedDescription& told = model.unused.emplace();
  told.vertices = reader.Integer(*unused, "vertices", 1, mostCount);
  told.bytes = reader.Integer(*unused, "bytes", 0, mostCount);
  told.farthest = reader.Vector(*unused, "farthest");
}

AttributeInfo ReadStoredAttribute(JsonReader& reader, const JsonValue& object)
{
  AttributeInfo attribute;
  attribute.name = reader.Text(object, "name", longestAttributeName);
  attribute.type = static_cast<AttributeType>(
    reader.Integer(object, "type", 0, static_cast<std::uint64_t>(AttributeType::Float64)));
  attribute.association =
    static_cast<AttributeAssociation>(reader.Integer(object, "association", 0, 1));
  attribute.components = reader.Small<std::uint8_t>(object, "components", 1, 255);
  if (!IsAttributeName(attribute.name))
  {
    reader.Fail("\"name\" of an attribute is no text");
  }
  return attribute;
}

// The members of a resolution, up to where the depth of a level belongs, and from there on.
void PutResolution(JsonWriter& json, const ResolutionDescription& resolution, const int* depth)
{
  json.BeginObject().Member("bytes", resolution.bytes);
  if (depth)
  {
    json.Member("depth", *depth);
  }
  json.Member("deviation", resolution.deviation)
    .Member("deviation_99", resolution.deviation99)
    .Member("pieces", resolution.pieces);
  if (depth)
  {
    json.Member("spacing", resolution.spacing);
  }
  json.Member("triangles", resolution.triangles)
    .Member("vertices", resolution.vertices)
    .EndObject();
}

void PutStoredLevels(JsonWriter& json, const std::vector<ResolutionDescription>& levels)
{
  json.BeginArray();
  for (int depth = 0; depth < static_cast<int>(levels.size()); ++depth)
  {
    PutResolution(json, levels[static_cast<std::size_t>(depth)], &depth);
  }
  json.EndArray();
}

void PutGrid(JsonWriter& json, const CoordinateGrid& grid)
{
  json.BeginObject()
    .Member("bits", grid.bits)
    .Member("origin", grid.origin)
    .Member("scalar_type", static_cast<unsigned>(grid.scalarType))
    .Member("step", grid.step)
    .EndObject();
}

void PutNumberedAttributes(JsonWriter& json, const std::vector<AttributeInfo>& attributes)
{
  json.BeginArray();
  for (const AttributeInfo& attribute : attributes)
  {
    json.BeginObject()
      .Member("association", static_cast<unsigned>(attribute.association))
      .Member("components", attribute.components)
      .Member("name", attribute.name)
      .Member("type", static_cast<unsigned>(attribute.type))
      .EndObject();
  }
  json.EndArray();
}

void PutBox(JsonWriter& json, const Box& box)
{
  json.BeginObject().Member("hi", box.hi).Member("lo", box.lo).EndObject();
}

}

std::string WriteStoredModel(const ModelDescription& model, std::string (*number)(double))
{
  JsonWriter json({ 0, number });
  json.BeginObject().Key("attributes");
  PutNumberedAttributes(json, model.attributes);
  json.Key("box");
  PutBox(json, model.box);
  json.Member("credit", model.credit);
  PutUnlessEmpty(json, "description", model.description);
  json.Member("digest", model.digest).Member("finest_depth", model.depths.finest).Key("grid");
  PutGrid(json, model.grid);
  json.Member("inconsistent_edges", model.inconsistentEdges).Member("input", model.input);
  PutUnlessEmpty(json, "input_digest", model.inputDigest);
  json.Member("largest_partition", model.largestPartition)
    .Member("level_maker", model.levelMaker)
    .Key("levels");
  PutStoredLevels(json, model.levels);
  json.Member("license", model.license).Key("original");
  PutResolution(json, model.original, nullptr);
  json.Member("partition_depth", model.depths.partition)
    .Member("partitioner", model.partitioner)
    .Member("partitions", model.partitions);
  PutPose(json, model);
  json.Member("primitive", static_cast<unsigned>(model.primitive))
    .Member("representative", model.representative);
  PutScalars(json, model);
  json.Member("sheets", model.sheets)
    .Member("smallest_partition", model.smallestPartition)
    .Member("stitch_depth", model.depths.stitch);
  PutTextures(json, model);
  json.Member("title", model.title).Member("triangles", model.triangles).Member("unit", model.unit);
  PutUnused(json, model);
  json.Member("vertices", model.vertices)
    .Member("weld", model.weld)
    .Member("welded", model.welded)
    .EndObject();
  return json.Text();
}

Result<ModelDescription> ParseStoredModel(std::string_view text)
{
  const Result<JsonDocument> parsed = ParseJson(text);
  if (!parsed)
  {
    return Error{ ErrorCode::Damaged, "the metadata: " + parsed.GetError().message };
  }
  const JsonValue& json = *parsed;
  JsonReader reader("the metadata");
  ModelDescription model;
  const auto textOf = [&](const char* key) { return reader.Text(json, key, text.size()); };
  model.digest = textOf("digest");
  ReadShared(reader, json, model);
  ReadPartitioner(reader, json, model);
  if (const JsonValue* grid = reader.Find(json, "grid"))
  {
    ReadGrid(reader, *grid, model.grid);
  }
  model.primitive = static_cast<PrimitiveType>(reader.Integer(json, "primitive", 0, 1));
  if (const JsonValue* attributes = reader.Array(json, "attributes", mostAttributes))
  {
    for (const JsonValue& attribute : attributes->GetArray())
    {
      model.attributes.push_back(ReadStoredAttribute(reader, attribute));
    }
  }
  ReadScalars(reader, json, model);
  ReadTexts(reader, json, text.size(), model);
  model.input = textOf("input");
  model.inputDigest = reader.Text(json, "input_digest", text.size(), false);
  if (!model.inputDigest.empty() && !IsDigest(model.inputDigest))
  {
    reader.Fail("\"input_digest\" has not 32 hexadecimal digits");
  }
  model.welded = reader.Integer(json, "welded", 0, mostCount);
  model.inconsistentEdges = reader.Integer(json, "inconsistent_edges", 0, mostCount);
  model.smallestPartition = reader.Integer(json, "smallest_partition", 0, mostCount);
  model.largestPartition = reader.Integer(json, "largest_partition", 0, mostCount);
  ReadUnused(reader, json, model);
  model.levelMaker = textOf("level_maker");
  model.representative = textOf("representative");
  model.sheets = reader.Boolean(json, "sheets");
  model.weld = reader.Boolean(json, "weld");
  if (!reader.Good())
  {
    return Error{ ErrorCode::Damaged, reader.Fault() };
  }
  return model;
}

void PutStatistics(JsonWriter& json, const ModelDescription& model, std::uint64_t storeBytes)
{
  json.Member("input", model.input);
  PutUnlessEmpty(json, "input_digest", model.inputDigest);
  json.Member("vertices", model.vertices)
    .Member("triangles", model.triangles)
    .Member("partitions", model.partitions)
    .Member("partition_depth", model.depths.partition)
    .Member("stitch_depth", model.depths.stitch)
    .Member("finest_depth", model.depths.finest)
    .Member("welded", model.welded)
    .Member("inconsistent_edges", model.inconsistentEdges);
  json.Key("partition_vertices")
    .BeginObject()
    .Member("min", model.smallestPartition)
    .Member("max", model.largestPartition)
    .EndObject();
  json.Member("partition_bytes", model.original.bytes).Key("levels");
  PutStoredLevels(json, model.levels);
  json.Key("precision");
  PutBits(json, model.grid);
  json.Member("scalar_type", NameOf(model.grid.scalarType))
    .Member("primitive", NameOf(model.primitive))
    .Key("box");
  PutBox(json, model.box);
  json.Key("attributes");
  PutAttributes(json, model.attributes);
  PutScalars(json, model);
  json.Member("partitioner", model.partitioner)
    .Member("level_maker", model.levelMaker)
    .Member("representative", model.representative)
    .Member("sheets", model.sheets)
    .Member("weld", model.weld);
  PutTexts(json, model);
  PutPose(json, model);
  PutTextures(json, model, "tiles");
  PutUnused(json, model);
  json.Member("store_bytes", storeBytes).Member("digest", model.digest);
}

}
