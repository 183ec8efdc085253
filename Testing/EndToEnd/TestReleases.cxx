// SPDX-License-Identifier: BSD-3-Clause
// Every later version must be able to read what released versions have written
// (doc/compatibility.md): stores, and a stream, which contains a client's requests and a server's
// answers. These files are in Testing/Released, in a folder for each version, and are never made
// again.
//
// Commands for a new version's folder:
//   kdstream-generate vase vase.ply --vertices 600
//   kdstream-build vase.ply -o vase.kds --vertices-per-partition 100 --title "Painted vase"
//   kdstream-generate statue statue.obj --vertices 300 --picture-side 64
//   kdstream-build statue.obj -o statue.kds --vertices-per-partition 100 --precision lossless
//     --texture-quality lossless (in one line)
//   KDSTREAM_RECORD_STREAM=FOLDER/stream.jsonl ReleasesTests TestReleases
// and add a line to `releases` below.
#include "filters/codec/PieceCodec.h"
#include "filters/codec/TextureTile.h"
#include "filters/protocol/BinaryFrame.h"
#include "filters/protocol/ControlMessage.h"
#include "filters/store/Store.h"
#include "filters/store/StoreMesh.h"
#include "server/session/StoreCatalog.h"
#include "server/session/Testing/PullMessage.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <numeric>
#include <span>
#include <string>
#include <vector>

using namespace kdstream;
using namespace kdstream::protocol;
using nlohmann::json;
namespace fs = std::filesystem;

