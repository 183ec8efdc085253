// SPDX-License-Identifier: BSD-3-Clause
// Pictures of scenes: see ComparedPictures.h.
#include "Testing/Benchmarks/ComparedPictures.h"

#include "viewer/offscreen/OffscreenWindow.h"
#include "viewer/rendering/DecodeTile.h"

#include <vtkRenderer.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace kdstream::bench
{
namespace
{

constexpr int finer = 2;

[[noreturn]] void Fail(const std::string& what)
{
  std::fprintf(stderr, "error: %s\n", what.c_str());
  std::exit(2);
}

WindowPicture Shrunk(const WindowPicture& fine)
{
  WindowPicture picture{ width, height, std::vector<std::uint8_t>(3 * width * height) };
  for (std::size_t y = 0; y < height; ++y)
  {
    for (std::size_t x = 0; x < 3 * width; ++x)
    {
      unsigned sum = 0;
      for (std::size_t i = 0; i < finer * finer; ++i)
      {
        const std::size_t column = (x / 3 * finer + i % finer) * 3 + x % 3;
        sum += fine.rgb[(y * finer + i / finer) * 3 * width * finer + column];
      }
      picture.rgb[y * 3 * width + x] =
        static_cast<std::uint8_t>((sum + finer * finer / 2) / (finer * finer));
    }
  }
  return picture;
}

bool Differs(const WindowPicture& a, const WindowPicture& b, std::size_t pixel, int most)
{
  for (std::size_t k = 3 * pixel; k < 3 * pixel + 3; ++k)
  {
    if (std::abs(int{ a.rgb[k] } - int{ b.rgb[k] }) > most)
    {
      return true;
    }
  }
  return false;
}

}

Painter::Painter()
{
  auto window = MakeOffscreenWindow(WindowBackend::Auto, width * finer, height * finer);
  if (!window)
  {
    Fail(window.GetError().message);
  }
  this->Scene.SetTileDecoder(DecodeTile);
  this->Window = *window;
  this->Window->AddRenderer(&this->Scene.Renderer());
}

WindowPicture Painter::Draw(const ViewerScene& scene)
{
  const Vec3 centre = scene.box.lo * 0.5 + scene.box.hi * 0.5;
  const Status drawn = this->Scene.Update(*scene.surface, scene.depths, centre, scene.tiles);
  const Status placed =
    this->Scene.SetCamera({ scene.eye, scene.focal, scene.up, scene.viewAngle });
  auto picture = Pixels(*this->Window);
  if (!drawn || !placed || !picture)
  {
    Fail("a picture cannot be drawn");
  }
  return Shrunk(*picture);
}

double ShareOfWrong(
  const WindowPicture& picture, const WindowPicture& original, const WindowPicture& background)
{
  std::size_t object = 0, wrong = 0;
  for (std::size_t i = 0; i < std::size_t{ width } * height; ++i)
  {
    const bool seen = Differs(original, background, i, 0) || Differs(picture, background, i, 0);
    object += seen;
    wrong += seen && Differs(picture, original, i, 8);
  }
  return object > 0 ? static_cast<double>(wrong) / static_cast<double>(object) : 0;
}

double RmsDifference(const WindowPicture& a, const WindowPicture& b)
{
  double sum = 0;
  for (std::size_t i = 0; i < a.rgb.size(); ++i)
  {
    const double difference = (double{ 1 } * a.rgb[i] - b.rgb[i]) / 255;
    sum += difference * difference;
  }
  return std::sqrt(sum / static_cast<double>(a.rgb.size()));
}

}
