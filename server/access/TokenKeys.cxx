// SPDX-License-Identifier: BSD-3-Clause
#include "server/access/TokenKeys.h"

#include "filters/core/SystemReason.h"
#include "filters/model/Json.h"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <initializer_list>

namespace kdstream
{

namespace
{

Error WrongKeys(const std::string& what)
{
  return { ErrorCode::InvalidInput, what };
}

bool IsKeyId(std::string_view id)
{
  return !id.empty() && id.size() <= 64 &&
         id.find_first_not_of(
           "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-") == id.npos;
}

// Checks that an object has only these members, each once.
Status CheckMembers(const JsonValue& object, std::initializer_list<std::string_view> known)
{
  std::set<std::string_view> seen;
  for (const JsonMember& member : object.GetObject())
  {
    const auto name = TextOf(member.name);
    if (std::find(known.begin(), known.end(), name) == known.end())
    {
      return WrongKeys("has an unknown member \"" + std::string(name.substr(0, 40)) + "\"");
    }
    if (!seen.insert(name).second)
    {
      return WrongKeys("\"" + std::string(name) + "\" appears twice");
    }
  }
  return {};
}

Result<TokenKeys::Key> ParseKey(const JsonValue& object)
{
  const auto* secret = FindMember(object, "secret");
  if (!secret || !secret->IsString() || TextOf(*secret).size() < leastSecretBytes)
  {
    return WrongKeys(
      "\"secret\" must be a string of at least " + std::to_string(leastSecretBytes) + " bytes");
  }
  const auto* id = FindMember(object, "id");
  if (id && !(id->IsString() && IsKeyId(TextOf(*id))))
  {
    return WrongKeys("\"id\" must have 1 to 64 characters of A-Z a-z 0-9 . _ -");
  }
  return TokenKeys::Key{ id ? std::string(TextOf(*id)) : "", std::string(TextOf(*secret)) };
}

Status AddKey(TokenKeys& keys, const JsonValue& object)
{
  auto key = ParseKey(object);
  KDSTREAM_TRY(key);
  if (keys.Find(key->id))
  {
    return WrongKeys(
      key->id.empty() ? "two secrets have no \"id\"" : "two secrets have the \"id\" " + key->id);
  }
  if (keys.keys.size() == maximumKeys)
  {
    return WrongKeys("has more than " + std::to_string(maximumKeys) + " secrets");
  }
  keys.keys.push_back(std::move(*key));
  return {};
}

Status AddEarlier(TokenKeys& keys, const JsonValue* earlier)
{
  if (!earlier)
  {
    return {};
  }
  if (!earlier->IsArray())
  {
    return WrongKeys("\"earlier\" must be a list");
  }
  for (const auto& each : earlier->GetArray())
  {
    if (!each.IsObject())
    {
      return WrongKeys("\"earlier\" must be a list of objects with \"secret\" and \"id\"");
    }
    KDSTREAM_TRY(CheckMembers(each, { "secret", "id" }));
    KDSTREAM_TRY(AddKey(keys, each));
  }
  return {};
}

Status AddNames(
  std::set<std::string, std::less<>>& names, const JsonValue& file, const std::string& member)
{
  const auto* list = FindMember(file, member);
  if (!list)
  {
    return {};
  }
  if (!list->IsArray())
  {
    return WrongKeys("\"" + member + "\" must be a list of strings");
  }
  for (const auto& each : list->GetArray())
  {
    if (!each.IsString() || each.GetString().empty())
    {
      return WrongKeys("\"" + member + "\" must be a list of strings");
    }
    names.emplace(TextOf(each));
  }
  return {};
}

}

const TokenKeys::Key* TokenKeys::Find(std::string_view id) const
{
  const auto found = std::find_if(
    this->keys.begin(), this->keys.end(), [id](const Key& key) { return key.id == id; });
  return found == this->keys.end() ? nullptr : &*found;
}

Result<TokenKeys> ParseTokenKeys(std::string_view json)
{
  if (json.size() > maximumKeysBytes)
  {
    return WrongKeys("is larger than " + std::to_string(maximumKeysBytes) + " bytes");
  }
  const auto file = ParseJson(json);
  KDSTREAM_TRY(file);
  if (!file->IsObject())
  {
    return WrongKeys("is not a JSON object");
  }
  KDSTREAM_TRY(CheckMembers(*file, { "secret", "id", "earlier", "revoked", "revoked_subjects" }));
  TokenKeys keys;
  KDSTREAM_TRY(AddKey(keys, *file));
  KDSTREAM_TRY(AddEarlier(keys, FindMember(*file, "earlier")));
  KDSTREAM_TRY(AddNames(keys.revoked, *file, "revoked"));
  KDSTREAM_TRY(AddNames(keys.revokedSubjects, *file, "revoked_subjects"));
  return keys;
}

Result<TokenKeys> ReadTokenKeys(const std::filesystem::path& file)
{
  std::error_code error;
  const auto kind = std::filesystem::status(file, error).type();
  if (kind == std::filesystem::file_type::directory)
  {
    return Error{ ErrorCode::InputOutput, "is a folder" };
  }
  if (std::filesystem::exists(file, error) && kind != std::filesystem::file_type::regular)
  {
    return Error{ ErrorCode::InputOutput, "is not a file" }; // reading a pipe could block forever
  }
  errno = 0;
  std::ifstream input(file, std::ios::binary);
  if (!input)
  {
    return Error{ errno == ENOENT ? ErrorCode::NotFound : ErrorCode::InputOutput,
      "cannot be read: " + SystemReason(errno) };
  }
  // Reads no further than the limit: if the file is longer, its beginning is enough to refuse it.
  std::string text(maximumKeysBytes + 1, '\0');
  input.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (input.bad())
  {
    return Error{ ErrorCode::InputOutput, "cannot be read: " + SystemReason(errno) };
  }
  text.resize(static_cast<std::size_t>(input.gcount()));
  return ParseTokenKeys(text);
}

}
