// SPDX-License-Identifier: BSD-3-Clause
// Notes beside a store: they are written completely or not at all, and no file of that name can
// block a reader.
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/store/StoreNotes.h"

#include <gtest/gtest.h>

#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <string>

using namespace kdstream;

namespace
{

namespace fs = std::filesystem;

class TestStoreNotes : public testing::Test
{
protected:
  Error Wrong() const
  {
    const auto notes = ReadNotes(this->File);
    return notes ? Error{ ErrorCode::Cancelled, "they were read" } : notes.GetError();
  }
  const fixtures::TemporaryFolder Folder;
  const fs::path File = NotesFileOf(this->Folder / "dragon.1.kds");
};

TEST_F(TestStoreNotes, WhatWasWrittenIsRead)
{
  EXPECT_EQ(this->File, this->Folder / "dragon.1.notes.json");
  EXPECT_EQ(this->Wrong().code, ErrorCode::NotFound);
  const std::vector<Note> notes{ { "One", "A\ntext", "model=dragon", "de" }, { "Two", "", "" } };
  for (const auto& each : { notes, std::vector<Note>{}, std::vector<Note>{ notes[1] } })
  {
    ASSERT_TRUE(WriteNotes(this->File, each));
    const auto read = ReadNotes(this->File);
    ASSERT_TRUE(read) << read.GetError().message;
    EXPECT_EQ(read->notes, each);
    EXPECT_EQ(std::string(read->bytes.begin(), read->bytes.end()), FormatNotes(each));
  }
  EXPECT_EQ(this->Folder.Names().size(), 1U) << "and nothing beside it";
}

TEST_F(TestStoreNotes, WhatCannotBeWrittenLeavesWhatWas)
{
  const std::vector<Note> notes{ { "One", "", "" } };
  ASSERT_TRUE(WriteNotes(this->File, notes));
  const std::vector<Note> many(mostNotes, { "Long", std::string(Note::longestText, 'x'), "" });
  const Status tooLong = WriteNotes(this->File, many);
  ASSERT_FALSE(tooLong);
  EXPECT_EQ(tooLong.GetError().code, ErrorCode::LimitExceeded);
  EXPECT_EQ(ReadNotes(this->File)->notes, notes);

  const Status noFolder = WriteNotes(this->Folder / "none/a.notes.json", notes);
  EXPECT_TRUE(fixtures::FailsAt(noFolder, ErrorCode::InputOutput));

  fs::create_directories(this->Folder / "b.notes.json/full");
  const Status folder = WriteNotes(this->Folder / "b.notes.json", notes);
  ASSERT_FALSE(folder);
  EXPECT_NE(folder.GetError().message.find("cannot be written: "), std::string::npos);
  EXPECT_FALSE(fs::exists(this->Folder / "b.notes.json.new"));
}

TEST_F(TestStoreNotes, NoLinkBesideThemIsFollowedAndTheyStayPrivate)
{
  std::ofstream(this->Folder / "victim") << "precious";
  const fs::path planted = this->File.string() + ".new";
  fs::create_symlink("victim", planted);
  const std::vector<Note> notes{ { "One", "", "" } };
  ASSERT_TRUE(WriteNotes(this->File, notes));
  ASSERT_EQ(::chmod(this->File.c_str(), 0600), 0);
  ASSERT_TRUE(WriteNotes(this->File, notes));
  struct stat state = {};
  ASSERT_EQ(::stat(this->File.c_str(), &state), 0);
  EXPECT_EQ(state.st_mode & 0777, 0600U);
  EXPECT_EQ(fixtures::ReadWhole(this->Folder / "victim"), "precious");
  EXPECT_TRUE(fs::is_symlink(planted));
}

TEST_F(TestStoreNotes, InvalidValuesAreRefused)
{
  std::ofstream(this->File) << "[]";
  EXPECT_EQ(this->Wrong().code, ErrorCode::InvalidInput);
  std::ofstream(this->File) << std::string(maximumNotesBytes + 1, ' ');
  EXPECT_EQ(this->Wrong().code, ErrorCode::LimitExceeded);
  fs::remove(this->File);
  fs::create_directory(this->File);
  EXPECT_EQ(this->Wrong().code, ErrorCode::InvalidInput);
  fs::remove(this->File);
  ASSERT_EQ(::mkfifo(this->File.c_str(), 0600), 0); // nobody writes to it
  EXPECT_EQ(this->Wrong().code, ErrorCode::InvalidInput);
}

}
