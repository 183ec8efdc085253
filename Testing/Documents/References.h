// SPDX-License-Identifier: BSD-3-Clause
// Finds references in documents and comments that lead nowhere, for TestDocuments: links,
// citations, names of files and of tests.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace kdstream
{

// The files of a source tree, by their paths from its root ("doc/design.md").
struct SourceTree
{
  std::map<std::string, std::string> texts; // of documents, sources and build files
  std::set<std::string> paths;              // of all files, and of their folders
};

// Reads the files of a clone; leaves out build folders and files that scripts fetch.
SourceTree ReadSourceTree(const std::filesystem::path& root);

// The anchor of a heading, as GitHub makes it: "7. The cut rule" becomes "7-the-cut-rule".
std::string AnchorOfHeading(const std::string& heading);

// The references that lead nowhere, one line for each: "doc/cli.md:12: …".
//
// In documents (Markdown), links [text](target) are checked: the file, and the anchor in it. In
// documents and in comments of sources these references are checked:
//   - files and folders of the tree, by their path or the end of it; sources also by only their
//     name;
//   - tests by their name;
//   - documents by their path, which sources give from the root. After the path there may be
//     "#anchor", ", section 3", or a title in quotes: a heading, or the bold words that begin a
//     line;
//   - decisions by their number.
std::vector<std::string> FindDeadReferences(const SourceTree& tree);

}
