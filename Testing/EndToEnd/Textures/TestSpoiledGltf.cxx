// SPDX-License-Identifier: BSD-3-Clause
// kdstream-build with textured glTF files that are damaged in one way: images, textures, samplers
// and their references; nodes, buffers and accessors.
#include "Testing/EndToEnd/Textures/SpoiledFiles.h"

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

constexpr const char* taken = ": the material's colour is used";
const std::string oneTexture = ",\"textures\":[{\"source\":0}]";

class TestSpoiledGltf : public SpoiledTest
{
protected:
  void SetUp() override { this->WriteBytes("a.png", TwoHalves(PictureType::Png)); }

  // Builds a .glb with these members, and checks the warnings.
  void ExpectGlb(const std::string& more, const std::vector<std::string>& warnings,
    const std::vector<Rgb>& colors, const std::string& texture = "{\"index\":0}")
  {
    SCOPED_TRACE(more + " " + texture);
    GltfBuffer buffer;
    this->WriteText("m.glb",
      Glb(buffer, more, "\"pbrMetallicRoughness\":{\"baseColorTexture\":" + texture + "}"));
    this->ExpectBuilt("m.glb", warnings, colors);
  }
  void ExpectImage(const std::string& image, const std::string& said)
  {
    this->ExpectGlb("\"images\":[" + image + "]" + oneTexture, { said + taken }, { white, white });
  }
};

}

TEST_F(TestSpoiledGltf, ImagesThatNameNothingAreReported)
{
  this->ExpectGlb("\"images\":[{\"uri\":\"a.png\"}]" + oneTexture, {}, { red, blue });
  this->ExpectImage("{}", "image 0: it has neither uri nor bufferView");
  this->ExpectImage("{\"uri\":7}", "image 0: it has neither uri nor bufferView");
  this->ExpectImage("7", "image 0: it has neither uri nor bufferView");
  this->ExpectImage("{\"bufferView\":9}", "image 0: it names bufferView 9, but there are 2");
  this->ExpectImage("{\"bufferView\":-1}", "image 0: it names bufferView -1, but there are 2");
  this->ExpectImage("{\"bufferView\":\"x\"}", "image 0: it names no bufferView");
  this->ExpectImage(
    "{\"uri\":\"data:image/png;base64,iVBORw0KGgo?\"}", "image 0: its data URI is not base64");
  this->ExpectImage(
    "{\"uri\":\"data:image/png,abc\"}", "image 0: it is neither JPEG, PNG nor WebP");
  this->ExpectImage("{\"uri\":\"data:image/png;base64,iVBORw0KGgo=\"}",
    "image 0: it is a damaged or truncated PNG (it ends too early)");
  this->ExpectImage("{\"uri\":\"data:image/png;base64,\"}", "image 0: it is empty");
}

TEST_F(TestSpoiledGltf, NothingIsReadElsewhere)
{
  this->ExpectImage("{\"uri\":\"http://example.org/a.png\"}",
    "image 0: it is at 'http://example.org/a.png', and nothing is downloaded");
  this->ExpectImage("{\"uri\":\"file:///etc/passwd\"}",
    "image 0: it is at 'file:///etc/passwd', and nothing is downloaded");
  for (const std::string uri :
    { "../../../../etc/passwd", "%2e%2e/%2e%2e/etc/passwd", "/etc/passwd" })
  {
    this->ExpectImage("{\"uri\":\"" + uri + "\"}",
      "image 0 '" + uri + "': it lies outside the mesh's folder, and nothing is read there");
  }
  // The same for the buffer with the geometry.
  for (const std::string uri : { "../../etc/passwd", "/etc/passwd", "x/../../b.bin" })
  {
    GltfBuffer buffer;
    const std::string scene = Scene(buffer, "");
    this->WriteText("m.gltf", buffer.Json(scene, uri));
    this->ExpectRefused("m.gltf",
      "the file '" + uri +
        "', in which its geometry is, lies outside the mesh's folder, and nothing is read there");
  }
}

TEST_F(TestSpoiledGltf, ViewsBeyondTheirBuffersAreReported)
{
  GltfBuffer buffer;
  const std::vector<std::uint8_t> picture = TwoHalves(PictureType::Png);
  const int view = buffer.AddView(picture.data(), picture.size());
  std::string glb =
    Glb(buffer, "\"images\":[{\"bufferView\":" + std::to_string(view) + "}]" + oneTexture);
  this->WriteText("m.glb", glb);
  this->ExpectBuilt("m.glb", {}, { red, blue });
  const std::string length = "\"byteLength\":" + std::to_string(picture.size());
  std::string longer = "\"byteLength\":9" + std::string(length.size() - 14, '9');
  glb.replace(glb.find(length), length.size(), longer);
  this->WriteText("m.glb", glb);
  this->ExpectBuilt("m.glb",
    { std::string("image 0: its bufferView 0 reaches beyond the end of its buffer") + taken },
    { white, white });
}

