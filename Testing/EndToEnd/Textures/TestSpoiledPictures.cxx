// SPDX-License-Identifier: BSD-3-Clause
// kdstream-build with textured OBJ, PLY and glTF files whose pictures are missing, truncated, odd,
// or claim too much. A warning names the picture, the rest is built, and no claim takes memory.
#include "Testing/EndToEnd/Textures/SpoiledFiles.h"
#include "filters/texture/Testing/OddPictures.h"

using namespace kdstream;
using namespace kdstream::fixtures;
using namespace kdstream::test;

namespace
{

constexpr const char* taken = ": the material's colour is used";

// 32 rows of 64 pixels. left, right: the bytes of a pixel in the left half (red) and in the right
// half (blue), in the packing of a kind of PNG.
Bytes HalvesOf(const Bytes& left, const Bytes& right)
{
  Bytes rows;
  for (int i = 0; i < 32 * 64; ++i)
  {
    const Bytes& pixel = i % 64 < 32 ? left : right;
    rows.insert(rows.end(), pixel.begin(), pixel.end());
  }
  return rows;
}

class TestSpoiledPictures : public SpoiledTest
{
protected:
  // Builds the mesh with this picture in all formats, under this name; checks the warning about it,
  // if any.
  void ExpectInAllFormats(const std::string& name, const Bytes& bytes, const std::string& said,
    const std::vector<Rgb>& obj, const std::vector<Rgb>& others, int tolerance = 0)
  {
    SCOPED_TRACE(name);
    const auto warnings = [&](const std::string& picture) {
      return said.empty() ? std::vector<std::string>() : std::vector<std::string>{ picture + said };
    };
    this->WriteBytes(name, bytes);
    this->WriteMtl(name);
    this->WriteObj(leftAndRight);
    this->ExpectBuilt(
      "m.obj", warnings("the picture '" + name + "' (m.mtl, line 3)"), obj, tolerance);
    this->WritePly(name, { List("0.25"), List("0.75") });
    this->ExpectBuilt("m.ply", warnings("the picture '" + name + "' (TextureFile)"), others,
      tolerance, { "--textures", "colors" });
    GltfBuffer beside;
    this->WriteText("m.glb",
      Glb(beside, "\"images\":[{\"uri\":\"" + name + "\"}],\"textures\":[{\"source\":0}]"));
    this->ExpectBuilt("m.glb", warnings("image 0 '" + name + "'"), others, tolerance);
    GltfBuffer inside;
    const int view = inside.AddView(bytes.data(), bytes.size());
    this->WriteText("in.glb",
      Glb(inside, "\"images\":[{\"mimeType\":\"image/png\",\"bufferView\":" + std::to_string(view) +
                    "}],\"textures\":[{\"source\":0}]"));
    // Inside a .glb the picture has no name.
    const bool ofName = said.find("is named as") != std::string::npos;
    this->ExpectBuilt(
      "in.glb", ofName ? std::vector<std::string>() : warnings("image 0"), others, tolerance);
  }
  void ExpectBad(const std::string& name, const Bytes& bytes, const std::string& said)
  {
    this->ExpectInAllFormats(name, bytes, ": " + said + taken, { green, green }, { white, white });
  }
  void ExpectGood(const std::string& name, const Bytes& bytes, const std::string& said = "",
    const std::vector<Rgb>& colors = { red, blue }, int tolerance = 0)
  {
    this->ExpectInAllFormats(name, bytes, said, colors, colors, tolerance);
  }
};

}

TEST_F(TestSpoiledPictures, MissingOnesAreNamed)
{
  this->WriteMtl("gone.png");
  this->WriteObj(leftAndRight);
  this->ExpectBuilt("m.obj",
    { std::string("the picture 'gone.png' (m.mtl, line 3) is not there") + taken },
    { green, green });
  this->WritePly("gone.png", { List("0.25"), List("0.75") });
  this->ExpectBuilt("m.ply",
    { std::string("the picture 'gone.png' (TextureFile) is not there") + taken }, { white, white });
  GltfBuffer buffer;
  this->WriteText(
    "m.glb", Glb(buffer, "\"images\":[{\"uri\":\"gone.png\"}],\"textures\":[{\"source\":0}]"));
  this->ExpectBuilt(
    "m.glb", { std::string("image 0 'gone.png' is not there") + taken }, { white, white });
  // There is a folder with the picture's name.
  std::filesystem::create_directory(this->Folder / "gone.png");
  this->WriteMtl("gone.png");
  this->ExpectBuilt("m.obj",
    { std::string("the picture 'gone.png' (m.mtl, line 3): is a directory, not a file") + taken },
    { green, green });
}

TEST_F(TestSpoiledPictures, CutOnesAreNamed)
{
  const auto cut = [](Bytes whole)
  {
    whole.resize(whole.size() * 6 / 10);
    return whole;
  };
  this->ExpectBad("a.jpg", cut(TwoHalves(PictureType::Jpeg)),
    "it is a damaged or truncated JPEG (it ends too early)");
  this->ExpectBad("a.png", cut(TwoHalves(PictureType::Png)),
    "it is a damaged or truncated PNG (it ends too early)");
  this->ExpectBad("a.webp", cut(TwoHalves(PictureType::Webp)), "it is a damaged or truncated WebP");
}

