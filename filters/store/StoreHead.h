// SPDX-License-Identifier: BSD-3-Clause
// Checks the first page of a store's file before SQLite reads it: a store is data, but an SQLite
// schema can contain programs (views, triggers, expressions). Only for filters/store.
#pragma once

#include "filters/core/Result.h"

namespace kdstream
{

// Checks that the file is a store of a readable version: the header is that of a store; the schema
// has exactly the tables of StoreSchema.h, all in the first page; the table of metadata has at most
// one row. Reads two pages, whatever the file claims. Returns the version. Errors: InvalidInput if
// it is not a store, naming what it contains instead; Unsupported for another version; Damaged if a
// table is missing or a page is malformed; InputOutput if it cannot be read.
Result<int> CheckStoreHead(int descriptor);

}
