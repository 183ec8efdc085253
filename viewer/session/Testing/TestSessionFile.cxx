// SPDX-License-Identifier: BSD-3-Clause
// Session files are read, refused with the number of the line, and written back bit for bit.
#include "viewer/session/SessionFile.h"

#include <gtest/gtest.h>

#include <random>

using namespace kdstream;
using Kind = SessionStep::Kind;

namespace
{

TEST(TestSessionFile, ReadsEveryKindOfLine)
{
  const auto steps = ParseSession("{\"select\":\"dragon\"}\n\n{\"wait\":\"idle\"}\r\n"
                                  "{\"t\":0.25,\"touches\":[{\"id\":1,\"x\":640,\"y\":360.5}]}\n"
                                  "{\"t\":0.3,\"touches\":[]}\n{\"screenshot\":\"a b.png\"}\n"
                                  "{\"turning\":\"upright\"}\n{\"detail\":\"level\"}\n"
                                  "{\"go\":\"home\"}\n{\"rings\":3}\n"
                                  "{\"zoom\":1.5,\"x\":-2,\"y\":7.5}\n"
                                  "{\"window\":[640,480],\"ratio\":2}\n"
                                  "{\"triangles\":5000,\"memory\":8000000000}\n"
                                  "{\"colours\":\"none\"}\n{\"light\":\"plain\"}\n"
                                  "{\"boxes\":\"on\"}\n{\"side\":\"top\"}\n"
                                  "{\"link\":\"model=dragon\"}\n{\"tool\":\"measure\"}\n"
                                  "{\"colours\":\"by:a%20b:cividis:0:2.5\"}");
  ASSERT_TRUE(steps) << steps.GetError().message;
  ASSERT_EQ(steps->size(), 19u);
  EXPECT_EQ((*steps)[0], (SessionStep{ Kind::Select, {}, "dragon" }));
  EXPECT_EQ((*steps)[1], (SessionStep{ Kind::WaitForIdle, {}, {} }));
  EXPECT_EQ((*steps)[2], (SessionStep{ Kind::Touches, { 0.25, { { 1, 640, 360.5 } } }, {} }));
  EXPECT_EQ((*steps)[3], (SessionStep{ Kind::Touches, { 0.3, {} }, {} }));
  EXPECT_EQ((*steps)[4], (SessionStep{ Kind::Screenshot, {}, "a b.png" }));
  EXPECT_EQ((*steps)[5], (SessionStep{ Kind::Turning, {}, "upright" }));
  EXPECT_EQ((*steps)[6], (SessionStep{ Kind::Detail, {}, "level" }));
  EXPECT_EQ((*steps)[7], (SessionStep{ Kind::Go, {}, "home" }));
  EXPECT_EQ((*steps)[8], (SessionStep{ Kind::Rings, {}, {}, 1, 0, 0, 3 }));
  EXPECT_EQ((*steps)[9], (SessionStep{ Kind::Zoom, {}, {}, 1.5, -2, 7.5 }));
  EXPECT_EQ((*steps)[10], (SessionStep{ Kind::Window, {}, {}, 1, 0, 0, 1, { 640, 480, 2 } }));
  SessionStep budgets{ Kind::Budgets, {} };
  budgets.triangles = 5000;
  budgets.memory = 8'000'000'000;
  EXPECT_EQ((*steps)[11], budgets);
  EXPECT_EQ((*steps)[12], (SessionStep{ Kind::Colors, {}, "none" }));
  EXPECT_EQ((*steps)[13], (SessionStep{ Kind::Light, {}, "plain" }));
  EXPECT_EQ((*steps)[14], (SessionStep{ Kind::Boxes, {}, "on" }));
  EXPECT_EQ((*steps)[15], (SessionStep{ Kind::Side, {}, "top" }));
  EXPECT_EQ((*steps)[16], (SessionStep{ Kind::Link, {}, "model=dragon" }));
  EXPECT_EQ((*steps)[17], (SessionStep{ Kind::Tool, {}, "measure" }));
  EXPECT_EQ((*steps)[18], (SessionStep{ Kind::Colors, {}, "by:a%20b:cividis:0:2.5" }));
  EXPECT_TRUE(ParseSession("")->empty());
}

TEST(TestSessionFile, NamesTheLineAndWhatIsWrong)
{
  const std::vector<std::pair<std::string, std::string>> cases = {
    { "hello", "not a JSON object" },
    { "[1]", "not a JSON object" },
    { "{}", "unknown step" },
    { R"({"wait":"long"})", "'idle'" },
    { R"({"wait":1})", "'wait'" },
    { R"({"turning":"round"})", "'upright', 'free'" },
    { R"({"go":"away"})", "'home', 'undo', 'back'" },
    { R"({"tool":"saw"})", "'none', 'measure'" },
    { R"({"side":"inside"})", "'front', 'back'" },
    { R"({"link":"view=1"})", "this link to a view" },
    { R"({"detail":"high"})", "'view', 'level', 'full'" },
    { R"({"rings":4})", "'rings'" },
    { R"({"rings":1.5})", "'rings'" },
    { R"({"colours":"by:a:red"})", "'by:NAME:MAP:LOW:HIGH'" },
    { R"({"colours":"red"})", "'own', 'none', 'partition', 'resolution'" },
    { R"({"light":true})", "'light'" },
    { R"({"boxes":"yes"})", "'on', 'off'" },
    { R"({"triangles":0,"memory":1})", "above 0" },
    { R"({"triangles":7,"memory":1.5})", "above 0" },
    { R"({"triangles":7})", "'memory' is missing" },
    { R"({"zoom":0,"x":1,"y":1})", "above 0" },
    { R"({"zoom":2,"x":1})", "'y'" },
    { R"({"window":[640],"ratio":1})", "'window'" },
    { R"({"window":[640,0],"ratio":1})", "'window'" },
    { R"({"window":[640,9000],"ratio":1})", "'window'" },
    { R"({"window":[640,480],"ratio":0})", "'ratio'" },
    { R"({"window":[640,480]})", "'ratio'" },
    { R"({"select":""})", "'select'" },
    { R"({"screenshot":"a.png","quality":3})", "'quality'" },
    { R"({"touches":[]})", "'t'" },
    { R"({"t":"1","touches":[]})", "'t'" },
    { R"({"t":1,"touches":{}})", "'touches'" },
    { R"({"t":1,"touches":[{"id":1,"x":2}]})", "'y'" },
    { R"({"t":1,"touches":[{"id":1.5,"x":2,"y":3}]})", "id must be an integer" },
    { R"({"t":1e999,"touches":[]})", "not a JSON object" },
    { R"({"t":1,"touches":[7]})", "not an object" },
  };
  for (const auto& [line, what] : cases)
  {
    const auto steps = ParseSession("{\"wait\":\"idle\"}\n" + line + "\n");
    ASSERT_FALSE(steps) << line;
    EXPECT_EQ(steps.GetError().code, ErrorCode::InvalidInput);
    EXPECT_NE(steps.GetError().message.find("line 2: "), std::string::npos);
    EXPECT_NE(steps.GetError().message.find(what), std::string::npos) << steps.GetError().message;
  }
}

TEST(TestSessionFile, WritesWhatItReads)
{
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> any(-1e4, 1e4);
  std::string text;
  std::vector<SessionStep> steps = { { Kind::Select, {}, "a \"quoted\" \\ name\n\x01" },
    { Kind::WaitForIdle, {}, {} }, { Kind::Screenshot, {}, "x.png" }, { Kind::Turning, {}, "free" },
    { Kind::Detail, {}, "full" }, { Kind::Go, {}, "undo" }, { Kind::Rings, {}, {}, 1, 0, 0, 2 },
    { Kind::Zoom, {}, {}, 1.0 / 3, 0.1, 1e-9 },
    { Kind::Window, {}, {}, 1, 0, 0, 1, { 8192, 1, 1.5 } },
    { Kind::Budgets, {}, {}, 1, 0, 0, 1, {}, 1, std::uint64_t{ 1 } << 53 },
    { Kind::Colors, {}, "resolution" }, { Kind::Light, {}, "relief" }, { Kind::Boxes, {}, "off" } };
  for (int i = 0; i < 500; ++i)
  {
    SessionStep step{ Kind::Touches, { any(random) / 3, {} }, {} };
    for (auto k = random() % 4; k > 0; --k)
    {
      step.frame.touches.push_back(
        { static_cast<std::int64_t>(random()), any(random), any(random) * 1e-7 });
    }
    steps.push_back(step);
  }
  for (const SessionStep& step : steps)
  {
    text += FormatSessionStep(step) + "\n";
  }
  const auto back = ParseSession(text);
  ASSERT_TRUE(back) << back.GetError().message;
  EXPECT_EQ(*back, steps);
}

}
