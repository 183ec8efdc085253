// SPDX-License-Identifier: BSD-3-Clause
// kdstream-convert with textured glTF, with pictures inside and beside the file: vertex colours,
// and every warning about what could not be kept.
#include "Testing/EndToEnd/Textures/BakedColors.h"

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

class TestTexturedGltf : public BakedColorsTest
{
};

}

TEST_F(TestTexturedGltf, GltfIsTexturedByPicturesInItAndBeside)
{
  const std::string beside = "\"images\":[{\"uri\":\"a%20b.png\"}],\"textures\":[{\"source\":0}]";
  this->WritePicture("a b.png", Row({ red, blue }), PictureType::Png);
  const auto colors = [&](const std::string& material, const std::string& more)
  {
    GltfBuffer buffer;
    this->WriteText("m.glb", Scene(buffer, leftAndRight, material, more));
    EXPECT_EQ(WarningsOf("m.glb"), "") << material;
    return ColorsOf(this->Read("out.ply"));
  };
  const std::vector plain{ red, blue }, swapped{ blue, red };
  EXPECT_EQ(colors(Textured(), beside), plain);
  EXPECT_EQ(Find(this->Read("out.ply"), "TCoords"), nullptr);
  // Pictures in the file's own buffer, as WebP, and as text.
  GltfBuffer own;
  const std::vector<std::uint8_t> webp = EncodePicture(Row({ red, blue }), PictureType::Webp);
  const int view = own.AddView(webp.data(), webp.size());
  const std::string inside =
    "\"images\":[{\"mimeType\":\"image/webp\",\"bufferView\":" + std::to_string(view) +
    "}],\"textures\":[{\"extensions\":{\"EXT_texture_webp\":{\"source\":0}}}]";
  GltfBuffer apart = own;
  this->WriteText("m.glb", Scene(own, leftAndRight, Textured(), inside));
  EXPECT_EQ(WarningsOf("m.glb"), "");
  EXPECT_EQ(ColorsOf(this->Read("out.ply")), plain);
  this->WriteText("m.gltf", Scene(apart, leftAndRight, Textured(), inside, false));
  this->WriteText("b.bin", apart.Bytes);
  EXPECT_EQ(WarningsOf("m.gltf"), "");
  EXPECT_EQ(ColorsOf(this->Read("out.ply")), plain);
  // Two texels, red and blue, as a data URI.
  const std::vector<std::uint8_t> png = EncodePicture(Row({ red, blue }), PictureType::Png);
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < png.size(); i += 3)
  {
    const auto at = [&](std::size_t k) { return i + k < png.size() ? unsigned(png[i + k]) : 0U; };
    const unsigned bits = at(0) << 16U | at(1) << 8U | at(2);
    for (const unsigned shift : { 18U, 12U, 6U, 0U })
    {
      text += digits[(bits >> shift) & 63U];
    }
  }
  EXPECT_EQ(colors(Textured(), "\"images\":[{\"uri\":\"data:image/png;base64," + text +
                                 "\"}],\"textures\":[{\"source\":0}]"),
    plain);
  // Transforms, wrap modes and factors.
  const auto transform = [&](const std::string& members)
  { return Textured(",\"extensions\":{\"KHR_texture_transform\":{" + members + "}}"); };
  EXPECT_EQ(colors(transform("\"offset\":[0.5,0]"), beside), swapped);
  EXPECT_EQ(colors(transform("\"scale\":[3,1]"), beside), swapped);
  EXPECT_EQ(colors(transform("\"rotation\":3.14159265"), beside), swapped);
  // A quarter turn: u' = v, which is 0.5 at both.
  EXPECT_EQ(colors(transform("\"rotation\":1.5707963,\"offset\":[-0.25,0]"), beside),
    (std::vector{ red, red }));
  EXPECT_EQ(colors(transform("\"rotation\":-1.5707963,\"offset\":[1.25,0]"), beside),
    (std::vector{ blue, blue }));
  const std::string far = transform("\"offset\":[1,0]");
  const auto sampler = [&](const std::string& wrap)
  {
    return "\"images\":[{\"uri\":\"a%20b.png\"}],\"textures\":[{\"source\":0,\"sampler\":0}],"
           "\"samplers\":[{\"wrapS\":" +
           wrap + "}]";
  };
  EXPECT_EQ(colors(far, sampler("10497")), plain);
  EXPECT_EQ(colors(far, sampler("33648")), swapped);
  EXPECT_EQ(colors(far, sampler("33071")), (std::vector{ blue, blue }));
  EXPECT_EQ(colors("{\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,0,1],\"baseColorTexture\":{"
                   "\"index\":0}}}",
              beside),
    (std::vector{ red, { 0, 0, 0 } }));
}

TEST_F(TestTexturedGltf, WhatAGltfLosesIsNamed)
{
  this->WritePicture("a.png", Row({ red, blue }), PictureType::Png);
  const std::string factor = "\"baseColorFactor\":[0,1,0,1],";
  GltfBuffer buffer;
  this->WriteText(
    "m.glb", Scene(buffer, leftAndRight,
               "{\"normalTexture\":{\"index\":0},\"emissiveTexture\":{\"index\":0},"
               "\"pbrMetallicRoughness\":{" +
                 factor +
                 "\"metallicRoughnessTexture\":{\"index\":0},"
                 "\"baseColorTexture\":{\"index\":0}}}",
               "\"images\":[{\"uri\":\"../gone.png\"}],\"textures\":[{\"source\":0}]"));
  EXPECT_EQ(WarningsOf("m.glb"), "left out: textures of materials: normalTexture, emissiveTexture, "
                                 "metallicRoughnessTexture\n"
                                 "image 0 '../gone.png': it lies outside the mesh's folder, and "
                                 "nothing is read there: the material's colour is used\n");
  EXPECT_EQ(ColorsOf(this->Read("out.ply")), (std::vector{ green, green }));
  const Outcome off = this->Convert("m.glb", { "--textures", "off" });
  EXPECT_NE(off.err.find("pictures are left out\n"), std::string::npos) << off.err;
  EXPECT_EQ(ColorsOf(this->Read("out.ply")), (std::vector{ green, green }));
  for (const std::string nodes : { "{\"children\":[0]}", "{\"children\":[1]},{\"children\":[0]}" })
  {
    GltfBuffer cyclic;
    const std::string json =
      cyclic.Json("\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[" + nodes + "]", "b.bin");
    this->WriteText("b.bin", "");
    this->WriteText("c.gltf", json);
    this->ExpectError("c.gltf", "node 0 is its own descendant");
  }
}
