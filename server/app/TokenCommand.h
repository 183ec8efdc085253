// SPDX-License-Identifier: BSD-3-Clause
// kdstream-serve token: prints a token (doc/cli.md#tokens).
#pragma once

namespace kdstream
{

// `argv` begins with the command itself. Returns the program's exit code.
int RunTokenCommand(int argc, char** argv);

}
