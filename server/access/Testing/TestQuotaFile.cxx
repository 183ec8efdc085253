// SPDX-License-Identifier: BSD-3-Clause
// The quotas' file while something is wrong with it: nothing is allowed. Afterwards, without a
// restart, exactly the earlier entries count again.
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/store/Sqlite.h"
#include "server/access/QuotaBook.h"

#include <gtest/gtest.h>

#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <fstream>
#include <functional>
#include <new>
#include <set>
#include <thread>
#include <utility>
#include <vector>

using namespace kdstream;
namespace fs = std::filesystem;

namespace
{

constexpr std::int64_t second = 1'000'000;

class QuotaFile : public testing::Test
{
protected:
  const fixtures::TemporaryFolder folder;
  const fs::path place = this->folder.Path / "place", file = this->place / "quotas.db";
  std::atomic<std::int64_t> time{ 1'000'000 * second };
  std::atomic<int> throwing{ 0 }; // n: the n-th look at the clock from now throws

  void SetUp() override { fs::create_directory(this->place); }

  // Each subject may have `most` of 1000 partitions.
  std::unique_ptr<QuotaBook> Open(double most, const fs::path& at)
  {
    QuotaLimits limits;
    limits.share = most / 1000;
    limits.window = std::chrono::seconds(100);
    limits.regionsPerMinute = 1;
    auto book = QuotaBook::Open(at, limits,
      [this]
      {
        if (this->throwing > 0 && --this->throwing == 0)
        {
          throw std::bad_alloc();
        }
        return this->time.load();
      });
    EXPECT_TRUE(book) << book.GetError().message;
    return std::move(*book);
  }
  std::unique_ptr<QuotaBook> Open(double most) { return this->Open(most, this->file); }

  static QuotaBook::Taken Take(
    QuotaBook& book, std::uint32_t partition, const std::string& subject = "ann")
  {
    return book.TakePartition(subject, CountedModel{ "m", {}, "1000", 1000 }, partition, 1);
  }
  static QuotaBook::Taken TakeRegion(QuotaBook& book)
  {
    return book.TakeRegion("ann", CountedModel{ "m", {}, "1000", 1000 });
  }
  static bool May(QuotaBook& book, std::uint32_t partition, const std::string& subject = "ann")
  {
    const auto taken = Take(book, partition, subject);
    EXPECT_TRUE(taken) << taken.GetError().message;
    return taken && !*taken;
  }
  static std::string WhyNot(QuotaBook& book, std::uint32_t partition)
  {
    const auto taken = Take(book, partition);
    EXPECT_FALSE(taken);
    return taken ? "" : taken.GetError().message;
  }
};

// Runs `work` on a thread whose mounts no other thread sees. Returns whether the system allows
// this.
template <class Work>
bool WithMounts(const Work& work)
{
  bool may = false;
  std::thread(
    [&]
    {
      may = ::unshare(CLONE_NEWNS) == 0 &&
            ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0;
      if (may)
      {
        work();
      }
    })
    .join();
  return may;
}

// A server in a process of its own, because SQLite shares its knowledge of a file within a process.
class OtherServer
{
public:
  // REQUIRES: no book is open yet, and there is no other thread.
  template <class OpenBook>
  explicit OtherServer(const OpenBook& openBook)
  {
    int ends[2];
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
    this->Process = ::fork();
    if (this->Process == 0)
    {
      ::close(ends[0]);
      {
        const auto book = openBook();
        std::uint32_t partition = 0;
        while (::read(ends[1], &partition, sizeof partition) == sizeof partition)
        {
          const auto taken =
            book->TakePartition("ann", CountedModel{ "m", {}, "1000", 1000 }, partition, 1);
          const char answer = !taken ? 'f' : *taken ? 'n' : 'y';
          if (::write(ends[1], &answer, 1) != 1)
          {
            break;
          }
        }
      }
      ::_exit(0);
    }
    ::close(ends[1]);
    this->End = ends[0];
  }
  OtherServer(const OtherServer&) = delete;
  OtherServer& operator=(const OtherServer&) = delete;
  ~OtherServer() { this->Stop(); }

