// SPDX-License-Identifier: BSD-3-Clause
// Textured meshes for tests of kept pictures: one with everything that is difficult, and the
// colours of a file at places of its triangles.
#pragma once

#include "Testing/EndToEnd/ProgramsTest.h"
#include "filters/texture/FindTextures.h"
#include "filters/texture/Picture.h"
#include "filters/texture/PictureTexels.h"
#include "filters/texture/WritePicture.h"

#include <cmath>
#include <random>
#include <sstream>
#include <string>
#include <vector>

namespace kdstream::fixtures
{

// The decoded pictures, from bytes or files.
inline std::vector<Picture> PicturesOf(const TexturedMesh& textured)
{
  std::vector<Picture> pictures;
  for (const PictureSource& source : textured.pictures)
  {
    const std::string bytes = source.bytes.empty()
                                ? ReadWhole(source.file)
                                : std::string(source.bytes.begin(), source.bytes.end());
    Result<Picture> picture =
      DecodePicture({ reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size() });
    EXPECT_TRUE(picture) << source.name << ": " << picture.GetError().message;
    pictures.push_back(picture ? std::move(*picture) : Picture{ 1, 1, 1, { 0 } });
  }
  return pictures;
}

inline PlaceInPicture PlaceOf(const TexturedMaterial& material, double u, double v)
{
  const TextureTransform& m = material.transform;
  return { m.u[0] * u + m.u[1] * v + m.u[2], m.v[0] * u + m.v[1] * v + m.v[2] };
}

class TexturedTest : public ProgramsTest
{
protected:
  // Writes NAME.obj, NAME.mtl and two PNGs: a height field with a seam along its middle between two
  // pictures, one of which repeats while the other is clamped. One part is mirrored, one has no
  // coordinates, one has a material without a picture, and some triangles cross the pictures'
  // edges.
  void WriteHardObj(const std::string& name, unsigned seed, std::size_t side = 24)
  {
    std::mt19937 random(seed);
    for (const char* picture : { "-a.png", "-b.png" })
    {
      this->WriteNoise(name + picture, random);
    }
    this->WriteText(name + ".mtl", "newmtl a\nmap_Kd " + name +
                                     "-a.png\nnewmtl b\nmap_Kd -clamp on " + name +
                                     "-b.png\nnewmtl c\nKd 0.2 0.4 0.6\n");
    std::ostringstream text;
    text.precision(9);
    text << "mtllib " << name << ".mtl\n";
    for (std::size_t y = 0; y <= side; ++y)
    {
      for (std::size_t x = 0; x <= side; ++x)
      {
        const double u = double(x) / double(side), v = double(y) / double(side);
        text << "v " << u << " " << v << " " << float(0.05 * std::sin(9 * u) * std::cos(7 * v))
             << "\nvt " << float(1.3 * u + 0.001 * double(random() % 9)) << " " << float(v * 0.9)
             << "\nvt " << float(1 - u) << " " << float(v - 0.02) << "\n"; // mirrored, below 0
      }
    }
    const char* material = "";
    for (std::size_t y = 0; y < side; ++y)
    {
      for (std::size_t x = 0; x < side; ++x)
      {
        const bool right = 2 * x >= side;
        const char* const used = y + 2 >= side ? "c" : right ? "b" : "a";
        if (used != material)
        {
          text << "usemtl " << used << "\n";
          material = used;
        }
        const std::size_t a = y * (side + 1) + x, b = a + side + 1;
        const bool bare = y == 0 && x < 3;
        for (const std::array<std::size_t, 3>& t :
          { std::array{ a, a + 1, b + 1 }, std::array{ a, b + 1, b } })
        {
          text << "f";
          for (const std::size_t v : t)
          {
            text << " " << v + 1;
            if (!bare)
            {
              text << "/" << 2 * v + (right ? 2 : 1);
            }
          }
          text << "\n";
        }
      }
    }
    this->WriteText(name + ".obj", text.str());
  }

  TexturedMesh ReadWithTextures(const std::string& name)
  {
    Result<TexturedFile> read = ReadTextured(this->Folder / name);
    EXPECT_TRUE(read) << read.GetError().message;
    EXPECT_EQ(read->warnings, std::vector<std::string>{});
    return std::move(read->textured);
  }

private:
  // Writes noise with waves, which lossy compression keeps well.
  void WriteNoise(const std::string& name, std::mt19937& random)
  {
    Picture picture{ 200, 160, 3, {} };
    const double wave = 3 + double(random() % 5);
    for (std::size_t i = 0; i < picture.width * picture.height; ++i)
    {
      const double x = double(i % picture.width) / 30, y = double(i / picture.width) / 30;
      for (double k = 0; k < 3; ++k)
      {
        const double light = 128 + 90 * std::sin(wave * x + k) * std::cos(y + wave);
        picture.texels.push_back(static_cast<std::uint8_t>(light + double(random() % 8)));
      }
    }
    const std::vector<std::uint8_t> bytes = EncodePicture(picture, PictureType::Png);
    this->WriteText(name, { bytes.begin(), bytes.end() });
  }
};

}
