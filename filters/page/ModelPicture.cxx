// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. Decode the preview.
// 2. Place its vertices as in the first view, so large that they fill the picture.
// 3. Draw triangles, or the discs of points, into four samples a pixel; in each sample the nearest
//    one stays.
// 4. Encode the means of the samples as a JPEG.
#include "filters/page/ModelPicture.h"

#include "filters/codec/PieceCodec.h"
#include "filters/core/UnitVector.h"
#include "filters/core/drawing/PartNormals.h"
#include "filters/page/JpegBytes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <utility>

namespace kdstream
{

namespace
{

constexpr std::size_t mostPreviewBytes = std::size_t{ 4 } << 20;
constexpr unsigned samplesAcross = 2; // of a pixel, in each direction
constexpr unsigned sampleColumns = samplesAcross * pictureWidth,
                   sampleRows = samplesAcross * pictureHeight;
constexpr std::uint64_t mostSamplesTested = std::uint64_t{ 100 } * sampleColumns * sampleRows;

// As in viewer/session/appearance: Palette.h and SceneAppearance.h.
constexpr Vec3 stone{ 217.0 / 255, 208.0 / 255, 192.0 / 255 };
constexpr Vec3 groundBottom{ 91.0 / 255, 94.0 / 255, 99.0 / 255 };
constexpr Vec3 groundTop{ 33.0 / 255, 35.0 / 255, 40.0 / 255 };
struct PictureLight
{
  Vec3 from, color; // from: of length 1
};
const std::array<PictureLight, 2>& PictureLights()
{
  static const std::array<PictureLight, 2> lights{ {
    { UnitVector({ -0.75, 0.95, 0.75 }), { 0.8, 0.776, 0.728 } },
    { UnitVector({ 0.3, 0.2, 1.0 }), { 0.3312, 0.342, 0.36 } },
  } };
  return lights;
}
constexpr double ambientLight = 0.15, diffuseLight = 0.85, specularLight = 0.14;

// The axes of the view: to the right, up, and towards the eye.
struct PictureAxes
{
  Vec3 right, up, view;
};

PictureAxes AxesOf(const ModelDescription& model)
{
  const HomeView home = model.homeView.value_or(HomeView{});
  const auto view = ScaledUnitVector(home.view).value_or(Vec3{ 0, 0, 1 });
  for (const Vec3& up : { home.up, Vec3{ 0, 1, 0 }, Vec3{ 0, 0, 1 }, Vec3{ 1, 0, 0 } })
  {
    const Vec3 right = Cross(up, view);
    constexpr double parallel = 1e-6;
    if (Length(right) > parallel)
    {
      const Vec3 unit = UnitVector(right);
      return { unit, Cross(view, unit), view };
    }
  }
  return { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } }; // if vectors are not finite
}

Vec3 Turned(const PictureAxes& axes, const Vec3& v)
{
  return { Dot(axes.right, v), Dot(axes.up, v), Dot(axes.view, v) };
}

struct PictureVertex
{
  double x = 0, y = 0; // in samples, from the upper left corner
  double near = 0;     // 1 / distance from the eye
  Vec3 normal{};       // in the picture's axes; 0: unknown
  Vec3 color = stone;
  bool IsFinite() const
  {
    return std::isfinite(this->x) && std::isfinite(this->y) && std::isfinite(this->near);
  }
};

// The smallest and the largest coordinate of what is shown, in one direction.
struct Span
{
  double lo = 0, hi = 0;
  double Middle() const { return 0.5 * (this->lo + this->hi); }
  // The factor by which the span fits into `room`.
  double Scale(double room) const { return this->hi > this->lo ? room / (this->hi - this->lo) : 0; }
};

Vec3 MiddleOf(const Box& box)
{
  return Times(Plus(box.lo, box.hi), 0.5);
}

// Finds where vertices are in the picture, seen from a distance of some radii of the model, and as
// large as they fit.
void PlaceVertices(
  const Piece& piece, const PictureAxes& axes, std::vector<PictureVertex>& vertices)
{
  Box box;
  for (const Vec3& position : piece.positions)
  {
    box.Add(position);
  }
  const Vec3 middle = MiddleOf(box);
  double radius = 0;
  for (const Vec3& position : piece.positions)
  {
    radius = std::max(radius, Length(Minus(position, middle)));
  }
  constexpr double away = 4; // in radii
  const double distance = radius > 0 ? away * radius : 1;
  Span across, upright;
  for (std::size_t i = 0; i < vertices.size(); ++i)
  {
    const Vec3 seen = Turned(axes, Minus(piece.positions[i], middle));
    auto& vertex = vertices[i];
    vertex.near = 1 / (distance - seen[2]);
    vertex.x = seen[0] * distance * vertex.near;
    vertex.y = seen[1] * distance * vertex.near;
    across = i == 0 ? Span{ vertex.x, vertex.x }
                    : Span{ std::min(across.lo, vertex.x), std::max(across.hi, vertex.x) };
    upright = i == 0 ? Span{ vertex.y, vertex.y }
                     : Span{ std::min(upright.lo, vertex.y), std::max(upright.hi, vertex.y) };
  }
  constexpr double filled = 0.88;
  const double byWidth = across.Scale(filled * sampleColumns);
  const double byHeight = upright.Scale(filled * sampleRows);
  const double scale = byWidth == 0    ? byHeight
                       : byHeight == 0 ? byWidth
                                       : std::min(byWidth, byHeight);
  for (auto& vertex : vertices)
  {
    vertex.x = 0.5 * sampleColumns + scale * (vertex.x - across.Middle());
    vertex.y = 0.5 * sampleRows - scale * (vertex.y - upright.Middle());
  }
}

std::vector<PictureVertex> VerticesOf(const Piece& piece, const PictureAxes& axes)
{
  std::vector<PictureVertex> vertices(piece.positions.size());
  PlaceVertices(piece, axes, vertices);
  const auto sums = SumOfNormals(piece.positions, piece.triangles);
  const Attribute* const normals =
    piece.triangles.empty() ? FindRole(piece.attributes, AttributeRole::Normals) : nullptr;
  const Attribute* const colors = FindRole(piece.attributes, AttributeRole::Colors);
  for (std::size_t i = 0; i < vertices.size(); ++i)
  {
    const Vec3 normal =
      normals ? Vec3{ normals->Get(i, 0), normals->Get(i, 1), normals->Get(i, 2) } : sums[i];
    vertices[i].normal = Turned(axes, ScaledUnitVector(normal).value_or(Vec3{}));
    if (colors)
    {
      vertices[i].color = { colors->Get(i, 0) / 255, colors->Get(i, 1) / 255,
        colors->Get(i, 2) / 255 };
    }
  }
  return vertices;
}

// Phong's lighting model, with a distant eye.
Vec3 LitColor(const Vec3& color, const Vec3& anyNormal)
{
  Vec3 normal = UnitVector(anyNormal);
  if (normal[2] < 0) // the visible side is lit
  {
    normal = Times(normal, -1);
  }
  if (normal == Vec3{})
  {
    normal = { 0, 0, 1 };
  }
  Vec3 diffuse{}, specular{};
  for (const PictureLight& light : PictureLights())
  {
    const double facing = Dot(normal, light.from);
    if (facing > 0)
    {
      double mirrored = std::max(0.0, 2 * facing * normal[2] - light.from[2]);
      for (int power = 1; power < 32; power *= 2)
      {
        mirrored *= mirrored;
      }
      diffuse = Plus(diffuse, Times(light.color, facing));
      specular = Plus(specular, Times(light.color, mirrored));
    }
  }
  Vec3 lit{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    lit[k] = color[k] * (ambientLight + diffuseLight * diffuse[k]) +
             stone[k] * specularLight * specular[k];
  }
  return lit;
}

std::uint8_t ByteOf(double share)
{
  return static_cast<std::uint8_t>(255 * std::clamp(share, 0.0, 1.0) + 0.5);
}

class PictureSamples
{
public:
  PictureSamples()
    : Near(std::size_t{ sampleColumns } * sampleRows, 0.0F)
    , Colors(3 * this->Near.size())
  {
    for (unsigned row = 0; row < sampleRows; ++row)
    {
      const double height = 1 - (row + 0.5) / sampleRows;
      const Vec3 ground = Plus(groundBottom, Times(Minus(groundTop, groundBottom), height));
      for (unsigned column = 0; column < sampleColumns; ++column)
      {
        this->Put(this->PlaceOf(column, row), ground);
      }
    }
  }

