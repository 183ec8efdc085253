// SPDX-License-Identifier: BSD-3-Clause
#include "server/app/FolderWatch.h"

#include "Testing/Fixtures/TemporaryFolder.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>

using namespace kdstream;
namespace fs = std::filesystem;

namespace
{

class Watch : public testing::Test
{
protected:
  const fixtures::TemporaryFolder temporary;
  const fs::path folder = temporary / "stores", away = temporary / "away";

  void SetUp() override { fs::create_directory(this->folder); }

  FolderWatch Open() const
  {
    auto watch = FolderWatch::Open(this->folder);
    EXPECT_TRUE(watch) << watch.GetError().message;
    return std::move(*watch);
  }
  static void Write(const fs::path& file) { std::ofstream(file) << "x"; }
};

}

TEST_F(Watch, SeesStoresComeChangeAndGo)
{
  auto watch = this->Open();
  EXPECT_FALSE(watch.HasChanged());
  Write(this->folder / "one.kds");
  EXPECT_TRUE(watch.HasChanged());
  EXPECT_FALSE(watch.HasChanged()) << "told once";
  Write(this->folder / "notes.txt");
  EXPECT_FALSE(watch.HasChanged());
  fs::rename(this->folder / "notes.txt", this->folder / "two.kds");
  EXPECT_TRUE(watch.HasChanged());
  fs::remove(this->folder / "one.kds");
  EXPECT_TRUE(watch.HasChanged());
}

TEST_F(Watch, SeesLinksButNotWhatIsStillWritten)
{
  Write(this->away);
  auto watch = this->Open();
  std::ofstream slow(this->folder / "slow.kds");
  EXPECT_FALSE(watch.HasChanged());
  fs::create_symlink(this->away, this->folder / "soft.kds");
  EXPECT_TRUE(watch.HasChanged());
  fs::create_hard_link(this->away, this->folder / "hard.kds");
  EXPECT_TRUE(watch.HasChanged());
  slow.close();
  EXPECT_TRUE(watch.HasChanged());
}

TEST_F(Watch, FollowsItsNameToAnotherFolder)
{
  auto watch = this->Open();
  fs::rename(this->folder, this->away);
  EXPECT_FALSE(watch.HasChanged()) << "there is none";
  fs::create_directory(this->folder);
  EXPECT_TRUE(watch.HasChanged());
  Write(this->away / "old.kds");
  EXPECT_FALSE(watch.HasChanged());
  Write(this->folder / "new.kds");
  EXPECT_TRUE(watch.HasChanged());
}

TEST_F(Watch, FollowsALink)
{
  const fs::path first = this->temporary / "1", second = this->temporary / "2";
  fs::create_directory(first);
  fs::create_directory(second);
  fs::remove(this->folder);
  fs::create_directory_symlink(first, this->folder);
  auto watch = this->Open();
  fs::create_directory_symlink(second, this->away);
  fs::rename(this->away, this->folder);
  EXPECT_TRUE(watch.HasChanged());
  Write(second / "new.kds");
  EXPECT_TRUE(watch.HasChanged());
  Write(first / "old.kds");
  EXPECT_FALSE(watch.HasChanged());
}

// The new folder may get the same inode as the old one.
TEST_F(Watch, FollowsAFolderThatIsMadeAnew)
{
  auto watch = this->Open();
  for (int i = 0; i < 20; ++i)
  {
    fs::remove(this->folder);
    fs::create_directory(this->folder);
    EXPECT_TRUE(watch.HasChanged());
    Write(this->folder / "new.kds");
    EXPECT_TRUE(watch.HasChanged());
    fs::remove(this->folder / "new.kds");
    EXPECT_TRUE(watch.HasChanged());
  }
}

TEST_F(Watch, WantsAFolder)
{
  EXPECT_FALSE(FolderWatch::Open(this->away));
  Write(this->away);
  EXPECT_FALSE(FolderWatch::Open(this->away));
}
