// SPDX-License-Identifier: BSD-3-Clause
// Parses JSON, by RapidJSON: small enough for a phone's page. Internal: not installed.
//
// Texts are hostile: parsing does not recurse, however deep they nest; numbers are rounded
// correctly, and one that is too large for a double is no JSON, nor is text that is not UTF-8.
// Where a key comes twice the last one counts, as in JavaScript.
#pragma once

#include "filters/core/Result.h"

#include <rapidjson/document.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <new>
#include <string_view>

namespace kdstream
{

// Memory for RapidJSON, whose own goes on with a null pointer where there is none left: this throws
// std::bad_alloc, as all other code does.
struct JsonMemory
{
  static const bool kNeedFree = true;
  static void* Malloc(std::size_t bytes) { return bytes == 0 ? nullptr : ::operator new(bytes); }
  static void* Realloc(void* old, std::size_t oldBytes, std::size_t bytes)
  {
    void* const memory = Malloc(bytes);
    if (memory && old)
    {
      std::memcpy(memory, old, std::min(oldBytes, bytes));
    }
    Free(old);
    return memory;
  }
  static void Free(void* memory) noexcept { ::operator delete(memory); }
};

using JsonDocument = rapidjson::GenericDocument<rapidjson::UTF8<>,
  rapidjson::MemoryPoolAllocator<JsonMemory>, JsonMemory>;
using JsonValue = JsonDocument::ValueType;

// The memory is at most about 24 bytes a byte of text: bound the text first.
// Errors: InvalidInput naming the byte from which on it is no JSON.
Result<JsonDocument> ParseJson(std::string_view text);

// The member, or null where there is none. REQUIRES: an object. O(members).
const JsonValue* FindMember(const JsonValue& object, std::string_view key);

// REQUIRES: a string. It may be no UTF-8: an escape can name half a surrogate pair.
inline std::string_view TextOf(const JsonValue& value)
{
  return { value.GetString(), value.GetStringLength() };
}

}