  // 'y': the subject may have it, 'n': she may not, 'f': the call fails.
  char Take(std::uint32_t partition) const
  {
    char answer = '-';
    EXPECT_EQ(
      ::send(this->End, &partition, sizeof partition, MSG_NOSIGNAL), ssize_t(sizeof partition));
    EXPECT_EQ(::read(this->End, &answer, 1), 1);
    return answer;
  }
  void Stop()
  {
    if (this->Process > 0)
    {
      ::close(this->End);
      ::waitpid(std::exchange(this->Process, 0), nullptr, 0);
    }
  }

private:
  int End = -1;
  pid_t Process = 0;
};

bool MountMemory(const fs::path& folder, const char* options = "size=1m")
{
  return ::mount("none", folder.c_str(), "tmpfs", 0, options) == 0;
}

}

TEST_F(QuotaFile, AFolderThatGoesAndComes)
{
  const auto book = this->Open(3);
  for (std::uint32_t round = 0; round < 3; ++round)
  {
    EXPECT_TRUE(May(*book, round));
    fs::rename(this->place, this->folder / "away");
    for (int i = 0; i < 3; ++i)
    {
      EXPECT_NE(WhyNot(*book, 7), "");
      EXPECT_FALSE(TakeRegion(*book));
    }
    EXPECT_FALSE(fs::exists(this->place));
    fs::rename(this->folder / "away", this->place);
  }
  EXPECT_FALSE(May(*book, 7)) << "all that was had before it went counts";
  EXPECT_TRUE(May(*book, 1));
  EXPECT_FALSE(May(*this->Open(3), 7)) << "in the file, too";
}

TEST_F(QuotaFile, AFolderThatIsRemovedAndMadeAnew)
{
  const auto book = this->Open(2);
  for (int round = 0; round < 2; ++round)
  {
    EXPECT_TRUE(May(*book, 1));
    fs::remove_all(this->place);
    EXPECT_NE(WhyNot(*book, 2), "");
    EXPECT_NE(WhyNot(*book, 2), "");
    fs::create_directory(this->place);
    EXPECT_TRUE(May(*book, 2));
    EXPECT_TRUE(May(*book, 3));
    EXPECT_FALSE(May(*book, 4));
    fs::remove_all(this->place);
    fs::create_directory(this->place);
    EXPECT_EQ(WhyNot(*book, 4),
      "the quota file was removed or replaced: counting starts again with the file of this name");
  }
}

TEST_F(QuotaFile, AnExceptionInATransactionEntersNothing)
{
  const auto book = this->Open(3), other = this->Open(3);
  for (std::uint32_t partition = 0; partition < 3; ++partition)
  {
    this->throwing = 1;
    EXPECT_THROW((void)Take(*book, 100 + partition), std::bad_alloc);
    EXPECT_TRUE(May(*other, partition)) << "nobody is kept waiting";
    EXPECT_TRUE(May(*book, partition)) << "which she has";
    this->throwing = 1;
    EXPECT_THROW((void)TakeRegion(*book), std::bad_alloc);
  }
  EXPECT_FALSE(May(*book, 3));
  EXPECT_FALSE(May(*other, 100));
  EXPECT_FALSE(*TakeRegion(*book)) << "she had none";
  EXPECT_TRUE(*TakeRegion(*other));
  // An exception while the file is opened again.
  fs::rename(this->place, this->folder / "away");
  EXPECT_NE(WhyNot(*book, 1), "");
  fs::rename(this->folder / "away", this->place);
  this->throwing = 1;
  EXPECT_THROW((void)Take(*book, 1), std::bad_alloc);
  EXPECT_TRUE(May(*book, 1));
}

