// SPDX-License-Identifier: BSD-3-Clause
// Steps of reading a token: 1. parse it  2. check the header: it must name HS256 and one of our
// keys (nothing else is ever tried, whatever it says)  3. check the signature  4. only then read
// the claims. cjose does parsing, signing and checking (RFC 7515).
#include "server/access/Token.h"

#include "filters/model/Json.h"
#include "filters/model/JsonWriter.h"

#include <cjose/cjose.h>
#include <malloc.h>
#include <openssl/rand.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <optional>
#include <utility>

namespace kdstream
{

namespace
{

constexpr std::string_view tokenCharacters =
  "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_.";

// Reserve memory for cjose, which does not check for null pointers. If the system refuses memory,
// cjose gets it from here, and our function that called cjose throws. Memory from the reserve is
// not used after a call.
class Reserve
{
public:
  // Empties the reserve at the start of a call. From now on cjose gets its memory through this
  // class.
  Reserve()
  {
    static const bool isSet = (cjose_set_alloc_funcs(&Take, &TakeAgain, &Give), true);
    static_cast<void>(isSet);
    used = 0;
  }
  // Throws std::bad_alloc if the system refused memory, because then cjose's results are not
  // reliable.
  static void Check()
  {
    if (used > 0)
    {
      throw std::bad_alloc();
    }
  }
  static void Give(void* memory)
  {
    if (!IsOwn(memory))
    {
      std::free(memory);
    }
  }

private:
  // Several times the memory that the longest token needs.
  static constexpr std::size_t size = std::size_t{ 1 } << 17, step = alignof(std::max_align_t);
  alignas(std::max_align_t) static inline thread_local std::array<char, size> bytes{};
  static inline thread_local std::size_t used = 0;

