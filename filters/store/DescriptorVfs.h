// SPDX-License-Identifier: BSD-3-Clause
// A file system for SQLite in which an open descriptor names a file. So all connections to a store
// read the same file, even if its path names another one meanwhile. No other file is opened: a
// database that is written to needs a journal in memory. There are no locks. Only for Sqlite.cxx.
#pragma once

namespace kdstream
{

// The name with which to open a database ("vfs"); the descriptor is the URI's parameter
// "descriptor". The descriptor must stay open as long as the database, and is not closed with it.
// Returns null if SQLite has no memory.
const char* DescriptorVfs();

}
