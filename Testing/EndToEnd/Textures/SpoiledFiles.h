// SPDX-License-Identifier: BSD-3-Clause
// Shared by the tests of textured meshes that are damaged in one way: a mesh of two faces, which
// its picture makes red and blue, in each format; and running kdstream-build with it.
#pragma once

#include "Testing/EndToEnd/GltfFile.h"
#include "Testing/EndToEnd/ProgramsTest.h"
#include "filters/texture/WritePicture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <sstream>
#include <string>
#include <vector>

namespace kdstream::fixtures
{

using Rgb = std::array<int, 3>;
using Coordinates = std::vector<std::array<std::string, 2>>; // u, v of each face, as text

class SpoiledTest : public ProgramsTest
{
protected:
  static constexpr Rgb red{ 255, 0, 0 }, green{ 0, 255, 0 }, blue{ 0, 0, 255 },
    white{ 255, 255, 255 };
  // The middles of the picture's left and right halves.
  inline static const Coordinates leftAndRight{ { "0.25", "0.5" }, { "0.75", "0.5" } };

  void WriteBytes(const std::string& name, const std::vector<std::uint8_t>& bytes)
  {
    this->WriteText(name, { bytes.begin(), bytes.end() });
  }

  // A picture of 64 x 32 texels, red on the left and blue on the right.
  static Picture TwoHalves()
  {
    Picture picture{ 64, 32, 3, {} };
    for (std::size_t i = 0; i < picture.width * picture.height; ++i)
    {
      const bool left = i % picture.width < picture.width / 2;
      picture.texels.insert(picture.texels.end(),
        { std::uint8_t(left ? 255 : 0), std::uint8_t{ 0 }, std::uint8_t(left ? 0 : 255) });
    }
    return picture;
  }
  static std::vector<std::uint8_t> TwoHalves(PictureType type)
  {
    return EncodePicture(TwoHalves(), type);
  }

  // Writes "m.obj", with the material "a" and a face for each coordinate, at x = 0, 1, …. more:
  // lines after these.
  void WriteObj(const Coordinates& at, const std::string& more = "",
    const std::string& before = "mtllib m.mtl\nusemtl a\n")
  {
    std::string text = before;
    int face = 0;
    for (const auto& [u, v] : at)
    {
      text += Places(face++, "v ");
      text += "vt " + u + " " + v + "\nf -3/-1 -2/-1 -1/-1\n";
    }
    this->WriteText("m.obj", text + more);
  }
  // Writes "m.mtl". Its material "a" is green where no picture covers it.
  void WriteMtl(const std::string& picture)
  {
    this->WriteText("m.mtl", "newmtl a\nKd 0 1 0\nmap_Kd " + picture + "\n");
  }

  // Writes "m.ply", with the name of a picture, and with a face for each text, which contains the
  // lists and numbers of the face.
  void WritePly(const std::string& picture, const std::vector<std::string>& faces,
    const std::string& properties = "property list uchar float texcoord\n")
  {
    std::string places, lists;
    for (std::size_t i = 0; i < faces.size(); ++i)
    {
      places += Places(int(i), "");
      lists += "3 " + std::to_string(3 * i) + " " + std::to_string(3 * i + 1) + " " +
               std::to_string(3 * i + 2) + " " + faces[i] + "\n";
    }
    this->WriteText("m.ply", "ply\nformat ascii 1.0\ncomment TextureFile " + picture +
                               "\nelement vertex " + std::to_string(3 * faces.size()) +
                               "\nproperty float x\nproperty float y\nproperty float z\nelement "
                               "face " +
                               std::to_string(faces.size()) +
                               "\nproperty list uchar int vertex_indices\n" + properties +
                               "end_header\n" + places + lists);
  }
  static std::string List(const std::string& u, const std::string& v = "0.5")
  {
    return "6 " + u + " " + v + " " + u + " " + v + " " + u + " " + v;
  }

  // Makes a .glb. more: images, textures and other members of the document. material: members of
  // the material.
  static std::string Glb(GltfBuffer& buffer, const std::string& more,
    const std::string& material = "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}")
  {
    return buffer.Glb(Scene(buffer, more, material));
  }
  static std::string Scene(GltfBuffer& buffer, const std::string& more,
    const std::string& material = "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}")
  {
    const std::vector<float> points{ 0, 0, 0, 0, 1, 0, 0.5F, 0, 1, 1, 0, 0, 1, 1, 0, 1.5F, 0, 1 };
    const std::vector<float> at{ 0.25F, 0.5F, 0.25F, 0.5F, 0.25F, 0.5F, 0.75F, 0.5F, 0.75F, 0.5F,
      0.75F, 0.5F };
    const int position = buffer.Add(points, "VEC3", gltfFloat, ",\"min\":[0,0,0],\"max\":[2,1,1]");
    const int coordinates = buffer.Add(at, "VEC2", gltfFloat);
    return "\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],\"materials\":[{" +
           material +
           "}],\"meshes\":[{\"primitives\":[{\"material\":0,\"attributes\":{\"POSITION\":" +
           std::to_string(position) + ",\"TEXCOORD_0\":" + std::to_string(coordinates) + "}}]}]" +
           (more.empty() ? "" : "," + more);
  }

