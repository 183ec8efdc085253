// SPDX-License-Identifier: BSD-3-Clause
// Recording what is done in a window as a session file.
#include "viewer/desktop/window/SessionRecorder.h"

#include "Testing/Fixtures/TemporaryFolder.h"

#include <gtest/gtest.h>

using namespace kdstream;
using Kind = SessionStep::Kind;

namespace
{

TEST(TestSessionRecorder, WaitsWhereSomebodyHasWaited)
{
  const fixtures::TemporaryFolder folder;
  const SessionStep select{ Kind::Select, {}, "a" };
  const SessionStep home{ Kind::Go, {}, "home" };
  const SessionStep wait{ Kind::WaitForIdle, {} };
  auto recorder = SessionRecorder::Make((folder / "r.jsonl").string());
  ASSERT_TRUE(recorder);
  EXPECT_TRUE(recorder->IsOn());
  recorder->NoteIdle(); // before the first step
  recorder->Add(select);
  recorder->Add(home); // immediately
  recorder->NoteIdle();
  recorder->NoteIdle();
  EXPECT_EQ(*ParseSession(fixtures::ReadWhole(folder / "r.jsonl")),
    (std::vector<SessionStep>{ select, home }))
    << "on the disk at once, and no wait yet";
  recorder->Add(home);
  ASSERT_TRUE(recorder->Finish());
  EXPECT_EQ(*ParseSession(fixtures::ReadWhole(folder / "r.jsonl")),
    (std::vector<SessionStep>{ select, home, wait, home, wait }));
}

TEST(TestSessionRecorder, RecordsNothingWithoutAFileAndSaysWhereItCannot)
{
  auto none = SessionRecorder::Make("");
  ASSERT_TRUE(none);
  EXPECT_FALSE(none->IsOn());
  none->Add({ Kind::WaitForIdle, {} });
  EXPECT_TRUE(none->Finish());
  const auto nowhere = SessionRecorder::Make("/no/such/folder/r.jsonl");
  ASSERT_FALSE(nowhere);
  EXPECT_NE(nowhere.GetError().message.find("cannot be written"), std::string::npos);
}

}