TEST_F(TestSpoiledPictures, WhatIsNotAPictureIsNamed)
{
  this->ExpectBad("a.png", {}, "it is empty");
  const std::string text = "A text, and a long one, that somebody has named as a picture.\n";
  this->ExpectBad("a.png", { text.begin(), text.end() }, "it is neither JPEG, PNG nor WebP");
  this->ExpectBad("a.jpg", CmykJpeg(), "it is a JPEG in CMYK, which is for print: save it in RGB");
}

TEST_F(TestSpoiledPictures, ClaimsTakeNoMemory)
{
  const Bytes deep = RawPng(1, 1, 16, PNG_COLOR_TYPE_RGBA, Bytes(8), 8);
  this->ExpectBad("a.png", PngClaiming(deep, 60000, 60000),
    "it claims 60000 x 60000 pixels, more than the limit of 1073741824");
  this->ExpectBad("a.png", PngClaiming(deep, 10'000'000, 1),
    "it claims 10000000 x 1 pixels, more than 131072 along a side");
  this->ExpectBad("a.jpg", JpegClaiming(TwoHalves(PictureType::Jpeg), 65500, 65500),
    "it claims 65500 x 65500 pixels, more than the limit of 1073741824");
  // The claim is within the limit (half a gigabyte), but there is no data after the header.
  constexpr unsigned side = 12000;
  this->ExpectBad("a.png", PngClaiming(deep, side, side),
    "it is a damaged or truncated PNG (its texels end too early)");
  const Bytes interlaced = RawPng(1, 1, 16, PNG_COLOR_TYPE_RGBA, Bytes(8), 8, true);
  this->ExpectBad("a.png", PngClaiming(interlaced, side, side),
    "it is a damaged or truncated PNG (its texels end too early)");
  this->ExpectBad("a.jpg", JpegClaiming(TwoHalves(PictureType::Jpeg), side, side),
    "it is a damaged or truncated JPEG (its texels end too early)");
  this->ExpectBad("a.jpg", JpegClaiming(ProgressiveJpeg(), side, side),
    "it is a damaged or truncated JPEG (its texels end too early)");
  this->ExpectBad("a.webp", WebpOfNothing(), "it is a damaged or truncated WebP");
  this->WriteBytes("a.png", TwoHalves(PictureType::Png));
  this->WriteMtl("a.png");
  this->WriteObj(leftAndRight);
  this->ExpectBuilt("m.obj",
    { std::string("the picture 'a.png' (m.mtl, line 3): it claims 64 x 32 pixels, more than the "
                  "limit of 2047") +
      taken },
    { green, green }, 0, { "--texture-pixels", "2047" });
  this->ExpectBuilt("m.obj", {}, { red, blue }, 0, { "--texture-pixels", "2048" });
}

TEST_F(TestSpoiledPictures, ASparseFileOfAnySizeTakesNoMemory)
{
  this->WriteMtl("a.png");
  this->WriteObj(leftAndRight);
  constexpr std::uintmax_t size = std::uintmax_t{ 1 } << 36;
  this->WriteText("a.png", "no picture");
  std::filesystem::resize_file(this->Folder / "a.png", size);
  const std::string named = "the picture 'a.png' (m.mtl, line 3): ";
  this->ExpectBuilt(
    "m.obj", { named + "it is neither JPEG, PNG nor WebP" + taken }, { green, green });
  this->WriteBytes("a.png", TwoHalves(PictureType::Png));
  std::filesystem::resize_file(this->Folder / "a.png", size);
  this->ExpectBuilt("m.obj",
    { named + "it has 68719476736 bytes, more than a picture of the limit of 1073741824 pixels" +
      taken },
    { green, green });
}

TEST_F(TestSpoiledPictures, TypesAreThoseOfTheBytes)
{
  this->ExpectGood(
    "a.jpg", TwoHalves(PictureType::Png), " is named as a JPEG file but contains a PNG");
  this->ExpectGood("a.png", TwoHalves(PictureType::Jpeg),
    " is named as a PNG file but contains a JPEG", { red, blue }, 4);
  this->ExpectGood("a.picture", TwoHalves(PictureType::Webp));
}

TEST_F(TestSpoiledPictures, OddKindsJustWork)
{
  const Rgb light{ 200, 200, 200 }, dark{ 50, 50, 50 };
  this->ExpectGood("a.jpg",
    EncodePicture({ 64, 32, 1, HalvesOf({ 200 }, { 50 }) }, PictureType::Jpeg), "", { light, dark },
    4);
  this->ExpectGood("a.png",
    RawPng(64, 32, 16, PNG_COLOR_TYPE_RGB,
      HalvesOf({ 255, 255, 0, 0, 0, 0 }, { 0, 0, 0, 0, 255, 255 }), std::size_t{ 6 } * 64));
  this->ExpectGood("a.png", RawPng(64, 32, 8, PNG_COLOR_TYPE_PALETTE, HalvesOf({ 1 }, { 4 }), 64,
                              false, { 255, 0, 255, 255, 128 }));
  this->ExpectGood("a.png", RawPng(64, 32, 8, PNG_COLOR_TYPE_RGB,
                              HalvesOf({ 255, 0, 0 }, { 0, 0, 255 }), std::size_t{ 3 } * 64, true));
  this->ExpectGood(
    "a.png", EncodePicture(
               { 64, 32, 4, HalvesOf({ 255, 0, 0, 128 }, { 0, 0, 255, 64 }) }, PictureType::Png));
  this->ExpectGood("a.png",
    EncodePicture({ 64, 32, 2, HalvesOf({ 200, 9 }, { 50, 0 }) }, PictureType::Png), "",
    { light, dark });
}
