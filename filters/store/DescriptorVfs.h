// SPDX-License-Identifier: BSD-3-Clause
// A file system for SQLite in which a file is named by an open descriptor, so that all connections
// to a store read the same file, whatever its path names meanwhile. No other file is opened: a
// database that is written to needs a journal in memory. There are no locks. Only for Sqlite.cxx.
#pragma once

namespace kdstream
{

// The name for opening a database ("vfs"); the descriptor is the URI's parameter "descriptor". It
// must stay open as long as the database, and is not closed with it. Null if SQLite has no memory.
const char* DescriptorVfs();

}
