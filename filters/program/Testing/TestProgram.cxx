// SPDX-License-Identifier: BSD-3-Clause
// However the work of a program ends, the user gets one line and an exit code.
#include "filters/program/Program.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <new>
#include <stdexcept>
#include <string>
#include <system_error>

using namespace kdstream;

namespace
{

struct Ending
{
  int exitCode = 0;
  std::string said;
};

// A program whose work only throws.
template <class Exception>
Ending RunThrowing(const Exception& exception)
{
  CLI::App app("throws", "kdstream-test");
  char name[] = "kdstream-test";
  char* arguments[] = { name, nullptr };
  testing::internal::CaptureStderr();
  Ending ending;
  ending.exitCode = RunProgram(app, 1, arguments, [&exception]() -> int { throw exception; });
  ending.said = testing::internal::GetCapturedStderr();
  return ending;
}

TEST(TestProgram, EveryExceptionBecomesOneLine)
{
  const auto expect = [](const Ending& ending, const std::string& line)
  {
    EXPECT_EQ(ending.exitCode, exitFailed);
    EXPECT_EQ(ending.said, "kdstream-test: error: " + line + "\n");
  };
  expect(RunThrowing(std::bad_alloc()), "out of memory");
  expect(RunThrowing(std::length_error("vector::reserve")), "out of memory");
  const auto missing = std::make_error_code(std::errc::no_such_file_or_directory);
  expect(RunThrowing(std::filesystem::filesystem_error("cannot be told", "x.kds", missing)),
    "filesystem error: cannot be told: No such file or directory [x.kds]");
  expect(RunThrowing(std::system_error(missing, "thread")), "thread: No such file or directory");
  expect(RunThrowing(std::runtime_error("two\nlines")), "unexpected: two lines");
  expect(RunThrowing(42), "unexpected: an exception without a message");
}

// An error of an input ends with advice, after the place, unless its message already contains some.
TEST(TestProgram, RefusalsSayWhatToDo)
{
  const auto said = [](const Error& error)
  {
    testing::internal::CaptureStderr();
    PrintError("kdstream-test", "in.ply", error);
    return testing::internal::GetCapturedStderr();
  };
  const std::string begin = "kdstream-test: error: in.ply: bad, byte 9";
  const auto bad = [](ErrorCode code, Remedy remedy = Remedy::Unknown) {
    return Error{ code, "bad", {}, "byte 9", remedy };
  };
  constexpr ErrorCode invalid = ErrorCode::InvalidInput;
  EXPECT_EQ(said(bad(invalid)), begin + "\n");
  EXPECT_EQ(said(bad(invalid, Remedy::InMessage)), begin + "\n");
  EXPECT_EQ(said(OfInput(bad(invalid, Remedy::InMessage))), begin + "\n");
  EXPECT_EQ(said(OfInput(bad(invalid))), begin + ": correct the file, or export it again\n");
  EXPECT_EQ(said(OfInput(bad(ErrorCode::Unsupported))),
    begin + ": export it in another way, for example as .ply\n");
  EXPECT_EQ(
    said(OfInput(bad(ErrorCode::LimitExceeded))), begin + ": divide it into several files\n");
  EXPECT_EQ(said(OfInput(bad(ErrorCode::InputOutput))), begin + "\n");
  EXPECT_EQ(said(OfInput(bad(invalid, Remedy::CopyAgain))),
    begin + ": copy the file again, or export it again\n");
  EXPECT_EQ(said(bad(invalid, Remedy::Rename)),
    begin + ": give the file the ending of its format, or export it again\n");
  EXPECT_EQ(said(bad(invalid, Remedy::Retry)),
    begin + ": wait until no program writes to it, then try again\n");
}

TEST(TestProgram, InterruptedWorkBlamesNoFile)
{
  testing::internal::CaptureStderr();
  const int exitCode =
    PrintError("kdstream-test", "in.ply", { ErrorCode::Cancelled, "cancelled", "other.ply" });
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "kdstream-test: error: interrupted\n");
  EXPECT_EQ(exitCode, exitFailed);
  testing::internal::CaptureStderr();
  PrintError("kdstream-test", "in.ply", { ErrorCode::Cancelled, "cancelled" }, "out.kds");
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
    "kdstream-test: error: interrupted: out.kds is not written\n");
}

}