TEST_F(TestSpoiledGltf, TexturesThatNameNothingAreReported)
{
  const std::string images = "\"images\":[{\"uri\":\"a.png\"}],";
  const std::vector<Rgb> whites{ white, white };
  this->ExpectGlb(
    images + "\"textures\":[{}]", { std::string("texture 0 names no image") + taken }, whites);
  this->ExpectGlb(images + "\"textures\":[{\"source\":4}]",
    { std::string("texture 0 names image 4, but there is 1") + taken }, whites);
  this->ExpectGlb(
    images + "\"textures\":[{\"extensions\":{\"KHR_texture_basisu\":{\"source\":0}}}]",
    { std::string("texture 0 has its image only as KTX 2, which is not read") + taken }, whites);
  this->ExpectGlb(images + "\"textures\":[{\"source\":0}]",
    { "material 0 names texture 3, but there is 1: its colour is used" }, whites, "{\"index\":3}");
  this->ExpectGlb(images + "\"textures\":[{\"source\":0}]",
    { "material 0 names no texture: its colour is used" }, whites, "{}");
  this->ExpectGlb("\"textures\":[{\"source\":0}]",
    { std::string("texture 0 names image 0, but there are 0") + taken }, whites);
  this->ExpectGlb(images + "\"samplers\":[{}],\"textures\":[{\"source\":0,\"sampler\":5}]",
    { "texture 0 names sampler 5, but there is 1: its picture is repeated" }, { red, blue });
  this->ExpectGlb(images + "\"textures\":[{\"source\":0}]",
    { "2 triangles have no texture coordinates, or ones that are not numbers (the first is "
      "triangle "
      "0): the material's colour is used" },
    whites, "{\"index\":0,\"texCoord\":1}");
}

TEST_F(TestSpoiledGltf, TwentyOfManyAreReported)
{
  std::string materials, primitives;
  for (int i = 0; i < 30; ++i)
  {
    materials += (i == 0 ? "{" : ",{") + std::string("\"pbrMetallicRoughness\":{") +
                 "\"baseColorTexture\":{\"index\":7}}}";
  }
  GltfBuffer buffer;
  std::string scene = Scene(buffer, "\"images\":[{\"uri\":\"a.png\"}]" + oneTexture, "");
  scene.replace(scene.find("[{}]"), 4, "[" + materials + "]");
  this->WriteText("m.glb", buffer.Glb(scene));
  std::vector<std::string> warnings;
  for (int i = 0; i < 20; ++i)
  {
    warnings.push_back(
      "material " + std::to_string(i) + " names texture 7, but there is 1: its colour is used");
  }
  warnings.push_back("10 further materials name textures, images or samplers that do not exist");
  this->ExpectBuilt("m.glb", warnings, { white, white });
}

TEST_F(TestSpoiledGltf, NodesAreTreesOrNearly)
{
  const auto withNodes = [&](const std::string& nodes)
  {
    GltfBuffer buffer;
    std::string scene = Scene(buffer, "\"images\":[{\"uri\":\"a.png\"}]" + oneTexture);
    const std::string one = "\"nodes\":[{\"mesh\":0}]";
    scene.replace(scene.find(one), one.size(), "\"nodes\":[" + nodes + "]");
    this->WriteText("m.glb", buffer.Glb(scene));
  };
  withNodes("{\"mesh\":0,\"children\":[0]}");
  this->ExpectRefused("m.glb", "node 0 is its own descendant");
  withNodes("{\"mesh\":0,\"children\":[1]},{\"children\":[2]},{\"children\":[1]}");
  this->ExpectRefused("m.glb", "node 1 is its own descendant");
  // Each node occurs twice below the previous one: 2^40 meshes.
  std::string doubled;
  for (int i = 1; i <= 40; ++i)
  {
    const std::string next = std::to_string(i);
    doubled += "{\"children\":[" + next + "," + next + "]},";
  }
  withNodes(doubled + "{\"mesh\":0}");
  this->ExpectRefused("m.glb", "descendants: nodes are shared over and over");
  withNodes("{\"mesh\":0,\"children\":[7,-1,\"x\"]}");
  const Outcome built = this->Build({ "m.glb", "-o", "m.kds", "--quiet" });
  EXPECT_LE(built.exitCode, 1) << built.err;
}

TEST_F(TestSpoiledGltf, AccessorsThatClaimTooMuchAreErrors)
{
  const auto withCount = [&](const std::string& count)
  {
    const std::string six = "\"count\":6,", other = "\"count\":" + count + ",";
    GltfBuffer again;
    std::string json =
      again.Json(Scene(again, "\"images\":[{\"uri\":\"a.png\"}]" + oneTexture), "b.bin");
    for (std::size_t at = json.find(six); at != std::string::npos; at = json.find(six, at + 1))
    {
      json.replace(at, six.size(), other);
    }
    this->WriteText("m.gltf", json);
    this->WriteText("b.bin", again.Bytes);
  };
  withCount("6");
  this->ExpectBuilt("m.gltf", {}, { red, blue });
  for (const std::string count : { "7", "1000000000", "4000000000000", "1e+300", "-6", "null" })
  {
    withCount(count);
    this->ExpectRefused(
      "m.gltf", "accessor 0 claims " + count + " elements, more than its bufferView has");
  }
}