  // Expects that the store is built, complete, and with these colours of its faces. The warnings,
  // except the last one (how much was baked), must be these. tolerance: for each channel.
  void ExpectBuilt(const std::string& input, const std::vector<std::string>& warnings,
    const std::vector<Rgb>& colors, int tolerance = 0, const std::vector<std::string>& more = {})
  {
    SCOPED_TRACE(input);
    std::vector<std::string> arguments{ input, "-o", "m.kds", "--quiet", "--precision",
      "lossless" };
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome built = this->Build(arguments);
    EXPECT_LT(built.peakBytes, mostBytes) << "a claim must take no memory";
    ASSERT_EQ(built.exitCode, 0) << built.err;
    EXPECT_EQ(WarningsOf(built.err, input), warnings);
    const Outcome verified = this->Store({ "verify", "m.kds" });
    EXPECT_EQ(verified.exitCode, 0) << verified.err;
    std::filesystem::remove(this->Folder / "back.ply");
    const Outcome extracted = this->Store({ "extract", "m.kds", "--all", "-o", "back.ply" });
    ASSERT_EQ(extracted.exitCode, 0) << extracted.err;
    this->ExpectColors(this->Read("back.ply"), colors, tolerance);
  }

  // Expects exit code 1, one line that names the file and contains `what`, no store, and no file
  // that is left.
  void ExpectRefused(const std::string& input, const std::string& what)
  {
    SCOPED_TRACE(input);
    std::filesystem::remove(this->Folder / "m.kds");
    const std::set<std::string> before = this->Files();
    const Outcome built = this->Build({ input, "-o", "m.kds", "--quiet" });
    EXPECT_LT(built.peakBytes, mostBytes) << "a claim must take no memory";
    EXPECT_EQ(built.exitCode, 1);
    EXPECT_EQ(built.err.rfind("kdstream-build: error: " + input + ": ", 0), 0U) << built.err;
    EXPECT_NE(built.err.find(what), std::string::npos) << built.err << "lacks: " << what;
    EXPECT_EQ(std::count(built.err.begin(), built.err.end(), '\n'), 1) << built.err;
    EXPECT_EQ(this->Files(), before);
  }

private:
  static constexpr std::uint64_t mostBytes = std::uint64_t{ 300 } << 20; // VTK takes most of it

  static std::string Places(int face, const std::string& lead)
  {
    const std::string x = std::to_string(face);
    return lead + x + " 0 0\n" + lead + x + " 1 0\n" + lead + x + ".5 0 1\n";
  }

  static std::vector<std::string> WarningsOf(const std::string& err, const std::string& input)
  {
    const std::string lead = "kdstream-build: warning: " + input + ": ";
    std::vector<std::string> warnings;
    std::istringstream lines(err);
    for (std::string line; std::getline(lines, line);)
    {
      EXPECT_EQ(line.rfind(lead, 0), 0U) << line;
      const std::string text = line.substr(std::min(lead.size(), line.size()));
      if (text.rfind("textures are baked", 0) != 0)
      {
        warnings.push_back(text);
      }
    }
    return warnings;
  }

  static void ExpectColors(const Mesh& mesh, const std::vector<Rgb>& colors, int tolerance)
  {
    EXPECT_EQ(mesh.points.size(), 3 * colors.size());
    const auto array = std::find_if(mesh.attributes.begin(), mesh.attributes.end(),
      [](const Attribute& each) { return RoleOf(each) == AttributeRole::Colors; });
    for (std::size_t i = 0; i < mesh.points.size(); ++i)
    {
      const auto face = static_cast<std::size_t>(std::floor(mesh.points[i][0]));
      for (std::size_t k = 0; k < 3 && face < colors.size(); ++k)
      {
        const double value = array == mesh.attributes.end() ? 255 : array->Get(i, k);
        EXPECT_NEAR(value, colors[face][k], tolerance) << "face " << face << ", channel " << k;
      }
    }
  }
};

}
