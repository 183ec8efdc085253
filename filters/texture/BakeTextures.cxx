// SPDX-License-Identifier: BSD-3-Clause
// Pictures as colours of vertices: see BakeTextures.h.
//   1. Which vertices are one place.
//   2. Triangles without a picture, or without coordinates: their material's colour.
//   3. Picture by picture: decode it; how finely its triangles are looked at; the sums of their
//      texels, for their corners.
//   4. The means, as bytes; what is lost, from sums that were made along the way.
#include "filters/texture/BakeTextures.h"

#include "filters/core/VectorMath.h"
#include "filters/core/Weld.h"
#include "filters/texture/PaintArrays.h"
#include "filters/texture/PaintFolder.h"
#include "filters/texture/PictureReader.h"
#include "filters/texture/PictureTexels.h"
#include "filters/texture/SumTexels.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>
#include <numeric>
#include <optional>

namespace kdstream
{
namespace
{

constexpr std::size_t fewestCuts = 3;  // of a side
constexpr double texelsOfCut = 1.4;    // of the longest side: a part or more for each texel
constexpr double partsOfTexel = 8;     // of the picture, for all triangles together
constexpr double partsOfTriangle = 64; // on top of that
constexpr std::size_t trianglesAtOnce = 16384;
constexpr double mostCuts = 1 << 15; // of a side; before the limit for all
// Triangles without area count so much, and none more than the most: sums stay numbers.
constexpr double leastArea = 1e-250, mostArea = 1e250;

// The place of each vertex: the number of the lowest one with its coordinates and its normal.
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

// Three digits, or all before the point.
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
  Baker(TexturedMesh& textured, std::uint64_t mostPixels, PaintFolderWriter* folder)
    : Textured(textured)
    , Reader(textured.pictures, mostPixels, folder)
  {
  }

  Result<BakeReport> Bake(const Execution& execution)
  {
    this->Places = PlacesOf(this->Textured.mesh, execution);
    this->Sums.resize(this->Places.size());
    const std::vector<std::vector<std::uint32_t>> ofPicture = this->SortTriangles();
    for (std::size_t i = 0; i < ofPicture.size(); ++i)
    {
      KDSTREAM_TRY(execution.Report("textures", double(i) / double(ofPicture.size())));
      if (!ofPicture[i].empty())
      {
        const auto done = [&](double part)
        { return execution.Report("textures", (double(i) + part) / double(ofPicture.size())); };
        KDSTREAM_TRY(
          this->BakePicture(static_cast<std::uint32_t>(i), ofPicture[i], execution, done));
      }
    }
    const std::vector<std::string> unread = this->Reader.Warnings();
    this->Report.warnings.insert(this->Report.warnings.end(), unread.begin(), unread.end());
    this->Finish();
    return std::move(this->Report);
  }

private:
  const TexturedMaterial& MaterialOf(std::size_t triangle) const
  {
    return this->Textured.materials[this->Textured.materialOf[triangle]];
  }

  // Of one without a picture.
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

  // The triangles that each picture paints. The others are painted at once.
  std::vector<std::vector<std::uint32_t>> SortTriangles()
  {
    std::vector<std::vector<std::uint32_t>> ofPicture(this->Textured.pictures.size());
    std::size_t bare = 0, firstBare = 0;
    for (std::size_t i = 0; i < this->Textured.mesh.triangles.size(); ++i)
    {
      const std::uint32_t picture = this->MaterialOf(i).picture;
      const bool painted = picture != noPicture && this->HasCoordinates(i);
      if (painted)
      {
        ofPicture[picture].push_back(static_cast<std::uint32_t>(i));
        continue;
      }
      this->Paint(i, this->ColorOf(i));
      firstBare = picture != noPicture && bare == 0 ? i : firstBare;
      bare += picture != noPicture ? 1 : 0;
    }
    if (bare > 0)
    {
      this->Report.warnings.push_back(
        std::to_string(bare) + (bare == 1 ? " triangle has" : " triangles have") +
        " no texture coordinates, or such that are no numbers (the "
        "first is triangle " +
        std::to_string(firstBare) + "): the material's colour is taken");
    }
    return ofPicture;
  }

  double AreaOf(const Triangle& t) const
  {
    const std::vector<Vec3>& points = this->Textured.mesh.points;
    const Vec3 normal = Cross(Minus(points[t[1]], points[t[0]]), Minus(points[t[2]], points[t[0]]));
    const double area = Length(normal) / 2;
    return area >= leastArea ? std::min(area, mostArea) : leastArea; // NaN: the least
  }

