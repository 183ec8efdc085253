// SPDX-License-Identifier: BSD-3-Clause
// Which build may continue with the files of an interrupted one, and what is reported if a build
// may not.
#include "Testing/Fixtures/ErrorAt.h"
#include "filters/outofcore/Testing/BuildFolders.h"
#include "filters/outofcore/journal/BuildFingerprint.h"

#include <chrono>
#include <fstream>

using namespace kdstream;
using namespace kdstream::testing;
namespace fs = std::filesystem;

namespace
{

class TestBuildFingerprint : public BuildFolderTest
{
};

}

TEST_F(TestBuildFingerprint, ABuildWhoseInputNamesAnotherFileIsNotResumed)
{
  const fs::path input = this->Parent.Path() / "input", picture = this->Parent.Path() / "a.png",
                 gone = this->Parent.Path() / "gone.mtl";
  std::ofstream(input) << "some mesh";
  std::ofstream(picture) << "some picture";
  const BuildIdentity identity{ "program 1", input, { { "--weld", "on" } }, { picture, gone } };
  const std::string fingerprint = *FingerprintOf(identity);
  {
    BuildFolder folder = this->Open(false, fingerprint);
    ASSERT_TRUE(MakeNumbers(folder));
    folder.Keep(true);
  }
  const auto expectRefused = [&](const BuildIdentity& other, const fs::path& file)
  {
    const std::string now = *FingerprintOf(other);
    const auto refused = BuildFolder::Open(this->Path(), now, true);
    const std::string name = CanonicalPath(file).string();
    EXPECT_TRUE(fixtures::FailsAt(refused, ErrorCode::InvalidArgument, name + " "));
    EXPECT_TRUE(fixtures::Mentions(DescribeOtherBuild(fingerprint, now), { name + " " }));
  };
  const auto time = fs::last_write_time(picture);
  fs::last_write_time(picture, time + std::chrono::seconds(1));
  expectRefused(identity, picture);
  std::ofstream(picture, std::ios::app) << "more";
  fs::last_write_time(picture, time);
  expectRefused(identity, picture);
  std::ofstream(picture) << "some picture";
  fs::last_write_time(picture, time);
  std::ofstream(gone) << "newmtl a";
  expectRefused(identity, gone);
  fs::remove(gone);
  BuildIdentity other = identity;
  other.named = { gone };
  expectRefused(other, picture);
  other.named = { gone, picture, this->Parent.Path() / "b.png" };
  expectRefused(other, other.named.back());
  BuildFolder same = this->Open(true, *FingerprintOf(identity));
  EXPECT_EQ(same.FinishedPhases(), 1U);
}

TEST_F(TestBuildFingerprint, AnotherBuildIsNotResumedAndLosesNothing)
{
  const fs::path input = this->Parent.Path() / "input";
  std::ofstream(input) << "some mesh";
  BuildIdentity identity{ "program 1", input,
    { { "--weld", "on" }, { "--title", "" }, { "--unit", "mm" } } };
  const std::string fingerprint = *FingerprintOf(identity);
  {
    BuildFolder folder = this->Open(false, fingerprint);
    ASSERT_TRUE(MakeNumbers(folder));
    folder.Keep(true);
  }
  const auto refusal = [&](const BuildIdentity& other)
  {
    const std::vector<fs::path> before = EntriesOf(this->Path());
    const auto refused = BuildFolder::Open(this->Path(), *FingerprintOf(other), true);
    EXPECT_FALSE(refused);
    EXPECT_EQ(EntriesOf(this->Path()), before);
    return refused ? Error{} : refused.GetError();
  };
  BuildIdentity other = identity;
  other.options = { { "--weld", "off" }, { "--title", "A statue" }, { "--unit", "mm" } };
  EXPECT_TRUE(fixtures::IsAt(refusal(other), ErrorCode::InvalidArgument));
  other = identity;
  other.program = "program 2";
  EXPECT_EQ(refusal(other).code, ErrorCode::Unsupported);
  EXPECT_NE(refusal(other).message.find("another version"), std::string::npos);
  other = identity;
  other.options.pop_back();
  EXPECT_EQ(refusal(other).code, ErrorCode::Unsupported) << "this version knows fewer options";
  const auto time = fs::last_write_time(input);
  fs::last_write_time(input, time + std::chrono::seconds(1));
  EXPECT_EQ(refusal(identity).code, ErrorCode::InvalidArgument);
  EXPECT_NE(refusal(identity).message.find("another input, or its input"), std::string::npos);
  fs::last_write_time(input, time);
  EXPECT_EQ(this->Open(true, fingerprint).FinishedPhases(), 1U);
}

TEST_F(TestBuildFingerprint, FingerprintsDistinguishBuilds)
{
  const SpillFolder folder = MakeSpillFolder();
  const fs::path input = folder.Path() / "mesh.ply";
  std::ofstream(input) << "ply";
  const BuildIdentity identity{ "kdstream-build 1", input, { { "--precision", "20" } } };
  const std::string fingerprint = *FingerprintOf(identity);
  EXPECT_EQ(fingerprint, *FingerprintOf(identity));
  BuildIdentity other = identity;
  other.program = "kdstream-build 2";
  EXPECT_NE(fingerprint, *FingerprintOf(other));
  other = identity;
  other.options[0].second = "21";
  EXPECT_NE(fingerprint, *FingerprintOf(other));
  fs::copy(input, folder.Path() / "copy.ply");
  other = identity;
  other.input = folder.Path() / "copy.ply";
  EXPECT_NE(fingerprint, *FingerprintOf(other));
  fs::last_write_time(input, fs::last_write_time(input) + std::chrono::microseconds(1));
  const std::string touched = *FingerprintOf(identity);
  EXPECT_NE(fingerprint, touched);
  const auto time = fs::last_write_time(input);
  std::ofstream(input) << "plys";
  fs::last_write_time(input, time);
  EXPECT_NE(touched, *FingerprintOf(identity));
  other.input = folder.Path() / "none.ply";
  EXPECT_FALSE(FingerprintOf(other));
}
