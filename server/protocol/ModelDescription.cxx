#include "server/protocol/ModelDescription.h"

#include "server/protocol/ModelJson.h"
#include "server/protocol/ResourcePath.h"

#include <algorithm>
#include <limits>

namespace kdstream::protocol
{

namespace
{

// Every integer up to here is exact in a client whose numbers are doubles.
constexpr std::uint64_t mostCount = std::uint64_t{ 1 } << 53;
constexpr std::size_t mostTextBytes = 4096;
constexpr std::size_t mostAttributes = 256;
constexpr std::size_t mostAttributeNameBytes = 256;
constexpr std::size_t mostModels = 65536;

constexpr std::string_view attributeTypes[] = { "int8", "uint8", "int16", "uint16", "int32",
  "uint32", "int64", "uint64", "float32", "float64" };

// The members of a resolution, without the object around them.
void PutResolution(JsonWriter& writer, const ResolutionDescription& resolution)
{
  writer.Member("vertices", resolution.vertices);
  writer.Member("triangles", resolution.triangles);
  writer.Member("pieces", resolution.pieces);
  writer.Member("bytes", resolution.bytes);
  writer.Member("deviation", resolution.deviation);
  writer.Member("deviation_99", resolution.deviation99);
}

ResolutionDescription ResolutionFromJson(JsonReader& reader, const Json& object)
{
  ResolutionDescription resolution;
  resolution.vertices = reader.Integer(object, "vertices", 0, mostCount);
  resolution.triangles = reader.Integer(object, "triangles", 0, mostCount);
  resolution.pieces = reader.Integer(object, "pieces", 0, std::uint64_t{ 1 } << maximumDepth);
  resolution.bytes = reader.Integer(object, "bytes", 0, mostCount);
  resolution.deviation = reader.Number(object, "deviation", 0);
  resolution.deviation99 = reader.Number(object, "deviation_99", 0);
  return resolution;
}

void PutPrecision(JsonWriter& writer, const ModelDescription& model)
{
  writer.BeginObject();
  writer.Member("scalar_type", model.doublePrecision ? "float64" : "float32");
  writer.Member("origin", model.gridOrigin);
  writer.Member("step", model.gridStep);
  if (model.bits == 0)
  {
    writer.Member("bits", "lossless");
  }
  else
  {
    writer.Member("bits", model.bits);
  }
  writer.EndObject();
}

void PrecisionFromJson(JsonReader& reader, const Json& object, ModelDescription& model)
{
  const Json* bits = reader.Find(object, "bits");
  if (bits && bits->IsString() && TextOf(*bits) == "lossless")
  {
    model.bits = 0;
  }
  else
  {
    model.bits = reader.Small<std::uint8_t>(object, "bits", 8, 24);
  }
  const auto scalarType = reader.Text(object, "scalar_type", 16);
  if (scalarType != "float32" && scalarType != "float64")
  {
    reader.Fail("\"scalar_type\" is neither float32 nor float64");
  }
  model.doublePrecision = scalarType == "float64";
  model.gridOrigin = reader.Vector(object, "origin");
  model.gridStep = reader.Number(object, "step", std::numeric_limits<double>::denorm_min());
}

void PutAttribute(JsonWriter& writer, const AttributeDescription& attribute)
{
  writer.BeginObject();
  writer.Member("name", attribute.name);
  writer.Member("type", attribute.type);
  writer.Member("association", attribute.association);
  writer.Member("components", attribute.components);
  writer.EndObject();
}

AttributeDescription AttributeFromJson(JsonReader& reader, const Json& object)
{
  AttributeDescription attribute;
  attribute.name = reader.Text(object, "name", mostAttributeNameBytes);
  attribute.type = reader.Text(object, "type", 16);
  if (std::find(std::begin(attributeTypes), std::end(attributeTypes), attribute.type) ==
      std::end(attributeTypes))
  {
    reader.Fail("\"type\" of an attribute is no type of numbers");
  }
  attribute.association = reader.Text(object, "association", 16);
  if (attribute.association != "point" && attribute.association != "cell")
  {
    reader.Fail("\"association\" is neither point nor cell");
  }
  attribute.components = reader.Small<std::uint8_t>(object, "components", 1, 255);
  return attribute;
}

void IdentityFromJson(JsonReader& reader, const Json& object, std::string& id, std::string& digest)
{
  id = reader.Text(object, "id", 128);
  if (!IsModelId(id))
  {
    reader.Fail("\"id\" is no model id");
  }
  digest = reader.Text(object, "digest", 32);
  if (!IsDigest(digest))
  {
    reader.Fail("\"digest\" has not 32 hexadecimal digits");
  }
}

void DepthsFromJson(JsonReader& reader, const Json& object, ModelDescription& model)
{
  model.partitionDepth = reader.Small<std::uint8_t>(object, "partition_depth", 0, maximumDepth);
  model.finestDepth =
    reader.Small<std::uint8_t>(object, "finest_depth", model.partitionDepth, maximumDepth);
  model.stitchDepth =
    reader.Small<std::uint8_t>(object, "stitch_depth", model.partitionDepth, model.finestDepth);
  model.partitions =
    reader.Integer(object, "partitions", 1, std::uint64_t{ 1 } << model.partitionDepth);
}

void BoxFromJson(JsonReader& reader, const Json& object, ModelDescription& model)
{
  const Json* box = reader.Find(object, "box");
  if (!box)
  {
    return;
  }
  model.boxLo = reader.Vector(*box, "lo");
  model.boxHi = reader.Vector(*box, "hi");
  for (std::size_t k = 0; k < 3; ++k)
  {
    if (model.boxLo[k] > model.boxHi[k])
    {
      reader.Fail("\"box\" is inside out");
    }
  }
}

void LevelsFromJson(JsonReader& reader, const Json& object, ModelDescription& model)
{
  const Json* levels = reader.Array(object, "levels", maximumDepth + 1);
  if (!levels)
  {
    return;
  }
  const rapidjson::SizeType count = levels->Size();
  if (count != 0 && count != model.finestDepth + std::size_t{ 1 })
  {
    reader.Fail("\"levels\" has " + std::to_string(count) + " entries, not 0 or " +
                std::to_string(model.finestDepth + 1));
    return;
  }
  for (rapidjson::SizeType depth = 0; depth < count; ++depth)
  {
    reader.Integer((*levels)[depth], "depth", depth, depth);
    model.levels.push_back(ResolutionFromJson(reader, (*levels)[depth]));
  }
}

Error TooLarge(std::size_t bytes, std::size_t most)
{
  return Error{ ErrorCode::LimitExceeded, std::to_string(bytes) + " bytes of JSON, where at most " +
                                            std::to_string(most) + " are taken" };
}

}

void PutModel(JsonWriter& writer, const ModelDescription& model)
{
  writer.BeginObject();
  writer.Member("id", model.id);
  writer.Member("digest", model.digest);
  writer.Member("vertices", model.vertices);
  writer.Member("triangles", model.triangles);
  writer.Member("partitions", model.partitions);
  writer.Key("box");
  writer.BeginObject();
  writer.Member("lo", model.boxLo);
  writer.Member("hi", model.boxHi);
  writer.EndObject();
  writer.Member("partition_depth", model.partitionDepth);
  writer.Member("stitch_depth", model.stitchDepth);
  writer.Member("finest_depth", model.finestDepth);
  writer.Key("precision");
  PutPrecision(writer, model);
  writer.Member("primitive", model.hasTriangles ? "triangles" : "points");
  writer.Key("levels");
  writer.BeginArray();
  for (std::size_t depth = 0; depth < model.levels.size(); ++depth)
  {
    writer.BeginObject();
    writer.Member("depth", depth);
    PutResolution(writer, model.levels[depth]);
    writer.EndObject();
  }
  writer.EndArray();
  writer.Key("original");
  writer.BeginObject();
  PutResolution(writer, model.original);
  writer.EndObject();
  writer.Member("title", model.title);
  writer.Member("credit", model.credit);
  writer.Member("license", model.license);
  writer.Member("unit", model.unit);
  writer.Key("attributes");
  writer.BeginArray();
  for (const auto& attribute : model.attributes)
  {
    PutAttribute(writer, attribute);
  }
  writer.EndArray();
  writer.EndObject();
}

ModelSummary Summarize(const ModelDescription& model)
{
  return { model.id, model.digest, model.title, model.vertices, model.triangles };
}

unsigned PieceDepth(const ModelDescription& model, unsigned depth)
{
  return std::min<unsigned>(model.partitionDepth, depth > 11 ? depth - 11 : 0);
}

unsigned PreviewLevel(const ModelDescription& model)
{
  return std::min<unsigned>(model.finestDepth, 11);
}

std::string WriteModel(const ModelDescription& model)
{
  JsonWriter writer;
  PutModel(writer, model);
  return writer.Text();
}

std::string WriteModelList(const std::vector<ModelSummary>& models)
{
  JsonWriter writer;
  writer.BeginObject();
  writer.Key("models");
  writer.BeginArray();
  for (const auto& model : models)
  {
    writer.BeginObject();
    writer.Member("id", model.id);
    writer.Member("digest", model.digest);
    writer.Member("title", model.title);
    writer.Member("vertices", model.vertices);
    writer.Member("triangles", model.triangles);
    writer.EndObject();
  }
  writer.EndArray();
  writer.EndObject();
  return writer.Text();
}

Result<ModelDescription> ParseModel(std::string_view text)
{
  if (text.size() > maximumModelBytes)
  {
    return TooLarge(text.size(), maximumModelBytes);
  }
  const auto json = ParseJson(text);
  return json ? ModelFromJson(*json) : json.GetError();
}

Result<ModelDescription> ModelFromJson(const Json& json)
{
  JsonReader reader("model");
  ModelDescription model;
  IdentityFromJson(reader, json, model.id, model.digest);
  model.vertices = reader.Integer(json, "vertices", 1, mostCount);
  model.triangles = reader.Integer(json, "triangles", 0, mostCount);
  DepthsFromJson(reader, json, model);
  BoxFromJson(reader, json, model);
  if (const Json* precision = reader.Find(json, "precision"))
  {
    PrecisionFromJson(reader, *precision, model);
  }
  const auto primitive = reader.Text(json, "primitive", 16);
  if (primitive != "triangles" && primitive != "points")
  {
    reader.Fail("\"primitive\" is neither triangles nor points");
  }
  model.hasTriangles = primitive == "triangles";
  LevelsFromJson(reader, json, model);
  if (const Json* original = reader.Find(json, "original"))
  {
    model.original = ResolutionFromJson(reader, *original);
  }
  model.title = reader.Text(json, "title", mostTextBytes, false);
  model.credit = reader.Text(json, "credit", mostTextBytes, false);
  model.license = reader.Text(json, "license", mostTextBytes, false);
  model.unit = reader.Text(json, "unit", mostTextBytes, false);
  if (const Json* attributes = reader.Array(json, "attributes", mostAttributes))
  {
    for (const Json& attribute : attributes->GetArray())
    {
      model.attributes.push_back(AttributeFromJson(reader, attribute));
    }
  }
  if (!reader.Good())
  {
    return Error{ ErrorCode::InvalidInput, reader.Fault() };
  }
  return model;
}

Result<std::vector<ModelSummary>> ParseModelList(std::string_view text)
{
  if (text.size() > maximumModelListBytes)
  {
    return TooLarge(text.size(), maximumModelListBytes);
  }
  const auto json = ParseJson(text);
  KDSTREAM_TRY(json);
  JsonReader reader("models");
  std::vector<ModelSummary> models;
  if (const Json* list = reader.Array(*json, "models", mostModels))
  {
    for (const Json& entry : list->GetArray())
    {
      ModelSummary& model = models.emplace_back();
      IdentityFromJson(reader, entry, model.id, model.digest);
      model.title = reader.Text(entry, "title", mostTextBytes, false);
      model.vertices = reader.Integer(entry, "vertices", 1, mostCount);
      model.triangles = reader.Integer(entry, "triangles", 0, mostCount);
    }
  }
  if (!reader.Good())
  {
    return Error{ ErrorCode::InvalidInput, reader.Fault() };
  }
  return models;
}

}
