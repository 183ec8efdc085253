// SPDX-License-Identifier: BSD-3-Clause
// However the work of a program ends, the person gets one line and an exit code.
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

// A program whose work is to throw.
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
