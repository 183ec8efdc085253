// SPDX-License-Identifier: BSD-3-Clause
// The error message if a model lacks the array that was requested for its colours.
#include "viewer/desktop/CheckColors.h"

#include <gtest/gtest.h>

using namespace kdstream;

namespace
{

ColorChoice By(const std::string& name)
{
  return { SurfaceColoring::Attribute, name };
}

std::string Refused(const std::string& name, const std::vector<ScalarDescription>& scalars)
{
  const Status status = CheckColors(By(name), scalars);
  EXPECT_FALSE(status);
  return status ? "" : status.GetError().message;
}

const ScalarDescription height{ "height", 0, 1, 0, 1, {} };

}

TEST(CheckColors, ArraysOfFacesAreSaidNotToBeShown)
{
  const std::string begin = "the model has no array of numbers 'quality' to colour it by; it has ";
  EXPECT_EQ(Refused("quality", {}), begin + "none; arrays of faces cannot be shown");
  EXPECT_EQ(Refused("quality", { height }), begin + "'height'; arrays of faces cannot be shown");
}

TEST(CheckColors, ASlipIsSaidToBeOne)
{
  EXPECT_EQ(Refused("hight", { height }),
    "the model has no array of numbers 'hight' to colour it by; it has 'height'; did you mean "
    "height?");
}

TEST(CheckColors, WhatThereIsCanBeHad)
{
  EXPECT_TRUE(CheckColors(By("height"), std::vector<ScalarDescription>{ height }));
  EXPECT_TRUE(CheckColors({ SurfaceColoring::Stone }, {}));
}
