// SPDX-License-Identifier: BSD-3-Clause
// Bakes pictures into colours of vertices: see BakeTextures.h.
//   1. Find vertices in the same place.
//   2. Add the material's colour for triangles without a picture, or without coordinates.
//   3. For each picture: decode it; decide how finely its triangles are sampled; sum their texels
//      for their corners.
//   4. Compute the means, as bytes, and the loss, from sums that were made on the way.
#include "filters/texture/BakeTextures.h"

#include "filters/core/VectorMath.h"
#include "filters/core/Weld.h"
#include "filters/texture/PictureReader.h"
#include "filters/texture/PictureTexels.h"
#include "filters/texture/SumTexels.h"
#include "filters/texture/TextureArrays.h"
#include "filters/texture/TextureFolder.h"
#include "filters/texture/TileCharts.h"
#include "filters/texture/TintPictures.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>
#include <numeric>
#include <optional>
#include <span>

namespace kdstream
{
namespace
{

constexpr std::size_t fewestCuts = 3;  // of each side
constexpr double texelsOfCut = 1.4;    // of the longest side, for each cut
constexpr double partsOfTexel = 8;     // for each texel of the picture, over all triangles
constexpr double partsOfTriangle = 64; // further parts for each triangle
constexpr std::size_t trianglesAtOnce = 16384;
constexpr std::size_t trianglesOfTask = 64;
constexpr double readShare = 0.3;    // of the progress: for decoding pictures
constexpr double mostCuts = 1 << 15; // of a side; before the limit for all triangles
// Triangles without area get the least weight, and no triangle has more than the maximum, so that
// sums stay finite.
constexpr double leastArea = 1e-250, mostArea = 1e250;

// The place of each vertex: the lowest number of a vertex with the same coordinates and normal.
std::vector<VertexId> PlacesOf(const Mesh& mesh, const Execution& execution)
{
  std::vector<VertexId> places = FirstCoincident(mesh.points, Coincidence::BitEqual, execution);
  const auto normals = std::find_if(mesh.attributes.begin(), mesh.attributes.end(),
    [](const Attribute& attribute) { return RoleOf(attribute) == AttributeRole::Normals; });
  if (normals == mesh.attributes.end())
  {
    return places;
  }
  const std::size_t size = normals->TupleSize();
  const auto compare = [&](VertexId a, VertexId b)
  { return std::memcmp(&normals->values[a * size], &normals->values[b * size], size); };
  std::vector<VertexId> order(places.size());
  std::iota(order.begin(), order.end(), VertexId{ 0 });
  std::sort(order.begin(), order.end(),
    [&](VertexId a, VertexId b)
    {
      const int normal = places[a] == places[b] ? compare(a, b) : 0;
      return places[a] != places[b] ? places[a] < places[b] : normal != 0 ? normal < 0 : a < b;
    });
  std::vector<VertexId> refined(places.size());
  for (std::size_t i = 0; i < order.size(); ++i)
  {
    const bool same =
      i > 0 && places[order[i]] == places[order[i - 1]] && compare(order[i], order[i - 1]) == 0;
    refined[order[i]] = same ? refined[order[i - 1]] : order[i];
  }
  return refined;
}

// Σ of(i). The result does not depend on the threads: sums of blocks are added in order.
template <class Of>
auto SumInBlocks(std::size_t count, const Execution& execution, const Of& of)
{
  using Sums = decltype(of(std::size_t{}));
  constexpr std::size_t block = 1 << 16;
  std::vector<Sums> parts((count + block - 1) / block, Sums{});
  execution.parallelFor(parts.size(), 1,
    [&](std::size_t begin, std::size_t end)
    {
      for (std::size_t i = begin * block; i < std::min(end * block, count); ++i)
      {
        const Sums values = of(i);
        std::transform(values.begin(), values.end(), parts[i / block].begin(),
          parts[i / block].begin(), std::plus<>());
      }
    });
  Sums all{};
  for (const Sums& part : parts)
  {
    std::transform(part.begin(), part.end(), all.begin(), all.begin(), std::plus<>());
  }
  return all;
}

// With three digits, or all digits before the decimal point.
std::string NumberText(double value)
{
  char text[64];
  std::snprintf(text, sizeof text, value < 1000 ? "%.3g" : "%.0f", value);
  return text;
}

class Baker
{
public:
  // folder: where decoded pictures go; null: into memory.
  Baker(TexturedMesh& textured, std::uint64_t mostPixels, TextureFolderWriter* folder)
    : Textured(textured)
    , Reader(textured.pictures, mostPixels, folder)
  {
  }