TEST_F(TestSpoiledGltf, AccessorsBeyondBuffersAreErrors)
{
  const auto with = [&](const std::string& before, const std::string& after)
  {
    GltfBuffer buffer;
    std::string json = buffer.Json(Scene(buffer, ""), "b.bin");
    const std::size_t at = json.find(before);
    ASSERT_NE(at, std::string::npos) << json;
    json.replace(at, before.size(), after);
    this->WriteText("m.gltf", json);
    this->WriteText("b.bin", buffer.Bytes);
  };
  with("{\"bufferView\":1", "{\"bufferView\":4");
  this->ExpectRefused("m.gltf", "accessor 1 names bufferView 4, but there are 2");
  with("\"byteOffset\":72", "\"byteOffset\":73");
  this->ExpectRefused("m.gltf", "accessor 1 lies in a bufferView that reaches beyond its buffer");
  for (const std::string offset : { "9000000000", "-40", "0.5", "\"x\"" })
  {
    with("\"byteOffset\":0", "\"byteOffset\":" + offset);
    this->ExpectRefused("m.gltf", "accessor 0 lies in a bufferView that reaches beyond its buffer");
  }
  with("\"buffer\":0", "\"buffer\":3");
  this->ExpectRefused(
    "m.gltf", "accessor 0 lies in a bufferView that names buffer 3, but there is 1");
  with("\"POSITION\":0", "\"POSITION\":9");
  this->ExpectRefused("m.gltf", "mesh 0, part 0: 'POSITION' names accessor 9, but there are 2");
  with("\"attributes\"", "\"indices\":7,\"attributes\"");
  this->ExpectRefused("m.gltf", "mesh 0, part 0: 'indices' names accessor 7, but there are 2");
  with("\"count\":6", "\"count\":5");
  this->ExpectRefused(
    "m.gltf", "mesh 0, part 0: 'TEXCOORD_0' has another number of elements than 'POSITION'");
  with("\"attributes\"", "\"indices\":1,\"attributes\"");
  this->ExpectRefused("m.gltf", "mesh 0, part 0: 'indices' are not whole numbers");
  with("\"attributes\"", "\"indices\":2,\"attributes\"");
  const std::string json = ReadWhole(this->Folder / "m.gltf");
  this->WriteText("m.gltf", std::string(json).replace(json.find("}],\"bufferViews\""), 1,
                              "},{\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}"));
  this->ExpectRefused("m.gltf", "mesh 0, part 0: 'indices' are not whole numbers");
  with("\"attributes\"", "\"mode\":5122,\"attributes\"");
  this->ExpectRefused("m.gltf", "mesh 0, part 0: unknown mode '5122'");
  with("\"VEC2\"", "\"VEC3\"");
  this->ExpectRefused("m.gltf", "accessor 1 claims 6 elements, more than its bufferView has");
  with("\"TEXCOORD_0\":1", "\"TEXCOORD_0\":0");
  this->ExpectRefused("m.gltf", "mesh 0, part 0: 'TEXCOORD_0' has a type that cannot be read: type "
                                "'\"VEC3\"', componentType '5126'");
  with("{\"mesh\":0}", "{\"mesh\":0,\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,1]}");
  this->ExpectRefused("m.gltf", "node 0 has a matrix that is not of 16 numbers");
  with("{\"mesh\":0}", "{\"mesh\":7}");
  this->ExpectRefused("m.gltf", "node 0 names mesh 7, but there is 1");
}

TEST_F(TestSpoiledGltf, BuffersThatAreShorterThanTheyClaimAreErrors)
{
  GltfBuffer buffer;
  std::string glb = Glb(buffer, "");
  const std::string length = "\"byteLength\":120}]}";
  ASSERT_NE(glb.find(length), std::string::npos) << glb;
  glb.replace(glb.find(length), length.size(), "\"byteLength\":999}]}");
  this->WriteText("m.glb", glb);
  this->ExpectRefused("m.glb", "claims 999 bytes of its binary chunk (BIN); it has 120");
  const auto withData = [&](const std::string& data)
  {
    GltfBuffer again;
    const std::string scene = Scene(again, "");
    this->WriteText("m.gltf", again.Json(scene, "data:application/octet-stream;base64," + data));
  };
  withData(std::string(160, 'A'));
  const Outcome built = this->Build({ "m.gltf", "-o", "m.kds", "--quiet" });
  EXPECT_EQ(built.exitCode, 0) << built.err;
  withData(std::string(156, 'A') + "AA==");
  this->ExpectRefused("m.gltf", "claims 120 bytes of buffer 0; it has 118");
  withData(std::string(159, 'A') + "?");
  this->ExpectRefused("m.gltf", "buffer 0 is a data URI that is not base64");
}

TEST_F(TestSpoiledGltf, ExtensionsThatAreReadAreNotWarnedOf)
{
  const std::string ours = "[\"KHR_texture_transform\",\"EXT_texture_webp\"]";
  this->ExpectGlb("\"images\":[{\"uri\":\"a.png\"}]" + oneTexture + ",\"extensionsUsed\":" + ours +
                    ",\"extensionsRequired\":" + ours,
    {}, { red, blue });
}
