// SPDX-License-Identifier: BSD-3-Clause
#include "filters/model/ModelMembers.h"

#include "filters/core/VectorMath.h"

#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace kdstream
{
namespace
{

ResolutionDescription ReadResolution(JsonReader& reader, const JsonValue& object)
{
  ResolutionDescription resolution;
  resolution.vertices = reader.Integer(object, "vertices", 0, mostCount);
  resolution.triangles = reader.Integer(object, "triangles", 0, mostCount);
  resolution.pieces = reader.Integer(object, "pieces", 0, std::uint64_t{ 1 } << maximumDepth);
  resolution.bytes = reader.Integer(object, "bytes", 0, mostCount);
  resolution.geometricError = reader.Number(object, "deviation", 0);
  resolution.geometricError99 = reader.Number(object, "deviation_99", 0);
  return resolution;
}

void ReadDepths(JsonReader& reader, const JsonValue& object, ModelDescription& model)
{
  TreeDepths& depths = model.depths;
  depths.partition = reader.Small<unsigned>(object, "partition_depth", 0, maximumDepth);
  depths.finest = reader.Small<unsigned>(object, "finest_depth", depths.partition, maximumDepth);
  depths.stitch = reader.Small<unsigned>(object, "stitch_depth", depths.partition, depths.finest);
  model.partitions =
    reader.Integer(object, "partitions", 1, std::uint64_t{ 1 } << depths.partition);
}

void ReadBox(JsonReader& reader, const JsonValue& object, Box& box)
{
  const JsonValue* corners = reader.Find(object, "box");
  if (!corners)
  {
    return;
  }
  box.lo = reader.Vector(*corners, "lo");
  box.hi = reader.Vector(*corners, "hi");
  for (std::size_t k = 0; k < 3; ++k)
  {
    if (box.lo[k] > box.hi[k])
    {
      reader.Fail("\"box\" has a minimum above its maximum");
    }
  }
}

void ReadLevels(JsonReader& reader, const JsonValue& object, ModelDescription& model)
{
  const JsonValue* levels = reader.Array(object, "levels", maximumDepth + 1);
  if (!levels)
  {
    return;
  }
  const std::size_t count = levels->Size();
  if (count != 0 && count != model.depths.finest + std::size_t{ 1 })
  {
    reader.Fail("\"levels\" has " + std::to_string(count) + " entries, not 0 or " +
                std::to_string(model.depths.finest + 1));
    return;
  }
  for (std::size_t depth = 0; depth < count; ++depth)
  {
    reader.Integer((*levels)[depth], "depth", depth, depth);
    ResolutionDescription& level =
      model.levels.emplace_back(ReadResolution(reader, (*levels)[depth]));
    level.spacing = reader.Small<std::uint32_t>((*levels)[depth], "spacing", 1, mostSpacing);
    if (reader.Find((*levels)[depth], "tile_bytes", false))
    {
      level.tileBytes = reader.Integer((*levels)[depth], "tile_bytes", 1, mostCount);
      level.texels = reader.Integer((*levels)[depth], "texels", 0, mostCount);
    }
  }
}

void ReadHomeView(JsonReader& reader, const JsonValue& object, ModelDescription& model)
{
  const JsonValue* homeView = reader.Find(object, "pose", false);
  if (!homeView)
  {
    return;
  }
  const JsonValue* guessed = reader.Find(*homeView, "guessed");
  model.homeView = { reader.Vector(*homeView, "up"), reader.Vector(*homeView, "view"),
    guessed && guessed->IsTrue() };
  const auto isLong = [](const Vec3& vector) { return std::abs(Dot(vector, vector) - 1) < 0.01; };
  if (!(guessed && guessed->IsBool() && isLong(model.homeView->up) && isLong(model.homeView->view)))
  {
    reader.Fail("\"pose\" is invalid: \"up\" and \"view\" must be directions");
  }
}

void ReadTextures(JsonReader& reader, const JsonValue& object, ModelDescription& model)
{
  const JsonValue* textures = reader.Find(object, "textures", false);
  if (!textures)
  {
    return;
  }
  TextureDescription& reported = model.textures.emplace();
  reported.format = reader.Text(*textures, "format", 16);
  reported.lossless = reader.Boolean(*textures, "lossless");
  reported.bytes = reader.Integer(*textures, "bytes", 0, mostCount);
  reported.texels = reader.Integer(*textures, "texels", 0, mostCount);
  if (reader.Find(*textures, "levels", false))
  {
    reported.levels = reader.Boolean(*textures, "levels");
  }
}

// Takes numbers one after the other; each must be at least as large as the one before.
class AscendingNumbers
{
public:
  double Take(const JsonValue& number)
  {
    const double value = NumberOf(number);
    this->Ascends = this->Ascends && value >= this->Before;
    this->Before = value;
    return value;
  }
  bool AllAscend() const { return this->Ascends; }

private:
  double Before = -std::numeric_limits<double>::infinity();
  bool Ascends = true;
};

bool TakeRange(const JsonValue& range, ScalarDescription& scalar)
{
  AscendingNumbers numbers;
  std::size_t i = 0;
  for (double* const value : { &scalar.least, &scalar.low, &scalar.high, &scalar.most })
  {
    *value = i < range.Size() ? numbers.Take(range[i++]) : std::nan("");
  }
  return numbers.AllAscend() && scalar.most >= scalar.high;
}

// Reads a list with each value followed by its number of vertices.
bool TakeClasses(const JsonValue& list, std::vector<ScalarDescription::Class>& classes)
{
  AscendingNumbers values;
  for (std::size_t i = 0; i + 1 < list.Size(); i += 2)
  {
    if (!list[i + 1].IsUint64())
    {
      return false;
    }
    classes.push_back({ values.Take(list[i]), list[i + 1].GetUint64() });
  }
  return values.AllAscend() && list.Size() % 2 == 0;
}

}

std::string_view NameOf(ScalarType type)
{
  return type == ScalarType::Float64 ? "float64" : "float32";
}

std::string_view NameOf(PrimitiveType type)
{
  return type == PrimitiveType::Points ? "points" : "triangles";
}

std::string_view NameOf(AttributeAssociation association)
{
  return association == AttributeAssociation::Point ? "point" : "cell";
}

void PutAttributes(JsonWriter& json, const std::vector<AttributeInfo>& attributes)
{
  json.BeginArray();
  for (const AttributeInfo& attribute : attributes)
  {
    json.BeginObject()
      .Member("name", attribute.name)
      .Member("type", NameOf(attribute.type))
      .Member("association", NameOf(attribute.association))
      .Member("components", attribute.components)
      .EndObject();
  }
  json.EndArray();
}

void PutTexts(JsonWriter& json, const ModelDescription& model)
{
  json.Member("title", model.title)
    .Member("credit", model.credit)
    .Member("license", model.license)
    .Member("unit", model.unit);
  PutUnlessEmpty(json, "description", model.description);
}

void PutUnlessEmpty(JsonWriter& json, const char* key, const std::string& text)
{
  if (!text.empty())
  {
    json.Member(key, text);
  }
}

void PutHomeView(JsonWriter& json, const ModelDescription& model)
{
  if (model.homeView)
  {
    json.Key("pose")
      .BeginObject()
      .Member("guessed", model.homeView->guessed)
      .Member("up", model.homeView->up)
      .Member("view", model.homeView->view)
      .EndObject();
  }
}

void PutTextures(JsonWriter& json, const ModelDescription& model, const char* key)
{
  if (model.textures)
  {
    json.Key(key)
      .BeginObject()
      .Member("bytes", model.textures->bytes)
      .Member("format", model.textures->format);
    if (model.textures->levels)
    {
      json.Member("levels", true);
    }
    json.Member("lossless", model.textures->lossless)
      .Member("texels", model.textures->texels)
      .EndObject();
  }
}

void PutBox(JsonWriter& json, const Box& box)
{
  json.BeginObject().Member("lo", box.lo).Member("hi", box.hi).EndObject();
}

void PutResolution(JsonWriter& json, const ResolutionDescription& resolution)
{
  json.Member("vertices", resolution.vertices)
    .Member("triangles", resolution.triangles)
    .Member("pieces", resolution.pieces)
    .Member("bytes", resolution.bytes)
    .Member("deviation", resolution.geometricError)
    .Member("deviation_99", resolution.geometricError99);
}

void PutLevels(JsonWriter& json, const std::vector<ResolutionDescription>& levels)
{
  json.BeginArray();
  for (std::size_t depth = 0; depth < levels.size(); ++depth)
  {
    json.BeginObject().Member("depth", depth);
    PutResolution(json, levels[depth]);
    json.Member("spacing", levels[depth].spacing);
    if (levels[depth].tileBytes > 0)
    {
      json.Member("texels", levels[depth].texels).Member("tile_bytes", levels[depth].tileBytes);
    }
    json.EndObject();
  }
  json.EndArray();
}

void PutUnused(JsonWriter& json, const ModelDescription& model)
{
  if (model.unused)
  {
    json.Key("unused")
      .BeginObject()
      .Member("bytes", model.unused->bytes)
      .Member("farthest", model.unused->farthest)
      .Member("vertices", model.unused->vertices)
      .EndObject();
  }
}

void PutScalars(JsonWriter& json, const ModelDescription& model)
{
  if (model.scalars.empty())
  {
    return;
  }
  json.Key("scalars").BeginArray();
  for (const ScalarDescription& scalar : model.scalars)
  {
    json.BeginObject().Key("classes").BeginArray();
    for (const ScalarDescription::Class& each : scalar.classes)
    {
      json.Put(each.value).Put(each.vertices);
    }
    json.EndArray()
      .Member("name", scalar.name)
      .Member("range", std::array{ scalar.least, scalar.low, scalar.high, scalar.most })
      .EndObject();
  }
  json.EndArray();
}

void PutBits(JsonWriter& json, const CoordinateGrid& grid)
{
  if (grid.Lossless())
  {
    json.Put("lossless");
  }
  else
  {
    json.Put(grid.bits);
  }
}

void ReadShared(JsonReader& reader, const JsonValue& object, ModelDescription& model)
{
  model.vertices = reader.Integer(object, "vertices", 1, mostCount);
  model.triangles = reader.Integer(object, "triangles", 0, mostCount);
  ReadDepths(reader, object, model);
  ReadBox(reader, object, model.box);
  ReadLevels(reader, object, model);
  if (const JsonValue* original = reader.Find(object, "original"))
  {
    model.original = ReadResolution(reader, *original);
  }
  ReadHomeView(reader, object, model);
  ReadTextures(reader, object, model);
}

void ReadScalars(JsonReader& reader, const JsonValue& object, ModelDescription& model)
{
  if (!reader.Find(object, "scalars", false))
  {
    return;
  }
  std::vector<ScalarDescription> all;
  const JsonValue* scalars = reader.Array(object, "scalars", mostScalars);
  for (std::size_t i = 0; scalars && i < scalars->Size(); ++i)
  {
    const JsonValue& entry = (*scalars)[i];
    ScalarDescription& scalar = all.emplace_back();
    scalar.name = reader.Text(entry, "name", longestAttributeName);
    const JsonValue* range = reader.Array(entry, "range", 4);
    const JsonValue* classes = reader.Array(entry, "classes", 2 * ScalarDescription::mostClasses);
    if (!range || !classes || !TakeRange(*range, scalar) || !TakeClasses(*classes, scalar.classes))
    {
      reader.Fail("\"scalars\" have values that do not ascend");
    }
  }
  model.scalars = std::move(all);
}

void ReadTexts(
  JsonReader& reader, const JsonValue& object, std::size_t mostBytes, ModelDescription& model)
{
  model.title = reader.Text(object, "title", mostBytes, false);
  model.credit = reader.Text(object, "credit", mostBytes, false);
  model.license = reader.Text(object, "license", mostBytes, false);
  model.unit = reader.Text(object, "unit", mostBytes, false);
  model.description = reader.Text(object, "description", mostBytes, false);
}

}
