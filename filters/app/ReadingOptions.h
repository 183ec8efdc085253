// SPDX-License-Identifier: BSD-3-Clause
// Options for reading inputs, which kdstream-build and kdstream-convert share.
#pragma once

#include "filters/meshio/FileEnding.h"
#include "filters/program/Program.h"

#include <string>

namespace kdstream
{

// Adds --strict: see Tolerance.h.
inline CLI::Option* AddStrictOption(CLI::App& app, bool& strict)
{
  return app.add_flag(
    "--strict", strict, "fail instead of warning where input would be dropped or repaired");
}

// Adds --columns "x y z r g b class".
inline CLI::Option* AddColumnsOption(CLI::App& app, std::string& columns)
{
  return app
    .add_option("--columns", columns,
      "names of the columns of an .xyz, .txt, .csv, .pts or .asc: x y z, and r g b, nx ny nz, "
      "intensity, class, - (skip this column) or any other name")
    ->type_name("\"x y z NAMES\"");
}

// Checks that --columns is given only for an input that has columns to name. Errors:
// InvalidArgument.
inline Status CheckColumns(const std::string& columns, const std::string& input)
{
  return columns.empty() || IsPointText(FileEnding(input))
           ? Status()
           : Status(Error{ ErrorCode::InvalidArgument,
               "--columns is only for points as text (.xyz, .txt, .csv, .pts, .asc); the input's "
               "name has another ending" });
}

}
