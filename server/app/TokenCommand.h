// SPDX-License-Identifier: BSD-3-Clause
// kdstream-serve token: prints a token (doc/cli.md#token).
#pragma once

#include "filters/program/Program.h"
#include "server/access/Token.h"

#include <string>
#include <vector>

namespace kdstream
{

struct TokenOptions
{
  std::string file, subject, expires = "7d", detail;
  std::vector<std::string> models;
};

// Adds the command `token` to the program's command line.
CLI::App* AddTokenCommand(CLI::App& app, TokenOptions& line);

// Prints the token. Returns the program's exit code.
int PrintToken(const std::string& program, const TokenOptions& line);

}
