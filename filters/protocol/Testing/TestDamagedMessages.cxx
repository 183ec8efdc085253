// SPDX-License-Identifier: BSD-3-Clause
// Every type of message, truncated after each of its bytes, and with each byte changed to every
// other value: the result must be an error, or a message that is the same after writing and reading
// it.
#include "Testing/Fixtures/Sanitized.h"
#include "filters/protocol/BinaryFrame.h"
#include "filters/protocol/ControlMessage.h"

#include "filters/protocol/Testing/RandomMessages.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

using namespace kdstream;
using namespace kdstream::protocol;

namespace
{

using Bytes = std::vector<std::uint8_t>;

std::vector<ClientMessage> EveryClientMessage()
{
  return {
    { 1, OpenRequest{ "dragon-2.x" } },
    { 4294967295u, BlobsRequest{ { BlobId::Partition(4) } } },
    { 6, RegionRequest{ 312, 2, {} } },
    { 6, RegionRequest{ 312, 2, { 7, 9 } } },
    { 8, BlobsRequest{ { BlobId::TreePage(1), BlobId::PartitionBoxes(2), BlobId::LevelPiece(12, 3),
           BlobId::Partition(7) } } },
    { 9, CancelRequest{} },
  };
}

std::vector<ServerMessage> EveryServerMessage()
{
  RandomMessages random(3);
  return {
    { 1, OpenedAnswer{ random.Model() } },
    { 2, BeginAnswer{ 3, 70000, std::nullopt } },
    { 2, BeginAnswer{ 3, 70000, std::vector<std::uint32_t>{ 4, 0, 5 } } },
    { 2, ProgressAnswer{ 1, 1048576 } },
    { 2, EndAnswer{ 3, 70000, 1, true } },
    { 0, ErrorAnswer{ 400, "a \"quoted\" \xC3\xA4 text", std::nullopt } },
    { 2, ErrorAnswer{ 503, "later", BlobId::LevelPiece(7, 1) } },
  };
}

std::vector<std::pair<FrameHeader, Bytes>> EveryFrame()
{
  return {
    { { 1, BlobId::TreePage(1), 0, 3 }, { 1, 2, 3 } },
    { { 0x01020304, BlobId::LevelPiece(7, 0x11121314), 5, 9 }, { 1, 2, 3, 4 } },
    { { 2, BlobId::Partition(3), 1, 2 }, { 255 } },
    { { 4294967295u, BlobId::PartitionBoxes(32), 0, maximumBlobBytes }, { 0, 1 } },
  };
}

// The parsed message; no value if there was an error.
template <class Message>
std::optional<Message> Taken(Result<Message> parsed)
{
  return parsed ? std::optional(std::move(*parsed)) : std::nullopt;
}

// Calls `look` with the text truncated after each byte except the last: none of these texts is a
// message.
template <class Look>
void CutEverywhere(const std::string& text, const Look& look)
{
  for (std::size_t size = 0; size < text.size(); ++size)
  {
    look(text.substr(0, size));
  }
}

template <class Look>
void ChangeEverywhere(const std::string& text, const Look& look)
{
  // With a sanitizer, only single bits are flipped, in about 256 places at most, because all values
  // in all places take six minutes.
  const std::size_t step = fixtures::sanitized ? 1 + text.size() / 256 : 1;
  for (std::size_t place = 0; place < text.size(); place += step)
  {
    auto changed = text;
    for (unsigned value = 1; value < 256; value = fixtures::sanitized ? 2 * value : value + 1)
    {
      changed[place] = static_cast<char>(static_cast<unsigned char>(text[place]) ^ value);
      look(changed);
    }
    changed = text;
    changed.erase(place, 1);
    look(changed);
    changed = text;
    changed.insert(place, 1, text[place]);
    look(changed);
  }
}

}

