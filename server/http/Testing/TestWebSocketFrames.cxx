// SPDX-License-Identifier: BSD-3-Clause
// Frames without sockets. The events are the same however the bytes are divided, and only those
// that RFC 6455 allows. TestWebSocketConformance tests what a client sees.
#include "server/http/Testing/ClientFrames.h"
#include "server/http/WebSocketFrames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

using namespace kdstream;

namespace
{

using WebSocketEvent = WebSocketReader::Event;

constexpr std::size_t mostMessageBytes = 1000;

// All events, in words.
std::vector<std::string> EventsOf(std::string_view bytes, const std::vector<std::size_t>& cuts = {})
{
  WebSocketReader reader(mostMessageBytes);
  std::vector<std::string> events;
  std::size_t begin = 0;
  const auto take = [&](std::size_t end)
  {
    auto part = bytes.substr(begin, end - begin);
    begin = end;
    for (;;)
    {
      switch (reader.Take(part))
      {
        case WebSocketEvent::None:
          EXPECT_TRUE(part.empty());
          return;
        case WebSocketEvent::Text:
          events.push_back("text " + reader.Message());
          break;
        case WebSocketEvent::Binary:
          events.emplace_back("binary");
          break;
        case WebSocketEvent::Ping:
          events.push_back("ping " + std::string(reader.Control()));
          break;
        case WebSocketEvent::Pong:
          events.push_back("pong " + std::string(reader.Control()));
          break;
        case WebSocketEvent::Close:
          events.push_back(
            "close " + std::to_string(reader.Status()) + " " + std::string(reader.Control()));
          break;
        case WebSocketEvent::Error:
          events.push_back("error " + std::to_string(reader.Status()));
          break;
      }
    }
  };
  for (const auto cut : cuts)
  {
    take(cut);
  }
  take(bytes.size());
  return events;
}

// Random bytes: whole conversations, some with a flipped bit.
std::string RandomFrames(std::mt19937& random)
{
  const auto upTo = [&random](unsigned most)
  { return std::uniform_int_distribution<unsigned>(0, most)(random); };
  std::string bytes;
  for (unsigned n = upTo(6); n > 0; --n)
  {
    ClientFrame frame;
    constexpr unsigned opcodes[] = { 0, 0, 1, 1, 1, 2, 8, 9, 9, 10, 3, 15 };
    frame.opcode = opcodes[upTo(11)];
    frame.payload = std::string(upTo(3) == 0 ? upTo(700) : upTo(130), 'a');
    frame.isLast = upTo(3) != 0;
    frame.mask = static_cast<std::uint32_t>(random());
    bytes += frame.Bytes();
  }
  for (unsigned n = upTo(4) == 0 ? 1 : 0; n > 0 && !bytes.empty(); --n)
  {
    bytes[random() % bytes.size()] ^= static_cast<char>(1u << upTo(7));
  }
  return bytes;
}

}

TEST(WebSocketFrames, MessagesComeWholeWithControlFramesBetween)
{
  const auto bytes = ClientFrame{ 1, "Hel", false }.Bytes() + ClientFrame{ 9, "?" }.Bytes() +
                     ClientFrame{ 0, "", false }.Bytes() + ClientFrame{ 0, "lo" }.Bytes() +
                     ClientFrame{ 10, "!" }.Bytes() + TextFrame("") +
                     ClientFrame{ 2, "xyz" }.Bytes() + TextFrame("end") + CloseFrame(1000, "bye") +
                     TextFrame("late");
  EXPECT_EQ(EventsOf(bytes), (std::vector<std::string>{ "ping ?", "text Hello", "pong !", "text ",
                               "binary", "text end", "close 1000 bye" }));
}

TEST(WebSocketFrames, AMessageHasALimitedSizeInAllItsParts)
{
  const std::string most(mostMessageBytes, 'x');
  EXPECT_EQ(EventsOf(TextFrame(most)), std::vector<std::string>{ "text " + most });
  const std::vector<std::string> tooLarge{ "error 1009" };
  EXPECT_EQ(EventsOf(TextFrame(most + "x")), tooLarge);
  EXPECT_EQ(
    EventsOf(ClientFrame{ 1, most, false }.Bytes() + ClientFrame{ 0, "x" }.Bytes()), tooLarge);
  // Reported at once: the reader does not wait for the announced bytes, and allocates no memory for
  // them.
  ClientFrame huge;
  huge.length = std::uint64_t{ 1 } << 62;
  EXPECT_EQ(EventsOf(huge.Bytes()), tooLarge);
}

TEST(WebSocketFrames, AnErrorIsReportedAtItsFirstByte)
{
  EXPECT_EQ(EventsOf("\xf1"), std::vector<std::string>{ "error 1002" }) << "reserved bits";
  EXPECT_EQ(EventsOf(std::string_view("\x81\x01", 2)), std::vector<std::string>{ "error 1002" });
  // The error is at the second byte of the surrogate, although more bytes are to come.
  auto begun = TextFrame("ab\xed\xa0\x80 and so on");
  begun.resize(6 + 4);
  EXPECT_EQ(EventsOf(begun), std::vector<std::string>{ "error 1007" });
}