  void DrawTriangle(const PictureVertex& a, PictureVertex b, PictureVertex c)
  {
    double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (!a.IsFinite() || !b.IsFinite() || !c.IsFinite() || area == 0)
    {
      return;
    }
    if (area < 0)
    {
      std::swap(b, c);
      area = -area;
    }
    this->ForEach(std::min({ a.x, b.x, c.x }), std::max({ a.x, b.x, c.x }),
      std::min({ a.y, b.y, c.y }), std::max({ a.y, b.y, c.y }),
      [&](std::size_t place, double x, double y)
      {
        const double ofA = ((c.x - b.x) * (y - b.y) - (c.y - b.y) * (x - b.x)) / area;
        const double ofB = ((a.x - c.x) * (y - c.y) - (a.y - c.y) * (x - c.x)) / area;
        const double ofC = 1 - ofA - ofB;
        const double near = ofA * a.near + ofB * b.near + ofC * c.near;
        if (ofA < 0 || ofB < 0 || ofC < 0 || near <= this->Near[place])
        {
          return;
        }
        const auto mean = [&](const Vec3& atA, const Vec3& atB, const Vec3& atC)
        { return Plus(Plus(Times(atA, ofA), Times(atB, ofB)), Times(atC, ofC)); };
        this->Near[place] = static_cast<float>(near);
        this->Put(
          place, LitColor(mean(a.color, b.color, c.color), mean(a.normal, b.normal, c.normal)));
      });
  }

