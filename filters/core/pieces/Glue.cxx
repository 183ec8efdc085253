#include "filters/core/pieces/Glue.h"

#include <algorithm>
#include <map>
#include <string>

namespace kdstream
{
namespace
{

// The arrays of a glued mesh. Every piece has the same, checked by Start.
class GluedArrays
{
public:
  explicit GluedArrays(std::vector<Attribute>& arrays)
    : Arrays(arrays)
  {
  }

  Status Start(std::span<const Piece> partitions)
  {
    const Piece* first = nullptr;
    for (const Piece& piece : partitions)
    {
      if (piece.ownVertices == 0)
      {
        continue;
      }
      first = first ? first : &piece;
      if (!std::equal(piece.attributes.begin(), piece.attributes.end(), first->attributes.begin(),
            first->attributes.end(),
            [](const Attribute& a, const Attribute& b) { return a.Info() == b.Info(); }))
      {
        return Error{ ErrorCode::InvalidInput,
          "partitions " + std::to_string(PartitionOfKey(first->keys[0])) + " and " +
            std::to_string(PartitionOfKey(piece.keys[0])) + " have different arrays" };
      }
    }
    for (std::size_t k = 0; first && k < first->attributes.size(); ++k)
    {
      this->Arrays.push_back({ first->attributes[k].Info(), {} });
    }
    return {};
  }

  void Append(const Piece& piece, AttributeAssociation association, std::size_t tuple)
  {
    for (std::size_t k = 0; k < this->Arrays.size(); ++k)
    {
      if (this->Arrays[k].association == association)
      {
        this->Arrays[k].Append(piece.attributes[k], tuple);
      }
    }
  }

private:
  std::vector<Attribute>& Arrays;
};

}

Result<Mesh> GluePartitions(std::span<const Piece> partitions, ScalarType scalarType)
{
  Mesh mesh;
  mesh.scalarType = scalarType;
  GluedArrays arrays(mesh.attributes);
  KDSTREAM_TRY(arrays.Start(partitions));
  struct Own
  {
    VertexId first;
    std::uint32_t count;
  };
  std::map<std::uint32_t, Own> given; // by partition
  for (const Piece& piece : partitions)
  {
    if (!piece.id.resolution.IsOriginal())
    {
      return Error{ ErrorCode::InvalidArgument, "only partitions of the original can be glued" };
    }
    const auto partition = piece.ownVertices > 0 ? PartitionOfKey(piece.keys[0]) : noVertex;
    const bool fresh =
      given
        .try_emplace(partition, Own{ static_cast<VertexId>(mesh.points.size()), piece.ownVertices })
        .second;
    if (!fresh && piece.ownVertices > 0)
    {
      return Error{ ErrorCode::InvalidArgument,
        "partition " + std::to_string(partition) + " is given twice" };
    }
    mesh.points.insert(
      mesh.points.end(), piece.positions.data(), piece.positions.data() + piece.ownVertices);
    for (std::uint32_t v = 0; v < piece.ownVertices; ++v)
    {
      arrays.Append(piece, AttributeAssociation::Point, v);
    }
  }

  std::map<VertexKey, VertexId> outside; // ghosts of partitions that are not given
  std::vector<VertexId> place;
  for (const Piece& piece : partitions)
  {
    if (piece.ownVertices == 0)
    {
      continue;
    }
    const std::uint32_t partition = PartitionOfKey(piece.keys[0]);
    place.resize(piece.VertexCount());
    for (std::uint32_t v = 0; v < piece.VertexCount(); ++v)
    {
      const auto owner = given.find(PartitionOfKey(piece.keys[v]));
      if (owner == given.end())
      {
        const auto [entry, fresh] =
          outside.try_emplace(piece.keys[v], static_cast<VertexId>(mesh.points.size()));
        if (fresh)
        {
          mesh.points.push_back(piece.positions[v]);
          arrays.Append(piece, AttributeAssociation::Point, v);
        }
        place[v] = entry->second;
        continue;
      }
      if (IndexOfKey(piece.keys[v]) >= owner->second.count)
      {
        return Error{ ErrorCode::InvalidInput,
          "partition " + std::to_string(partition) + " names vertex " +
            std::to_string(IndexOfKey(piece.keys[v])) + " of partition " +
            std::to_string(PartitionOfKey(piece.keys[v])) + ", which has " +
            std::to_string(owner->second.count) };
      }
      place[v] = owner->second.first + IndexOfKey(piece.keys[v]);
    }
    for (std::size_t i = 0; i < piece.triangles.size(); ++i)
    {
      const Triangle& t = piece.triangles[i];
      const bool fromLower = std::any_of(t.begin(), t.end(),
        [&](VertexId v)
        {
          const std::uint32_t other = PartitionOfKey(piece.keys[v]);
          return other < partition && given.contains(other);
        });
      if (!fromLower)
      {
        mesh.triangles.push_back({ place[t[0]], place[t[1]], place[t[2]] });
        arrays.Append(piece, AttributeAssociation::Cell, i);
      }
    }
  }
  return mesh;
}

}
