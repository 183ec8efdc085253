// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/ErrorAt.h"
#include "server/access/Testing/ForgedToken.h"
#include "server/access/Token.h"
#include "server/access/TokenGuard.h"

#include <gtest/gtest.h>

using namespace kdstream;
using fixtures::FailsAt, fixtures::Mentions;

namespace
{

constexpr std::int64_t now = 1000;

// The message of ReadToken; "" if the token is valid.
std::string Refusal(
  const std::string& token, const TokenKeys& keys = forged::Keys(), std::int64_t time = now)
{
  const auto claims = ReadToken(token, keys, time);
  return claims ? "" : claims.GetError().message;
}

std::string RefusalOfHeader(const std::string& header)
{
  return Refusal(forged::Token(header, forged::claims));
}

std::string RefusalOfClaims(const std::string& claims)
{
  return Refusal(forged::Token(forged::header, claims));
}

TEST(Token, SaysWhatItsBearerMayHave)
{
  const auto claims = ReadToken(forged::Token(forged::header, forged::claims), forged::Keys(), now);
  ASSERT_TRUE(claims) << claims.GetError().message;
  EXPECT_EQ(claims->subject, "ann");
  EXPECT_EQ(claims->expires, 2000);
  EXPECT_EQ(claims->detail, ModelDetail::Levels);
  EXPECT_TRUE(claims->AllowsModel("vase"));
  EXPECT_FALSE(claims->AllowsModel("vas"));
  EXPECT_FALSE(claims->AllowsModel("*"));
}

// RFC 7515, A.1: the signature of the standard's example, whose claims are not ours.
TEST(Token, AgreesWithTheStandardsExample)
{
  const std::string key = "\x03\x23\x35\x4b\x2b\x0f\xa5\xbc\x83\x7e\x06\x65\x77\x7b\xa6\x8f\x5a\xb3"
                          "\x28\xe6\xf0\x54\xc9\x28\xa9\x0f\x84\xb2\xd2\x50\x2e\xbf\xd3\xfb\x5a\x92"
                          "\xd2\x06\x47\xef\x96\x8a\xb4\xc3\x77\x62\x3d\x22\x3d\x2e\x21\x72\x05\x2e"
                          "\x4f\x08\xc0\xcd\x9a\xf5\x67\xd0\x80\xa3";
  const std::string token = "eyJ0eXAiOiJKV1QiLA0KICJhbGciOiJIUzI1NiJ9."
                            "eyJpc3MiOiJqb2UiLA0KICJleHAiOjEzMDA4MTkzODAsDQogImh0dHA6Ly9leGFtcGxlLm"
                            "NvbS9pc19yb290Ijp0cnVlfQ."
                            "dBjftJeZ4CVP-mB92K27uhbUJU1p1r_wW1gFWFOEjXk";
  EXPECT_TRUE(Mentions(Refusal(token, { { { "", key } }, {}, {} }), { "\"sub\"" }));
  EXPECT_TRUE(Mentions(Refusal(token), { "signature" }));
}

TEST(Token, ComesBackAsItWasWritten)
{
  TokenClaims claims;
  claims.subject = "Ann \"Ä\" Smith";
  claims.id = *MakeTokenId();
  claims.notBefore = 900;
  claims.expires = 5000;
  claims.models = { "dragon", "a.b-c_D" };
  claims.detail = ModelDetail::Regions;
  for (const bool all : { false, true })
  {
    for (const std::string id : { "", "2026-11" })
    {
      claims.allModels = all;
      claims.models = all ? std::vector<std::string>() : claims.models;
      const TokenKeys keys{ { { id, forged::secret } }, {}, {} };
      const auto token = WriteToken(claims, keys, 800);
      ASSERT_TRUE(token) << token.GetError().message;
      EXPECT_TRUE(LooksLikeToken(*token));
      const auto read = ReadToken(*token, keys, now);
      ASSERT_TRUE(read) << read.GetError().message;
      EXPECT_EQ(*read, claims);
    }
  }
  EXPECT_EQ(claims.id.size(), 32u);
  EXPECT_NE(claims.id, *MakeTokenId());
}

TEST(Token, IsNotWrittenWithWhatNoneMayHave)
{
  TokenClaims claims;
  claims.expires = 5000;
  EXPECT_FALSE(WriteToken(claims, forged::Keys(), now)); // no subject
  claims.subject = "a\nb";
  EXPECT_FALSE(WriteToken(claims, forged::Keys(), now));
  claims.subject = "ann";
  claims.models = { "../x" };
  EXPECT_FALSE(WriteToken(claims, forged::Keys(), now));
  claims.models.assign(1000, "dragon");
  EXPECT_FALSE(WriteToken(claims, forged::Keys(), now));
}

TEST(Token, OnlyOneAlgorithmIsTaken)
{
  const std::string other = "the token is not signed with HS256";
  for (const std::string algorithm : { R"("none")", R"("None")", R"("hs256")", R"("RS256")",
         R"("HS384")", R"("HS512")", R"("ES256")", R"("")", "null", "256", R"(["HS256"])" })
  {
    EXPECT_EQ(RefusalOfHeader(R"({"alg":)" + algorithm + "}"), other) << algorithm;
  }
  EXPECT_EQ(RefusalOfHeader(R"({"typ":"JWT"})"), other);
  // As an attacker would try who confuses algorithms: no signature, or one by another algorithm.
  const std::string none =
    forged::Base64(R"({"alg":"none"})") + "." + forged::Base64(forged::claims) + ".";
  EXPECT_EQ(Refusal(none), other);
  EXPECT_EQ(
    Refusal(forged::Token(R"({"alg":"HS512"})", forged::claims, forged::secret, EVP_sha512())),
    other);
  EXPECT_TRUE(
    Mentions(Refusal(forged::Token(forged::header, forged::claims, forged::secret, EVP_sha512())),
      { "signature" }));
  EXPECT_TRUE(
    Mentions(Refusal(forged::Base64(forged::header) + "." + forged::Base64(forged::claims) + "."),
      { "signature" }));
}

TEST(Token, HeadersThatDemandMoreAreRefused)
{
  EXPECT_EQ(RefusalOfHeader(R"({"alg":"HS256"})"), "");
  EXPECT_EQ(RefusalOfHeader(R"({"alg":"HS256","typ":"jwt"})"), "");
  EXPECT_NE(RefusalOfHeader(R"({"alg":"HS256","typ":"JWE"})"), "");
  EXPECT_NE(RefusalOfHeader(R"({"alg":"HS256","typ":"JWTX"})"), "");
  EXPECT_NE(RefusalOfHeader(R"({"alg":"HS256","typ":1})"), "");
  EXPECT_NE(RefusalOfHeader(R"({"alg":"HS256","crit":["b64"],"b64":false})"), "");
  EXPECT_NE(RefusalOfHeader(R"({"alg":"HS256","crit":1})"), "");
  EXPECT_NE(RefusalOfHeader(R"({"alg":"none","alg":"HS256"})"), "");
  EXPECT_NE(RefusalOfHeader(R"({"alg":"HS256","alg":"none"})"), "");
  EXPECT_NE(RefusalOfHeader(R"(["HS256"])"), "");
  EXPECT_NE(RefusalOfHeader("{"), "");
  EXPECT_NE(RefusalOfHeader(""), "");
}

TEST(Token, KeysAreFoundByTheirIds)
{
  const std::string other(32, 'x'), third(32, 'y');
  const TokenKeys keys{ { { "new", other }, { "old", third }, { "", forged::secret } }, {}, {} };
  const auto token = [](const std::string& header, const std::string& secret)
  { return forged::Token(header, forged::claims, secret); };
  EXPECT_EQ(Refusal(token(R"({"alg":"HS256","kid":"new"})", other), keys), "");
  EXPECT_EQ(Refusal(token(R"({"alg":"HS256","kid":"old"})", third), keys), "");
  EXPECT_EQ(Refusal(token(R"({"alg":"HS256"})", forged::secret), keys), "");
  EXPECT_TRUE(
    Mentions(Refusal(token(R"({"alg":"HS256","kid":"old"})", other), keys), { "signature" }));
  const auto isUnknown = [](const std::string& refusal)
  { return Mentions(refusal, { "a key that " }); };
  EXPECT_TRUE(isUnknown(Refusal(token(R"({"alg":"HS256","kid":"gone"})", other), keys)));
  EXPECT_TRUE(isUnknown(Refusal(token(R"({"alg":"HS256","kid":""})", forged::secret), keys)));
  EXPECT_TRUE(isUnknown(Refusal(token(R"({"alg":"HS256","kid":7})", other), keys)));
  EXPECT_TRUE(
    isUnknown(Refusal(token(R"({"alg":"HS256"})", other), { { { "new", other } }, {}, {} })));
}

TEST(Token, EveryClaimMustBeThere)
{
  EXPECT_TRUE(
    Mentions(RefusalOfClaims(R"({"exp":2000,"models":"*","detail":"levels"})"), { "\"sub\"" }));
  EXPECT_TRUE(
    Mentions(RefusalOfClaims(R"({"sub":"ann","models":"*","detail":"levels"})"), { "\"exp\"" }));
  EXPECT_TRUE(
    Mentions(RefusalOfClaims(R"({"sub":"ann","exp":2000,"detail":"levels"})"), { "\"models\"" }));
  EXPECT_TRUE(
    Mentions(RefusalOfClaims(R"({"sub":"ann","exp":2000,"models":"*"})"), { "\"detail\"" }));
  EXPECT_TRUE(Mentions(RefusalOfClaims("{}"), { "\"sub\"" }));
  for (const std::string none : { "", "[]", "null", "7", "\"ann\"", "{", "{\"sub\":\"ann\"" })
  {
    EXPECT_TRUE(Mentions(RefusalOfClaims(none), { "no claims" })) << none;
  }
}

TEST(Token, EveryClaimMustBeWhatItIs)
{
  const auto claims = [](const std::string& sub, const std::string& exp, const std::string& models,
                        const std::string& detail)
  {
    return RefusalOfClaims("{\"sub\":" + sub + ",\"exp\":" + exp + ",\"models\":" + models +
                           ",\"detail\":" + detail + "}");
  };
  const std::string ann = "\"ann\"", all = "\"*\"", levels = "\"levels\"";
  EXPECT_EQ(claims(ann, "2000", all, levels), "");
  EXPECT_EQ(claims(ann, "2000", "[]", levels), "");
  const std::string tooLong = "\"" + std::string(maximumSubjectBytes + 1, 'a') + "\"";
  for (const std::string& sub :
    { std::string("7"), std::string("null"), std::string("\"\""), std::string("[\"ann\"]"),
      std::string("\"a\\u0000b\""), std::string("\"a\\nb\""), tooLong })
  {
    EXPECT_NE(claims(sub, "2000", all, levels), "") << sub;
  }
  for (const std::string exp : { "\"2000\"", "null", "true", "2000.5", "-1", "1e30",
         "9007199254740993", "18446744073709551615", "99999999999999999999999", "[2000]" })
  {
    EXPECT_NE(claims(ann, exp, all, levels), "") << exp;
  }
  for (const std::string models :
    { "\"dragon\"", "\"**\"", "{}", "null", "[7]", "[\"*\"]", "[\"a/b\"]", "[\"\"]", "[[\"a\"]]" })
  {
    EXPECT_NE(claims(ann, "2000", models, levels), "") << models;
  }
  for (const std::string detail : { "\"all\"", "\"Levels\"", "\"\"", "null", "2", "[\"levels\"]" })
  {
    EXPECT_NE(claims(ann, "2000", all, detail), "") << detail;
  }
}

TEST(Token, FurtherClaimsCountWhereTheyMust)
{
  const std::string start = R"({"sub":"ann","exp":2000,"models":"*","detail":"levels",)";
  EXPECT_EQ(RefusalOfClaims(start + R"("iat":1,"name":"Ann"})"), "");
  EXPECT_TRUE(Mentions(RefusalOfClaims(start + R"("aud":"another"})"), { "audience" }));
  EXPECT_NE(RefusalOfClaims(start + R"("jti":7})"), "");
  EXPECT_NE(RefusalOfClaims(start + R"("nbf":"1"})"), "");
  EXPECT_EQ(RefusalOfClaims(start + R"("nbf":1000})"), "");
  EXPECT_TRUE(Mentions(RefusalOfClaims(start + R"("nbf":1001})"), { "yet" }));
  EXPECT_TRUE(
    Mentions(RefusalOfClaims(start + R"("detail":"regions"})"), { "no claims" })); // twice
}

TEST(Token, ExpiresToTheSecond)
{
  const auto token = forged::Token(forged::header, forged::claims);
  EXPECT_EQ(Refusal(token, forged::Keys(), 1999), "");
  EXPECT_TRUE(Mentions(Refusal(token, forged::Keys(), 2000), { "expired" }));
}

TEST(Token, MayBeRevoked)
{
  const auto token = forged::Token(
    forged::header, R"({"sub":"ann","exp":2000,"models":"*","detail":"levels","jti":"t1"})");
  auto keys = forged::Keys();
  EXPECT_EQ(Refusal(token, keys), "");
  keys.revoked = { "t1" };
  EXPECT_TRUE(Mentions(Refusal(token, keys), { "revoked" }));
  keys.revoked = { "t2" };
  EXPECT_EQ(Refusal(token, keys), "");
  keys.revokedSubjects = { "ann" };
  EXPECT_TRUE(Mentions(Refusal(token, keys), { "revoked" }));
}

// The token is truncated at each byte, and each bit of each byte is changed. (Two bits of the
// signature's last digit do not belong to the signature.)
TEST(Token, NothingButTheTokenItselfIsValid)
{
  const auto token = forged::Token(forged::header, forged::claims);
  ASSERT_EQ(Refusal(token), "");
  for (std::size_t size = 0; size < token.size(); ++size)
  {
    EXPECT_NE(Refusal(token.substr(0, size)), "") << size;
    EXPECT_NE(Refusal(token.substr(size + 1)), "") << size;
  }
  for (std::size_t at = 0; at + 1 < token.size(); ++at)
  {
    for (unsigned bit = 0; bit < 8; ++bit)
    {
      auto changed = token;
      changed[at] = static_cast<char>(changed[at] ^ (1 << bit));
      EXPECT_NE(Refusal(changed), "") << at << " " << bit;
    }
  }
  for (const std::string& more : { token + "=", token + ".", token + " ", " " + token, token + "A",
         "." + token, token + "." + token, token + std::string(1, '\0') })
  {
    EXPECT_NE(Refusal(more), "") << more;
  }
}

TEST(Token, IsOfABoundedSize)
{
  const std::string none =
    "the token is incomplete: it must have three parts with dots between them, and at most 4096 "
    "bytes. Copy it again from its source";
  EXPECT_EQ(Refusal(std::string(1 << 20, 'A')), none);
  EXPECT_EQ(Refusal("garbage"), none);
  std::string models = "[\"a\"";
  while (models.size() < maximumTokenBytes)
  {
    models += ",\"a\"";
  }
  EXPECT_EQ(
    RefusalOfClaims(R"({"sub":"ann","exp":2000,"detail":"levels","models":)" + models + "]}"),
    none);
  EXPECT_TRUE(Mentions(RefusalOfClaims(std::string(2500, '[')), { "no claims" }));
}

TEST(Token, IsNotReportedInRefusals)
{
  const auto reported = RefusalOfClaims(R"({"sub":"verysecret\n","exp":2000})") +
                        RefusalOfHeader(R"({"alg":"verysecret"})") + Refusal("verysecret.x.y");
  EXPECT_EQ(reported.find("verysecret"), reported.npos);
}

TEST(Guard, KnowsATokenForAsLongAsItIsValid)
{
  std::int64_t time = now;
  TokenGuard guard(forged::Keys(), [&time] { return time; });
  EXPECT_FALSE(guard.Admit(""));
  const auto pass = guard.Admit(forged::Token(forged::header, forged::claims));
  ASSERT_TRUE(pass);
  EXPECT_EQ((*pass)->claims.subject, "ann");
  EXPECT_TRUE(guard.Check(**pass));
  time = 2000;
  EXPECT_TRUE(FailsAt(guard.Check(**pass), ErrorCode::InvalidInput, "expired"));
  time = now;
  EXPECT_TRUE(guard.Check(**pass));
  auto keys = forged::Keys();
  keys.revokedSubjects = { "bob" };
  guard.Replace(keys);
  EXPECT_TRUE(guard.Check(**pass));
  keys.revokedSubjects = { "ann" };
  guard.Replace(keys);
  EXPECT_TRUE(FailsAt(guard.Check(**pass), ErrorCode::InvalidInput, "revoked"));
  guard.Replace({ { { "", std::string(32, 'x') } }, {}, {} });
  EXPECT_TRUE(FailsAt(guard.Check(**pass), ErrorCode::InvalidInput, "signature"));
  guard.Replace(forged::Keys());
  EXPECT_TRUE(guard.Check(**pass));
}

TEST(Guard, FindsTheTokenInTheFieldsOfARequest)
{
  EXPECT_EQ(FindToken("Bearer a.b.c"), "a.b.c");
  EXPECT_EQ(FindToken("bearer   a.b.c "), "a.b.c");
  EXPECT_EQ(FindToken("Bearer"), "");
  EXPECT_EQ(FindToken(""), "");
  EXPECT_EQ(FindToken("Basic YTpi"), "");
  EXPECT_EQ(FindToken("Bearers a.b.c"), "");
  EXPECT_EQ(FindToken("", "kdstream.v2, a.b.c"), "a.b.c");
  EXPECT_EQ(FindToken("", "a.b.c,kdstream.v2"), "a.b.c");
  EXPECT_EQ(FindToken("", "kdstream.v2,,"), "");
  EXPECT_EQ(FindToken("Bearer a.b.c", "kdstream.v2, d.e.f"), "a.b.c");
  EXPECT_EQ(FindToken("Basic YTpi", "kdstream.v2, d.e.f"), "d.e.f");
}

}
