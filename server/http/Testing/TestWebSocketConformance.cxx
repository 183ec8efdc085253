// SPDX-License-Identifier: BSD-3-Clause
// The server against RFC 6455, sections 5 to 8, frame by frame, with the groups of cases of the
// usual test suites: framing, pings and pongs, reserved bits, opcodes, fragments, UTF-8, closing,
// limits. Every case is sent at once, cut at random, and byte by byte.
//
// The conversation decides what a message may contain: "{}" is answered with an error of request 0,
// and the stream stays open.
#include "server/http/Testing/ClientFrames.h"
#include "server/http/Testing/RawSocket.h"
#include "server/http/Testing/ServerTest.h"

#include <functional>
#include <random>

using namespace kdstream;

namespace
{

struct WebSocketStep
{
  std::string bytes;
  bool awaitsAnswer = false; // continues when one more frame has arrived
};

const WebSocketStep untilAnswered{ "", true };

struct WebSocketCase
{
  std::string name;
  // Then the client closes with 1000, unless the case tests closing.
  std::vector<WebSocketStep> steps;
  unsigned closedWith = 1000;
  std::size_t texts = 0; // messages from the server
  std::vector<std::string> pongs = {};
};

// What the server has sent.
struct Outcome
{
  std::size_t texts = 0;
  std::vector<std::string> pongs;
  unsigned closedWith = 0; // 0: no Close frame
  std::size_t wrong = 0;   // frames that the server must not send
  bool ended = false;
};

enum class Cut
{
  AtOnce,
  AtRandom,
  Bytes
};

class Exchange
{
public:
  Exchange(std::uint16_t port, Cut cut)
    : Socket(port)
    , How(cut)
  {
    this->Socket.Send(UpgradeRequest());
    std::string answer;
    EXPECT_TRUE(this->Socket.ReceiveUntil("\r\n\r\n", answer, RawSocket::patience));
    EXPECT_EQ(answer.substr(0, 12), "HTTP/1.1 101");
    EXPECT_NE(
      answer.find("\r\nSec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=\r\n"), std::string::npos);
    this->Received = answer.substr(std::min(answer.size(), answer.find("\r\n\r\n") + 4));
  }

  Outcome Do(const WebSocketCase& each)
  {
    for (const auto& step : each.steps)
    {
      step.awaitsAnswer ? this->AwaitFrame() : this->Send(step.bytes);
    }
    this->Send(CloseFrame(1000));
    const auto until = std::chrono::steady_clock::now() + RawSocket::patience;
    while (!this->Socket.HasEnded() && std::chrono::steady_clock::now() < until)
    {
      this->Received += this->Socket.Receive(RawSocket::patience);
    }
    this->TakeFrames();
    this->Result.ended = this->Socket.HasEnded();
    this->Result.wrong += this->Received.empty() ? 0u : 1u;
    return this->Result;
  }

private:
  void Send(std::string_view bytes)
  {
    while (!bytes.empty())
    {
      const bool isSingle = this->How == Cut::Bytes && this->Singles++ < mostSingles;
      const auto count = this->How == Cut::AtOnce ? bytes.size()
                         : isSingle               ? 1
                                                  : 1 + this->Random() % bytes.size();
      if (!this->Socket.Send(bytes.substr(0, count), RawSocket::patience))
      {
        return; // the server has ended the connection
      }
      bytes.remove_prefix(count);
    }
  }
  void AwaitFrame()
  {
    const auto until = std::chrono::steady_clock::now() + RawSocket::patience;
    for (++this->Awaited, this->TakeFrames();
         this->Frames < this->Awaited && !this->Socket.HasEnded() &&
         std::chrono::steady_clock::now() < until;
         this->TakeFrames())
    {
      this->Received += this->Socket.Receive(RawSocket::patience);
    }
  }
  void TakeFrames()
  {
    while (const auto frame = TakeServerFrame(this->Received))
    {
      ++this->Frames;
      const bool isLate = this->Result.closedWith != 0; // nothing may follow a Close frame
      this->Result.wrong += frame->isRight && !isLate ? 0u : 1u;
      switch (frame->opcode)
      {
        case 1:
          ++this->Result.texts;
          break;
        case 8:
          this->Result.closedWith = frame->payload.size() < 2
                                      ? 1
                                      : static_cast<std::uint8_t>(frame->payload[0]) * 256u +
                                          static_cast<std::uint8_t>(frame->payload[1]);
          break;
        case 10:
          this->Result.pongs.push_back(frame->payload);
          break;
        default:
          ++this->Result.wrong;
      }
    }
  }

