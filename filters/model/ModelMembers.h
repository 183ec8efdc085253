// SPDX-License-Identifier: BSD-3-Clause
// The members that a description's forms as JSON share. Internal: not installed.
#pragma once

#include "filters/model/JsonReader.h"
#include "filters/model/JsonWriter.h"
#include "filters/model/ModelDescription.h"

#include <cstdint>
#include <string>
#include <string_view>

namespace kdstream
{

// Every integer up to here is exact in a client whose numbers are doubles.
inline constexpr std::uint64_t mostCount = std::uint64_t{ 1 } << 53;

// "float32", "float64"; "triangles", "points"; "point", "cell".
std::string_view NameOf(ScalarType type);
std::string_view NameOf(PrimitiveType type);
std::string_view NameOf(AttributeAssociation association);

// {"name","type","association","components"}, as texts.
void PutAttributes(JsonWriter& json, const std::vector<AttributeInfo>& attributes);
// "title", "credit", "license", "unit", and "description", if it has one.
void PutTexts(JsonWriter& json, const ModelDescription& model);
void PutUnlessEmpty(JsonWriter& json, const char* key, const std::string& text);
// "pose", if it has one.
void PutHomeView(JsonWriter& json, const ModelDescription& model);
// Its textures as a member `key`, if it has some.
void PutTextures(JsonWriter& json, const ModelDescription& model, const char* key = "textures");

// {"lo","hi"}.
void PutBox(JsonWriter& json, const Box& box);
// The members of a resolution, without the object around them; and all levels.
void PutResolution(JsonWriter& json, const ResolutionDescription& resolution);
void PutLevels(JsonWriter& json, const std::vector<ResolutionDescription>& levels);

// "unused", if the model has such vertices.
void PutUnused(JsonWriter& json, const ModelDescription& model);
// "scalars", if the model has any: {"classes","name","range"}. "classes": each value, followed by
// its number of vertices; "range": smallest, low, high and largest value.
void PutScalars(JsonWriter& json, const ModelDescription& model);
// The bits of an axis, or "lossless".
void PutBits(JsonWriter& json, const CoordinateGrid& grid);

// Reads what all forms have in common: counts, depths, box, levels, original, home view (`pose`)
// and textures.
void ReadShared(JsonReader& reader, const JsonValue& object, ModelDescription& model);
void ReadScalars(JsonReader& reader, const JsonValue& object, ModelDescription& model);
// The members that stores and servers have in common, and back. mostText: bytes of each text.
void PutDescription(JsonWriter& json, const ModelDescription& model);
void ReadDescription(
  JsonReader& reader, const JsonValue& json, std::size_t mostText, ModelDescription& model);

void ReadTexts(
  JsonReader& reader, const JsonValue& object, std::size_t mostBytes, ModelDescription& model);

}