  Result<BakeReport> Bake(const Execution& execution)
  {
    this->Places = PlacesOf(this->Textured.mesh, execution);
    this->Sums.resize(this->Places.size());
    const std::vector<std::vector<std::uint32_t>> ofPicture = this->SortTriangles();
    std::vector<std::uint32_t> used;
    for (std::uint32_t i = 0; i < ofPicture.size(); ++i)
    {
      if (!ofPicture[i].empty())
      {
        used.push_back(i);
      }
    }
    KDSTREAM_TRY(this->Reader.ReadAhead(used, readShare, execution));
    for (std::size_t i = 0; i < used.size(); ++i)
    {
      const auto done = [&](double part)
      {
        return execution.Report(
          "textures", readShare + (1 - readShare) * (double(i) + part) / double(used.size()));
      };
      KDSTREAM_TRY(done(0));
      KDSTREAM_TRY(this->BakePicture(used[i], ofPicture[used[i]], execution, done));
    }
    if (this->FarTriangles > 0)
    {
      this->Report.warnings.push_back(
        std::to_string(this->FarTriangles) +
        (this->FarTriangles == 1 ? " triangle has" : " triangles have") +
        " texture coordinates of 2^30 texels or more, which are not places in a picture");
    }
    const std::vector<std::string> unread = this->Reader.Warnings();
    this->Report.warnings.insert(this->Report.warnings.end(), unread.begin(), unread.end());
    this->Finish(execution);
    return std::move(this->Report);
  }

private:
  const TexturedMaterial& MaterialOf(std::size_t triangle) const
  {
    return this->Textured.materials[this->Textured.materialOf[triangle]];
  }

  // The colour of a triangle without a picture.
  Color ColorOf(std::size_t triangle) const
  {
    const TexturedMaterial& material = this->MaterialOf(triangle);
    Color color = material.color;
    color[3] = material.opaque ? 1 : color[3];
    return color;
  }

  bool HasCoordinates(std::size_t triangle) const
  {
    const auto& corners = this->Textured.corners[triangle];
    return std::all_of(corners.begin(), corners.end(),
      [](const PictureCoordinate& c) { return std::isfinite(c[0]) && std::isfinite(c[1]); });
  }

  // The triangles of each picture. Triangles without a picture get their colours at once.
  std::vector<std::vector<std::uint32_t>> SortTriangles()
  {
    std::vector<std::vector<std::uint32_t>> ofPicture(this->Textured.pictures.size());
    std::size_t bare = 0, firstBare = 0;
    for (std::size_t i = 0; i < this->Textured.mesh.triangles.size(); ++i)
    {
      const std::uint32_t picture = this->MaterialOf(i).picture;
      const bool hasPicture = picture != noPicture && this->HasCoordinates(i);
      if (hasPicture)
      {
        ofPicture[picture].push_back(static_cast<std::uint32_t>(i));
        continue;
      }
      this->AddFlatColor(i, this->ColorOf(i));
      firstBare = picture != noPicture && bare == 0 ? i : firstBare;
      bare += picture != noPicture ? 1 : 0;
    }
    if (bare > 0)
    {
      this->Report.warnings.push_back(
        std::to_string(bare) + (bare == 1 ? " triangle has" : " triangles have") +
        " no texture coordinates, or ones that are not numbers (the "
        "first is triangle " +
        std::to_string(firstBare) + "): the material's colour is used");
    }
    return ofPicture;
  }

  double AreaOf(const Triangle& t) const
  {
    const std::vector<Vec3>& points = this->Textured.mesh.points;
    const Vec3 normal = Cross(Minus(points[t[1]], points[t[0]]), Minus(points[t[2]], points[t[0]]));
    const double area = Length(normal) / 2;
    return area >= leastArea ? std::min(area, mostArea) : leastArea; // NaN gives leastArea
  }

  // Adds the whole triangle in one colour.
  void AddFlatColor(std::size_t triangle, const Color& light)
  {
    const Triangle& t = this->Textured.mesh.triangles[triangle];
    const double area = this->AreaOf(t);
    const std::array<double, 3> shown{ 255 * FromLinear(light[0]), 255 * FromLinear(light[1]),
      255 * FromLinear(light[2]) };
    for (const VertexId corner : t)
    {
      this->Sums[this->Places[corner]].Add(area / 3, light, shown);
    }
    this->Squares += area * SquareOf(shown);
    this->Cuts.resize(this->Textured.mesh.triangles.size());
    this->Cuts[triangle] = 0;
  }

