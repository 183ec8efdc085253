// SPDX-License-Identifier: BSD-3-Clause
#include "filters/protocol/ResourcePath.h"

#include "filters/protocol/Testing/RandomMessages.h"

#include <gtest/gtest.h>

using namespace kdstream;
using namespace kdstream::protocol;
using Kind = ResourcePath::Kind;

namespace
{
const std::string digest = "0123456789abcdef0123456789abcdef";

ErrorCode CodeOf(const std::string& path)
{
  const auto resource = ParseResourcePath(path);
  EXPECT_FALSE(resource) << path;
  return resource ? ErrorCode::Cancelled : resource.GetError().code;
}
}

TEST(TestResourcePath, ParsesEveryPathThatIsMade)
{
  EXPECT_EQ(ParseResourcePath(modelListPath)->kind, Kind::ModelList);
  EXPECT_EQ(ParseResourcePath("/api/models")->kind, Kind::ModelList);
  const auto model = ParseResourcePath(ModelPath("dragon.v2"));
  ASSERT_TRUE(model);
  EXPECT_EQ(model->kind, Kind::Model);
  EXPECT_EQ(model->model, "dragon.v2");
  const auto notes = ParseResourcePath(NotesPath("dragon.v2"));
  ASSERT_TRUE(notes);
  EXPECT_EQ(notes->kind, Kind::Notes);
  EXPECT_EQ(notes->model, "dragon.v2");

  RandomMessages random(2);
  for (int i = 0; i < 500; ++i)
  {
    const auto blob = random.Blob();
    const auto resource = ParseResourcePath(BlobPath("dragon", digest, blob));
    ASSERT_TRUE(resource);
    EXPECT_EQ(resource->kind, Kind::Blob);
    EXPECT_EQ(resource->model, "dragon");
    EXPECT_EQ(resource->digest, digest);
    EXPECT_EQ(resource->blob, blob);
  }
}

TEST(TestResourcePath, UnknownPathsAreNotFound)
{
  for (const std::string path : { "", "/", "/api", "/api/", "/api/models/", "/api/models.jso",
         "/api/models.json/", "/api//models", "/API/models", "api/models", "/api/models/dragon",
         "/api/models/dragon/", "/api/models/dragon/model.json/", "/api/models/dragon/Model.json",
         "/api/models/dragon/tree/1" })
  {
    EXPECT_EQ(CodeOf(path), ErrorCode::NotFound) << path;
  }
  EXPECT_EQ(CodeOf("/api/models/dragon/" + digest), ErrorCode::NotFound);
  EXPECT_EQ(CodeOf("/api/models/dragon/" + digest + "/leaves/1"), ErrorCode::NotFound);
}

TEST(TestResourcePath, MalformedPartsAreInvalid)
{
  for (const std::string path : { "/api/models/../model.json", "/api/models/./model.json",
         "/api/models/%2e%2e/model.json", "/api/models//model.json", "/api/models/a b/model.json" })
  {
    EXPECT_EQ(CodeOf(path), ErrorCode::InvalidArgument) << path;
  }
  const std::string blobs = "/api/models/dragon/";
  EXPECT_EQ(CodeOf(blobs + "xyz/tree/1"), ErrorCode::InvalidArgument);
  EXPECT_EQ(CodeOf(blobs + std::string(32, 'A') + "/tree/1"), ErrorCode::InvalidArgument);
  EXPECT_EQ(CodeOf(blobs + digest + "0/tree/1"), ErrorCode::InvalidArgument);
  EXPECT_EQ(CodeOf(blobs + digest + "/tree/01"), ErrorCode::InvalidArgument);
  EXPECT_EQ(CodeOf(blobs + digest + "/partitions/9999999999"), ErrorCode::InvalidArgument);
}

TEST(TestResourcePath, RandomPathsGiveAnErrorOrAPathThatIsMadeAlike)
{
  RandomMessages random(3);
  const std::string path = BlobPath("dragon", digest, BlobId::LevelPiece(12, 345));
  for (int i = 0; i < 20000; ++i)
  {
    const auto mutated = random.Mutated(path);
    const auto resource = ParseResourcePath(mutated);
    if (resource && resource->kind == Kind::Blob)
    {
      EXPECT_EQ(BlobPath(resource->model, resource->digest, resource->blob), mutated);
    }
    else if (resource && resource->kind == Kind::Model)
    {
      EXPECT_EQ(ModelPath(resource->model), mutated);
    }
  }
}
