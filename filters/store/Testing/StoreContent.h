// SPDX-License-Identifier: BSD-3-Clause
// Reads and replaces the tables of a store by plain SQL, for the tests of damaged or hostile
// stores.
#pragma once

#include "filters/codec/PartitionBoxes.h"
#include "filters/codec/TreePage.h"
#include "filters/store/Store.h"
#include "filters/store/StoreSchema.h"
#include "filters/store/UnusedList.h"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace kdstream::fixtures
{

using Blob = std::vector<std::uint8_t>;

inline void Sql(const std::filesystem::path& file, const std::string& statements)
{
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(database, statements.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
    << statements << ": " << sqlite3_errmsg(database);
  EXPECT_EQ(sqlite3_close(database), SQLITE_OK);
}

// The data as an SQL expression.
inline std::string Literal(std::span<const std::uint8_t> data)
{
  std::string text = "x'";
  for (const std::uint8_t byte : data)
  {
    constexpr const char* digits = "0123456789ABCDEF";
    text += digits[byte >> 4];
    text += digits[byte & 15];
  }
  return text + "'";
}

// The SQL statement that replaces the metadata by this text, with the right checksum.
inline std::string PutMetadata(const std::string& json)
{
  return "UPDATE metadata SET checksum = " + std::to_string(MetadataChecksum("model", json)) +
         ", value = '" + json + "'";
}

// The text of the metadata.
inline std::string Metadata(const std::filesystem::path& file)
{
  sqlite3* database = nullptr;
  EXPECT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  std::string text;
  sqlite3_exec(
    database, "SELECT value FROM metadata",
    [](void* to, int, char** values, char**)
    {
      *static_cast<std::string*>(to) = values[0];
      return 0;
    },
    &text, nullptr);
  sqlite3_close(database);
  return text;
}

// The names of all blobs, in the order of the store.
inline std::vector<std::string> NamesOfBlobs(const Store& store)
{
  const ModelDescription& model = store.Info();
  std::vector<std::string> names;
  for (const PieceId id : store.PieceIds())
  {
    names.push_back(protocol::BlobName(BlobOfPiece(id, model.depths)));
    if (id.resolution.IsOriginal() && model.textures)
    {
      names.push_back("textures" + names.back().substr(names.back().find('/')));
    }
  }
  for (std::size_t depth = model.levels.size();
       model.textures && model.textures->levels && depth-- > 0;)
  {
    const Resolution level = Resolution::Level(static_cast<unsigned>(depth));
    const NodeId first = NodeId{ 1 } << PieceDepth(level, model.depths);
    for (NodeId node = first; node < 2 * first; ++node)
    {
      names.push_back(protocol::BlobName(TextureOfPiece({ level, node }, model.depths)));
    }
  }
  for (const NodeId node : AllPartitionBoxes(model.depths))
  {
    names.push_back("boxes/" + std::to_string(node));
  }
  for (const NodeId page : TreePages(model.depths))
  {
    names.push_back("tree/" + std::to_string(page));
  }
  for (std::uint64_t part = 0; part < UnusedPartCount(model); ++part)
  {
    names.push_back("unused/" + std::to_string(part));
  }
  return names;
}

// The blobs in the directory and in the content, which can be changed and written back.
class StoreContent
{
public:
  explicit StoreContent(const std::filesystem::path& file)
    : File(file)
  {
    sqlite3* database = nullptr;
    EXPECT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
    std::uint64_t part = 0;
    for (const Blob& row : Rows(database, "SELECT data FROM directory ORDER BY part"))
    {
      const auto decoded = DecodeDirectoryRow(part++, row);
      EXPECT_TRUE(decoded);
      this->Places.insert(this->Places.end(), decoded->begin(), decoded->end());
    }
    for (const Blob& row : Rows(database, "SELECT data FROM content ORDER BY part"))
    {
      this->Bytes.insert(this->Bytes.end(), row.begin(), row.end());
    }
    sqlite3_close(database);
    this->Names = NamesOfBlobs(**Store::Open(file));
    EXPECT_EQ(this->Names.size(), this->Places.size());
  }

  BlobPlace& PlaceOf(const std::string& name)
  {
    const auto found = std::find(this->Names.begin(), this->Names.end(), name);
    EXPECT_NE(found, this->Names.end()) << name;
    return this->Places.at(static_cast<std::size_t>(found - this->Names.begin()));
  }
  std::uint8_t& FirstByteOf(const std::string& name)
  {
    return this->Bytes.at(this->PlaceOf(name).begin);
  }

  // Replaces a blob and its checksum; the blobs after it move.
  void Replace(const std::string& name, std::span<const std::uint8_t> data)
  {
    BlobPlace& place = this->PlaceOf(name);
    const auto begin = this->Bytes.begin() + static_cast<std::ptrdiff_t>(place.begin);
    this->Bytes.erase(begin, begin + place.bytes);
    this->Bytes.insert(
      this->Bytes.begin() + static_cast<std::ptrdiff_t>(place.begin), data.begin(), data.end());
    for (BlobPlace& other : this->Places)
    {
      other.begin += other.begin > place.begin ? data.size() - place.bytes : 0;
    }
    place.bytes = static_cast<std::uint32_t>(data.size());
    place.checksum = BlobChecksum(data);
  }

  void Write() const
  {
    std::string statements = "BEGIN; DELETE FROM directory; DELETE FROM content;";
    for (std::size_t first = 0; first < this->Places.size(); first += blobsOfDirectoryRow)
    {
      const std::uint64_t part = first / blobsOfDirectoryRow;
      const auto row =
        std::span(this->Places)
          .subspan(first, std::min(blobsOfDirectoryRow, this->Places.size() - first));
      statements += "INSERT INTO directory VALUES (" + std::to_string(part) + ", " +
                    Literal(EncodeDirectoryRow(part, row)) + ");";
    }
    for (std::size_t first = 0; first < this->Bytes.size(); first += contentRowBytes)
    {
      const auto row = std::span(this->Bytes)
                         .subspan(first, std::min(contentRowBytes, this->Bytes.size() - first));
      statements += "INSERT INTO content VALUES (" + std::to_string(first / contentRowBytes) +
                    ", " + Literal(row) + ");";
    }
    Sql(this->File, statements + "COMMIT");
  }

  std::vector<std::string> Names;
  std::vector<BlobPlace> Places;
  Blob Bytes;

private:
  static std::vector<Blob> Rows(sqlite3* database, const char* select)
  {
    std::vector<Blob> rows;
    sqlite3_stmt* statement = nullptr;
    EXPECT_EQ(sqlite3_prepare_v2(database, select, -1, &statement, nullptr), SQLITE_OK);
    while (sqlite3_step(statement) == SQLITE_ROW)
    {
      const auto* data = static_cast<const std::uint8_t*>(sqlite3_column_blob(statement, 0));
      rows.emplace_back(data, data + sqlite3_column_bytes(statement, 0));
    }
    sqlite3_finalize(statement);
    return rows;
  }

  std::filesystem::path File;
};

}