  Status BakePicture(std::uint32_t number, const std::vector<std::uint32_t>& triangles,
    const Execution& execution, const std::function<Status(double part)>& done)
  {
    const Result<std::optional<ReadablePicture>> picture = this->Reader.Read(number);
    KDSTREAM_TRY(picture);
    this->Cuts.resize(this->Textured.mesh.triangles.size());
    if (!*picture)
    {
      for (const std::uint32_t triangle : triangles)
      {
        this->AddFlatColor(triangle, this->ColorOf(triangle));
      }
      return {};
    }
    ++this->Report.pictures;
    const PictureTexels texels((*picture)->Texels());
    const double thinning = this->FindThinning(texels, triangles, execution);
    // Triangles are sampled independently, on any thread, while the earlier ones are added in
    // order. So the sums do not depend on the threads.
    std::array<std::vector<TriangleSum>, 2> sums;
    sums.fill(std::vector<TriangleSum>(std::min(triangles.size(), trianglesAtOnce)));
    const std::size_t blocks = (triangles.size() + trianglesAtOnce - 1) / trianglesAtOnce;
    const auto ofBlock = [&](std::size_t block)
    {
      return std::span(triangles).subspan(block * trianglesAtOnce,
        std::min(trianglesAtOnce, triangles.size() - block * trianglesAtOnce));
    };
    for (std::size_t block = 0; block <= blocks; ++block)
    {
      const auto now = block < blocks ? ofBlock(block) : std::span<const std::uint32_t>();
      const auto task = [&](std::size_t i)
      {
        if (i == 0)
        {
          this->AddAll(block > 0 ? ofBlock(block - 1) : now.first(0), sums[(block + 1) % 2]);
          return;
        }
        const std::size_t first = (i - 1) * trianglesOfTask;
        for (std::size_t t = first; t < std::min(first + trianglesOfTask, now.size()); ++t)
        {
          sums[block % 2][t] = this->SumOf(now[t], texels, thinning);
        }
      };
      execution.parallelFor(1 + (now.size() + trianglesOfTask - 1) / trianglesOfTask, 1,
        [&](std::size_t begin, std::size_t end)
        {
          for (std::size_t i = begin; i < end; ++i)
          {
            task(i);
          }
        });
      KDSTREAM_TRY(done(double(block) / double(blocks)));
    }
    return {};
  }

  void AddAll(std::span<const std::uint32_t> triangles, const std::vector<TriangleSum>& sums)
  {
    for (std::size_t i = 0; i < triangles.size(); ++i)
    {
      this->Add(triangles[i], sums[i]);
    }
  }

  void Add(std::size_t triangle, const TriangleSum& sum)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      this->Sums[this->Places[this->Textured.mesh.triangles[triangle][k]]].Add(sum.corners[k]);
    }
    this->Squares += sum.squares;
    this->Cuts[triangle] = sum.cuts;
  }

  // The corners' places in the picture, in units of the picture.
  std::array<PlaceInPicture, 3> CornersOf(std::size_t triangle) const
  {
    std::array<PlaceInPicture, 3> places{};
    const TextureTransform& m = this->MaterialOf(triangle).transform;
    for (std::size_t k = 0; k < 3; ++k)
    {
      const double u = this->Textured.corners[triangle][k][0];
      const double v = this->Textured.corners[triangle][k][1];
      places[k] = { m.u[0] * u + m.u[1] * v + m.u[2], m.v[0] * u + m.v[1] * v + m.v[2] };
    }
    return places;
  }

  // The factor by which cuts must be reduced to stay within the limits. Also counts the texels that
  // are covered.
  double FindThinning(const PictureTexels& texels, const std::vector<std::uint32_t>& triangles,
    const Execution& execution)
  {
    const auto [parts, covered, far] = SumInBlocks(triangles.size(), execution,
      [&](std::size_t i) -> std::array<double, 3>
      {
        const std::array<PlaceInPicture, 3> at = this->CornersOf(triangles[i]);
        const double cuts = CutsOf(texels, at);
        return { cuts * cuts, texels.Covered(at),
          texels.Farthest(at) < mostChartTexels ? 0.0 : 1.0 };
      });
    this->FarTriangles += static_cast<std::uint64_t>(far);
    this->Report.texels += covered;
    const double most = partsOfTexel * texels.Count() + partsOfTriangle * double(triangles.size());
    return parts > most ? std::sqrt(most / parts) : 1;
  }

