// SPDX-License-Identifier: BSD-3-Clause
// Everything that a document or a comment refers to exists.
#include "Testing/Documents/References.h"

#include <gtest/gtest.h>

namespace
{

using namespace kdstream;

// A small tree in which all references are correct, with one more file that contains `text`.
SourceTree TreeWith(const std::string& path, const std::string& text)
{
  SourceTree tree;
  tree.texts = { { "doc/guide.md",
                   "# Guide\n\n## 1. The cut rule\n\n**Symbols.** A state.\n\n"
                   "<a id=\"old-name\"></a>\n```\n# no heading\n```\n## ./dev\n## ./dev\n" },
    { "doc/decisions/0007-order.md", "# 7. Order\n" },
    { "CMakeLists.txt", "add_test(NAME TestOrder)" }, { "filters/core/Piece.h", "// A piece.\n" } };
  tree.texts[path] = text;
  for (const auto& [file, content] : tree.texts)
  {
    for (std::filesystem::path part = file; !part.empty(); part = part.parent_path())
    {
      tree.paths.insert(part.string());
    }
  }
  return tree;
}

std::vector<std::string> DeadIn(const std::string& path, const std::string& text)
{
  return FindDeadReferences(TreeWith(path, text));
}

TEST(References, AnchorsAreThoseOfGitHub)
{
  EXPECT_EQ(AnchorOfHeading("7. The cut rule"), "7-the-cut-rule");
  EXPECT_EQ(AnchorOfHeading("./dev"), "dev");
  EXPECT_EQ(AnchorOfHeading("`--resume`, and more"), "--resume-and-more");
}

TEST(References, ThatLeadSomewhereAreFound)
{
  for (const char* text :
    { "[rule](guide.md#1-the-cut-rule)", "[old](guide.md#old-name) [here](#title)\n# Title",
      "[twice](guide.md#dev-1)", "[folder](decisions/)", "[out](https://example.org/x.md#y)",
      "`[no link](nowhere.md)`", "```\n[no link](nowhere.png)\n```",
      "[up](../filters/core/Piece.h)", "`filters/core/Piece.h`, Piece.h, core/Piece.h",
      "doc/decisions/0007-order.md, guide.md", "[guide.md](guide.md)", "decision 7", "TestOrder",
      "a Test of ours", "filters/core/*.h and filters/core/Pie{ce,t}.h", "Data/models/dragon.ply" })
  {
    EXPECT_EQ(DeadIn("doc/page.md", text), std::vector<std::string>{}) << text;
  }
  for (const char* text : { "// See doc/guide.md.", "// (doc/guide.md#1-the-cut-rule).",
         "// Layout:\n  // doc/guide.md,\n  // section 1.",
         "/**\n * doc/guide.md,\n * \"Symbols\".\n */", "// doc/guide.md (sections 1 to 3)",
         "int a; // decision 7", "const char* a = \"x.md\";" })
  {
    EXPECT_EQ(DeadIn("filters/core/New.h", text), std::vector<std::string>{}) << text;
  }
}

TEST(References, ThatLeadNowhereAreNamedWithTheirLine)
{
  const std::pair<const char*, const char*> inDocuments[] = {
    { "\n[x](nowhere.md)", "doc/page.md:2: link to nowhere.md: there is no doc/nowhere.md" },
    { "![x](pictures/x.png)",
      "doc/page.md:1: link to pictures/x.png: there is no doc/pictures/x.png" },
    { "[x](guide.md#no-heading)", "doc/page.md:1: doc/guide.md has no heading for #no-heading" },
    { "[x](#here)", "doc/page.md:1: doc/page.md has no heading for #here" },
    { "`filters/core/Gone.h`", "doc/page.md:1: there is no filters/core/Gone.h" },
    { "in filters/gone", "doc/page.md:1: there is no filters/gone" },
    { "a file tree/Piece.h", "doc/page.md:1: there is no tree/Piece.h" },
    { "a file Gone.cxx", "doc/page.md:1: there is no Gone.cxx" },
    { "a\n\nTestGone", "doc/page.md:3: there is no test TestGone" },
    { "see\ndecision 8", "doc/page.md:2: there is no decision 8" },
    { "[decision 9](guide.md)", "doc/page.md:1: there is no decision 9" },
    { "see CLI.md", "doc/page.md:1: there is no CLI.md" }
  };
  for (const auto& [text, dead] : inDocuments)
  {
    EXPECT_EQ(DeadIn("doc/page.md", text), std::vector<std::string>{ dead }) << text;
  }
  const std::pair<const char*, const char*> inSources[] = {
    { "// CLI.md", "filters/core/New.h:1: there is no CLI.md" },
    { "\n// a (doc/gone.md)", "filters/core/New.h:2: there is no doc/gone.md" },
    { "int a; // doc/guide.md#gone.",
      "filters/core/New.h:1: doc/guide.md has no heading for #gone" },
    { "// doc/guide.md,\n// section 4", "filters/core/New.h:1: doc/guide.md has no section 4" },
    { "/**\n * doc/guide.md, \"States\"\n */",
      "filters/core/New.h:2: doc/guide.md has no \"States\"" },
    { "// As Gone.h does.", "filters/core/New.h:1: there is no Gone.h" },
    { "// decision 12", "filters/core/New.h:1: there is no decision 12" },
    { "// (DESIGN\n// section 4)",
      "filters/core/New.h:1: DESIGN is not a document of this tree: doc/design.md#… is" }
  };
  for (const auto& [text, dead] : inSources)
  {
    EXPECT_EQ(DeadIn("filters/core/New.h", text), std::vector<std::string>{ dead }) << text;
  }
  EXPECT_EQ(DeadIn("cmake/New.cmake", "x() # doc/gone.md").size(), 1U);
}

TEST(Documents, ReferToWhatIsThere)
{
  SourceTree tree = ReadSourceTree(KDSTREAM_SOURCE_TREE);
  tree.texts.erase("Testing/Documents/TestDocuments.cxx"); // its examples lead nowhere
  ASSERT_TRUE(tree.texts.count("README.md"));
  ASSERT_GT(tree.texts.size(), 500U) << "not the tree of this project";
  for (const std::string& dead : FindDeadReferences(tree))
  {
    ADD_FAILURE() << dead;
  }
}

}
