// SPDX-License-Identifier: BSD-3-Clause
// Argument: the library of faults.
#include "Testing/Faults/Operations.h"

#include <gtest/gtest.h>

std::string kdstream::fixtures::faultLibrary;

int main(int argc, char** argv)
{
  testing::InitGoogleTest(&argc, argv);
  kdstream::fixtures::faultLibrary = argc > 1 ? std::filesystem::absolute(argv[1]).string() : "";
  return RUN_ALL_TESTS();
}