  static double CutsOf(const PictureTexels& texels, const std::array<PlaceInPicture, 3>& at)
  {
    return std::clamp(
      std::ceil(texels.LongestSide(at) / texelsOfCut), double(fewestCuts), mostCuts);
  }

  TriangleSum SumOf(std::size_t triangle, const PictureTexels& texels, double thinning) const
  {
    const std::array<PlaceInPicture, 3> at = this->CornersOf(triangle);
    const TexturedMaterial& material = this->MaterialOf(triangle);
    const auto cuts =
      std::max(fewestCuts, static_cast<std::size_t>(std::floor(CutsOf(texels, at) * thinning)));
    const double area = this->AreaOf(this->Textured.mesh.triangles[triangle]);
    return SumTexels(material, texels, at, area, cuts);
  }

  void Finish(const Execution& execution)
  {
    std::vector<std::array<std::uint8_t, 4>> colors(this->Sums.size());
    execution.parallelFor(colors.size(), 4096,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t v = begin; v < end; ++v)
        {
          colors[v] = ByteColor(this->Sums[this->Places[v]]);
        }
      });
    std::size_t places = 0;
    for (std::size_t v = 0; v < colors.size(); ++v)
    {
      places += this->Places[v] == v ? 1 : 0;
    }
    this->Report.texelsPerVertex = places > 0 ? this->Report.texels / double(places) : 0;
    this->MeasureLoss(colors, execution);
    this->Keep(colors);
  }

  static std::array<std::uint8_t, 4> ByteColor(const PlaceSum& sum)
  {
    std::array<std::uint8_t, 4> color{ 255, 255, 255, 255 };
    if (sum.weight > 0)
    {
      std::transform(sum.light.begin(), sum.light.begin() + 3, color.begin(),
        [&](double light) { return ByteOfLinear(light / sum.weight); });
      const double alpha = sum.light[3] / sum.weight;
      color[3] = static_cast<std::uint8_t>(std::lround(255 * std::clamp(alpha, 0.0, 1.0)));
    }
    return color;
  }

  // Stores the colours, in place of those that the mesh had.
  void Keep(const std::vector<std::array<std::uint8_t, 4>>& colors)
  {
    Mesh& mesh = this->Textured.mesh;
    std::erase_if(mesh.attributes, [](const Attribute& attribute)
      { return attribute.name == "RGB" || attribute.name == "RGBA"; });
    const bool opaque =
      std::all_of(colors.begin(), colors.end(), [](const auto& color) { return color[3] == 255; });
    const std::uint8_t components = opaque ? 3 : 4;
    Attribute attribute{
      { opaque ? "RGB" : "RGBA", AttributeType::UInt8, AttributeAssociation::Point, components }, {}
    };
    attribute.values.reserve(components * colors.size());
    for (const std::array<std::uint8_t, 4>& color : colors)
    {
      attribute.values.insert(attribute.values.end(), color.begin(), color.begin() + components);
    }
    mesh.attributes.push_back(std::move(attribute));
  }

  // Σ area (texel - Σ share × colour)², multiplied out. The squares of texels, and their products
  // with the shares, were summed in the loop; the products of the shares follow from the number of
  // cuts.
  void MeasureLoss(
    const std::vector<std::array<std::uint8_t, 4>>& colors, const Execution& execution)
  {
    const auto [mixed] = SumInBlocks(colors.size(), execution,
      [&](std::size_t v) -> std::array<double, 1>
      {
        const std::array<double, 3>& shown = this->Sums[v].shown;
        return { this->Places[v] == v
                   ? colors[v][0] * shown[0] + colors[v][1] * shown[1] + colors[v][2] * shown[2]
                   : 0 };
      });
    this->Cuts.resize(this->Textured.mesh.triangles.size());
    const auto [squares, all] = SumInBlocks(this->Cuts.size(), execution,
      [&](std::size_t i) -> std::array<double, 2>
      {
        const double area = this->AreaOf(this->Textured.mesh.triangles[i]);
        return { area * this->SquaresOfColors(i, colors), area };
      });
    const double mean = (this->Squares - 2 * mixed + squares) / all / 3;
    this->Report.loss = all > 0 && std::isfinite(mean) ? std::sqrt(std::max(0.0, mean)) : 0;
  }

  // The mean square of the colours that a triangle's corners interpolate at the centres of its
  // parts.
  double SquaresOfColors(
    std::size_t triangle, const std::vector<std::array<std::uint8_t, 4>>& colors) const
  {
    const Triangle& t = this->Textured.mesh.triangles[triangle];
    const double cuts = this->Cuts[triangle];
    const double within = cuts > 0 ? 1 / (cuts * cuts) : 0; // for the spread within a part
    double sum = 0;
    for (std::size_t a = 0; a < 3; ++a)
    {
      for (std::size_t b = 0; b < 3; ++b)
      {
        const double whole = (a == b ? 2.0 : 1.0) / 12;
        const double products = whole - (whole - 1.0 / 9) * within;
        int dot = 0;
        for (std::size_t k = 0; k < 3; ++k)
        {
          dot += int{ colors[t[a]][k] } * colors[t[b]][k];
        }
        sum += products * dot;
      }
    }
    return sum;
  }

  TexturedMesh& Textured;
  PictureReader Reader;
  std::vector<VertexId> Places;
  std::vector<PlaceSum> Sums;      // for each place, at its number
  std::vector<std::uint16_t> Cuts; // cuts of each triangle's sides; 0: one colour
  double Squares = 0;
  std::uint64_t FarTriangles = 0; // those that are TooFar in tiles
  BakeReport Report;
};

}