namespace
{

struct ReleasedStore
{
  const char* name;
  const char* digest;
  std::size_t vertices, triangles;
  std::uint64_t surface; // HashOfSurface
};

struct Release
{
  const char* version;
  std::vector<ReleasedStore> stores;
};

const std::vector<Release> releases{
  { "0.9", { { "statue", "9977e61e19a79cbfac7ff945447a7797", 290, 576, 10319997224221695517U },
             { "vase", "4ec23390ecfd3b45046db5abcd37427e", 582, 1160, 512084816950698980U } } },
};

fs::path FolderOf(const Release& release)
{
  return fs::path(KDSTREAM_RELEASED) / release.version;
}

// A hash (FNV-1a) of the corners of all triangles, bit for bit, independent of their order.
std::uint64_t HashOfSurface(const Mesh& mesh)
{
  std::vector<std::array<double, 9>> triangles;
  for (const Triangle& triangle : mesh.triangles)
  {
    std::array<Vec3, 3> corners{ mesh.points[triangle[0]], mesh.points[triangle[1]],
      mesh.points[triangle[2]] };
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    std::array<double, 9>& values = triangles.emplace_back();
    for (std::size_t i = 0; i < values.size(); ++i)
    {
      values[i] = corners[i / 3][i % 3];
    }
  }
  std::sort(triangles.begin(), triangles.end());
  std::uint64_t hash = 14695981039346656037U;
  for (const auto& values : triangles)
  {
    for (const std::byte byte : std::as_bytes(std::span(values)))
    {
      hash = (hash ^ std::to_integer<std::uint64_t>(byte)) * 1099511628211U;
    }
  }
  return hash;
}

std::string HexOf(std::span<const std::uint8_t> bytes)
{
  std::string text;
  for (const std::uint8_t byte : bytes)
  {
    text += "0123456789abcdef"[byte >> 4];
    text += "0123456789abcdef"[byte & 15];
  }
  return text;
}

std::vector<std::uint8_t> BytesOf(const std::string& hex)
{
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
  {
    bytes.push_back(static_cast<std::uint8_t>(std::stoul(hex.substr(i, 2), nullptr, 16)));
  }
  return bytes;
}

// Reads a stream: a list of {"client": text}, {"server": text} and {"frame": hexadecimal digits}.
std::vector<json> ReadStream(const fs::path& file)
{
  std::vector<json> stream;
  std::ifstream lines(file);
  for (std::string line; std::getline(lines, line);)
  {
    stream.push_back(json::parse(line));
  }
  return stream;
}

// The answers of the present version to these messages of a client.
std::vector<json> AnswersToday(const Catalog& catalog, const std::vector<std::string>& client)
{
  std::vector<json> stream;
  Conversation conversation(catalog);
  for (const std::string& text : client)
  {
    stream.push_back({ { "client", text } });
    conversation.Receive(text);
    while (const auto message = PullMessage(conversation))
    {
      if (const auto* answer = std::get_if<std::string>(&*message))
      {
        stream.push_back({ { "server", *answer } });
      }
      else
      {
        stream.push_back({ { "frame", HexOf(std::get<std::vector<std::uint8_t>>(*message)) } });
      }
    }
  }
  return stream;
}

// One request of each kind, and some that are refused.
const std::vector<std::string> recordedRequests{
  R"({"type":"open","request":1,"model":"nothing"})",
  R"({"type":"open","request":2,"model":"statue"})",
  R"({"type":"blobs","request":3,"blobs":["tree/1","boxes/1","levels/0/1","levels/6/1","textures/2"]})",
  R"({"type":"blobs","request":4,"blobs":["levels/30/1","levels/8/1"]})",
  R"({"type":"region","request":5,"cell":4,"rings":0,"except":[3]})",
  R"({"type":"region","request":6,"cell":7,"rings":3})",
  R"({"type":"cancel","request":6})",
  R"({"type":"level","request":7,"level":3})",
  R"({"type":"open","request":8,"model":"vase"})",
  R"({"type":"blobs","request":9,"blobs":["levels/9/1","partitions/5"]})",
};

// Checks that everything that a client of that time reads still exists; members may have been
// added.
void ExpectKept(const json& then, const json& now, const std::string& where)
{
  if (then.is_array() && now.is_array() && then.size() == now.size())
  {
    for (std::size_t i = 0; i < then.size(); ++i)
    {
      ExpectKept(then[i], now[i], where + "[" + std::to_string(i) + "]");
    }
    return;
  }
  if (!then.is_object() || !now.is_object())
  {
    EXPECT_EQ(then, now) << where;
    return;
  }
  for (const auto& [name, value] : then.items())
  {
    if (name == "message" && then.value("type", "") == "error")
    {
      continue; // wording is for people, and may change
    }
    ASSERT_TRUE(now.contains(name)) << where << ": " << name << " is gone";
    ExpectKept(value, now[name], where + "." + name);
  }
}

// The answers in a stream, without messages whose time may vary.
std::vector<json> Answers(const std::vector<json>& stream)
{
  std::vector<json> answers;
  for (const json& line : stream)
  {
    if (line.contains("frame") ||
        (line.contains("server") &&
          json::parse(line["server"].get<std::string>())["type"] != "progress"))
    {
      answers.push_back(line);
    }
  }
  return answers;
}

class TestReleases : public testing::Test
{
protected:
  StoreCatalog catalog{ FolderOf(releases.back()),
    [](const fs::path& file, const std::string& what) { ADD_FAILURE() << file << ": " << what; } };
};

}

TEST_F(TestReleases, StoresAreRead)
{
  for (const Release& release : releases)
  {
    for (const ReleasedStore& released : release.stores)
    {
      SCOPED_TRACE(std::string(release.version) + "/" + released.name);
      const auto opened = Store::Open(FolderOf(release) / (std::string(released.name) + ".kds"));
      ASSERT_TRUE(opened) << opened.GetError().message;
      const Store& store = **opened;
      for (const Error& error : store.Verify())
      {
        ADD_FAILURE() << error.message;
      }
      EXPECT_EQ(store.Info().digest, released.digest);
      std::vector<std::uint32_t> partitions(store.Info().partitions);
      std::iota(partitions.begin(), partitions.end(), 0U);
      const auto original = GlueStoreMesh(store, partitions);
      ASSERT_TRUE(original) << original.GetError().message;
      EXPECT_EQ(original->points.size(), released.vertices);
      EXPECT_EQ(original->triangles.size(), released.triangles);
      EXPECT_EQ(HashOfSurface(*original), released.surface) << "the original, to the last bit";
      EXPECT_EQ(original->attributes.size(), 1U) << "its colours";
      for (const PieceId id : store.PieceIds())
      {
        const auto piece = store.ReadPiece(id);
        ASSERT_TRUE(piece) << piece.GetError().message;
      }
      for (const std::uint32_t partition : partitions)
      {
        if (store.Info().textures)
        {
          const auto piece =
            store.ReadPiece(PieceOfBlob(BlobId::Partition(partition), store.Info().depths));
          const auto blob = store.Read(BlobId::Texture(partition));
          ASSERT_TRUE(piece && blob);
          const auto tile = DecodeTextureTile(*blob, piece->triangles, piece->positions);
          ASSERT_TRUE(tile) << tile.GetError().message;
          EXPECT_TRUE(tile->isExact);
        }
      }
    }
  }
}