  RawSocket Socket;
  Cut How;
  std::mt19937 Random{ 6455 };
  static constexpr int mostSingles = 500;
  int Singles = 0;
  std::string Received;
  std::size_t Frames = 0, Awaited = 0;
  Outcome Result;
};

class WebSocketConformance : public ServerTest
{
protected:
  void Check(const std::vector<WebSocketCase>& cases)
  {
    this->options.admin = ListenAddress{};
    this->options.requestsOfAddress = 0;
    const auto port = this->Start();
    for (const auto& each : cases)
    {
      for (const auto cut : { Cut::AtOnce, Cut::AtRandom, Cut::Bytes })
      {
        SCOPED_TRACE(each.name + ", cut " + std::to_string(static_cast<int>(cut)));
        const auto outcome = Exchange(port, cut).Do(each);
        EXPECT_EQ(outcome.closedWith, each.closedWith);
        EXPECT_EQ(outcome.texts, each.texts);
        EXPECT_EQ(outcome.pongs, each.pongs);
        EXPECT_EQ(outcome.wrong, 0u);
        EXPECT_TRUE(outcome.ended);
      }
    }
    EXPECT_TRUE(this->SlotsAreFree());
  }

  bool SlotsAreFree()
  {
    const auto until = std::chrono::steady_clock::now() + RawSocket::patience;
    while (std::chrono::steady_clock::now() < until)
    {
      HttpTestClient admin(this->AdminPort());
      if (this->MetricsHave("kdstream_connections 0\n", admin) &&
          this->MetricsHave("kdstream_streams 0\n", admin))
      {
        return true;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }
};

std::string FrameOf(unsigned opcode, const std::string& payload, bool isLast = true)
{
  return ClientFrame{ opcode, payload, isLast }.Bytes();
}

// "{}" and this number of spaces.
std::string Json(std::size_t bytes)
{
  return "{}" + std::string(bytes - 2, ' ');
}

}

// Section 5.2: lengths, their shortest form, masks.
TEST_F(WebSocketConformance, Framing)
{
  std::vector<WebSocketCase> cases;
  for (const std::size_t bytes : { 2u, 125u, 126u, 127u, 128u, 4096u })
  {
    cases.push_back({ "text of " + std::to_string(bytes),
      { { TextFrame(Json(bytes)) }, untilAnswered }, 1000, 1 });
  }
  cases.push_back({ "no text at all", { { TextFrame("") } }, 1007, 1 });
  cases.push_back({ "two messages",
    { { TextFrame("{}") }, untilAnswered, { TextFrame("{}") }, untilAnswered }, 1000, 2 });
  cases.push_back({ "a mask of zeros",
    { { ClientFrame{ 1, "{}", true, 0, true, 0, {}, 0 }.Bytes() }, untilAnswered }, 1000, 1 });
  cases.push_back({ "no mask", { { ClientFrame{ 1, "{}", true, 0, false }.Bytes() } }, 1002 });
  cases.push_back(
    { "a ping without a mask", { { ClientFrame{ 9, "", true, 0, false }.Bytes() } }, 1002 });
  for (const std::size_t bytes : { 2u, 125u })
  {
    cases.push_back({ "a short length in two bytes",
      { { ClientFrame{ 1, Json(bytes), true, 0, true, 2 }.Bytes() } }, 1002 });
  }
  for (const std::size_t bytes : { 2u, 126u, 4096u, 65535u })
  {
    cases.push_back({ "a short length in eight bytes",
      { { ClientFrame{ 1, Json(bytes), true, 0, true, 8 }.Bytes() } }, 1002 });
  }
  cases.push_back({ "a length with its highest bit",
    { { ClientFrame{ 1, "{}", true, 0, true, 8, std::uint64_t{ 1 } << 63 }.Bytes() } }, 1002 });
  this->Check(cases);
}

// Sections 5.5.2 and 5.5.3.
TEST_F(WebSocketConformance, PingsAndPongs)
{
  const std::string any{ "\x00\xff\xfe\xfd\xfc\xfb\x00\xff", 8 };
  const std::string most(125, '\xfe');
  this->Check({
    { "an empty ping", { { FrameOf(9, "") }, untilAnswered }, 1000, 0, { "" } },
    { "a text", { { FrameOf(9, "Hello") }, untilAnswered }, 1000, 0, { "Hello" } },
    { "any bytes", { { FrameOf(9, any) }, untilAnswered }, 1000, 0, { any } },
    { "the largest", { { FrameOf(9, most) }, untilAnswered }, 1000, 0, { most } },
    { "one byte more", { { FrameOf(9, most + "x") } }, 1002 },
    { "a pong that nobody asked for", { { FrameOf(10, "") } } },
    { "one with bytes", { { FrameOf(10, any) } } },
    { "a pong, then a ping", { { FrameOf(10, "x") }, { FrameOf(9, "y") }, untilAnswered }, 1000, 0,
      { "y" } },
    { "a pong of too many bytes", { { FrameOf(10, most + "x") } }, 1002 },
    { "ten, one after the other",
      { { FrameOf(9, "0") }, untilAnswered, { FrameOf(9, "1") }, untilAnswered, { FrameOf(9, "2") },
        untilAnswered },
      1000, 0, { "0", "1", "2" } },
    { "beside a message",
      { { TextFrame("{}") }, untilAnswered, { FrameOf(9, "x") }, untilAnswered }, 1000, 1,
      { "x" } },
  });
}

// If many pings come at once, at least the last one is answered; and they delay no other answer.
TEST_F(WebSocketConformance, OfManyPingsTheLastIsAnswered)
{
  RawSocket socket(this->Start());
  socket.Send(UpgradeRequest());
  std::string received;
  ASSERT_TRUE(socket.ReceiveUntil("\r\n\r\n", received, RawSocket::patience));
  received.erase(0, received.find("\r\n\r\n") + 4);
  std::string pings;
  for (int i = 0; i < 1000; ++i)
  {
    pings += FrameOf(9, std::to_string(i));
  }
  ASSERT_TRUE(socket.Send(TextFrame("{}") + pings, RawSocket::patience));
  int texts = 0, last = -1;
  const auto until = std::chrono::steady_clock::now() + RawSocket::patience;
  while ((last != 999 || texts != 1) && std::chrono::steady_clock::now() < until)
  {
    received += socket.Receive(RawSocket::patience);
    while (const auto frame = TakeServerFrame(received))
    {
      if (frame->opcode == 1)
      {
        ++texts;
        continue;
      }
      ASSERT_EQ(frame->opcode, 10u);
      EXPECT_GT(std::stoi(frame->payload), last);
      last = std::stoi(frame->payload);
    }
  }
  EXPECT_EQ(last, 999);
  EXPECT_EQ(texts, 1);
}

// Section 5.2: reserved bits must be 0, because no extension has been agreed on.
TEST_F(WebSocketConformance, ReservedBits)
{
  std::vector<WebSocketCase> cases;
  for (unsigned bits = 1; bits < 8; ++bits)
  {
    for (const unsigned opcode : { 1u, 2u, 8u, 9u, 10u })
    {
      const auto name = std::to_string(bits) + " of " + std::to_string(opcode);
      const auto frame = ClientFrame{ opcode, "", true, bits }.Bytes();
      cases.push_back({ name, { { frame } }, 1002 });
      cases.push_back(
        { name + " after a message", { { TextFrame("{}") }, untilAnswered, { frame } }, 1002, 1 });
    }
    cases.push_back({ "of a continuation",
      { { FrameOf(1, "{", false) + ClientFrame{ 0, "}", true, bits }.Bytes() } }, 1002 });
  }
  this->Check(cases);
}

TEST_F(WebSocketConformance, Opcodes)
{
  std::vector<WebSocketCase> cases;
  for (const unsigned opcode : { 3u, 4u, 5u, 6u, 7u, 11u, 12u, 13u, 14u, 15u })
  {
    const auto name = std::to_string(opcode);
    cases.push_back({ name, { { FrameOf(opcode, "") } }, 1002 });
    cases.push_back({ name + " with bytes", { { FrameOf(opcode, "x") } }, 1002 });
    cases.push_back({ name + " after a message",
      { { TextFrame("{}") }, untilAnswered, { FrameOf(opcode, "") + FrameOf(9, "x") } }, 1002, 1 });
    cases.push_back(
      { name + " amid a message", { { FrameOf(1, "{", false) + FrameOf(opcode, "") } }, 1002 });
  }
  cases.push_back({ "a binary message", { { FrameOf(2, "x") } }, 1003, 1 });
  cases.push_back({ "an empty one", { { FrameOf(2, "") } }, 1003, 1 });
  cases.push_back({ "one in parts", { { FrameOf(2, "x", false) + FrameOf(0, "y") } }, 1003, 1 });
  this->Check(cases);
}

// Section 5.4.
TEST_F(WebSocketConformance, Fragments)
{
  const auto text = [](const std::string& part) { return FrameOf(1, part, false); };
  const auto more = [](const std::string& part, bool isLast) { return FrameOf(0, part, isLast); };
  const std::vector<WebSocketStep> answered{ untilAnswered };
  this->Check({
    { "two", { { text("{") + more("}", true) }, untilAnswered }, 1000, 1 },
    { "one by one", { { text("{") }, { more("}", true) }, untilAnswered }, 1000, 1 },
    { "empty ones around", { { text("") + more("{}", false) + more("", true) }, untilAnswered },
      1000, 1 },
    { "only empty ones", { { text("") + more("", false) + more("", true) } }, 1007, 1 },
    { "a ping between",
      { { text("{") + FrameOf(9, "p") }, untilAnswered, { more("}", true) }, untilAnswered }, 1000,
      1, { "p" } },
    { "a pong between", { { text("{") + FrameOf(10, "p") + more("}", true) }, untilAnswered }, 1000,
      1 },
    { "a ping in parts", { { FrameOf(9, "p", false) + more("q", true) } }, 1002 },
    { "a pong in parts", { { FrameOf(10, "p", false) + more("q", true) } }, 1002 },
    { "a close in parts", { { FrameOf(8, "\x03\xe8", false) } }, 1002 },
    { "a last part of nothing", { { more("x", true) } }, 1002 },
    { "a part of nothing", { { more("x", false) } }, 1002 },
    { "a part after a whole message", { { TextFrame("{}") }, untilAnswered, { more("x", true) } },
      1002, 1 },
    { "a message within another", { { text("{") + TextFrame("{}") } }, 1002 },
    { "a binary within a text", { { text("{") + FrameOf(2, "x") } }, 1002 },
    { "a close amid a message", { { text("{") + CloseFrame(1001) } }, 1001 },
    { "a thousand parts",
      { { text("{") +
          [&]
          {
            std::string parts;
            for (int i = 0; i < 1000; ++i)
            {
              parts += more(i % 3 == 0 ? "" : " ", false);
            }
            return parts + more("}", true);
          }() },
        untilAnswered },
      1000, 1 },
  });
}

// Section 8.1, and tables 3-6 and 3-7 of Unicode.
TEST_F(WebSocketConformance, Utf8)
{
  std::vector<WebSocketCase> cases;
  const auto quoted = [](const std::string& text) { return "{\"type\":\"" + text + "\"}"; };
  for (const char* text :
    { "Hello-\xc2\xb5@\xc3\x9f\xc3\xb6\xc3\xa4\xc3\xbc\xc3\xa0\xc3\xa1-UTF-8!!",
      "\xce\xba\xe1\xbd\xb9", "\xc2\x80", "\xdf\xbf", "\xe0\xa0\x80", "\xef\xbf\xbf",
      "\xef\xbf\xbe", "\xed\x9f\xbf", "\xee\x80\x80", "\xef\xbf\xbd", "\xf0\x90\x80\x80",
      "\xf4\x8f\xbf\xbf", "\xf0\x9f\xbf\xbe", "\xef\xb7\x90" })
  {
    const auto whole = quoted(text);
    cases.push_back({ "whole", { { TextFrame(whole) }, untilAnswered }, 1000, 1 });
    for (std::size_t cut = 1; cut < whole.size(); ++cut) // also within characters
    {
      cases.push_back({ "in two parts",
        { { FrameOf(1, whole.substr(0, cut), false) + FrameOf(0, whole.substr(cut)) },
          untilAnswered },
        1000, 1 });
    }
  }
  for (const char* text : { "\xce\xba\xe1\xbd\xb9\xcf\x83\xce\xbc\xce\xb5\xed\xa0\x80\x65",
         "\xc0\xaf", "\xe0\x80\xaf", "\xf0\x80\x80\xaf", "\xf8\x80\x80\x80\xaf", "\xc1\xbf",
         "\xe0\x9f\xbf", "\xf0\x8f\xbf\xbf", "\xf7\xbf\xbf\xbf", "\xfc\x84\x80\x80\x80\x80",
         "\xf4\x90\x80\x80", "\x80", "\xbf", "\x80\xbf\x80", "\xc2", "\xe1\xbd", "\xf0\x9f\x98",
         "\xc3 ", "\xfe", "\xff", "\xed\xa0\x80", "\xed\xbf\xbf", "\xed\xa0\x80\xed\xb0\x80" })
  {
    const auto whole = quoted(text);
    cases.push_back({ "wrong", { { TextFrame(whole) } }, 1007 });
    cases.push_back({ "wrong in parts",
      { { FrameOf(1, whole.substr(0, 10), false) + FrameOf(0, whole.substr(10)) } }, 1007 });
    // The error is reported at the first wrong byte, although the rest of the message does not
    // come.
    cases.push_back({ "wrong and begun", { { FrameOf(1, whole, false) }, untilAnswered }, 1007 });
  }
  cases.push_back({ "a text that ends amid a character", { { TextFrame("{}\xe2\x82") } }, 1007 });
  this->Check(cases);
}

// Sections 5.5.1 and 7.
TEST_F(WebSocketConformance, Closing)
{
  std::vector<WebSocketCase> cases{
    { "without a status", { { CloseFrame(0) } } },
    { "a status of one byte", { { FrameOf(8, "x") } }, 1002 },
    { "with a reason", { { CloseFrame(1000, "enough") } } },
    { "the longest reason", { { CloseFrame(1000, std::string(123, '*')) } } },
    { "a longer one", { { CloseFrame(1000, std::string(124, '*')) } }, 1002 },
    { "a reason that is not UTF-8", { { CloseFrame(1000, "\xce\xba\xed\xa0\x80") } }, 1007 },
    { "a reason that ends amid a character", { { CloseFrame(1000, "\xe2\x82") } }, 1007 },
    { "twice", { { CloseFrame(1000) + CloseFrame(1001) } } },
    { "a message after it", { { CloseFrame(1000) + TextFrame("{}") } } },
    { "a ping after it", { { CloseFrame(1000) + FrameOf(9, "x") } } },
    { "noise after it", { { CloseFrame(1000) + std::string(100000, '\xff') } } },
    { "the begin of a message before it", { { FrameOf(1, "{", false) + CloseFrame(1000) } } },
    { "after a message", { { TextFrame("{}") }, untilAnswered, { CloseFrame(1000) } }, 1000, 1 },
    // The server closes. Later bytes are dropped, and the server sends no second Close frame.
    { "an answer to the server's",
      { { TextFrame("[") }, untilAnswered, untilAnswered, { CloseFrame(1007) } }, 1007, 1 },
    { "none, and a second message that is wrong",
      { { TextFrame("[") + ClientFrame{ 1, "aa", true, 0, true, 0, 10 }.Bytes() }, untilAnswered,
        untilAnswered, { std::string(8, '\xff') } },
      1007, 1 },
    { "a wrong one to the server's",
      { { TextFrame("[") }, untilAnswered, untilAnswered, { FrameOf(8, "x") } }, 1007, 1 },
    { "frames that are wrong",
      { { TextFrame("[") }, untilAnswered, untilAnswered, { FrameOf(3, "") + FrameOf(9, "x") } },
      1007, 1 },
  };
  for (const unsigned status : { 1000u, 1001u, 1002u, 1003u, 1007u, 1008u, 1009u, 1010u, 1011u,
         1012u, 1013u, 1014u, 3000u, 3999u, 4000u, 4999u })
  {
    cases.push_back({ std::to_string(status), { { CloseFrame(status) } }, status });
  }
  for (const unsigned status :
    { 1u, 999u, 1004u, 1005u, 1006u, 1015u, 1016u, 1100u, 2000u, 2999u, 5000u, 65535u })
  {
    cases.push_back({ std::to_string(status), { { CloseFrame(status) } }, 1002 });
  }
  cases.push_back({ "status 0", { { FrameOf(8, std::string(2, '\0')) } }, 1002 });
  this->Check(cases);
}

// Section 10.4. The conversation refuses 4097 bytes with a message; beyond 64 KiB the server does
// not read on.
TEST_F(WebSocketConformance, Limits)
{
  const std::string spaces(40000, ' ');
  this->Check({
    { "too long for a conversation", { { TextFrame(Json(4097)) } }, 1009, 1 },
    { "as long as may be read", { { TextFrame(Json(65536)) } }, 1009, 1 },
    { "longer", { { TextFrame(Json(65537)) } }, 1009 },
    { "longer in parts", { { FrameOf(1, spaces, false) + FrameOf(0, spaces, false) } }, 1009 },
    { "as long as there is",
      { { ClientFrame{ 1, "{}", true, 0, true, 8, ~std::uint64_t{ 0 } >> 1 }.Bytes() } }, 1009 },
  });
}

// A client that sends nothing more, or only half a message, does not keep its slot.
TEST_F(WebSocketConformance, ConnectionsThatAreLeftOpenAreEnded)
{
  this->options.answerTimeout = std::chrono::milliseconds(200);
  this->options.streamTimeout = std::chrono::milliseconds(400);
  this->options.admin = ListenAddress{};
  const auto port = this->Start();
  std::vector<RawSocket> left;
  for (const auto& bytes : { std::string(), TextFrame("["), TextFrame("[") + FrameOf(1, "{", false),
         TextFrame("{}").substr(0, 7), FrameOf(3, ""), CloseFrame(1000), CloseFrame(1000) + "more",
         std::string("\x81"), FrameOf(2, "x", false) })
  {
    left.emplace_back(port);
    left.back().Send(UpgradeRequest());
    std::string answer;
    ASSERT_TRUE(left.back().ReceiveUntil("\r\n\r\n", answer, RawSocket::patience));
    left.back().Send(bytes);
  }
  EXPECT_TRUE(this->SlotsAreFree());
  for (auto& socket : left)
  {
    EXPECT_TRUE(socket.AwaitEnd(RawSocket::patience));
  }
}