  void DrawDisc(const PictureVertex& at, double radius)
  {
    if (!at.IsFinite())
    {
      return;
    }
    const Vec3 color = LitColor(at.color, at.normal);
    this->ForEach(at.x - radius, at.x + radius, at.y - radius, at.y + radius,
      [&](std::size_t place, double x, double y)
      {
        const double dx = x - at.x, dy = y - at.y;
        if (dx * dx + dy * dy <= radius * radius && at.near > this->Near[place])
        {
          this->Near[place] = static_cast<float>(at.near);
          this->Put(place, color);
        }
      });
  }

  bool IsExhausted() const { return this->Tested > mostSamplesTested; }

  std::vector<std::uint8_t> Pixels() const
  {
    std::vector<std::uint8_t> pixels;
    pixels.reserve(std::size_t{ 3 } * pictureWidth * pictureHeight);
    for (unsigned row = 0; row < pictureHeight; ++row)
    {
      for (unsigned column = 0; column < pictureWidth; ++column)
      {
        for (unsigned k = 0; k < 3; ++k)
        {
          unsigned sum = samplesAcross * samplesAcross / 2;
          for (unsigned sample = 0; sample < samplesAcross * samplesAcross; ++sample)
          {
            const auto place = this->PlaceOf(samplesAcross * column + sample % samplesAcross,
              samplesAcross * row + sample / samplesAcross);
            sum += this->Colors[3 * place + k];
          }
          pixels.push_back(static_cast<std::uint8_t>(sum / (samplesAcross * samplesAcross)));
        }
      }
    }
    return pixels;
  }

private:
  static std::size_t PlaceOf(unsigned column, unsigned row)
  {
    return std::size_t{ row } * sampleColumns + column;
  }

  // Calls `draw` for the samples whose centres are within the rectangle and within the picture.
  template <class Draw>
  void ForEach(double left, double right, double top, double bottom, const Draw& draw)
  {
    const auto first = [](double from)
    { return static_cast<unsigned>(std::clamp(std::ceil(from - 0.5), 0.0, 1e6)); };
    const auto end = [](double to, unsigned most)
    { return static_cast<unsigned>(std::clamp(std::floor(to - 0.5) + 1, 0.0, double(most))); };
    const unsigned lastRow = end(bottom, sampleRows), lastColumn = end(right, sampleColumns);
    for (unsigned row = first(top); row < lastRow; ++row)
    {
      for (unsigned column = first(left); column < lastColumn; ++column)
      {
        ++this->Tested;
        draw(PlaceOf(column, row), column + 0.5, row + 0.5);
      }
    }
  }

  void Put(std::size_t place, const Vec3& color)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      this->Colors[3 * place + k] = ByteOf(color[k]);
    }
  }

  std::vector<float> Near; // 1 / distance of what was drawn there; 0: background
  std::vector<std::uint8_t> Colors;
  std::uint64_t Tested = 0;
};

void DrawPiece(
  const Piece& piece, const std::vector<PictureVertex>& vertices, PictureSamples& samples)
{
  for (std::size_t i = 0; i < piece.triangles.size() && !samples.IsExhausted(); ++i)
  {
    const Triangle& t = piece.triangles[i];
    samples.DrawTriangle(vertices[t[0]], vertices[t[1]], vertices[t[2]]);
  }
  if (piece.primitive == PrimitiveType::Points)
  {
    constexpr double covered = 0.4 * sampleColumns * sampleRows;
    const double radius = std::clamp(std::sqrt(covered / double(vertices.size() + 1)), 1.5, 24.0);
    for (std::size_t i = 0; i < vertices.size() && !samples.IsExhausted(); ++i)
    {
      samples.DrawDisc(vertices[i], radius);
    }
  }
}

}

PieceId PreviewPiece(const ModelDescription& model)
{
  return { Resolution::Level(PreviewLevel(model)), 1 };
}

bool HasPicture(const ModelDescription& model)
{
  const auto level = PreviewLevel(model);
  const auto bytes = level < model.levels.size() ? model.levels[level].bytes : 0;
  return bytes > 0 && bytes <= mostPreviewBytes;
}

Result<Piece> DecodePreview(const ModelDescription& model, std::span<const std::uint8_t> blob)
{
  if (blob.size() > mostPreviewBytes)
  {
    return Error{ ErrorCode::LimitExceeded, "the preview is too large to be drawn" };
  }
  return DecodePiece(blob, PreviewPiece(model), model.Codec());
}

Result<std::vector<std::uint8_t>> DrawModelPicture(
  const ModelDescription& model, std::span<const std::uint8_t> blob)
{
  try
  {
    const auto piece = DecodePreview(model, blob);
    KDSTREAM_TRY(piece);
    const auto vertices = VerticesOf(*piece, AxesOf(model));
    std::vector<std::uint8_t> pixels;
    {
      PictureSamples samples;
      DrawPiece(*piece, vertices, samples);
      pixels = samples.Pixels();
    }
    return JpegBytes(pixels, pictureWidth, pictureHeight);
  }
  catch (const std::bad_alloc&)
  {
    return Error{ ErrorCode::LimitExceeded, "out of memory for a picture" };
  }
}

}