TEST(WebSocketFrames, SkippedMessagesAreNoEvents)
{
  WebSocketReader reader(mostMessageBytes);
  const auto bytes = ClientFrame{ 1, "begun", false }.Bytes() + ClientFrame{ 0, "\xff" }.Bytes() +
                     ClientFrame{ 2, std::string(5000, 'x') }.Bytes() + CloseFrame(1001);
  std::string_view left = bytes;
  auto first = left.substr(0, 8);
  EXPECT_EQ(reader.Take(first), WebSocketEvent::None);
  left.remove_prefix(8);
  reader.SkipMessages();
  EXPECT_EQ(reader.Take(left), WebSocketEvent::Close);
  EXPECT_EQ(reader.Status(), 1001);
  EXPECT_EQ(reader.Message().capacity(), std::string().capacity());
}

TEST(WebSocketFrames, CutsMakeNoDifference)
{
  std::mt19937 random(34);
  for (int i = 0; i < 2000; ++i)
  {
    const auto bytes = RandomFrames(random);
    const auto whole = EventsOf(bytes);
    std::vector<std::size_t> cuts(random() % 20);
    std::generate(cuts.begin(), cuts.end(), [&] { return random() % (bytes.size() + 1); });
    std::sort(cuts.begin(), cuts.end());
    EXPECT_EQ(EventsOf(bytes, cuts), whole) << i;
  }
}

TEST(WebSocketFrames, Utf8IsWhatTheStandardSaysForAllCharacters)
{
  // All sequences of up to three bytes, and sequences of four bytes with every first and second
  // byte.
  const auto isWhole = [](std::string_view text)
  {
    Utf8Check check;
    return check.Take(text) && check.IsWhole();
  };
  const auto encoded = [](std::uint32_t c)
  {
    std::string text;
    const auto put = [&text](std::uint32_t byte) { text += static_cast<char>(byte); };
    c < 0x80      ? put(c)
    : c < 0x800   ? (put(0xc0 | c >> 6), put(0x80 | (c & 63)))
    : c < 0x10000 ? (put(0xe0 | c >> 12), put(0x80 | (c >> 6 & 63)), put(0x80 | (c & 63)))
                  : (put(0xf0 | c >> 18), put(0x80 | (c >> 12 & 63)), put(0x80 | (c >> 6 & 63)),
                      put(0x80 | (c & 63)));
    return text;
  };
  std::size_t wrong = 0;
  for (std::uint32_t c = 0; c <= 0x1fffff; ++c)
  {
    const bool isCharacter = c <= 0x10ffff && (c < 0xd800 || c > 0xdfff);
    wrong += isWhole(encoded(c)) == isCharacter ? 0u : 1u;
  }
  EXPECT_EQ(wrong, 0u);
  for (const char* text :
    { "\xc0\x80", "\xc1\xbf", "\xe0\x9f\xbf", "\xf0\x8f\xbf\xbf", "\x80", "\xbf",
      "\xf5\x80\x80\x80", "\xff", "\xfe", "\xe2\x82", "a\xc3", "\xc3\x28", "\xf8\x88\x80\x80\x80" })
  {
    EXPECT_FALSE(isWhole(text)) << text;
  }
}

// The example of section 1.3.
TEST(WebSocketFrames, TheKeyIsAnswered)
{
  EXPECT_EQ(WebSocketAccept("dGhlIHNhbXBsZSBub25jZQ=="), "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");
  EXPECT_TRUE(IsWebSocketKey("dGhlIHNhbXBsZSBub25jZQ=="));
  for (const char* key : { "", "==", "dGhlIHNhbXBsZSBub25jZQ=", "dGhlIHNhbXBsZSBub25jZQ===",
         "dGhlIHNhbXBsZSBub25j ZQ=", "dGhlIHNhbXBs=SBub25jZQ==" })
  {
    EXPECT_FALSE(IsWebSocketKey(key)) << key;
  }
}

TEST(WebSocketFrames, HeadsHaveTheShortestLength)
{
  for (const std::size_t bytes : { 0u, 1u, 125u, 126u, 65535u, 65536u, 70000u })
  {
    auto frame =
      std::string(WebSocketHead(WebSocketOpcode::Binary, bytes).Bytes()) + std::string(bytes, 'x');
    EXPECT_EQ(frame.size() - bytes, bytes < 126 ? 2u : bytes < 65536 ? 4u : 10u);
    const auto read = TakeServerFrame(frame);
    ASSERT_TRUE(read);
    EXPECT_TRUE(read->isRight);
    EXPECT_EQ(read->opcode, 2u);
    EXPECT_EQ(read->payload.size(), bytes);
    EXPECT_TRUE(frame.empty());
  }
}
