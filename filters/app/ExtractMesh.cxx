// SPDX-License-Identifier: BSD-3-Clause
#include "filters/app/ExtractMesh.h"

#include "filters/core/SystemReason.h"
#include "filters/core/tree/PieceDepth.h"
#include "filters/core/tree/Region.h"
#include "filters/model/JsonReader.h"
#include "filters/store/StoreMesh.h"

#include <array>
#include <cerrno>
#include <fstream>
#include <iterator>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

namespace kdstream
{
namespace
{

Error BadArgument(const std::string& what)
{
  return { ErrorCode::InvalidArgument, what };
}

// A resolution in --resolutions: a depth from `least` to L, or "original".
std::optional<Resolution> ReadResolution(
  const JsonValue& entry, unsigned least, const TreeDepths& depths)
{
  if (entry.IsString() && TextOf(entry) == "original")
  {
    return Resolution::Original();
  }
  if (entry.IsUint() && entry.GetUint() >= least && entry.GetUint() <= depths.finest)
  {
    return Resolution::Level(entry.GetUint());
  }
  return {};
}

std::string NeededResolution(const JsonValue& entry, unsigned least, const TreeDepths& depths)
{
  return Show(entry) + "; it must be a depth from " + std::to_string(least) + " to " +
         std::to_string(depths.finest) + " or \"original\"";
}

// Reads --resolutions as a list: for each partition its resolution, S or finer.
Result<Cut> ReadPartitions(const JsonValue& list, const ModelDescription& info)
{
  const TreeDepths& depths = info.depths;
  std::set<PieceId> active;
  std::uint32_t partition = 0;
  for (const JsonValue& entry : list.GetArray())
  {
    const auto resolution = ReadResolution(entry, depths.stitch, depths);
    if (!resolution)
    {
      return BadArgument(": entry " + std::to_string(partition) + " is " +
                         NeededResolution(entry, depths.stitch, depths));
    }
    const bool finer = *resolution > Resolution::Level(depths.stitch);
    if (finer && partition < info.partitions)
    {
      active.insert(PieceOfPartition(*resolution, partition, depths));
    }
    ++partition;
  }
  if (partition != info.partitions)
  {
    return BadArgument(" has " + std::to_string(partition) + " entries for " +
                       std::to_string(info.partitions) + " partitions");
  }
  return Cut{ depths, Resolution::Level(depths.stitch), { active.begin(), active.end() } };
}

// Reads --resolutions as an object: the base, and finer pieces that are shown where possible, in
// any order.
Result<Cut> ReadPieces(const JsonValue& object, const ModelDescription& info)
{
  const TreeDepths& depths = info.depths;
  const JsonValue *base = FindMember(object, "base"), *pieces = FindMember(object, "pieces");
  if (!base || !pieces || !pieces->IsArray())
  {
    return BadArgument(" must have \"base\" and a list \"pieces\"");
  }
  const auto resolution = ReadResolution(*base, 0, depths);
  if (!resolution)
  {
    return BadArgument(": \"base\" is " + NeededResolution(*base, 0, depths));
  }
  std::set<PieceId> active;
  std::size_t number = 0;
  for (const JsonValue& entry : pieces->GetArray())
  {
    const bool pair = entry.IsArray() && entry.Size() == 2 && entry[1].IsUint();
    const auto of = pair ? ReadResolution(entry[0], 0, depths) : std::nullopt;
    const PieceId id{ of.value_or(Resolution()), pair ? NodeId{ entry[1].GetUint() } : 0 };
    if (!of || !info.HasPiece(id))
    {
      return BadArgument(": piece " + std::to_string(number) +
                         " does not name the resolution and node of a piece in the store");
    }
    active.insert(id);
    ++number;
  }
  return Cut{ depths, *resolution, { active.begin(), active.end() } };
}

Result<Cut> ReadResolutions(const Store& store, const std::string& file)
{
  const auto bad = [&file](const std::string& what)
  { return BadArgument("--resolutions: " + file + what); };
  std::ifstream stream(file, std::ios::binary);
  if (!stream)
  {
    return Error{ ErrorCode::NotFound, "cannot be read: " + SystemReason(errno), file };
  }
  const auto json = ParseJson(std::string{ std::istreambuf_iterator<char>(stream), {} });
  if (!json || (!json->IsArray() && !json->IsObject()))
  {
    return bad(" is not a JSON list or object");
  }
  Result<Cut> cut =
    json->IsArray() ? ReadPartitions(*json, store.Info()) : ReadPieces(*json, store.Info());
  return cut ? std::move(cut) : bad(cut.GetError().message);
}

Result<std::vector<std::uint32_t>> PartitionsOfRegion(const Store& store, const WantedMesh& wanted)
{
  const Result<std::vector<Box>> boxes = store.ReadBoxes();
  KDSTREAM_TRY(boxes);
  return FindRegion(*boxes, store.Info().depths, *wanted.region, wanted.rings);
}

std::vector<std::uint32_t> AllPartitions(const ModelDescription& info)
{
  std::vector<std::uint32_t> all(info.partitions);
  std::iota(all.begin(), all.end(), 0U);
  return all;
}

WantedPartitions PartitionsOfCut(const Cut& cut)
{
  WantedPartitions original{ {}, BaseOf(cut) == Resolution::Original() };
  for (const PieceId& piece : PiecesOf(cut))
  {
    if (piece.resolution == Resolution::Original())
    {
      original.partitions.push_back(piece.node - NodeOfPartition(0, cut.depths));
    }
  }
  return original;
}

Result<Mesh> ExtractRegionInContext(const Store& store, const WantedMesh& wanted)
{
  const auto partitions = PartitionsOfRegion(store, wanted);
  KDSTREAM_TRY(partitions);
  const TreeDepths& depths = store.Info().depths;
  std::vector<PieceId> pieces;
  for (const std::uint32_t p : *partitions)
  {
    pieces.push_back({ Resolution::Original(), NodeOfPartition(p, depths) });
  }
  return DrawStorePieces(store, Resolution::Level(*wanted.inContext), pieces);
}

}

Result<Mesh> ExtractMesh(const Store& store, const WantedMesh& wanted)
{
  const ModelDescription& info = store.Info();
  if (!info.HasLevels() && (wanted.level || wanted.inContext || !wanted.resolutions.empty()))
  {
    return BadArgument("a store by --partitioner " + info.partitioner +
                       " has no levels: use --partition, --region or --all");
  }
  for (const auto& [name, level] :
    { std::pair{ "--level ", wanted.level }, { "--in-context ", wanted.inContext } })
  {
    if (level && *level > info.depths.finest)
    {
      return BadArgument(name + std::to_string(*level) + ": the finest level is " +
                         std::to_string(info.depths.finest));
    }
  }
  if (wanted.level)
  {
    return DrawStoreMesh(store, { info.depths, Resolution::Level(*wanted.level) });
  }
  if (wanted.region && wanted.inContext)
  {
    return ExtractRegionInContext(store, wanted);
  }
  if (!wanted.resolutions.empty())
  {
    const Result<Cut> cut = ReadResolutions(store, wanted.resolutions);
    return cut ? DrawStoreMesh(store, *cut) : Result<Mesh>(cut.GetError());
  }
  const auto original = PartitionsOf(store, wanted);
  KDSTREAM_TRY(original);
  return GlueStoreMesh(store, original->partitions);
}

bool HasUnused(const Store& store, const WantedMesh& wanted)
{
  const bool whole =
    !wanted.level && !wanted.partition && !wanted.region && wanted.resolutions.empty();
  return whole && store.Info().unused;
}

Result<WantedPartitions> PartitionsOf(const Store& store, const WantedMesh& wanted)
{
  const ModelDescription& info = store.Info();
  if (wanted.level || (!wanted.resolutions.empty() && !info.HasLevels()))
  {
    return WantedPartitions{};
  }
  if (!wanted.resolutions.empty())
  {
    const Result<Cut> cut = ReadResolutions(store, wanted.resolutions);
    return cut ? PartitionsOfCut(*cut) : Result<WantedPartitions>(cut.GetError());
  }
  if (wanted.partition)
  {
    if (*wanted.partition >= info.partitions)
    {
      return BadArgument("--partition " + std::to_string(*wanted.partition) + ": the store has " +
                         std::to_string(info.partitions) + " partitions, 0 to " +
                         std::to_string(info.partitions - 1));
    }
    return WantedPartitions{ { *wanted.partition }, true };
  }
  if (wanted.region)
  {
    Result<std::vector<std::uint32_t>> region = PartitionsOfRegion(store, wanted);
    KDSTREAM_TRY(region);
    return WantedPartitions{ std::move(*region), !wanted.inContext };
  }
  return WantedPartitions{ AllPartitions(info), true };
}

}
