// SPDX-License-Identifier: BSD-3-Clause
// The record of a program's operations on files, in order. The fault library writes it, and
// PowerCut.h derives from it what a power cut would have left.
#pragma once

#include <cstdint>

namespace kdstream
{

enum class FileAction : std::uint8_t
{
  Make,       // a file: path, inode
  MakeFolder, // path, inode
  Write,      // inode, offset, data
  Size,       // inode; offset: the new size
  Rename,     // path, path2
  Link,       // path2 is another name of the inode
  Remove,     // path: a file or an empty folder
  Sync        // inode: a file or a folder
};

// After this come the two paths (absolute) and the data.
struct FileRecord
{
  FileAction action{};
  std::uint32_t pathBytes = 0, path2Bytes = 0;
  std::uint64_t inode = 0, offset = 0, dataBytes = 0;
};

}
