// SPDX-License-Identifier: BSD-3-Clause
#include "filters/model/ModelDescription.h"

#include "filters/core/Texts.h"
#include "filters/core/UnitVector.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

// The beginning of the text: at most `mostBytes` bytes, without splitting a character.
std::string BeginOf(const std::string& text, std::size_t mostBytes)
{
  const std::string_view begin = std::string_view(text).substr(0, mostBytes);
  return std::string(begin.substr(0, begin.size() < text.size() ? Utf8Prefix(begin) : begin.npos));
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

const ScalarDescription* ScalarDescriptions::Find(std::string_view name) const
{
  const ScalarDescription* found = std::find_if(this->begin(), this->end(),
    [name](const ScalarDescription& scalar) { return scalar.name == name; });
  return found == this->end() ? nullptr : found;
}

std::string_view NameOf(ModelDetail detail)
{
  constexpr std::string_view names[] = { "preview", "levels", "regions" };
  return names[static_cast<std::size_t>(detail)];
}

ModelSummary Summarize(const ModelDescription& model)
{
  return { model.id, model.digest, model.title, model.vertices, model.triangles,
    BeginOf(model.description, mostSummaryBytes), 0 };
}

std::optional<Vec3> DirectionOf(const Vec3& vector)
{
  // The inverse of the length must be finite.
  const bool isLong = std::any_of(vector.begin(), vector.end(),
    [](double x) { return std::abs(x) >= std::numeric_limits<double>::min(); });
  const auto unit = ScaledUnitVector(vector);
  return isLong && unit ? std::optional(WithPositiveZeros(*unit)) : std::nullopt;
}

Vec3 FrontOf(const Vec3& up)
{
  const bool zIsUp = std::abs(up[2]) > std::abs(up[1]);
  const Vec3 front = zIsUp ? Vec3{ 0, -1, 0 } : Vec3{ 0, 0, 1 };
  const double along = Dot(front, up);
  const Vec3 level{ front[0] - along * up[0], front[1] - along * up[1], front[2] - along * up[2] };
  return DirectionOf(level).value_or(front);
}

ModelDescription WithDetail(ModelDescription model, ModelDetail detail)
{
  model.detail = detail;
  if (detail != ModelDetail::Regions)
  {
    model.original = {};
    if (model.textures && model.textures->levels)
    {
      model.textures->bytes = model.textures->texels = 0;
    }
    else
    {
      model.textures.reset();
    }
  }
  for (std::size_t level = PreviewLevel(model) + std::size_t{ 1 };
       detail == ModelDetail::Preview && level < model.levels.size(); ++level)
  {
    model.levels[level] = {};
  }
  return model;
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

std::string ModelIdLike(std::string_view name)
{
  std::string id(name.substr(0, 128));
  for (char& c : id)
  {
    c = c == '.' || IsModelId({ &c, 1 }) ? c : '_';
  }
  if (!IsModelId(id))
  {
    id = "_" + id.substr(0, 127);
  }
  return id;
}

bool IsDigest(std::string_view digest)
{
  return digest.size() == 32 && std::all_of(digest.begin(), digest.end(), IsHexDigit);
}

}
