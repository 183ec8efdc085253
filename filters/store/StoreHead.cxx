// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. Check the header of the file.
// 2. Check each row of the schema, which must be a table of a store.
// 3. Check that no table is missing.
// 4. Check that the page of the metadata has one row.
// The meaning of the bytes: https://sqlite.org/fileformat2.html, sections 1.3, 1.6, 2.1 and 2.6.
#include "filters/store/StoreHead.h"

#include "filters/core/SystemReason.h"
#include "filters/core/Texts.h"
#include "filters/store/StoreSchema.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{
namespace
{

constexpr std::size_t headerBytes = 100;
constexpr std::uint8_t tableLeaf = 0x0D, indexLeaf = 0x0A; // kinds of a page

using PageBytes = std::array<std::uint8_t, mostStorePageBytes>;
using Bytes = std::span<const std::uint8_t>;

Error NotAStore(const std::string& why)
{
  return { ErrorCode::InvalidInput, "not a KdStream store: " + why };
}

Error DamagedPage()
{
  return { ErrorCode::Damaged, "its first page is damaged or incomplete" };
}

std::string InQuotes(std::string_view name)
{
  std::string quoted = Quoted(name);
  quoted.front() = quoted.back() = '\'';
  return quoted;
}

// Reads the bytes from `begin` on: at most those of the largest page, fewer at the end of the file.
Result<Bytes> ReadBytes(int descriptor, std::uint64_t begin, PageBytes& page)
{
  std::size_t end = 0;
  while (end < page.size())
  {
    const ssize_t got =
      ::pread(descriptor, page.data() + end, page.size() - end, static_cast<off_t>(begin + end));
    if (got < 0 && errno != EINTR)
    {
      return SystemError("cannot be read or written", errno);
    }
    if (got == 0)
    {
      break;
    }
    end += got > 0 ? static_cast<std::size_t>(got) : 0;
  }
  return Bytes(page).first(end);
}

// A number of `size` bytes, the highest byte first. REQUIRES: the bytes exist.
std::uint32_t NumberAt(Bytes bytes, std::size_t at, std::size_t size)
{
  std::uint32_t number = 0;
  for (const std::uint8_t byte : bytes.subspan(at, size))
  {
    number = number << 8 | byte;
  }
  return number;
}

// Returns the version.
Result<int> CheckHeader(Bytes page)
{
  constexpr std::string_view magic{ "SQLite format 3\0", 16 };
  if (page.size() < headerBytes ||
      !std::equal(magic.begin(), magic.end(), page.begin(),
        [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; }) ||
      NumberAt(page, 68, 4) != storeApplicationId)
  {
    return Error{ ErrorCode::InvalidInput, "not a KdStream store" };
  }
  const std::uint32_t version = NumberAt(page, 60, 4);
  if (version < oldestStoreVersion || version > newestStoreVersion)
  {
    return Error{ ErrorCode::Unsupported,
      "store version " + std::to_string(static_cast<std::int32_t>(version)) +
        "; this program reads versions " + std::to_string(oldestStoreVersion) + " to " +
        std::to_string(newestStoreVersion) +
        (version > newestStoreVersion ? ": a newer KdStream wrote it; update this one"
                                      : ": build the store again") };
  }
  const std::size_t pageBytes = PageBytesOfStore(static_cast<int>(version));
  if (NumberAt(page, 16, 2) != pageBytes || page[20] != 0)
  {
    return NotAStore(
      "its page size is not that of a store, " + std::to_string(pageBytes) + " bytes");
  }
  if (page[18] != 1 || page[19] != 1)
  {
    return NotAStore("it uses a write-ahead log");
  }
  if (NumberAt(page, 56, 4) != 1)
  {
    return NotAStore("its text encoding is not UTF-8");
  }
  if (NumberAt(page, 52, 4) != 0 || NumberAt(page, 64, 4) != 0)
  {
    return NotAStore("it uses auto-vacuum");
  }
  return static_cast<int>(version);
}

// Takes numbers and bytes from the beginning of a span, as long as there are enough.
class Taker
{
public:
  explicit Taker(Bytes bytes)
    : Left(bytes)
  {
  }
  // Seven bits of each byte, the highest first; all eight bits of a ninth byte.
  std::optional<std::uint64_t> Varint()
  {
    std::uint64_t number = 0;
    for (std::size_t i = 0; i < std::min<std::size_t>(9, this->Left.size()); ++i)
    {
      const std::uint8_t byte = this->Left[i];
      number = i == 8 ? number << 8 | byte : number << 7 | (byte & 0x7F);
      if (i == 8 || byte < 0x80)
      {
        this->Left = this->Left.subspan(i + 1);
        return number;
      }
    }
    return {};
  }
  std::size_t BytesLeft() const { return this->Left.size(); }
  std::optional<Bytes> Take(std::uint64_t count)
  {
    if (count > this->Left.size())
    {
      return {};
    }
    const Bytes taken = this->Left.first(static_cast<std::size_t>(count));
    this->Left = this->Left.subspan(taken.size());
    return taken;
  }

private:
  Bytes Left;
};

// A row of the schema.
struct SchemaRow
{
  std::string_view type, name, table, sql;
  std::uint32_t page = 0; // root page of the table; 0 if it has none
};

constexpr std::size_t schemaColumns = 5; // type, name, tbl_name, rootpage, sql

// How many bytes a value of a type takes; nothing if there is no such type.
std::optional<std::uint64_t> SizeOfSerial(std::uint64_t type)
{
  constexpr std::array<std::uint64_t, 10> ofNumbers{ 0, 1, 2, 3, 4, 6, 8, 8, 0, 0 };
  if (type < ofNumbers.size())
  {
    return ofNumbers[type];
  }
  return type < 12 ? std::nullopt : std::optional((type - 12) / 2);
}

std::string_view TextOf(std::uint64_t type, Bytes value)
{
  const bool isText = type >= 13 && type % 2 == 1;
  return isText ? std::string_view(reinterpret_cast<const char*>(value.data()), value.size())
                : std::string_view();
}

// The number in a value; 0 if it is negative or not a number.
std::uint32_t NumberOf(std::uint64_t type, Bytes value)
{
  const bool isSmall = type >= 1 && type <= 4 && value[0] < 0x80;
  return isSmall ? NumberAt(value, 0, value.size()) : type == 9 ? 1 : 0;
}

// Returns nothing if the bytes do not begin with the type and the name of a row of a schema. The
// other columns are set only if the row is completely in the page, and SQLite reads it in the same
// way.
std::optional<SchemaRow> RowOfCell(Bytes cell, std::size_t pageBytes)
{
  const std::uint64_t mostInPage = pageBytes - 35; // the rest of a longer row is in other pages
  Taker taker(cell);
  const auto payload = taker.Varint();
  const auto rowid = taker.Varint();
  const std::size_t before = taker.BytesLeft();
  const auto head = taker.Varint();
  if (!payload || !rowid || !head)
  {
    return {};
  }
  std::array<std::uint64_t, schemaColumns> types;
  for (std::uint64_t& type : types)
  {
    const auto taken = taker.Varint();
    if (!taken)
    {
      return {};
    }
    type = *taken;
  }
  const bool isHeadWhole = before - taker.BytesLeft() == *head;
  std::array<Bytes, schemaColumns> values;
  std::size_t taken = 0;
  for (; taken < schemaColumns; ++taken)
  {
    const auto size = SizeOfSerial(types[taken]);
    const auto value = size ? taker.Take(*size) : std::nullopt;
    if (!value)
    {
      break;
    }
    values[taken] = *value;
  }
  if (taken < 2)
  {
    return {};
  }
  SchemaRow row{ TextOf(types[0], values[0]), TextOf(types[1], values[1]), {}, {}, 0 };
  if (isHeadWhole && taken == schemaColumns && *payload <= mostInPage &&
      before - taker.BytesLeft() == *payload)
  {
    row.table = TextOf(types[2], values[2]);
    row.page = NumberOf(types[3], values[3]);
    row.sql = TextOf(types[4], values[4]);
  }
  return row;
}

// An error that names a part of the schema that a store does not have.
Error StrangeRow(const SchemaRow& row, bool isExpected)
{
  const std::string name = InQuotes(row.name);
  if (row.type != "table")
  {
    const bool known = row.type == "view" || row.type == "trigger" || row.type == "index";
    return NotAStore(!known                ? "its schema has other objects than tables"
                     : row.type == "index" ? "it has an index " + name
                                           : "it has a " + std::string(row.type) + " " + name);
  }
  if (!row.sql.empty() && row.page == 0)
  {
    return NotAStore("it has a virtual table " + name);
  }
  return NotAStore(
    isExpected ? "its table " + name + " differs from that of a store" : "it has a table " + name);
}

Result<std::vector<SchemaRow>> ReadRows(Bytes page)
{
  const std::uint32_t count = NumberAt(page, headerBytes + 3, 2);
  constexpr std::size_t firstPointer = headerBytes + 8;
  if (page[headerBytes] != tableLeaf)
  {
    return NotAStore("its schema has other tables than a store");
  }
  if (firstPointer + 2 * std::size_t{ count } > page.size())
  {
    return DamagedPage();
  }
  std::vector<SchemaRow> rows;
  for (std::size_t i = 0; i < count; ++i)
  {
    const std::uint32_t at = NumberAt(page, firstPointer + 2 * i, 2);
    const auto row = at < page.size() ? RowOfCell(page.subspan(at), page.size()) : std::nullopt;
    if (!row)
    {
      return DamagedPage();
    }
    rows.push_back(*row);
  }
  // Rows that are not tables come first, because they tell best what the file is.
  std::stable_partition(
    rows.begin(), rows.end(), [](const SchemaRow& row) { return row.type != "table"; });
  return rows;
}

// Returns the page where the metadata begin.
Result<std::uint32_t> CheckSchema(Bytes page, int version)
{
  const Result<std::vector<SchemaRow>> rows = ReadRows(page);
  KDSTREAM_TRY(rows);
  const std::vector<StoreTable> tables = TablesOfStore(version);
  std::vector<std::uint32_t> pages(tables.size(), 0);
  for (const SchemaRow& row : *rows)
  {
    const auto found = std::find_if(tables.begin(), tables.end(),
      [&row](const StoreTable& table) { return table.name == row.name; });
    const bool isExpected = found != tables.end();
    if (!isExpected || row.type != "table" || row.table != row.name || row.sql != found->sql ||
        row.page < 2)
    {
      return StrangeRow(row, isExpected);
    }
    std::uint32_t& own = pages[static_cast<std::size_t>(found - tables.begin())];
    if (own != 0 || std::find(pages.begin(), pages.end(), row.page) != pages.end())
    {
      return NotAStore("its table " + InQuotes(row.name) + " appears twice");
    }
    own = row.page;
  }
  const auto missing = std::find(pages.begin(), pages.end(), 0U);
  if (missing != pages.end())
  {
    return Error{ ErrorCode::Damaged,
      "its tables are not those of a store: " +
        InQuotes(tables[static_cast<std::size_t>(missing - pages.begin())].name) + " is missing" };
  }
  return pages.front();
}

}

Result<int> CheckStoreHead(int descriptor)
{
  PageBytes bytes;
  Result<Bytes> page = ReadBytes(descriptor, 0, bytes);
  KDSTREAM_TRY(page);
  const Result<int> version = CheckHeader(*page);
  KDSTREAM_TRY(version);
  const std::size_t pageBytes = PageBytesOfStore(*version);
  if (page->size() < pageBytes)
  {
    return DamagedPage();
  }
  const Result<std::uint32_t> metadata = CheckSchema(page->first(pageBytes), *version);
  KDSTREAM_TRY(metadata);
  // Keys of metadata are texts, which SQLite reads completely to compare them; so check the page
  // first.
  page = ReadBytes(descriptor, std::uint64_t{ *metadata - 1 } * pageBytes, bytes);
  KDSTREAM_TRY(page);
  const std::uint8_t leaf = HasRowsOfBlobs(*version) ? indexLeaf : tableLeaf;
  if (page->size() < pageBytes || bytes[0] != leaf || NumberAt(bytes, 3, 2) > 1)
  {
    return Error{ ErrorCode::Damaged, "metadata: more than one row, or a damaged page" };
  }
  return *version;
}

}
