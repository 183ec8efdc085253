// SPDX-License-Identifier: BSD-3-Clause
// What a program has done to files, in order: the fault library records it, and PowerCut.h finds
// from it what a power cut would have left.
#pragma once

#include <cstdint>

namespace kdstream
{

enum class FileAction : std::uint8_t
{
  Make,       // of a file: path, inode
  MakeFolder, // path, inode
  Write,      // inode, offset, data
  Size,       // inode; offset: the new size
  Rename,     // path, path2
  Link,       // path2 is a further name of the inode
  Remove,     // path: of a file or an empty folder
  Sync        // inode: of a file or a folder
};

// Then come the two paths (absolute) and the data.
struct FileRecord
{
  FileAction action{};
  std::uint32_t pathBytes = 0, path2Bytes = 0;
  std::uint64_t inode = 0, offset = 0, dataBytes = 0;
};

}
