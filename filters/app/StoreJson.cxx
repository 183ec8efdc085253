#include "filters/app/StoreJson.h"

namespace kdstream
{

nlohmann::json StoreToJson(const StoreInfo& info, std::uint64_t storeBytes)
{
  using Json = nlohmann::json;
  Json levels = Json::array();
  for (const ResolutionInfo& level : info.levels)
  {
    levels.push_back({ { "depth", level.resolution.Depth() }, { "vertices", level.vertices },
      { "triangles", level.triangles }, { "pieces", level.pieces }, { "bytes", level.bytes },
      { "deviation", level.deviation }, { "deviation_99", level.deviation99 } });
  }
  Json precision = "lossless";
  if (!info.grid.Lossless())
  {
    precision = info.grid.bits;
  }
  Json attributes = Json::array();
  for (const AttributeInfo& attribute : info.attributes)
  {
    const bool point = attribute.association == AttributeAssociation::Point;
    attributes.push_back({ { "name", attribute.name }, { "type", NameOf(attribute.type) },
      { "association", point ? "point" : "cell" }, { "components", attribute.components } });
  }
  return { { "input", info.input }, { "vertices", info.vertices }, { "triangles", info.triangles },
    { "partitions", info.partitions }, { "partition_depth", info.depths.partition },
    { "stitch_depth", info.depths.stitch }, { "finest_depth", info.depths.finest },
    { "welded", info.welded }, { "inconsistent_edges", info.inconsistentEdges },
    { "partition_vertices",
      { { "min", info.smallestPartition }, { "max", info.largestPartition } } },
    { "partition_bytes", info.original.bytes }, { "levels", levels }, { "precision", precision },
    { "scalar_type", info.grid.scalarType == ScalarType::Float32 ? "float32" : "float64" },
    { "primitive", info.primitive == PrimitiveType::Points ? "points" : "triangles" },
    { "box", { { "lo", info.box.lo }, { "hi", info.box.hi } } }, { "attributes", attributes },
    { "partitioner", info.partitioner }, { "level_maker", info.levelMaker },
    { "representative", info.representative }, { "sheets", info.sheets }, { "weld", info.weld },
    { "title", info.title }, { "credit", info.credit }, { "license", info.license },
    { "unit", info.unit }, { "store_bytes", storeBytes }, { "digest", info.digest } };
}

}