// The file can take no more bytes for a while.
TEST_F(QuotaFile, ADiskThatTakesNoMore)
{
  const auto book = this->Open(900);
  EXPECT_TRUE(May(*book, 0));
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  std::uint32_t had = 1;
  for (int round = 0; round < 3; ++round)
  {
    rlimit limit = before;
    limit.rlim_cur = fs::file_size(this->file.string() + "-wal") + 3 * 4096 + 7;
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
    int failed = 0;
    for (std::uint32_t i = 0; i < 100 && failed < 3; ++i)
    {
      const auto taken = Take(*book, had);
      had += taken ? 1 : 0;
      failed += taken ? 0 : 1;
    }
    EXPECT_EQ(failed, 3);
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
    EXPECT_TRUE(May(*book, had++));
  }
  std::signal(SIGXFSZ, handler);
  std::uint32_t more = 0;
  for (; more < 1000 && May(*book, 10'000 + more); ++more)
  {
  }
  EXPECT_EQ(had + more, 900u);
}

TEST_F(QuotaFile, AFullFileSystem)
{
  const bool may = WithMounts(
    [this]
    {
      if (!MountMemory(this->place, "size=256k"))
      {
        return;
      }
      const auto book = this->Open(900);
      EXPECT_TRUE(May(*book, 0));
      {
        std::ofstream fill(this->place / "fill");
        const std::string block(4096, 'x');
        while (fill.write(block.data(), 4096).flush())
        {
        }
      }
      std::uint32_t had = 1;
      for (int failed = 0; failed < 3 && had < 900;)
      {
        const auto taken = Take(*book, had);
        had += taken ? 1 : 0;
        failed += taken ? 0 : 1;
      }
      fs::remove(this->place / "fill");
      EXPECT_TRUE(May(*book, had++));
      EXPECT_TRUE(May(*book, had - 2)) << "what she has";
    });
  if (!may)
  {
    GTEST_SKIP() << "may not mount";
  }
}

// The log of the earlier file must not be taken for the new file's log.
TEST_F(QuotaFile, AFileThatIsReplacedByAnother)
{
  const auto another = this->place / "another.db";
  {
    const auto book = this->Open(2, another);
    EXPECT_TRUE(May(*book, 50));
  }
  const auto book = this->Open(2), other = this->Open(2);
  EXPECT_TRUE(May(*book, 1));
  EXPECT_TRUE(May(*other, 2));
  EXPECT_TRUE(May(*other, 1, "bob"));
  fs::rename(another, this->file);
  EXPECT_NE(WhyNot(*book, 3).find("replaced"), std::string::npos);
  EXPECT_TRUE(May(*book, 51));
  EXPECT_NE(WhyNot(*other, 3).find("replaced"), std::string::npos);
  EXPECT_TRUE(May(*other, 50));
  EXPECT_FALSE(May(*other, 1)) << "which she had in another file";
  EXPECT_FALSE(May(*book, 1));
  EXPECT_TRUE(May(*this->Open(2), 51)) << "the others' leaving has lost nothing";
  const auto database = OpenForWriting(this->file);
  ASSERT_TRUE(database);
  EXPECT_TRUE(*QueryInteger(
    database->get(), "SELECT count(*) FROM pragma_integrity_check WHERE integrity_check = 'ok'"));
  EXPECT_EQ(*QueryInteger(database->get(), "SELECT sum(count) FROM counts"), 2);
}

TEST_F(QuotaFile, AFileThatIsInvalidForAWhile)
{
  const auto book = this->Open(2);
  EXPECT_TRUE(May(*book, 1));
  const auto kept = this->folder / "kept.db";
  const auto spoil = [&](const std::string& bytes)
  {
    fs::rename(this->file, kept);
    std::ofstream(this->file) << bytes;
    for (int i = 0; i < 3; ++i)
    {
      EXPECT_NE(WhyNot(*book, 2), "");
    }
    EXPECT_EQ(fixtures::ReadWhole(this->file), bytes) << "left as it is";
    fs::rename(kept, this->file);
  };
  spoil(std::string(10'000, 'x'));
  EXPECT_TRUE(May(*book, 1));
  {
    // A truncated quota file.
    const auto bytes = fixtures::ReadWhole(this->file);
    spoil(bytes.substr(0, bytes.size() / 2 + 100));
  }
  EXPECT_TRUE(May(*book, 2));
  EXPECT_FALSE(May(*book, 3));
  {
    // A database with other tables of these names.
    fs::rename(this->file, kept);
    {
      const auto database = OpenForWriting(this->file);
      ASSERT_TRUE(Execute(database->get(), "CREATE TABLE had (anything); CREATE VIEW counts AS "
                                           "SELECT 0 AS subject, 0 AS model, 0 AS count"));
    }
    EXPECT_NE(WhyNot(*book, 3), "");
    EXPECT_NE(WhyNot(*book, 3), "");
    fs::rename(kept, this->file);
  }
  EXPECT_TRUE(May(*book, 2));
  EXPECT_FALSE(May(*book, 3));
}

TEST_F(QuotaFile, PermissionsThatAreTakenAndGivenBack)
{
  const auto book = this->Open(2);
  EXPECT_TRUE(May(*book, 1));
  // Root may do everything, so the test runs as another user.
  const bool isRoot = ::geteuid() == 0;
  constexpr uid_t nobody = 65534;
  for (const auto& each : fs::directory_iterator(this->place))
  {
    ASSERT_TRUE(!isRoot || ::chown(each.path().c_str(), nobody, nobody) == 0);
  }
  fs::permissions(this->folder.Path, fs::perms::group_exec | fs::perms::others_exec,
    fs::perm_options::add); // root stays in the file's group
  ASSERT_TRUE(!isRoot || ::chown(this->place.c_str(), nobody, nobody) == 0);
  struct Back
  {
    const uid_t user = ::geteuid();
    ~Back() { EXPECT_EQ(::seteuid(this->user), 0); }
  } const back;
  ASSERT_TRUE(!isRoot || ::seteuid(nobody) == 0);
  ASSERT_EQ(::chmod(this->place.c_str(), 0), 0);
  EXPECT_NE(WhyNot(*book, 2), "");
  ASSERT_EQ(::chmod(this->place.c_str(), 0700), 0);
  ASSERT_EQ(::chmod(this->file.c_str(), 0400), 0); // read only
  EXPECT_NE(WhyNot(*book, 2), "");
  EXPECT_NE(WhyNot(*book, 2), "");
  ASSERT_EQ(::chmod(this->file.c_str(), 0600), 0);
  EXPECT_TRUE(May(*book, 2));
  EXPECT_FALSE(May(*book, 3));
}

// The folder below an unmounted file system is not a place for quotas. When it is mounted again,
// the earlier entries count, even if it can only be read at first.
TEST_F(QuotaFile, AFileSystemThatIsNotMounted)
{
  const bool may = WithMounts(
    [this]
    {
      const auto disk = this->folder / "disk";
      fs::create_directory(disk);
      if (!MountMemory(disk))
      {
        return;
      }
      const auto mount = [&](unsigned long flags) {
        ASSERT_EQ(::mount(disk.c_str(), this->place.c_str(), nullptr, MS_BIND | flags, nullptr), 0);
      };
      mount(0);
      const auto book = this->Open(2);
      EXPECT_TRUE(May(*book, 1));
      for (int round = 0; round < 2; ++round)
      {
        ASSERT_EQ(::umount2(this->place.c_str(), MNT_DETACH), 0);
        for (int i = 0; i < 2; ++i)
        {
          EXPECT_NE(WhyNot(*book, 2), "");
        }
        EXPECT_TRUE(fs::is_empty(this->place));
        mount(0);
        mount(MS_REMOUNT | MS_RDONLY);
        EXPECT_NE(WhyNot(*book, 2), "");
        EXPECT_NE(WhyNot(*book, 2), "");
        mount(MS_REMOUNT);
        EXPECT_TRUE(May(*book, 1)) << "which she has";
      }
      EXPECT_TRUE(May(*book, 2));
      EXPECT_FALSE(May(*book, 3));
      // A new, empty disk in this place.
      ASSERT_EQ(::umount2(this->place.c_str(), MNT_DETACH), 0);
      EXPECT_NE(WhyNot(*book, 3), "");
      ASSERT_TRUE(MountMemory(this->place));
      EXPECT_TRUE(May(*book, 3));
    });
  if (!may)
  {
    GTEST_SKIP() << "may not mount";
  }
}

// The second server to notice that the file was removed takes nothing from the new file.
TEST_F(QuotaFile, TwoServersLoseNothingWhereItIsRemoved)
{
  const auto book = this->Open(3), other = this->Open(3);
  EXPECT_TRUE(May(*book, 1));
  EXPECT_TRUE(May(*other, 2));
  fs::remove(this->file);
  EXPECT_NE(WhyNot(*book, 3), "");
  EXPECT_TRUE(May(*book, 3));
  EXPECT_TRUE(May(*book, 4));
  EXPECT_NE(WhyNot(*other, 3), "");
  EXPECT_TRUE(May(*other, 5));
  EXPECT_FALSE(May(*other, 6));
  EXPECT_FALSE(May(*book, 6));
  EXPECT_TRUE(May(*this->Open(3), 4));
}

// Opening a new file switches it to a write-ahead log. If another server has the file locked,
// SQLite does not wait for this switch by itself.
TEST_F(QuotaFile, AServerWaitsForAnotherThatOpensTheNewFileToo)
{
  const auto other = OpenForWriting(this->file);
  ASSERT_TRUE(other);
  ASSERT_TRUE(Execute(other->get(), "BEGIN IMMEDIATE"));
  std::thread ends(
    [&]
    {
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
      EXPECT_TRUE(Execute(other->get(), "COMMIT"));
    });
  const auto book = this->Open(8);
  ends.join();
  EXPECT_TRUE(May(*book, 0));
}

// The server that notices that the file is gone removes the log. The other server, which gets no
// request in between, must not continue to use that log.
TEST_F(QuotaFile, TwoServersGiveWhatOneWouldWhereItGoesAndComes)
{
  const auto log = fs::path(this->file.string() + "-wal");
  const auto index = fs::path(this->file.string() + "-shm");
  const auto kept = this->folder / "kept.db";
  const std::function<void()> nothing = [] {};
  struct Round
  {
    const char* what;
    std::function<void()> breaks, repairs;
  };
  const auto repair = [&]
  {
    fs::remove_all(this->file);
    fs::rename(kept, this->file);
  };
  const auto awayAnd = [&](const std::function<void()>& put)
  {
    return [&, put]
    {
      fs::rename(this->file, kept);
      put();
    };
  };
  const Round rounds[] = {
    { "it is moved away and back", awayAnd(nothing), repair },
    { "a folder in its place", awayAnd([&] { fs::create_directory(this->file); }), repair },
    { "a FIFO in its place", awayAnd([&] { EXPECT_EQ(::mkfifo(this->file.c_str(), 0600), 0); }),
      repair },
    { "a device in its place", awayAnd([&] { fs::create_symlink("/dev/zero", this->file); }),
      repair },
    { "another file in its place", awayAnd([&] { std::ofstream(this->file) << "text"; }), repair },
    { "its log is removed", [&] { fs::remove(log); }, nothing },
    { "its index is removed", [&] { fs::remove(index); }, nothing },
    { "both are removed",
      [&]
      {
        fs::remove(log);
        fs::remove(index);
      },
      nothing },
  };
  for (const auto& round : rounds)
  {
    fs::remove_all(this->place);
    fs::create_directory(this->place);
    OtherServer other([this] { return this->Open(8); });
    const auto book = this->Open(8);
    std::set<std::uint32_t> given{ 0, 1 };
    EXPECT_TRUE(May(*book, 0)) << round.what;
    EXPECT_EQ(other.Take(1), 'y') << round.what;
    round.breaks();
    if (const auto taken = Take(*book, 2); taken && !*taken)
    {
      given.insert(2);
    }
    round.repairs();
    for (std::uint32_t i = 0; i < 24; ++i)
    {
      const auto partition = 3 + i / 2; // a second try of each, as one may fail
      const auto ask = [&]
      {
        const auto taken = Take(*book, partition);
        return taken && !*taken;
      };
      if (i % 4 < 2 ? ask() : other.Take(partition) == 'y')
      {
        given.insert(partition);
      }
    }
    EXPECT_EQ(given.size(), 8u) << round.what;
    other.Stop();
    const auto database = OpenForWriting(this->file);
    ASSERT_TRUE(database) << round.what;
    EXPECT_EQ(*QueryInteger(database->get(), "SELECT count(*) FROM had"), 8) << round.what;
    EXPECT_EQ(*QueryInteger(database->get(),
                "SELECT count(*) FROM pragma_integrity_check WHERE integrity_check = 'ok'"),
      1)
      << round.what;
  }
}
