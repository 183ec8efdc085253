// SPDX-License-Identifier: BSD-3-Clause
// The JSON of a description, and of the list of models.
//
// A store has the description with the facts of the build. A server sends it without these facts,
// but with the model's id; and also with the access level, if a client may not have everything.
#include "filters/model/ModelJson.h"

#include "filters/core/Texts.h"
#include "filters/model/ModelMembers.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace kdstream
{
namespace
{

constexpr std::size_t mostTextBytes = 4096;
constexpr std::size_t mostModels = 65536;

void PutPrecision(JsonWriter& json, const CoordinateGrid& grid)
{
  json.BeginObject()
    .Member("scalar_type", NameOf(grid.scalarType))
    .Member("origin", grid.origin)
    .Member("step", grid.step)
    .Key("bits");
  PutBits(json, grid);
  json.EndObject();
}

// The value, of two or more, whose name is in member `key`.
template <class T>
T ReadName(
  JsonReader& reader, const JsonValue& object, const char* key, T first, T last, const char* fault)
{
  const std::string name = reader.Text(object, key, 16);
  for (auto i = static_cast<int>(first); i <= static_cast<int>(last); ++i)
  {
    if (name == NameOf(static_cast<T>(i)))
    {
      return static_cast<T>(i);
    }
  }
  reader.Fail(fault);
  return first;
}

void ReadPrecision(JsonReader& reader, const JsonValue& object, CoordinateGrid& grid)
{
  const JsonValue* bits = reader.Find(object, "bits");
  const bool lossless = bits && bits->IsString() && TextOf(*bits) == "lossless";
  grid.bits = lossless ? std::uint8_t{ 0 } : reader.Small<std::uint8_t>(object, "bits", 8, 24);
  grid.scalarType = ReadName(reader, object, "scalar_type", ScalarType::Float32,
    ScalarType::Float64, "\"scalar_type\" is neither float32 nor float64");
  grid.origin = reader.Vector(object, "origin");
  grid.step = reader.Number(object, "step", std::numeric_limits<double>::denorm_min());
}

AttributeInfo ReadAttribute(JsonReader& reader, const JsonValue& object)
{
  AttributeInfo attribute;
  attribute.name = reader.Text(object, "name", longestAttributeName);
  attribute.type = ReadName(reader, object, "type", AttributeType::Int8, AttributeType::Float64,
    "\"type\" of an attribute is not a number type");
  attribute.association = ReadName(reader, object, "association", AttributeAssociation::Point,
    AttributeAssociation::Cell, "\"association\" is neither point nor cell");
  attribute.components = reader.Small<std::uint8_t>(object, "components", 1, 255);
  return attribute;
}

std::string ReadId(JsonReader& reader, const JsonValue& object)
{
  std::string id = reader.Text(object, "id", 128);
  if (!IsModelId(id))
  {
    reader.Fail("\"id\" is not a model id");
  }
  return id;
}

std::string ReadDigest(JsonReader& reader, const JsonValue& object)
{
  std::string digest = reader.Text(object, "digest", 32);
  if (!IsDigest(digest))
  {
    reader.Fail("\"digest\" must have 32 hexadecimal digits");
  }
  return digest;
}

Error TooLarge(std::size_t bytes, std::size_t most)
{
  return Error{ ErrorCode::LimitExceeded,
    std::to_string(bytes) + " bytes of JSON; the maximum is " + std::to_string(most) + "" };
}

}

void PutDescription(JsonWriter& json, const ModelDescription& model)
{
  json.Member("digest", model.digest)
    .Member("vertices", model.vertices)
    .Member("triangles", model.triangles)
    .Member("partitions", model.partitions);
  json.Key("box");
  PutBox(json, model.box);
  json.Member("partition_depth", model.depths.partition)
    .Member("stitch_depth", model.depths.stitch)
    .Member("finest_depth", model.depths.finest);
  json.Key("precision");
  PutPrecision(json, model.grid);
  json.Member("primitive", NameOf(model.primitive)).Key("levels");
  PutLevels(json, model.levels);
  json.Key("original").BeginObject();
  PutResolution(json, model.original);
  json.EndObject();
  PutTexts(json, model);
  PutHomeView(json, model);
  PutTextures(json, model);
  json.Key("attributes");
  PutAttributes(json, model.attributes);
  PutScalars(json, model);
}

void ReadDescription(
  JsonReader& reader, const JsonValue& json, std::size_t mostText, ModelDescription& model)
{
  model.digest = ReadDigest(reader, json);
  ReadShared(reader, json, model);
  if (const JsonValue* precision = reader.Find(json, "precision"))
  {
    ReadPrecision(reader, *precision, model.grid);
  }
  model.primitive = ReadName(reader, json, "primitive", PrimitiveType::Points,
    PrimitiveType::Triangles, "\"primitive\" is neither triangles nor points");
  ReadTexts(reader, json, mostText, model);
  if (const JsonValue* attributes = reader.Array(json, "attributes", mostAttributes))
  {
    for (const JsonValue& attribute : attributes->GetArray())
    {
      model.attributes.push_back(ReadAttribute(reader, attribute));
    }
  }
  ReadScalars(reader, json, model);
}

// Writes the members that a server adds: the id, and how much of the model the client may have.
void PutModel(JsonWriter& json, const ModelDescription& model)
{
  json.BeginObject().Member("id", model.id);
  PutDescription(json, model);
  if (model.detail != ModelDetail::Regions)
  {
    json.Member("detail", NameOf(model.detail));
  }
  json.EndObject();
}

std::string WriteModel(const ModelDescription& model)
{
  JsonWriter json;
  PutModel(json, model);
  return json.Text();
}

std::string WriteModelList(const std::vector<ModelSummary>& models, const SiteDescription& site)
{
  JsonWriter json;
  json.BeginObject();
  if (!site.title.empty() || !site.text.empty())
  {
    json.Key("site").BeginObject();
    PutUnlessEmpty(json, "title", site.title);
    PutUnlessEmpty(json, "text", site.text);
    json.EndObject();
  }
  json.Key("models").BeginArray();
  for (const ModelSummary& model : models)
  {
    json.BeginObject()
      .Member("id", model.id)
      .Member("digest", model.digest)
      .Member("title", model.title)
      .Member("vertices", model.vertices)
      .Member("triangles", model.triangles);
    PutUnlessEmpty(json, "description", model.description);
    if (model.notes > 0)
    {
      json.Member("notes", model.notes);
    }
    json.EndObject();
  }
  json.EndArray().EndObject();
  return json.Text();
}

Result<ModelDescription> ParseModel(std::string_view text)
{
  if (text.size() > maximumModelBytes)
  {
    return TooLarge(text.size(), maximumModelBytes);
  }
  const auto json = ParseJson(text);
  KDSTREAM_TRY(json);
  return ModelFromJson(*json);
}

Status CheckServed(const ModelDescription& model)
{
  const auto fault = [](const char* member, const std::string& what) {
    return Error{ ErrorCode::InvalidInput, std::string("model: \"") + member + "\" " + what };
  };
  if (!IsModelId(model.id))
  {
    return fault("id", "is not a model id");
  }
  if (!IsDigest(model.digest))
  {
    return fault("digest", "must have 32 hexadecimal digits");
  }
  const std::pair<const char*, const std::string*> texts[] = { { "title", &model.title },
    { "credit", &model.credit }, { "license", &model.license }, { "unit", &model.unit },
    { "description", &model.description } };
  for (const auto& [member, text] : texts)
  {
    if (text->size() > mostTextBytes)
    {
      return fault(member, "is longer than " + std::to_string(mostTextBytes) + " bytes");
    }
  }
  const std::size_t bytes = WriteModel(model).size();
  return bytes > maximumModelBytes ? Status(TooLarge(bytes, maximumModelBytes)) : Status();
}

Result<ModelDescription> ModelFromJson(const JsonValue& json)
{
  JsonReader reader("model");
  ModelDescription model;
  model.id = ReadId(reader, json);
  ReadDescription(reader, json, mostTextBytes, model);
  if (json.IsObject() && FindMember(json, "detail"))
  {
    model.detail = ReadName(reader, json, "detail", ModelDetail::Preview, ModelDetail::Regions,
      "\"detail\" must be preview, levels or regions");
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
  if (const JsonValue* list = reader.Array(*json, "models", mostModels))
  {
    for (const JsonValue& entry : list->GetArray())
    {
      ModelSummary& model = models.emplace_back();
      model.id = ReadId(reader, entry);
      model.digest = ReadDigest(reader, entry);
      model.title = reader.Text(entry, "title", mostTextBytes, false);
      model.vertices = reader.Integer(entry, "vertices", 1, mostCount);
      model.triangles = reader.Integer(entry, "triangles", 0, mostCount);
      model.description = reader.Text(entry, "description", mostTextBytes, false);
      if (reader.Find(entry, "notes", false))
      {
        model.notes = reader.Integer(entry, "notes", 0, mostCount);
      }
    }
  }
  if (!reader.Good())
  {
    return Error{ ErrorCode::InvalidInput, reader.Fault() };
  }
  return models;
}

}
