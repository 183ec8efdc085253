// SPDX-License-Identifier: BSD-3-Clause
#include "server/app/TokenCommand.h"

#include "filters/core/Texts.h"
#include "filters/core/UtcText.h"
#include "server/access/TokenKeys.h"

#include <charconv>
#include <chrono>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

namespace kdstream
{

namespace
{

constexpr const char* examples =
  "Everybody who has the token gets what it allows from a server with the same --tokens, until "
  "it\nexpires. Its id is printed on stderr; to revoke the token, add the id to \"revoked\" in "
  "FILE.\n\n"
  "Example:\n"
  "  kdstream-serve token --tokens tokens.json --sub ann --models dragon,vase --detail levels";

constexpr std::int64_t longest = std::int64_t{ 3660 } * 86400; // about ten years

// Converts "90s", "30m", "12h", "7d" or "4w" to seconds, at most `longest`; 0 for any other text.
std::int64_t SecondsIn(const std::string& text)
{
  std::int64_t count = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
  const std::string unit(end, text.data() + text.size());
  const std::int64_t seconds = unit == "s"   ? 1
                               : unit == "m" ? 60
                               : unit == "h" ? 3600
                               : unit == "d" ? 86400
                               : unit == "w" ? 7 * 86400
                                             : 0;
  const bool fits = error == std::errc{} && seconds != 0 && count > 0 && count <= longest / seconds;
  return fits ? count * seconds : 0;
}

void AddTokenOptions(CLI::App& app, TokenOptions& line)
{
  app.add_option("--tokens", line.file, "the server's key file (JSON)")
    ->type_name("FILE")
    ->required();
  app.add_option("--sub", line.subject, "name of the token's holder, for logs and quotas")
    ->type_name("NAME")
    ->required();
  app
    .add_option(
      "--models", line.models, "models that the token allows, separated by commas; *: all")
    ->type_name("IDS")
    ->delimiter(',')
    ->required();
  app
    .add_option("--detail", line.detail,
      "what the token allows: preview; levels: also all levels; regions: also the original")
    ->check(CLI::IsMember({ "preview", "levels", "regions" }))
    ->required();
  app.add_option("--expires", line.expires, "validity of the token: 90s, 30m, 12h, 7d, 4w")
    ->check(CLI::Validator(
      [](std::string& text)
      {
        return SecondsIn(text) != 0
                 ? std::string()
                 : text + " is not a time: give one such as 30m, 12h, 7d or 4w, at most 10 years";
      },
      ""))
    ->type_name("TIME")
    ->capture_default_str();
}

}

CLI::App* AddTokenCommand(CLI::App& app, TokenOptions& line)
{
  auto* const command = app.add_subcommand(
    "token", "makes a token for clients of a server with --tokens, and prints it");
  command->footer(examples);
  AddTokenOptions(*command, line);
  return command;
}

int PrintToken(const std::string& program, const TokenOptions& line)
{
  const auto keys = ReadTokenKeys(line.file);
  if (!keys)
  {
    return PrintError(program, line.file, keys.GetError());
  }
  TokenClaims claims;
  claims.subject = line.subject;
  const auto now = std::chrono::duration_cast<std::chrono::seconds>(
    std::chrono::system_clock::now().time_since_epoch())
                     .count();
  auto id = MakeTokenId();
  if (!id)
  {
    return PrintError(program, "", id.GetError());
  }
  claims.id = std::move(*id);
  claims.expires = now + SecondsIn(line.expires);
  claims.allModels = line.models == std::vector<std::string>{ "*" };
  claims.models = claims.allModels ? std::vector<std::string>() : line.models;
  claims.detail = *ParseDetail(line.detail);
  const auto token = WriteToken(claims, *keys, now);
  if (!token)
  {
    return PrintError(program, "", token.GetError());
  }
  std::cerr << program << ": token " << claims.id << " of " << claims.subject << ", valid until "
            << UtcText(claims.expires) << std::endl;
  std::cout << *token << std::endl;
  return exitDone;
}

}
