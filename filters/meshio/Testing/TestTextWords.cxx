// SPDX-License-Identifier: BSD-3-Clause
// TextWords: finds the words of a text, wherever the blocks of the file end.
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/meshio/Testing/RandomGenerator.h"
#include "filters/meshio/TextWords.h"

#include <gtest/gtest.h>

namespace kdstream::test
{

TEST(TextWords, GivesAllWordsAndSkipsLines)
{
  const fixtures::TemporaryFolder folder;
  for (unsigned seed = 0; seed < 20; ++seed)
  {
    SCOPED_TRACE(seed);
    RandomGenerator generator(seed);
    std::string text;
    std::vector<std::string> words;
    // Sizes from a few bytes to more than two blocks, so that words and gaps cross the ends of
    // blocks.
    const std::size_t size = generator.Pick(5 * ByteSource::blockSize / 2);
    while (text.size() < size)
    {
      const std::uint64_t most = generator.Chance(0.01) ? TextWords::longestWord : 9;
      words.push_back(
        std::string(1 + generator.Pick(most), static_cast<char>('!' + generator.Pick(90))));
      text += words.back();
      text += std::string(1 + generator.Pick(generator.Chance(0.001) ? ByteSource::blockSize : 3),
        generator.PickOf({ " ", "\t", "\v" })[0]);
      if (generator.Chance(0.1))
      {
        words.push_back("LINE");
        text += "LINE  is skipped " + std::string(generator.Pick(40), 's') +
                generator.PickOf({ "\n", "\r" });
      }
    }
    text += seed % 2 == 0 ? "end" : "";
    if (seed % 2 == 0)
    {
      words.push_back("end");
    }
    Result<ByteSource> source = ByteSource::Open(folder.Write("text", text));
    ASSERT_TRUE(source);
    TextWords reader(*source);
    for (const bool again : { false, true })
    {
      for (const std::string& word : words)
      {
        const Result<std::string_view> next = reader.Next();
        ASSERT_TRUE(next);
        ASSERT_EQ(*next, word);
        ASSERT_EQ(text.compare(reader.Position() - word.size(), word.size(), word), 0);
        ASSERT_TRUE(word != "LINE" || reader.SkipLine());
      }
      EXPECT_TRUE(reader.Next()->empty());
      EXPECT_TRUE(reader.Next()->empty()) << "the end stays";
      EXPECT_TRUE(again || reader.Position() == text.size());
      reader.Seek(0);
    }
  }
}

TEST(TextWords, CutsInvalidWords)
{
  const fixtures::TemporaryFolder folder;
  const std::string text(3 * TextWords::longestWord, 'x');
  Result<ByteSource> source = ByteSource::Open(folder.Write("text", text));
  ASSERT_TRUE(source);
  TextWords reader(*source);
  EXPECT_EQ(reader.Next()->size(), TextWords::longestWord + 1);
  EXPECT_EQ(reader.Next()->size(), TextWords::longestWord + 1) << "from what is in memory";
  EXPECT_EQ(reader.Next()->size(), TextWords::longestWord - 2);
  EXPECT_TRUE(reader.Next()->empty());
  reader.Seek(0);
  EXPECT_EQ(reader.Next()->size(), TextWords::longestWord + 1);
  EXPECT_TRUE(reader.SkipLine());
  EXPECT_TRUE(reader.Next()->empty());
}

}
