// SPDX-License-Identifier: BSD-3-Clause
// TextLines: lines end as editors of all systems end them; texts begin and end as these write them.
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/meshio/TextLines.h"

#include <gtest/gtest.h>

namespace kdstream::test
{
namespace
{

struct Lines
{
  std::vector<std::string> lines;
  std::uint64_t padding = 0;
  std::string error;
};

// Reads the lines twice; the second time after Restart.
Lines ReadLines(const std::string& bytes)
{
  const fixtures::TemporaryFolder folder;
  Result<ByteSource> source = ByteSource::Open(folder.Write("t.txt", bytes));
  EXPECT_TRUE(source);
  TextLines text(std::move(*source));
  Lines read;
  for (int round = 0; round < 2; ++round)
  {
    const std::vector<std::string> before = std::move(read.lines);
    read.lines.clear();
    for (;;)
    {
      const Result<bool> more = text.Next();
      if (!more)
      {
        read.error = more.GetError().message;
        return read;
      }
      if (!*more)
      {
        break;
      }
      read.lines.emplace_back(text.Line());
      EXPECT_EQ(text.Number(), read.lines.size());
    }
    EXPECT_TRUE(round == 0 || before == read.lines);
    text.Restart();
  }
  read.padding = text.Padding();
  return read;
}

const std::vector<std::string> three{ "v 1", "", "v 2 # \xC3\xA4" };

}

TEST(TextLines, EndAsOnAnySystem)
{
  for (const std::string end : { "\n", "\r\n", "\r" })
  {
    SCOPED_TRACE(end.size());
    const std::string text = three[0] + end + end + three[2];
    EXPECT_EQ(ReadLines(text).lines, three);
    EXPECT_EQ(ReadLines(text + end).lines, three);
    EXPECT_EQ(ReadLines("\xEF\xBB\xBF" + text + end).lines, three);
    EXPECT_EQ(ReadLines(text + end + "\x1A").lines, three);
    EXPECT_EQ(ReadLines(text + end + "\x1A" + end).lines, three);
    EXPECT_EQ(ReadLines(text + end + "\x1A").padding, 0U);
    const Lines padded = ReadLines(text + end + std::string(5000, '\0'));
    EXPECT_EQ(padded.lines, three);
    EXPECT_EQ(padded.padding, 5000U);
  }
  EXPECT_EQ(ReadLines("a\rb\r\nc\nd").lines, (std::vector<std::string>{ "a", "b", "c", "d" }));
  EXPECT_TRUE(ReadLines("").lines.empty());
  EXPECT_TRUE(ReadLines("\xEF\xBB\xBF").lines.empty());
  EXPECT_TRUE(ReadLines("\x1A").lines.empty());
}

TEST(TextLines, OfSeveralBlocks)
{
  for (const std::string end : { "\n", "\r\n", "\r" })
  {
    std::string text;
    std::vector<std::string> lines;
    for (std::size_t i = 0; i < 200000; ++i)
    {
      lines.push_back(std::string(i % 23, 'x') + std::to_string(i));
      text += lines.back() + end;
    }
    Lines read = ReadLines("\xEF\xBB\xBF" + text + "\x1A");
    if (end == "\r\n")
    {
      EXPECT_TRUE(read.lines == lines);
    }
    std::erase(read.lines, "");
    EXPECT_TRUE(read.lines == lines);
  }
}

TEST(TextLines, WideTextIsNamed)
{
  const std::string named =
    "is text in UTF-16 or UTF-32, two or four bytes a character: save it as UTF-8 or ASCII";
  using namespace std::string_literals;
  EXPECT_EQ(ReadLines("\xFF\xFEv\0 \0001\0"s).error, named);
  EXPECT_EQ(ReadLines("\xFE\xFF\0v\0 \0001"s).error, named);
  EXPECT_EQ(ReadLines("v\0 \0001\0\n\0v\0"s).error, named);
  EXPECT_EQ(ReadLines("v 1 2 3\n").error, "");
}

}
