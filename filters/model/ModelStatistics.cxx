// SPDX-License-Identifier: BSD-3-Clause
// Statistics of a model, for people and scripts.
#include "filters/model/ModelJson.h"
#include "filters/model/ModelMembers.h"

namespace kdstream
{

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
  PutLevels(json, model.levels);
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
  PutHomeView(json, model);
  PutTextures(json, model, "tiles");
  PutUnused(json, model);
  json.Member("store_bytes", storeBytes).Member("digest", model.digest);
}

}
