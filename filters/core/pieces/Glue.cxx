// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/pieces/Glue.h"

#include <algorithm>
#include <map>
#include <string>

namespace kdstream
{
namespace
{

// The arrays of a glued mesh. Start checks that all pieces have the same arrays.
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

// Glues pieces into one mesh, in two passes over them: AddOwnVertices for all, then AddTriangles
// for all.
class Gluing
{
public:
  explicit Gluing(ScalarType scalarType)
    : Arrays(this->Glued.attributes)
  {
    this->Glued.scalarType = scalarType;
  }
  Gluing(const Gluing&) = delete;
  Gluing& operator=(const Gluing&) = delete;

  Status Start(std::span<const Piece> partitions) { return this->Arrays.Start(partitions); }

  Status AddOwnVertices(const Piece& piece)
  {
    if (!piece.id.resolution.IsOriginal())
    {
      return Error{ ErrorCode::InvalidArgument, "only partitions of the original can be joined" };
    }
    if (piece.ownVertices == 0)
    {
      return {};
    }
    const std::uint32_t partition = PartitionOfKey(piece.keys[0]);
    const auto first = static_cast<VertexId>(this->Glued.points.size());
    if (!this->Given.try_emplace(partition, OwnVertices{ first, piece.ownVertices }).second)
    {
      return Error{ ErrorCode::InvalidArgument,
        "partition " + std::to_string(partition) + " is given twice" };
    }
    for (std::uint32_t v = 0; v < piece.ownVertices; ++v)
    {
      this->AddVertex(piece, v);
    }
    return {};
  }

  // Adds the piece's triangles, and the ghosts that no given partition owns.
  Status AddTriangles(const Piece& piece)
  {
    if (piece.ownVertices == 0)
    {
      return {};
    }
    const Result<std::vector<VertexId>> vertices = this->FindVertices(piece);
    KDSTREAM_TRY(vertices);
    for (std::size_t i = 0; i < piece.triangles.size(); ++i)
    {
      const Triangle& t = piece.triangles[i];
      if (!this->IsOfLowerPartition(piece, t))
      {
        this->Glued.triangles.push_back(
          { (*vertices)[t[0]], (*vertices)[t[1]], (*vertices)[t[2]] });
        this->Arrays.Append(piece, AttributeAssociation::Cell, i);
      }
    }
    return {};
  }

  Mesh Take() { return std::move(this->Glued); }

private:
  // Where the own vertices of a given partition are in the glued mesh.
  struct OwnVertices
  {
    VertexId first;
    std::uint32_t count;
  };

  VertexId AddVertex(const Piece& piece, std::uint32_t v)
  {
    this->Glued.points.push_back(piece.positions[v]);
    this->Arrays.Append(piece, AttributeAssociation::Point, v);
    return static_cast<VertexId>(this->Glued.points.size() - 1);
  }

  // For each vertex of the piece its vertex in the glued mesh; adds vertices that are not there
  // yet.
  Result<std::vector<VertexId>> FindVertices(const Piece& piece)
  {
    std::vector<VertexId> vertices(piece.VertexCount());
    for (std::uint32_t v = 0; v < piece.VertexCount(); ++v)
    {
      const VertexKey key = piece.keys[v];
      const auto owner = this->Given.find(PartitionOfKey(key));
      if (owner == this->Given.end())
      {
        const auto [ghost, isNew] = this->Outside.try_emplace(key, noVertex);
        if (isNew)
        {
          ghost->second = this->AddVertex(piece, v);
        }
        vertices[v] = ghost->second;
        continue;
      }
      const auto [first, count] = owner->second;
      if (IndexOfKey(key) >= count)
      {
        return Error{ ErrorCode::InvalidInput,
          "partition " + std::to_string(PartitionOfKey(piece.keys[0])) + " names vertex " +
            std::to_string(IndexOfKey(key)) + " of partition " +
            std::to_string(PartitionOfKey(key)) + ", which has " + std::to_string(count) };
      }
      vertices[v] = first + IndexOfKey(key);
    }
    return vertices;
  }

  // Whether a given partition with a lower number has the triangle too; then the triangle is taken
  // from there.
  bool IsOfLowerPartition(const Piece& piece, const Triangle& triangle) const
  {
    return std::any_of(triangle.begin(), triangle.end(),
      [&](VertexId v)
      {
        const std::uint32_t owner = PartitionOfKey(piece.keys[v]);
        return owner < PartitionOfKey(piece.keys[0]) && this->Given.contains(owner);
      });
  }

  Mesh Glued;
  GluedArrays Arrays;
  std::map<std::uint32_t, OwnVertices> Given; // by partition
  std::map<VertexKey, VertexId> Outside;      // ghosts of partitions that are not given
};

}

Result<Mesh> GluePartitions(
  std::span<const Piece> partitions, ScalarType scalarType, const Execution& execution)
{
  Gluing gluing(scalarType);
  KDSTREAM_TRY(gluing.Start(partitions));
  const double steps = 2 * static_cast<double>(partitions.size());
  double done = 0;
  for (const Piece& piece : partitions)
  {
    KDSTREAM_TRY(execution.Report("glue", done++ / steps));
    KDSTREAM_TRY(gluing.AddOwnVertices(piece));
  }
  for (const Piece& piece : partitions)
  {
    KDSTREAM_TRY(execution.Report("glue", done++ / steps));
    KDSTREAM_TRY(gluing.AddTriangles(piece));
  }
  return gluing.Take();
}

}
