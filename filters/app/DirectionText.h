// SPDX-License-Identifier: BSD-3-Clause
// Directions on a command line and in what programs say: "0,0,1"; and places.
#pragma once

#include "filters/model/ModelDescription.h"
#include "filters/program/Program.h"

#include <optional>
#include <string>

namespace kdstream
{

// An option that takes X,Y,Z, of any length but 0; `direction` gets it with length 1.
CLI::Option* AddDirectionOption(
  CLI::App& app, const std::string& name, std::optional<Vec3>& direction, const std::string& help);

// "+z" of an axis, else "0.6,0,-0.8".
std::string DirectionText(const Vec3& direction);

// "26 vertices that no triangle uses, the farthest at (0, 0, 0)", or ", within the model's box".
// REQUIRES: there are some.
std::string UnusedText(const ModelDescription& model);

}
