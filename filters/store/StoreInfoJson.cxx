// The metadata of a store as JSON: the value of the row "model", checked field by field when it is
// read.
#include "filters/store/StoreSchema.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace kdstream
{
namespace
{

using Json = nlohmann::json;

Json ToJson(const ResolutionInfo& info)
{
  Json json{ { "vertices", info.vertices }, { "triangles", info.triangles },
    { "pieces", info.pieces }, { "bytes", info.bytes }, { "deviation", info.deviation },
    { "deviation_99", info.deviation99 } };
  if (!info.resolution.IsOriginal())
  {
    json["depth"] = info.resolution.Depth();
  }
  return json;
}

// Takes fields out of a JSON object; remembers the first that is missing or out of range.
class Fields
{
public:
  Fields(const Json& json, std::string& problem)
    : Object(json)
    , Problem(problem)
  {
  }

  std::uint64_t Count(const char* key, std::uint64_t most = ~std::uint64_t{ 0 }) const
  {
    const Json* value = this->Find(key);
    if (!value || !value->is_number_unsigned() || value->get<std::uint64_t>() > most)
    {
      this->Bad(key);
      return 0;
    }
    return value->get<std::uint64_t>();
  }
  double Number(const char* key) const
  {
    const Json* value = this->Find(key);
    if (!value || !value->is_number())
    {
      this->Bad(key);
      return 0;
    }
    return value->get<double>();
  }
  std::string Text(const char* key) const
  {
    const Json* value = this->Find(key);
    if (!value || !value->is_string())
    {
      this->Bad(key);
      return {};
    }
    return value->get<std::string>();
  }
  bool Flag(const char* key) const
  {
    const Json* value = this->Find(key);
    if (!value || !value->is_boolean())
    {
      this->Bad(key);
      return false;
    }
    return value->get<bool>();
  }
  Vec3 Point(const char* key) const
  {
    Vec3 point{};
    const Json* value = this->Find(key);
    if (!value || !value->is_array() || value->size() != 3 ||
        !std::all_of(value->begin(), value->end(), [](const Json& v) { return v.is_number(); }))
    {
      this->Bad(key);
      return point;
    }
    for (std::size_t k = 0; k < 3; ++k)
    {
      point[k] = (*value)[k].get<double>();
    }
    return point;
  }
  const Json& List(const char* key) const
  {
    static const Json none = Json::array();
    const Json* value = this->Find(key);
    if (!value || !value->is_array())
    {
      this->Bad(key);
      return none;
    }
    return *value;
  }
  Fields Nested(const char* key) const
  {
    static const Json none = Json::object();
    const Json* value = this->Find(key);
    if (!value || !value->is_object())
    {
      this->Bad(key);
      return { none, this->Problem };
    }
    return { *value, this->Problem };
  }
  void Bad(const char* key) const
  {
    if (this->Problem.empty())
    {
      this->Problem = std::string("\"") + key + "\" is missing or wrong";
    }
  }

private:
  const Json* Find(const char* key) const
  {
    const auto found = this->Object.find(key);
    return found == this->Object.end() ? nullptr : &*found;
  }

  const Json& Object;
  std::string& Problem;
};

ResolutionInfo ResolutionFrom(const Fields& fields, Resolution resolution)
{
  ResolutionInfo info;
  info.resolution = resolution;
  info.vertices = fields.Count("vertices");
  info.triangles = fields.Count("triangles");
  info.pieces = fields.Count("pieces");
  info.bytes = fields.Count("bytes");
  info.deviation = fields.Number("deviation");
  info.deviation99 = fields.Number("deviation_99");
  return info;
}

void ReadGrid(const Fields& fields, CoordinateGrid& grid)
{
  grid.bits = static_cast<std::uint8_t>(fields.Count("bits", 24));
  grid.scalarType = static_cast<ScalarType>(fields.Count("scalar_type", 1));
  grid.origin = fields.Point("origin");
  grid.step = fields.Number("step");
  if ((grid.bits != 0 && grid.bits < 8) || !(grid.step > 0) || !std::isfinite(grid.step))
  {
    fields.Bad("grid");
  }
}

void ReadLevels(const Fields& fields, StoreInfo& info, std::string& problem)
{
  for (const Json& entry : fields.List("levels"))
  {
    const auto depth = static_cast<unsigned>(info.levels.size());
    if (!entry.is_object() || depth > Resolution::maximumLevel)
    {
      fields.Bad("levels");
      return;
    }
    info.levels.push_back(ResolutionFrom({ entry, problem }, Resolution::Level(depth)));
  }
  if (info.levels.size() != (info.HasLevels() ? info.depths.finest + std::size_t{ 1 } : 0))
  {
    fields.Bad("levels");
  }
}

// Depths and number of partitions have to fit the partitioner.
void ReadPartitioner(const Fields& fields, StoreInfo& info)
{
  info.partitioner = fields.Text("partitioner");
  info.partitions = fields.Count("partitions");
  const TreeDepths& depths = info.depths;
  const std::uint64_t most = std::uint64_t{ 1 } << depths.partition;
  if (info.HasLevels())
  {
    if (depths.finest < depths.partition ||
        depths.stitch != std::min(depths.finest, depths.partition + 4))
    {
      fields.Bad("finest_depth");
    }
    if (info.partitions != most)
    {
      fields.Bad("partitions");
    }
    return;
  }
  if (info.partitioner != "octree" && info.partitioner != "kmeans")
  {
    fields.Bad("partitioner");
  }
  if (depths.finest != depths.partition || depths.stitch != depths.partition)
  {
    fields.Bad("finest_depth");
  }
  if (info.partitions > most || info.partitions <= most / 2)
  {
    fields.Bad("partitions");
  }
}

void ReadAttributes(const Fields& fields, StoreInfo& info, std::string& problem)
{
  for (const Json& entry : fields.List("attributes"))
  {
    if (!entry.is_object())
    {
      fields.Bad("attributes");
      return;
    }
    const Fields attribute(entry, problem);
    info.attributes.push_back({ attribute.Text("name"),
      static_cast<AttributeType>(
        attribute.Count("type", static_cast<std::uint64_t>(AttributeType::Float64))),
      static_cast<AttributeAssociation>(attribute.Count("association", 1)),
      static_cast<std::uint8_t>(attribute.Count("components", 255)) });
    const AttributeInfo& last = info.attributes.back();
    if (last.components == 0 || !IsAttributeName(last.name) ||
        info.attributes.size() > mostAttributes)
    {
      fields.Bad("attributes");
      return;
    }
  }
}

}

std::string StoreInfoToJson(const StoreInfo& info)
{
  Json levels = Json::array();
  for (const ResolutionInfo& level : info.levels)
  {
    levels.push_back(ToJson(level));
  }
  Json attributes = Json::array();
  for (const AttributeInfo& attribute : info.attributes)
  {
    attributes.push_back({ { "name", attribute.name }, { "type", static_cast<int>(attribute.type) },
      { "association", static_cast<int>(attribute.association) },
      { "components", attribute.components } });
  }
  const Json json{ { "digest", info.digest }, { "input", info.input },
    { "partition_depth", info.depths.partition }, { "stitch_depth", info.depths.stitch },
    { "finest_depth", info.depths.finest },
    { "grid",
      { { "bits", info.grid.bits }, { "scalar_type", static_cast<int>(info.grid.scalarType) },
        { "origin", info.grid.origin }, { "step", info.grid.step } } },
    { "primitive", static_cast<int>(info.primitive) },
    { "box", { { "lo", info.box.lo }, { "hi", info.box.hi } } }, { "vertices", info.vertices },
    { "triangles", info.triangles }, { "partitions", info.partitions }, { "welded", info.welded },
    { "inconsistent_edges", info.inconsistentEdges },
    { "smallest_partition", info.smallestPartition },
    { "largest_partition", info.largestPartition }, { "levels", levels },
    { "original", ToJson(info.original) }, { "attributes", attributes }, { "title", info.title },
    { "credit", info.credit }, { "license", info.license }, { "unit", info.unit },
    { "partitioner", info.partitioner }, { "level_maker", info.levelMaker },
    { "representative", info.representative }, { "sheets", info.sheets }, { "weld", info.weld } };
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Result<StoreInfo> StoreInfoFromJson(std::string_view text)
{
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object())
  {
    return Error{ ErrorCode::Damaged, "the metadata is not JSON" };
  }
  std::string problem;
  const Fields fields(json, problem);
  StoreInfo info;
  constexpr std::uint64_t deepest = 30;
  info.digest = fields.Text("digest");
  info.input = fields.Text("input");
  info.depths.partition = static_cast<unsigned>(fields.Count("partition_depth", deepest));
  info.depths.stitch = static_cast<unsigned>(fields.Count("stitch_depth", deepest));
  info.depths.finest = static_cast<unsigned>(fields.Count("finest_depth", deepest));
  ReadPartitioner(fields, info);
  ReadGrid(fields.Nested("grid"), info.grid);
  info.primitive = static_cast<PrimitiveType>(fields.Count("primitive", 1));
  info.box.lo = fields.Nested("box").Point("lo");
  info.box.hi = fields.Nested("box").Point("hi");
  info.vertices = fields.Count("vertices");
  info.triangles = fields.Count("triangles");
  info.welded = fields.Count("welded");
  info.inconsistentEdges = fields.Count("inconsistent_edges");
  info.smallestPartition = fields.Count("smallest_partition");
  info.largestPartition = fields.Count("largest_partition");
  ReadLevels(fields, info, problem);
  info.original = ResolutionFrom(fields.Nested("original"), Resolution::Original());
  ReadAttributes(fields, info, problem);
  info.title = fields.Text("title");
  info.credit = fields.Text("credit");
  info.license = fields.Text("license");
  info.unit = fields.Text("unit");
  info.levelMaker = fields.Text("level_maker");
  info.representative = fields.Text("representative");
  info.sheets = fields.Flag("sheets");
  info.weld = fields.Flag("weld");
  if (!problem.empty())
  {
    return Error{ ErrorCode::Damaged, "the metadata: " + problem };
  }
  return info;
}

}
