// SPDX-License-Identifier: BSD-3-Clause
// Properties of materials other than a colour and its picture are not kept, and are reported: one
// line for each kind. Colours in an older form are read.
#include "Testing/EndToEnd/GltfFile.h"
#include "Testing/EndToEnd/ProgramsTest.h"
#include "filters/texture/WritePicture.h"

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

class TestLostLooks : public ProgramsTest
{
protected:
  void SetUp() override
  {
    const std::vector<std::uint8_t> bytes =
      EncodePicture({ 2, 1, 3, { 255, 0, 0, 0, 0, 255 } }, PictureType::Png);
    this->WriteText("a.png", std::string(bytes.begin(), bytes.end()));
  }

  std::string WarningsOf(const std::string& input)
  {
    const Outcome outcome = RunTool(this->Folder, "convert", { input, "-o", "out.ply", "--quiet" });
    EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
    std::istringstream lines(outcome.err);
    const std::string begin = "kdstream-convert: warning: " + input + ": ";
    std::string texts;
    for (std::string line; std::getline(lines, line);)
    {
      EXPECT_TRUE(line.starts_with(begin)) << line;
      const std::string text = line.substr(std::min(begin.size(), line.size()));
      texts += text.starts_with("textures are baked") ? "" : text + "\n";
    }
    return texts;
  }

  // The warnings for a triangle with the first of these materials; all materials have the picture.
  std::string WarningsOfMtl(const std::vector<std::string>& materials)
  {
    std::string text;
    for (std::size_t i = 0; i < materials.size(); ++i)
    {
      text += "newmtl m" + std::to_string(i) + "\nmap_Kd a.png\n" + materials[i];
    }
    this->WriteText("m.mtl", text);
    this->WriteText("m.obj", "mtllib m.mtl\nusemtl m0\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.25 0.5\n"
                             "f 1/1 2/1 3/1\n");
    return this->WarningsOf("m.obj");
  }

  // The warnings for one triangle of each of these materials, with coordinates in the picture's
  // left half.
  std::string WarningsOfGltf(const std::vector<std::string>& materials)
  {
    GltfBuffer buffer;
    buffer.Add(std::vector<float>{ 0.25F, 0.5F, 0.25F, 0.5F, 0.25F, 0.5F }, "VEC2", gltfFloat);
    std::string list, primitives;
    for (std::size_t i = 0; i < materials.size(); ++i)
    {
      const std::string comma = i == 0 ? "" : ",";
      const auto x = float(2 * i);
      const int places =
        buffer.Add(std::vector<float>{ x, 0, 0, x + 1, 0, 0, x, 1, 0 }, "VEC3", gltfFloat,
          ",\"min\":[" + std::to_string(x) + ",0,0],\"max\":[" + std::to_string(x + 1) + ",1,0]");
      list += comma + materials[i];
      primitives += comma + "{\"attributes\":{\"POSITION\":" + std::to_string(places) +
                    ",\"TEXCOORD_0\":0},\"material\":" + std::to_string(i) + "}";
    }
    this->WriteText("m.glb",
      buffer.Glb("\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],\"meshes\":[{"
                 "\"primitives\":[" +
                 primitives + "]}],\"materials\":[" + list +
                 "],\"images\":[{\"uri\":\"a.png\"}],\"textures\":[{\"source\":0}]"));
    return this->WarningsOf("m.glb");
  }

  std::vector<double> ColoursOfOutput()
  {
    const Mesh mesh = this->Read("out.ply");
    std::vector<double> values;
    for (std::size_t i = 0; i < 3 * mesh.points.size(); ++i)
    {
      values.push_back(mesh.attributes.at(0).Get(i / 3, i % 3));
    }
    return values;
  }

  static std::string Pbr(const std::string& members, const std::string& more = "")
  {
    return "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}" + members + "}" + more +
           "}";
  }
};

}

TEST_F(TestLostLooks, ValuesOfAnMtlAreNamed)
{
  EXPECT_EQ(
    this->WarningsOfMtl({ "Pm 1\nPr 0.2\n", "Ke 0 2 0\nTr 0.5\n", "d 0.25\n", "Pm 0.5\nPr 1\n" }),
    "the metalness of the material 'm0' and of 1 other is left out\n"
    "the roughness of the material 'm0' is left out\n"
    "the emission of the material 'm1' is left out\n"
    "the transparency of the material 'm1' and of 1 other is left out\n");
  EXPECT_EQ(this->WarningsOfMtl({ "Ke 1\n", "Ke 1\nKe 1\n", "Ke 1\n" }),
    "the emission of the material 'm0' and of 2 others is left out\n");
}