TEST_F(TestReleases, AnOldServerIsUnderstood)
{
  for (const Release& release : releases)
  {
    FrameAssembler frames;
    std::map<std::string, std::size_t> answers;
    std::shared_ptr<Store> store;
    std::size_t blobs = 0;
    for (const json& line : ReadStream(FolderOf(release) / "stream.jsonl"))
    {
      if (line.contains("frame"))
      {
        const auto message = BytesOf(line["frame"]);
        const auto frame = ParseFrame(message);
        ASSERT_TRUE(frame) << frame.GetError().message;
        const auto blob = frames.Accept(*frame);
        ASSERT_TRUE(blob) << blob.GetError().message;
        if (*blob)
        {
          const auto kept = store->Read((*blob)->id);
          ASSERT_TRUE(kept) << kept.GetError().message;
          EXPECT_EQ((*blob)->bytes, *kept) << BlobName((*blob)->id);
          if (IsOfPiece((*blob)->id))
          {
            const ModelDescription& model = store->Info();
            const auto piece =
              DecodePiece((*blob)->bytes, PieceOfBlob((*blob)->id, model.depths), model.Codec());
            EXPECT_TRUE(piece) << piece.GetError().message;
          }
          ++blobs;
        }
      }
      else if (line.contains("server"))
      {
        const std::string text = line["server"];
        const auto message = ParseServerMessage(text);
        ASSERT_TRUE(message) << text << ": " << message.GetError().message;
        ++answers[json::parse(text)["type"]];
        if (const auto* answer = std::get_if<OpenedAnswer>(&message->body))
        {
          const auto opened = Store::Open(FolderOf(release) / (answer->model.id + ".kds"));
          ASSERT_TRUE(opened) << opened.GetError().message;
          store = *opened;
          EXPECT_EQ(answer->model.digest, store->Info().digest);
          EXPECT_EQ(answer->model.levels.size(), store->Info().levels.size());
        }
      }
    }
    EXPECT_EQ(blobs, 12U);
    EXPECT_EQ(answers, (std::map<std::string, std::size_t>{
                         { "begin", 4 }, { "end", 4 }, { "error", 3 }, { "opened", 2 } }));
  }
}

TEST_F(TestReleases, AnOldClientIsAnswered)
{
  ASSERT_TRUE(this->catalog.Reload());
  if (const char* file = std::getenv("KDSTREAM_RECORD_STREAM"))
  {
    std::ofstream lines(file);
    for (const json& line : AnswersToday(this->catalog, recordedRequests))
    {
      lines << line.dump() << "\n";
    }
    GTEST_SKIP() << "recorded: " << file;
  }
  for (const Release& release : releases)
  {
    const std::vector<json> then = ReadStream(FolderOf(release) / "stream.jsonl");
    std::vector<std::string> client;
    for (const json& line : then)
    {
      if (line.contains("client"))
      {
        client.push_back(line["client"]);
      }
    }
    ASSERT_FALSE(client.empty());
    StoreCatalog stores(FolderOf(release),
      [](const fs::path& file, const std::string& what) { ADD_FAILURE() << file << ": " << what; });
    ASSERT_TRUE(stores.Reload());
    const std::vector<json> before = Answers(then), today = Answers(AnswersToday(stores, client));
    ASSERT_EQ(today.size(), before.size());
    for (std::size_t i = 0; i < before.size(); ++i)
    {
      ASSERT_EQ(today[i].contains("frame"), before[i].contains("frame")) << i;
      if (before[i].contains("frame"))
      {
        EXPECT_EQ(today[i], before[i]) << i;
        continue;
      }
      ExpectKept(json::parse(before[i]["server"].get<std::string>()),
        json::parse(today[i]["server"].get<std::string>()), std::to_string(i));
    }
  }
}
