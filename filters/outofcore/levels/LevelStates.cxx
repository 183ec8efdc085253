// SPDX-License-Identifier: BSD-3-Clause
#include "filters/outofcore/levels/LevelStates.h"

#include "filters/core/GhostCorners.h"
#include "filters/outofcore/files/ScatteredRead.h"
#include "filters/outofcore/files/Tuples.h"

#include <algorithm>
#include <cstring>

namespace kdstream
{
namespace
{

Status MakeFile(SpillFolder& folder, SpillFile& file, std::string_view purpose, std::uint64_t count,
  std::size_t elementBytes)
{
  if (elementBytes == 0)
  {
    return {};
  }
  Result<SpillFile> made = folder.CreateFile(purpose, count * elementBytes);
  KDSTREAM_TRY(made);
  file = std::move(*made);
  return {};
}

// The range of numbers that the block's own clusters have in the level.
BlockRange OwnNumbers(const LevelBlock& block)
{
  const std::size_t first = block.ownBegin < block.ownEnd ? block.clusters[block.ownBegin] : 0;
  return { first, first + block.ownEnd - block.ownBegin };
}

void AppendPlaces(std::span<const ClusterRecord> records, ClusterLevel& places)
{
  for (const ClusterRecord& record : records)
  {
    places.positions.push_back(record.position);
    places.geometricErrors.push_back(record.geometricError);
    places.lowest.push_back(record.lowest);
  }
}

// Loads the positions and geometric errors of all clusters of a block, including ghosts.
Status LoadPlaces(const LevelFile& level, const LevelBlock& block, ClusterLevel& places)
{
  const std::span<const VertexId> all(block.clusters);
  places.positions.reserve(all.size());
  places.geometricErrors.reserve(all.size());
  places.lowest.reserve(all.size());
  const auto appendGhosts = [&](std::span<const VertexId> ghosts) -> Status
  {
    std::vector<ClusterRecord> records(ghosts.size());
    KDSTREAM_TRY(
      ReadRecordsAt<ClusterRecord>(level.clusters, ghosts, std::span<ClusterRecord>(records)));
    AppendPlaces(records, places);
    return {};
  };
  const BlockRange own = OwnNumbers(block);
  KDSTREAM_TRY(appendGhosts(all.first(block.ownBegin)));
  KDSTREAM_TRY(ForEachBlockOf<ClusterRecord>(level.clusters, own.begin, own.end,
    [&](std::span<const ClusterRecord> records) { AppendPlaces(records, places); }));
  return appendGhosts(all.subspan(block.ownEnd));
}

// Loads the displayed colours of all clusters of a block, including ghosts.
Status LoadVertexColors(
  const LevelFile& level, const LevelArrays& arrays, const LevelBlock& block, ClusterLevel& places)
{
  const std::size_t tupleBytes = arrays.TupleBytes();
  std::vector<std::byte> tuples(block.clusters.size() * tupleBytes);
  KDSTREAM_TRY(ReadBlockElements(level.tuples, tupleBytes, block, tuples));
  places.vertexColors.resize(block.clusters.size());
  for (std::size_t c = 0; c < places.vertexColors.size(); ++c)
  {
    std::memcpy(places.vertexColors[c].data(), &tuples[c * tupleBytes + *arrays.vertexColors],
      places.vertexColors[c].size());
  }
  return {};
}

// Loads the sums of the block's own clusters.
Status LoadSums(const LevelStates& states, const LevelBlock& block, CollapseState& state)
{
  const BlockRange own = OwnNumbers(block);
  state.clusters.reserve(state.OwnCount());
  state.cellOf.reserve(state.OwnCount());
  KDSTREAM_TRY(ForEachBlockOf<ClusterState>(states.sums, own.begin, own.end,
    [&](std::span<const ClusterState> clusters)
    {
      for (const ClusterState& cluster : clusters)
      {
        state.clusters.push_back(cluster.sum);
        state.cellOf.push_back(cluster.cellOf);
      }
    }));
  std::vector<float>& values = state.attributes.values;
  values.resize(state.attributes.components * state.OwnCount());
  return states.components.IsOpen()
           ? ReadRecords<float>(
               states.components, own.begin * state.attributes.components, std::span<float>(values))
           : Status{};
}

}

std::size_t LevelArrays::TupleBytes() const
{
  std::size_t bytes = 0;
  for (const AttributeInfo& attribute : this->attributes)
  {
    bytes += attribute.TupleSize();
  }
  return bytes;
}

Status LevelWriter::Begin(SpillFolder& folder, std::uint64_t expected)
{
  this->Level.begin.assign(1, 0);
  const std::size_t sumBytes = AttributeSums(this->Arrays.attributes, 0).RecordSize();
  KDSTREAM_TRY(
    MakeFile(folder, this->Level.clusters, "clusters of a level", expected, sizeof(ClusterRecord)));
  KDSTREAM_TRY(MakeFile(
    folder, this->Level.tuples, "attributes of a level", expected, this->Arrays.TupleBytes()));
  KDSTREAM_TRY(
    MakeFile(folder, this->States.sums, "sums of clusters", expected, sizeof(ClusterState)));
  KDSTREAM_TRY(MakeFile(folder, this->States.components, "attributes of clusters", expected,
    this->Arrays.components * sizeof(float)));
  return MakeFile(folder, this->States.attributeSums, "sums of attributes", expected, sumBytes);
}

Status LevelWriter::Append(const CollapseState& block, const AttributeSums& attributes)
{
  const VertexId first = this->Level.begin.back();
  const std::size_t count = block.clusters.size();
  RecordWriter<ClusterRecord> records(this->Level.clusters, first);
  RecordWriter<ClusterState> states(this->States.sums, first);
  for (std::size_t c = 0; c < count; ++c)
  {
    const ClusterSum& sum = block.clusters[c];
    records.Append({ block.level.positions[c], sum.geometricError, sum.lowest,
      static_cast<VertexId>(sum.count) });
    states.Append({ sum, block.cellOf[c] });
  }
  this->States.area = AddAreas(this->States.area, block.clusters);
  KDSTREAM_TRY(records.Finish());
  KDSTREAM_TRY(states.Finish());
  if (this->States.components.IsOpen())
  {
    KDSTREAM_TRY(this->States.components.Write(
      std::uint64_t{ first } * this->Arrays.components * sizeof(float),
      std::as_bytes(std::span(block.attributes.values))));
  }
  if (this->States.attributeSums.IsOpen())
  {
    KDSTREAM_TRY(this->States.attributeSums.Write(
      std::uint64_t{ first } * attributes.RecordSize(), attributes.Bytes()));
  }
  if (this->Level.tuples.IsOpen())
  {
    std::vector<Attribute> means = attributes.Means();
    PutVertexColors(block.level.vertexColors, means);
    std::vector<const Attribute*> arrays;
    arrays.reserve(means.size());
    for (const Attribute& array : means)
    {
      arrays.push_back(&array);
    }
    KDSTREAM_TRY(this->Level.tuples.Write(
      std::uint64_t{ first } * this->Arrays.TupleBytes(), InterleaveTuples(arrays, count)));
  }
  this->Level.begin.push_back(first + static_cast<VertexId>(count));
  return {};
}

Result<CollapseState> LoadState(
  const LevelFile& level, const LevelStates& states, const LevelArrays& arrays, LevelBlock& block)
{
  CollapseState state;
  state.ownBegin = block.ownBegin;
  state.ownEnd = block.ownEnd;
  state.attributes.components = arrays.components;
  KDSTREAM_TRY(LoadPlaces(level, block, state.level));
  if (arrays.vertexColors)
  {
    KDSTREAM_TRY(LoadVertexColors(level, arrays, block, state.level));
  }
  KDSTREAM_TRY(LoadSums(states, block, state));
  state.level.triangles = std::move(block.triangles);
  return state;
}

Result<AttributeSums> LoadAttributeSums(
  const LevelStates& states, const LevelArrays& arrays, VertexId firstCluster, std::size_t clusters)
{
  AttributeSums none(arrays.attributes, clusters);
  if (none.Empty())
  {
    return none;
  }
  std::vector<std::byte> bytes(clusters * none.RecordSize());
  KDSTREAM_TRY(states.attributeSums.Read(std::uint64_t{ firstCluster } * none.RecordSize(), bytes));
  return AttributeSums::FromBytes(arrays.attributes, bytes);
}

void MergeBlocks(LevelFile& level, unsigned blockDepth)
{
  const std::size_t step = (level.begin.size() - 1) >> blockDepth;
  for (std::size_t i = 0; i <= std::size_t{ 1 } << blockDepth; ++i)
  {
    level.begin[i] = level.begin[i * step];
  }
  level.begin.resize((std::size_t{ 1 } << blockDepth) + 1);
  level.blockDepth = blockDepth;
}

Status MapCorners(
  std::vector<Triangle>& triangles, const SpillFile& map, VertexId first, VertexId end)
{
  const GhostCorners corners(triangles, first, end);
  const std::vector<VertexId> ghosts = corners.Vertices();
  std::vector<VertexId> own(end - first), ofGhosts(ghosts.size());
  KDSTREAM_TRY(ReadRecords<VertexId>(map, first, std::span<VertexId>(own)));
  KDSTREAM_TRY(ReadRecordsAt<VertexId>(map, ghosts, std::span<VertexId>(ofGhosts)));
  for (Triangle& t : triangles)
  {
    for (VertexId& corner : t)
    {
      corner = corner >= first && corner < end ? own[corner - first] : corner;
    }
  }
  corners.ReplaceIn(triangles, [&](std::size_t place) { return ofGhosts[place]; });
  return {};
}

}