  static bool IsOwn(const void* memory)
  {
    return memory >= bytes.data() && memory < bytes.data() + size;
  }
  static void* TakeOwn(std::size_t wanted)
  {
    if (wanted > size - used)
    {
      return nullptr;
    }
    void* const memory = bytes.data() + used;
    used += (wanted + step) / step * step; // takes memory even if `wanted` is 0
    used = std::min(used, size);
    return memory;
  }
  static void* Take(std::size_t wanted)
  {
    void* const memory = std::malloc(wanted);
    return memory ? memory : TakeOwn(wanted);
  }
  static void* TakeAgain(void* memory, std::size_t wanted)
  {
    void* const larger = IsOwn(memory) ? nullptr : std::realloc(memory, wanted);
    if (larger)
    {
      return larger;
    }
    void* const own = TakeOwn(wanted);
    if (own && memory)
    {
      const auto* const from = static_cast<const char*>(memory);
      const std::size_t had = IsOwn(memory) ? static_cast<std::size_t>(bytes.data() + size - from)
                                            : ::malloc_usable_size(memory);
      std::memmove(own, memory, std::min(wanted, had));
      Give(memory);
    }
    return own;
  }
};

struct Release
{
  void operator()(cjose_jws_t* jws) const { cjose_jws_release(jws); }
  void operator()(cjose_jwk_t* jwk) const { cjose_jwk_release(jwk); }
  void operator()(cjose_header_t* header) const { cjose_header_release(header); }
};
using Jws = std::unique_ptr<cjose_jws_t, Release>;
using Jwk = std::unique_ptr<cjose_jwk_t, Release>;
using JwsHeader = std::unique_ptr<cjose_header_t, Release>;

Error WrongToken(const std::string& what)
{
  return { ErrorCode::InvalidInput, "the token " + what };
}

Error NotSigned()
{
  return { ErrorCode::LimitExceeded, "a signature cannot be computed" };
}

// The object in the text. No name may occur twice in it: otherwise parsers could disagree on which
// value counts.
std::optional<JsonDocument> ParseObject(const std::string& text)
{
  auto json = ParseJson(text);
  if (!json || !json->IsObject())
  {
    return std::nullopt;
  }
  std::vector<std::string_view> names;
  for (const JsonMember& member : json->GetObject())
  {
    names.push_back(TextOf(member.name));
  }
  std::sort(names.begin(), names.end());
  const bool twice = std::adjacent_find(names.begin(), names.end()) != names.end();
  return twice ? std::nullopt : std::optional(std::move(*json));
}

bool IsText(const JsonValue* value, std::string_view text)
{
  return value && value->IsString() && TextOf(*value) == text;
}

bool IsTypeOfToken(const JsonValue& type)
{
  constexpr std::string_view jwt = "JWT";
  const auto text = type.IsString() ? TextOf(type) : std::string_view();
  return std::equal(text.begin(), text.end(), jwt.begin(), jwt.end(),
    [](char a, char b) { return std::toupper(static_cast<unsigned char>(a)) == b; });
}

// The header, up to the token's first dot. Because no name occurs twice, all parsers read the same
// values.
std::optional<JsonDocument> ParseHeader(std::string_view token)
{
  std::uint8_t* bytes = nullptr;
  std::size_t size = 0;
  if (!cjose_base64url_decode(token.data(), token.find('.'), &bytes, &size, nullptr))
  {
    return std::nullopt;
  }
  const std::unique_ptr<std::uint8_t, decltype(&Reserve::Give)> owned(bytes, &Reserve::Give);
  return ParseObject(std::string(bytes, bytes + size));
}

// The key that the token's header names.
Result<const TokenKeys::Key*> FindKey(std::string_view token, const TokenKeys& keys)
{
  const auto header = ParseHeader(token);
  if (!header)
  {
    return WrongToken("has no header");
  }
  if (!IsText(FindMember(*header, "alg"), CJOSE_HDR_ALG_HS256))
  {
    return WrongToken("is not signed with HS256");
  }
  if (const auto* type = FindMember(*header, "typ"); type && !IsTypeOfToken(*type))
  {
    return WrongToken("is not of type JWT");
  }
  if (FindMember(*header, "crit")) // extensions that must be understood; we know none
  {
    return WrongToken("requires an extension (\"crit\"), which is not supported");
  }
  const auto* id = FindMember(*header, "kid");
  const auto* key = !id                                        ? keys.Find("")
                    : id->IsString() && TextOf(*id).size() > 0 ? keys.Find(TextOf(*id))
                                                               : nullptr;
  if (!key)
  {
    return WrongToken("is signed with a key that this server does not have");
  }
  return key;
}

Jwk KeyOf(const std::string& secret)
{
  return Jwk(cjose_jwk_create_oct_spec(
    reinterpret_cast<const std::uint8_t*>(secret.data()), secret.size(), nullptr));
}

// Checks the signature, and returns the token's claims as text.
Result<std::string> ReadSigned(std::string_view token, const TokenKeys& keys)
{
  const Reserve reserve;
  const auto key = FindKey(token, keys);
  Reserve::Check();
  KDSTREAM_TRY(key);
  const Jws jws(cjose_jws_import(token.data(), token.size(), nullptr));
  const Jwk jwk = KeyOf((*key)->secret);
  Reserve::Check();
  if (!jwk)
  {
    return NotSigned();
  }
  std::uint8_t* text = nullptr;
  std::size_t size = 0;
  const bool isRight = jws && cjose_jws_verify(jws.get(), jwk.get(), nullptr) &&
                       cjose_jws_get_plaintext(jws.get(), &text, &size, nullptr);
  Reserve::Check();
  if (!isRight)
  {
    return WrongToken("has a wrong signature");
  }
  return std::string(text, text + size);
}

Result<std::string> Sign(const std::string& text, const TokenKeys::Key& key)
{
  const Reserve reserve;
  const JwsHeader header(cjose_header_new(nullptr));
  const Jwk jwk = KeyOf(key.secret);
  const auto set = [&header](const char* name, const std::string& value)
  { return cjose_header_set(header.get(), name, value.c_str(), nullptr); };
  if (!header || !jwk || !set("alg", CJOSE_HDR_ALG_HS256) || !set("typ", "JWT") ||
      !(key.id.empty() || set("kid", key.id)))
  {
    return NotSigned();
  }
  const Jws jws(cjose_jws_sign(jwk.get(), header.get(),
    reinterpret_cast<const std::uint8_t*>(text.data()), text.size(), nullptr));
  const char* token = nullptr; // of jws
  if (!jws || !cjose_jws_export(jws.get(), &token, nullptr))
  {
    return NotSigned();
  }
  return std::string(token);
}

// A time in seconds since 1970, small enough for a double to hold it exactly.
Result<std::int64_t> ParseTime(const JsonValue& value, const char* name)
{
  constexpr std::int64_t most = std::int64_t{ 1 } << 53;
  if (!value.IsInt64() || value.GetInt64() < 0 || value.GetInt64() > most)
  {
    return WrongToken(std::string("must have a time in seconds as \"") + name + "\"");
  }
  return value.GetInt64();
}

// Whether the text may be a name, which is shown and logged.
bool IsName(std::string_view text)
{
  return !text.empty() && text.size() <= maximumSubjectBytes &&
         std::none_of(text.begin(), text.end(),
           [](char c) { return static_cast<unsigned char>(c) < 32 || c == 127; });
}

Status ParseModels(const JsonValue* value, TokenClaims& claims)
{
  claims.allModels = IsText(value, "*");
  if (claims.allModels)
  {
    return {};
  }
  if (!value || !value->IsArray())
  {
    return WrongToken("must have \"*\" or a list as \"models\"");
  }
  for (const auto& each : value->GetArray())
  {
    if (!each.IsString() || !IsModelId(TextOf(each)))
    {
      return WrongToken("must have a list of models as \"models\"");
    }
    claims.models.emplace_back(TextOf(each));
  }
  return {};
}

Result<TokenClaims> ParseClaims(const JsonValue& json)
{
  TokenClaims claims;
  const auto* subject = FindMember(json, "sub");
  if (!subject || !subject->IsString() || !IsName(TextOf(*subject)))
  {
    return WrongToken("must have a name as \"sub\"");
  }
  claims.subject = TextOf(*subject);
  if (const auto* id = FindMember(json, "jti"))
  {
    if (!id->IsString() || !IsName(TextOf(*id)))
    {
      return WrongToken("must have a name as \"jti\"");
    }
    claims.id = TextOf(*id);
  }
  const auto* expires = FindMember(json, "exp");
  const auto expiry =
    expires ? ParseTime(*expires, "exp") : Result<std::int64_t>(WrongToken("has no \"exp\""));
  KDSTREAM_TRY(expiry);
  claims.expires = *expiry;
  if (const auto* begins = FindMember(json, "nbf"))
  {
    const auto beginning = ParseTime(*begins, "nbf");
    KDSTREAM_TRY(beginning);
    claims.notBefore = *beginning;
  }
  KDSTREAM_TRY(ParseModels(FindMember(json, "models"), claims));
  const auto* detail = FindMember(json, "detail");
  const auto parsed =
    ParseDetail(detail && detail->IsString() ? TextOf(*detail) : std::string_view());
  if (!parsed)
  {
    return WrongToken("must have \"preview\", \"levels\" or \"regions\" as \"detail\"");
  }
  claims.detail = *parsed;
  if (FindMember(json, "aud")) // the token is for another audience (RFC 7519, 4.1.3)
  {
    return WrongToken("is for another audience");
  }
  return claims;
}

Status CheckValidity(const TokenClaims& claims, const TokenKeys& keys, std::int64_t now)
{
  if (now >= claims.expires)
  {
    return WrongToken("has expired");
  }
  if (now < claims.notBefore)
  {
    return WrongToken("is not valid yet");
  }
  if (keys.revoked.contains(claims.id) || keys.revokedSubjects.contains(claims.subject))
  {
    return WrongToken("has been revoked");
  }
  return {};
}

}

Result<ModelDetail> ParseDetail(std::string_view name)
{
  for (const auto detail : { ModelDetail::Preview, ModelDetail::Levels, ModelDetail::Regions })
  {
    if (name == NameOf(detail))
    {
      return detail;
    }
  }
  return Error{ ErrorCode::InvalidArgument, "the detail must be preview, levels or regions" };
}

bool TokenClaims::AllowsModel(std::string_view model) const
{
  return this->allModels ||
         std::find(this->models.begin(), this->models.end(), model) != this->models.end();
}

bool LooksLikeToken(std::string_view text)
{
  return text.size() <= maximumTokenBytes && std::count(text.begin(), text.end(), '.') == 2 &&
         text.find_first_not_of(tokenCharacters) == text.npos;
}

Result<TokenClaims> ReadToken(std::string_view token, const TokenKeys& keys, std::int64_t now)
{
  if (!LooksLikeToken(token))
  {
    return WrongToken(
      "is incomplete: it must have three parts with dots between them, and at most " +
      std::to_string(maximumTokenBytes) + " bytes. Copy it again from its source");
  }
  const auto text = ReadSigned(token, keys);
  KDSTREAM_TRY(text);
  const auto json = ParseObject(*text);
  if (!json)
  {
    return WrongToken("has no claims");
  }
  auto claims = ParseClaims(*json);
  KDSTREAM_TRY(claims);
  KDSTREAM_TRY(CheckValidity(*claims, keys, now));
  return claims;
}

Result<std::string> WriteToken(
  const TokenClaims& claims, const TokenKeys& keys, std::int64_t issuedAt)
{
  if (!IsName(claims.subject))
  {
    return Error{ ErrorCode::InvalidArgument, "the name must have 1 to " +
                                                std::to_string(maximumSubjectBytes) +
                                                " bytes and no control characters" };
  }
  for (const auto& model : claims.models)
  {
    if (!IsModelId(model))
    {
      return Error{ ErrorCode::InvalidArgument,
        "'" + model + "' is not a model: its name must have " + std::string(modelIdRule) };
    }
  }
  JsonWriter body;
  body.BeginObject().Member("sub", claims.subject).Member("iat", issuedAt);
  claims.notBefore == 0 ? body : body.Member("nbf", claims.notBefore);
  body.Member("exp", claims.expires);
  claims.id.empty() ? body : body.Member("jti", claims.id);
  claims.allModels ? body.Member("models", "*") : body.Member("models", claims.models);
  body.Member("detail", NameOf(claims.detail)).EndObject();
  auto token = Sign(body.Text(), keys.keys.front());
  KDSTREAM_TRY(token);
  if (token->size() > maximumTokenBytes)
  {
    return Error{ ErrorCode::InvalidArgument, "too many models for one token, which has at most " +
                                                std::to_string(maximumTokenBytes) + " bytes" };
  }
  return token;
}

Result<std::string> MakeTokenId()
{
  std::array<unsigned char, 16> bytes{};
  if (RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1)
  {
    return Error{ ErrorCode::InputOutput, "the system provides no random numbers" };
  }
  std::string id;
  for (const auto byte : bytes)
  {
    id += "0123456789abcdef"[byte >> 4];
    id += "0123456789abcdef"[byte & 15];
  }
  return id;
}

}
