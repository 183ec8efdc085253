// SPDX-License-Identifier: BSD-3-Clause
// A file system for SQLite in which a file is named by an open descriptor, so that all connections
// to a store read the same file, whatever its path names meanwhile. No other file is opened: a
// database that is written to needs a journal in memory. Nothing is locked.
// Only for Sqlite.cxx.
#pragma once

namespace kdstream
{

// The name to open a database with ("vfs"); the descriptor is the URI's parameter "descriptor". It
// stays open as long as the database, and is not closed with it. Null where SQLite has no memory.
const char* DescriptorVfs();

}