namespace
{

// Multiplies the pictures of a folder that is finished by tints, or removes it.
Result<bool> TintKept(TexturedMesh& textured, std::span<const Color> tints,
  const std::filesystem::path& path, TextureFolderWriter& folder, const Execution& execution)
{
  const auto source = TextureFolder::Open(path);
  KDSTREAM_TRY(source);
  Result<bool> tinted = TintPictures(textured, tints, **source, folder, execution);
  KDSTREAM_TRY(tinted);
  if (*tinted)
  {
    KDSTREAM_TRY(folder.Finish(textured.materials));
    return true;
  }
  std::error_code ignored;
  std::filesystem::remove_all(path, ignored);
  return false;
}

}

std::string BakeReport::TellLoss() const
{
  char text[200];
  std::snprintf(text, sizeof text,
    "textures are baked to the colours of vertices: about %s texels a vertex; the pictures are "
    "%.1f of 255 grey values off (RMS)",
    NumberText(this->texelsPerVertex).c_str(), this->loss);
  return text;
}

std::string BakeReport::TellLevels() const
{
  return "the original keeps the pictures, and levels have them with fewer texels; vertex colours "
         "are their means (about " +
         NumberText(this->texelsPerVertex) + " texels a vertex)";
}

Result<BakeReport> BakeTextures(
  TexturedMesh& textured, std::uint64_t mostPixels, const Execution& execution)
{
  return Baker(textured, mostPixels, nullptr).Bake(execution);
}

Result<BakeReport> BakeAndKeepTextures(TexturedMesh& textured, const TextureOptions& options,
  const Execution& execution, std::span<const Color> tints)
{
  if (options.textureFolder.empty())
  {
    Result<BakeReport> report = BakeTextures(textured, options.mostPixels, execution);
    if (report && report->pictures > 0)
    {
      report->warnings.push_back(report->TellLoss());
    }
    return report;
  }
  Result<TextureFolderWriter> folder =
    TextureFolderWriter::Create(options.textureFolder, textured.pictures.size());
  KDSTREAM_TRY(folder);
  Result<BakeReport> report = Baker(textured, options.mostPixels, &*folder).Bake(execution);
  KDSTREAM_TRY(report);
  if (report->pictures == 0)
  {
    return report;
  }
  KDSTREAM_TRY(folder->Finish(textured.materials));
  if (!tints.empty())
  {
    const Result<bool> tinted =
      TintKept(textured, tints, options.textureFolder, *folder, execution);
    KDSTREAM_TRY(tinted);
    if (!*tinted)
    {
      report->warnings.emplace_back("multiplied by the colours of vertices, the pictures would "
                                    "become too large: they are not kept");
      report->warnings.push_back(report->TellLoss());
      return report;
    }
  }
  AddTextureArrays(textured);
  return report;
}

}
