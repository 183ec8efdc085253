// SPDX-License-Identifier: BSD-3-Clause
// The first page of a store's file, which is checked before SQLite reads any of it: a store is
// data, and its schema would be a program (views, triggers, expressions). Only for filters/store.
#pragma once

#include "filters/core/Result.h"

namespace kdstream
{

// Checks that the file is a store of a readable version: its header is that of a store; its schema
// has the tables of StoreSchema.h to the letter and nothing else, all in the first page; the table
// of metadata has at most one row. Reads two pages, whatever the file claims. Returns the version.
// Errors: InvalidInput where it is not a store, naming what it has; Unsupported for another
// version; Damaged where a table is missing, or a page is malformed; InputOutput where it cannot be
// read.
Result<int> CheckStoreHead(int descriptor);

}
