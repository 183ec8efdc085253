// SPDX-License-Identifier: BSD-3-Clause
#include "filters/model/ModelDescription.h"

#include <algorithm>

namespace kdstream
{
namespace
{

bool IsIdCharacter(char c)
{
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' ||
         c == '_' || c == '-';
}

bool IsHexDigit(char c)
{
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
}

}

bool ModelDescription::HasPiece(PieceId piece) const
{
  if (piece.node == 0 || DepthOfNode(piece.node) != PieceDepth(piece.resolution, this->depths))
  {
    return false;
  }
  return piece.resolution.IsOriginal()
           ? piece.node - (NodeId{ 1 } << this->depths.partition) < this->partitions
           : piece.resolution.Depth() < this->levels.size();
}

CodecContext ModelDescription::Codec() const
{
  CodecContext context{ this->depths, this->grid, {}, {} };
  for (const ResolutionDescription& level : this->levels)
  {
    context.spacings.push_back(level.spacing);
    context.clusters.push_back(level.vertices);
  }
  return context;
}

ModelSummary Summarize(const ModelDescription& model)
{
  return { model.id, model.digest, model.title, model.vertices, model.triangles };
}

unsigned PreviewLevel(const ModelDescription& model)
{
  return PreviewLevel(model.depths);
}

bool IsModelId(std::string_view id)
{
  return !id.empty() && id.size() <= 128 && id[0] != '.' &&
         std::all_of(id.begin(), id.end(), IsIdCharacter);
}

bool IsDigest(std::string_view digest)
{
  return digest.size() == 32 && std::all_of(digest.begin(), digest.end(), IsHexDigit);
}

}