// Values that programs write in every material.
TEST_F(TestLostLooks, UsualValuesOfAnMtlAreNot)
{
  EXPECT_EQ(this->WarningsOfMtl({ "Ns 225\nKa 1 1 1\nKs 0.5 0.5 0.5\nKe 0 0 0\nNi 1.45\nd 1\n"
                                  "illum 2\n",
              "Pr 0.5\nPm 0\nPs 0\nPc 0\nPcr 0\naniso 0\n", "Tr 0\n", "Tr 1\n", "d 1\nTr 0.5\n",
              "Ke x\nPm\nd -halo\nTr nan\nPm inf\n" }),
    "");
}

TEST_F(TestLostLooks, ValuesOfAGltfAreNamed)
{
  EXPECT_EQ(
    this->WarningsOfGltf(
      { Pbr(",\"metallicFactor\":1,\"roughnessFactor\":0.25", ",\"name\":\"go\\nld\""),
        Pbr("", ",\"emissiveFactor\":[0,0,0.5]"), Pbr(",\"metallicFactor\":0.5"),
        Pbr("", ",\"extensions\":{\"KHR_materials_transmission\":{\"transmissionFactor\":1,"
                "\"transmissionTexture\":{\"index\":0}},\"KHR_materials_clearcoat\":{"
                "\"clearcoatTexture\":{\"index\":0},\"clearcoatFactor\":1},\"odd\":{\"a\\nTexture\""
                ":{}},\"KHR_materials_specular\":{\"specularTexture\":{\"index\":0}},\"x\":3}") }),
    "left out: textures of materials: clearcoatTexture, specularTexture, "
    "transmissionTexture\n"
    "the metalness of the material 'go?ld' and of 1 other is left out\n"
    "the roughness of the material 'go?ld' is left out\n"
    "the emission of the material 1 is left out\n"
    "the transparency of the material 3 is left out\n");
}

// If metalness is missing, it would be 1, which nobody intends. An emissive picture has its own
// warning.
TEST_F(TestLostLooks, UsualValuesOfAGltfAreNot)
{
  EXPECT_EQ(this->WarningsOfGltf({ Pbr(""), Pbr(",\"metallicFactor\":0,\"roughnessFactor\":0.5"),
              Pbr("", ",\"emissiveFactor\":[0,0,0]"), Pbr("", ",\"extensions\":{}"),
              Pbr(",\"metallicFactor\":\"1\"", ",\"emissiveFactor\":\"x\",\"extensions\":\"y\"") }),
    "");
  EXPECT_EQ(this->WarningsOfGltf(
              { Pbr("", ",\"emissiveFactor\":[1,1,1],\"emissiveTexture\":{\"index\":0}") }),
    "left out: textures of materials: emissiveTexture\n");
}

TEST_F(TestLostLooks, ColoursOfSpecularAndGlossyMaterialsAreTaken)
{
  const auto glossy = [](const std::string& members)
  { return "\"extensions\":{\"KHR_materials_pbrSpecularGlossiness\":{" + members + "}}}"; };
  using Rgb = std::vector<double>;
  EXPECT_EQ(this->WarningsOfGltf(
              { "{" + glossy("\"diffuseTexture\":{\"index\":0},\"specularGlossinessTexture\":{"
                             "\"index\":0}") }),
    "left out: textures of materials: specularGlossinessTexture\n");
  EXPECT_EQ(this->ColoursOfOutput(), (Rgb{ 255, 0, 0, 255, 0, 0, 255, 0, 0 }));
  // Only the factor is used, unless the core material has a picture for its colour.
  EXPECT_EQ(this->WarningsOfGltf({ "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,0,0,1]}," +
                                     glossy("\"diffuseFactor\":[0,0,1,1]"),
              Pbr("", ",\"extensions\":{\"KHR_materials_pbrSpecularGlossiness\":{"
                      "\"diffuseFactor\":[0,0,0,1]}}") }),
    "");
  EXPECT_EQ(this->ColoursOfOutput(),
    (Rgb{ 0, 0, 255, 0, 0, 255, 0, 0, 255, 255, 0, 0, 255, 0, 0, 255, 0, 0 }));
}
