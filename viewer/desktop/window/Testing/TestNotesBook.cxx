// SPDX-License-Identifier: BSD-3-Clause
#include "viewer/desktop/window/NotesBook.h"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <string>
#include <vector>

using namespace kdstream;

namespace
{

const std::vector<Note> two{ { "One", "first", "model=elsewhere&view=AX9&turning=free", "de" },
  { "Two", "", "" } };

TEST(TestNotesBook, ViewsAreOfTheModelThatIsOpen)
{
  NotesBook book;
  book.Open("dragon", two);
  EXPECT_FALSE(book.Shown());
  EXPECT_EQ(book.Show(0), "model=dragon&view=AX9&turning=free");
  EXPECT_EQ(book.Shown(), 0u);
  EXPECT_EQ(book.Show(1), "model=dragon");
  book.ShowList();
  EXPECT_FALSE(book.Shown());
  EXPECT_FALSE(book.HasUnsaved());
}

TEST(TestNotesBook, WhatIsWrittenStaysUntilItIsSaved)
{
  NotesBook book;
  book.Open("dragon", two);
  ASSERT_TRUE(book.Keep({}, "  Three \n", "third", "model=dragon&view=B"));
  ASSERT_TRUE(book.Keep(0, "One more", "", "not taken"));
  book.Open("vase", {});
  EXPECT_TRUE(book.Notes().empty());
  EXPECT_FALSE(book.IsUnsaved());
  EXPECT_TRUE(book.HasUnsaved());
  book.Open("dragon", two);
  EXPECT_TRUE(book.IsUnsaved());
  const std::vector<Note> written{ { "One more", "", two[0].link, "de" }, two[1],
    { "Three", "third", "model=dragon&view=B" } };
  EXPECT_EQ(book.Notes(), written);
  book.Saved();
  EXPECT_FALSE(book.HasUnsaved());
  EXPECT_EQ(book.Notes(), written);
}

TEST(TestNotesBook, WhatNotesMayNotBeIsNotKept)
{
  NotesBook book;
  book.Open("dragon", two);
  const auto wrong = [&](const std::string& title, const std::string& text, const std::string& link)
  {
    const Status kept = book.Keep({}, title, text, link);
    return kept ? "kept" : kept.GetError().message;
  };
  EXPECT_EQ(wrong(" \t\n", "", ""), "a note needs a title");
  std::string longest; // lengths count characters, not bytes
  for (std::size_t i = 0; i < Note::longestTitle; ++i)
  {
    longest += "é";
  }
  EXPECT_EQ(wrong(longest + "é", "", ""), "a title may have at most 200 characters");
  EXPECT_EQ(wrong("a", std::string(Note::longestText + 1, 'x'), ""),
    "a note may have at most 4000 characters");
  EXPECT_EQ(wrong("a", "", std::string(Note::longestLink + 1, 'x')),
    "this view has too many distances for a note: remove some");
  EXPECT_EQ(book.Notes(), two);
  EXPECT_FALSE(book.IsUnsaved());

  EXPECT_EQ(wrong(longest, "\xff", ""), "kept");
  EXPECT_EQ(book.Notes().back().text, "\xEF\xBF\xBD") << "no UTF-8";
  while (book.Notes().size() < mostNotes)
  {
    ASSERT_EQ(wrong("a", "", ""), "kept");
  }
  EXPECT_EQ(wrong("a", "", ""), "a model can have at most 100 notes");
  EXPECT_TRUE(book.Keep(99, "b", "", "")) << "an old one changes";
}

// Whatever an author does, the resulting notes are valid for a server.
TEST(TestNotesBook, WhateverIsDoneCanBeServed)
{
  std::mt19937 random(20261125);
  const auto any = [&](std::size_t below)
  { return std::uniform_int_distribution<std::size_t>(0, below - 1)(random); };
  NotesBook book;
  book.Open("dragon", two);
  std::multiset<std::string> titles{ "One", "Two" };
  for (int i = 0; i < 2000; ++i)
  {
    const std::size_t count = book.Notes().size();
    const std::size_t at = count == 0 ? 0 : any(count);
    switch (any(count == 0 ? 1 : 4))
    {
      case 0:
        if (book.Keep({}, "n" + std::to_string(i), std::string(any(40), '<'), "model=dragon"))
        {
          titles.insert("n" + std::to_string(i));
        }
        break;
      case 1:
        book.Move(at, any(2) == 0 ? -1 : 1);
        break;
      case 2:
        titles.erase(titles.find(book.Notes()[at].title));
        book.Remove(at);
        break;
      default:
        book.Show(at);
    }
    std::multiset<std::string> now;
    for (const Note& note : book.Notes())
    {
      now.insert(note.title);
    }
    ASSERT_EQ(now, titles) << i;
    const auto served = ParseNotes(FormatNotes(book.Notes()));
    ASSERT_TRUE(served) << served.GetError().message;
    ASSERT_EQ(*served, book.Notes());
    ASSERT_TRUE(!book.Shown() || *book.Shown() < book.Notes().size());
  }
}

}