  // The whole triangle in one colour.
  void Paint(std::size_t triangle, const Color& light)
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
        this->Paint(triangle, this->ColorOf(triangle));
      }
      return {};
    }
    ++this->Report.pictures;
    const PictureTexels texels((*picture)->Texels());
    const double thinning = this->FindThinning(texels, triangles);
    // Each triangle by itself, on any thread; then all in their order: sums depend on no thread.
    std::vector<TriangleSum> sums(std::min(triangles.size(), trianglesAtOnce));
    for (std::size_t first = 0; first < triangles.size(); first += trianglesAtOnce)
    {
      const std::size_t count = std::min(trianglesAtOnce, triangles.size() - first);
      execution.parallelFor(count, 16,
        [&](std::size_t begin, std::size_t end)
        {
          for (std::size_t i = begin; i < end; ++i)
          {
            sums[i] = this->SumOf(triangles[first + i], texels, thinning);
          }
        });
      for (std::size_t i = 0; i < count; ++i)
      {
        this->Add(triangles[first + i], sums[i]);
      }
      KDSTREAM_TRY(done(double(first + count) / double(triangles.size())));
    }
    return {};
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

  // The corners' places in the picture, in pictures.
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

  // How much fewer cuts there must be than would be right, and how many texels are covered.
  double FindThinning(const PictureTexels& texels, const std::vector<std::uint32_t>& triangles)
  {
    double parts = 0;
    for (const std::uint32_t triangle : triangles)
    {
      const std::array<PlaceInPicture, 3> at = this->CornersOf(triangle);
      const double cuts = this->CutsOf(texels, at);
      parts += cuts * cuts;
      this->Report.texels += texels.Covered(at);
    }
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

  void Finish()
  {
    Mesh& mesh = this->Textured.mesh;
    std::erase_if(mesh.attributes, [](const Attribute& attribute)
      { return attribute.name == "RGB" || attribute.name == "RGBA"; });
    std::vector<std::array<std::uint8_t, 4>> colors(this->Sums.size());
    bool opaque = true;
    std::size_t places = 0;
    for (std::size_t v = 0; v < colors.size(); ++v)
    {
      const PlaceSum& sum = this->Sums[this->Places[v]];
      const bool any = sum.weight > 0;
      for (std::size_t k = 0; k < 3; ++k)
      {
        colors[v][k] = any ? ByteOfLinear(sum.light[k] / sum.weight) : 255;
      }
      const double alpha = any ? sum.light[3] / sum.weight : 1;
      colors[v][3] = static_cast<std::uint8_t>(std::lround(255 * std::clamp(alpha, 0.0, 1.0)));
      opaque = opaque && colors[v][3] == 255;
      places += this->Places[v] == v ? 1 : 0;
    }
    const bool alpha = !opaque;
    Attribute attribute{ { alpha ? "RGBA" : "RGB", AttributeType::UInt8,
                           AttributeAssociation::Point, std::uint8_t(alpha ? 4 : 3) },
      {} };
    for (const std::array<std::uint8_t, 4>& color : colors)
    {
      attribute.values.insert(
        attribute.values.end(), color.begin(), color.begin() + (alpha ? 4 : 3));
    }
    this->Report.texelsPerVertex = places > 0 ? this->Report.texels / double(places) : 0;
    this->MeasureLoss(colors);
    mesh.attributes.push_back(std::move(attribute));
  }

  // Σ area (texel - Σ share × colour)², multiplied out: the texels' squares and their products with
  // the shares were added up on the way, and the products of the shares follow from the cuts.
  void MeasureLoss(const std::vector<std::array<std::uint8_t, 4>>& colors)
  {
    double sum = this->Squares, all = 0;
    for (std::size_t v = 0; v < colors.size(); ++v)
    {
      for (std::size_t k = 0; k < 3 && this->Places[v] == v; ++k)
      {
        sum -= 2 * colors[v][k] * this->Sums[v].shown[k];
      }
    }
    this->Cuts.resize(this->Textured.mesh.triangles.size());
    for (std::size_t i = 0; i < this->Textured.mesh.triangles.size(); ++i)
    {
      const Triangle& t = this->Textured.mesh.triangles[i];
      const double area = this->AreaOf(t), cuts = this->Cuts[i];
      const double within = cuts > 0 ? 1 / (cuts * cuts) : 0; // of the spread of shares in a part
      all += area;
      for (std::size_t a = 0; a < 3; ++a)
      {
        for (std::size_t b = 0; b < 3; ++b)
        {
          const double whole = (a == b ? 2.0 : 1.0) / 12;
          const double products = whole - (whole - 1.0 / 9) * within;
          for (std::size_t k = 0; k < 3; ++k)
          {
            sum += area * products * colors[t[a]][k] * colors[t[b]][k];
          }
        }
      }
    }
    const double mean = sum / all / 3;
    this->Report.loss = all > 0 && std::isfinite(mean) ? std::sqrt(std::max(0.0, mean)) : 0;
  }

  TexturedMesh& Textured;
  PictureReader Reader;
  std::vector<VertexId> Places;
  std::vector<PlaceSum> Sums;      // of each place, at its number
  std::vector<std::uint16_t> Cuts; // of each triangle's sides; 0: of one colour
  double Squares = 0;
  BakeReport Report;
};

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
  return "levels are painted with the pictures' means (about " + NumberText(this->texelsPerVertex) +
         " texels a vertex); the original keeps the pictures";
}

Result<BakeReport> BakeTextures(
  TexturedMesh& textured, std::uint64_t mostPixels, const Execution& execution)
{
  return Baker(textured, mostPixels, nullptr).Bake(execution);
}

Result<BakeReport> BakeTexturesAndKeepPaint(
  TexturedMesh& textured, const TextureOptions& options, const Execution& execution)
{
  if (options.paintFolder.empty())
  {
    Result<BakeReport> report = BakeTextures(textured, options.mostPixels, execution);
    if (report && report->pictures > 0)
    {
      report->warnings.push_back(report->TellLoss());
    }
    return report;
  }
  Result<PaintFolderWriter> folder = PaintFolderWriter::Create(options.paintFolder);
  KDSTREAM_TRY(folder);
  Result<BakeReport> report = Baker(textured, options.mostPixels, &*folder).Bake(execution);
  KDSTREAM_TRY(report);
  if (report->pictures > 0)
  {
    KDSTREAM_TRY(folder->Finish(textured.materials, textured.pictures.size()));
    AddPaintArrays(textured);
  }
  return report;
}

}