TEST(TestDamagedMessages, EveryTypeIsHere)
{
  std::vector<bool> client(std::variant_size_v<decltype(ClientMessage::body)>);
  for (const auto& message : EveryClientMessage())
  {
    client[message.body.index()] = true;
  }
  EXPECT_EQ(client, std::vector<bool>(client.size(), true));
  std::vector<bool> server(std::variant_size_v<decltype(ServerMessage::body)>);
  for (const auto& message : EveryServerMessage())
  {
    server[message.body.index()] = true;
  }
  EXPECT_EQ(server, std::vector<bool>(server.size(), true));
}

TEST(TestDamagedMessages, OfClients)
{
  std::size_t taken = 0;
  for (const auto& message : EveryClientMessage())
  {
    const auto text = WriteClientMessage(message);
    ASSERT_EQ(Taken(ParseClientMessage(text)), message) << text;
    CutEverywhere(text,
      [](const std::string& cut)
      {
        const auto parsed = ParseClientMessage(cut);
        ASSERT_FALSE(parsed) << cut;
        EXPECT_EQ(parsed.GetError().code, ErrorCode::InvalidInput) << cut;
        EXPECT_FALSE(parsed.GetError().message.empty());
        EXPECT_EQ(FindRequestId(cut), 0u) << cut;
      });
    ChangeEverywhere(text,
      [&](const std::string& changed)
      {
        const auto parsed = ParseClientMessage(changed);
        if (!parsed)
        {
          EXPECT_FALSE(parsed.GetError().message.empty()) << changed;
          (void)FindRequestId(changed);
          return;
        }
        ++taken;
        EXPECT_NE(parsed->request, 0u) << changed;
        EXPECT_EQ(Taken(ParseClientMessage(WriteClientMessage(*parsed))), *parsed) << changed;
      });
  }
  EXPECT_GT(taken, 100u) << "other digits are other numbers";
}

TEST(TestDamagedMessages, OfServers)
{
  std::size_t taken = 0;
  for (const auto& message : EveryServerMessage())
  {
    const auto text = WriteServerMessage(message);
    ASSERT_EQ(Taken(ParseServerMessage(text)), message) << text;
    CutEverywhere(text,
      [](const std::string& cut)
      {
        const auto parsed = ParseServerMessage(cut);
        ASSERT_FALSE(parsed) << cut;
        EXPECT_FALSE(parsed.GetError().message.empty());
      });
    ChangeEverywhere(text,
      [&](const std::string& changed)
      {
        const auto parsed = ParseServerMessage(changed);
        if (!parsed)
        {
          EXPECT_FALSE(parsed.GetError().message.empty()) << changed;
          return;
        }
        ++taken;
        EXPECT_EQ(Taken(ParseServerMessage(WriteServerMessage(*parsed))), *parsed) << changed;
      });
  }
  EXPECT_GT(taken, 100u);
}

// A frame that has lost bytes at its end can be a valid frame with less payload. Then it must be
// exactly that, and complete no blob.
TEST(TestDamagedMessages, Frames)
{
  for (const auto& [header, payload] : EveryFrame())
  {
    const auto frame = EncodeFrame(header, payload);
    const auto look = [](const std::string& changed)
    {
      const Bytes bytes(changed.begin(), changed.end());
      const auto parsed = ParseFrame(bytes);
      if (!parsed)
      {
        EXPECT_FALSE(parsed.GetError().message.empty());
        return;
      }
      const auto& [reported, part] = *parsed;
      EXPECT_NE(reported.request, 0u);
      EXPECT_TRUE(IsValid(reported.blob));
      EXPECT_LE(reported.offset + part.size(), reported.total);
      EXPECT_EQ(EncodeFrame(reported, part), bytes);
      FrameAssembler assembler;
      const auto blob = assembler.Accept(*parsed);
      EXPECT_EQ(blob && *blob, reported.offset == 0 && part.size() == reported.total);
    };
    const std::string text(frame.begin(), frame.end());
    CutEverywhere(text,
      [&](const std::string& cut)
      {
        look(cut);
        const Bytes bytes(cut.begin(), cut.end());
        EXPECT_EQ(ParseFrame(bytes).HasValue(), cut.size() > frameHeaderBytes) << cut.size();
      });
    ChangeEverywhere(text, look);
  }
}
