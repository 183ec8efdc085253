// SPDX-License-Identifier: BSD-3-Clause
// Members that all JSON forms of a description share. Internal: not installed.
#pragma once

#include "filters/model/JsonReader.h"
#include "filters/model/JsonWriter.h"
#include "filters/model/ModelDescription.h"

#include <cstdint>
#include <string>
#include <string_view>

namespace kdstream
{

// Up to this number every integer is exact in a client whose numbers are doubles.
inline constexpr std::uint64_t mostCount = std::uint64_t{ 1 } << 53;

// Names in JSON: "float32", "float64"; "triangles", "points"; "point", "cell".
std::string_view NameOf(ScalarType type);
std::string_view NameOf(PrimitiveType type);
std::string_view NameOf(AttributeAssociation association);

// Writes {"name","type","association","components"}, as texts.
void PutAttributes(JsonWriter& json, const std::vector<AttributeInfo>& attributes);
// Writes "title", "credit", "license", "unit"; and "description" if the model has one.
void PutTexts(JsonWriter& json, const ModelDescription& model);
void PutUnlessEmpty(JsonWriter& json, const char* key, const std::string& text);
// Writes "pose" if the model has a home view.
void PutHomeView(JsonWriter& json, const ModelDescription& model);
// Writes the textures as member `key` if the model has textures.
void PutTextures(JsonWriter& json, const ModelDescription& model, const char* key = "textures");

// Writes {"lo","hi"}.
void PutBox(JsonWriter& json, const Box& box);
// Writes the members of a resolution, without the object around them; and those of all levels.
void PutResolution(JsonWriter& json, const ResolutionDescription& resolution);
void PutLevels(JsonWriter& json, const std::vector<ResolutionDescription>& levels);

// Writes "unused" if the model has unused vertices.
void PutUnused(JsonWriter& json, const ModelDescription& model);
// Writes "scalars" if the model has any: {"classes","name","range"}. "classes": each value,
// followed by its number of vertices; "range": smallest, low, high and largest value.
void PutScalars(JsonWriter& json, const ModelDescription& model);
// Writes the bits of an axis, or "lossless".
void PutBits(JsonWriter& json, const CoordinateGrid& grid);

// Reads the members that all forms have: counts, depths, box, levels, original, home view (`pose`)
// and textures.
void ReadShared(JsonReader& reader, const JsonValue& object, ModelDescription& model);
void ReadScalars(JsonReader& reader, const JsonValue& object, ModelDescription& model);
// Writes, and reads, the members that stores and servers have in common. mostText: maximum bytes of
// each text.
void PutDescription(JsonWriter& json, const ModelDescription& model);
void ReadDescription(
  JsonReader& reader, const JsonValue& json, std::size_t mostText, ModelDescription& model);

void ReadTexts(
  JsonReader& reader, const JsonValue& object, std::size_t mostBytes, ModelDescription& model);

}
