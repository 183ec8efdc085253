// SPDX-License-Identifier: BSD-3-Clause
// Directions on command lines and in messages, such as "0,0,1"; and places.
#pragma once

#include "filters/model/ModelDescription.h"
#include "filters/program/Program.h"

#include <optional>
#include <string>

namespace kdstream
{

// Adds an option that takes X,Y,Z, of any length but 0; `direction` is set to the vector of length
// 1.
CLI::Option* AddDirectionOption(
  CLI::App& app, const std::string& name, std::optional<Vec3>& direction, const std::string& help);

// "+z" if the direction is along an axis, else "0.6,0,-0.8".
std::string DirectionText(const Vec3& direction);

// "26 vertices that no triangle uses, the farthest at (0, 0, 0)", or ", within the model's box".
// REQUIRES: the model has unused vertices.
std::string UnusedText(const ModelDescription& model);

}
