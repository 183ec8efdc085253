// SPDX-License-Identifier: BSD-3-Clause
// For tests of baking by the programs: small meshes with textures of a few texels, as OBJ and glTF,
// and the resulting colours and warnings.
#pragma once

#include "Testing/EndToEnd/ConvertTools.h"
#include "Testing/EndToEnd/GltfFile.h"
#include "filters/texture/WritePicture.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <sstream>
#include <string>
#include <vector>

namespace kdstream::fixtures
{

// A picture of one row of texels with these colours, from left to right.
inline Picture Row(const std::vector<std::array<std::uint8_t, 3>>& colors)
{
  Picture picture{ colors.size(), 1, 3, {} };
  for (const auto& color : colors)
  {
    picture.texels.insert(picture.texels.end(), color.begin(), color.end());
  }
  return picture;
}

inline const std::array<std::uint8_t, 3> red{ 255, 0, 0 }, green{ 0, 255, 0 }, blue{ 0, 0, 255 };

// Texture coordinates of two faces: one is in the middle of the picture's left half, the other of
// its right half.
inline const std::vector<std::array<float, 2>> leftAndRight{ { 0.25F, 0.5F }, { 0.75F, 0.5F } };

class BakedColorsTest : public ConvertTest
{
protected:
  void WritePicture(const std::string& name, const Picture& picture, PictureType type)
  {
    const std::vector<std::uint8_t> bytes = EncodePicture(picture, type);
    this->WriteText(name, std::string(bytes.begin(), bytes.end()));
  }

  // An OBJ with a separate face for each coordinate; all corners of a face have the same
  // coordinate.
  static std::string Faces(const std::vector<std::array<float, 2>>& coordinates,
    const std::string& before = "mtllib m.mtl\nusemtl a\n")
  {
    std::string text = before;
    int number = 0;
    for (const auto& c : coordinates)
    {
      const std::string x = std::to_string(number);
      text += "v " + x + " 0 0\nv " + x + " 1 0\nv " + x + ".5 0 1\n";
      text += "vt " + std::to_string(c[0]) + " " + std::to_string(c[1]) + "\n";
      const auto corner = [&](int k)
      { return " " + std::to_string(3 * number + k) + "/" + std::to_string(number + 1); };
      text += "f" + corner(1) + corner(2) + corner(3) + "\n";
      ++number;
    }
    return text;
  }

  // The colour of each face in the resulting file.
  std::vector<std::array<std::uint8_t, 3>> ColorsOf(const Mesh& mesh)
  {
    std::vector<std::array<std::uint8_t, 3>> colors;
    const std::vector<double> values = ValuesOf(mesh, "RGB");
    for (std::size_t i = 0; i + 9 <= values.size(); i += 9)
    {
      colors.push_back(
        { std::uint8_t(values[i]), std::uint8_t(values[i + 1]), std::uint8_t(values[i + 2]) });
      EXPECT_TRUE(std::equal(&values[i], &values[i] + 3, &values[i] + 3));
    }
    return colors;
  }

  // The warnings of kdstream-convert except the last one, which says how much was baked.
  std::string WarningsOf(const std::string& file)
  {
    const Outcome outcome = this->Convert(file);
    EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
    const std::string lead = "kdstream-convert: warning: " + file + ": ";
    std::string all;
    std::istringstream lines(outcome.err);
    for (std::string line; std::getline(lines, line);)
    {
      EXPECT_EQ(line.rfind(lead, 0), 0U) << line;
      const std::string text = line.substr(std::min(lead.size(), line.size()));
      all += text.rfind("textures are baked", 0) == 0 ? "" : text + "\n";
    }
    return all;
  }
};

// A scene of one mesh, whose material has these members. more: further members of the document.
inline std::string Scene(GltfBuffer& buffer, const std::vector<std::array<float, 2>>& at,
  const std::string& material, const std::string& more, bool glb = true)
{
  std::vector<float> points, coordinates;
  for (std::size_t i = 0; i < at.size(); ++i)
  {
    const auto x = float(i);
    points.insert(points.end(), { x, 0, 0, x, 1, 0, x, 0, 1 });
    for (int k = 0; k < 3; ++k)
    {
      coordinates.insert(coordinates.end(), at[i].begin(), at[i].end());
    }
  }
  const int position = buffer.Add(points, "VEC3", gltfFloat, ",\"min\":[0,0,0],\"max\":[9,1,1]");
  const int texture = buffer.Add(coordinates, "VEC2", gltfFloat);
  const std::string rest =
    "\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],\"materials\":[" + material +
    "],\"meshes\":[{\"primitives\":[{\"material\":0,\"attributes\":{\"POSITION\":" +
    std::to_string(position) + ",\"TEXCOORD_0\":" + std::to_string(texture) + "}}]}]," + more;
  return glb ? buffer.Glb(rest) : buffer.Json(rest, "b.bin");
}

// A material whose colour is the first texture's. more: members of the reference to the texture.
inline std::string Textured(const std::string& more = "")
{
  return "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0" + more + "}}}";
}

}
