// SPDX-License-Identifier: BSD-3-Clause
#include "filters/model/Notes.h"

#include "filters/core/Texts.h"
#include "filters/model/JsonReader.h"
#include "filters/model/JsonWriter.h"

#include <algorithm>

namespace kdstream
{
namespace
{

constexpr const char* context = "http://iiif.io/api/presentation/3/context.json";
constexpr std::size_t mostBytesOfCharacter = 4;

std::string ReadText(JsonReader& reader, const JsonValue& value, const char* key, std::size_t most)
{
  auto text = reader.TextIn(value, key, most * mostBytesOfCharacter);
  if (CountCharacters(text) > most)
  {
    reader.Fail(
      std::string("\"") + key + "\" is longer than " + std::to_string(most) + " characters");
  }
  return text;
}

void ReadType(JsonReader& reader, const JsonValue& object, std::string_view wanted)
{
  if (reader.Text(object, "type", 64) != wanted)
  {
    reader.Fail("\"type\" is not " + std::string(wanted));
  }
}

// Whether the text consists of letters, digits and hyphens.
bool IsLanguage(std::string_view text)
{
  return std::all_of(text.begin(), text.end(),
    [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-';
    });
}

void ReadBody(JsonReader& reader, const JsonValue& object, Note& note)
{
  const JsonValue* body = reader.Find(object, "body");
  if (!body)
  {
    return;
  }
  ReadType(reader, *body, "TextualBody");
  if (const JsonValue* text = reader.Find(*body, "value"))
  {
    note.text = ReadText(reader, *text, "value", Note::longestText);
  }
  note.language = reader.Text(*body, "language", Note::longestLanguage, false);
  if (!IsLanguage(note.language))
  {
    reader.Fail("\"language\" is not a language code");
  }
}

// The texts of a label in the given language; otherwise in the first language that it has.
const JsonValue* FindLanguage(const JsonValue& label, const std::string& language)
{
  const JsonValue* own = FindMember(label, language);
  return own ? own : label.Size() > 0 ? &(*label.GetObject().begin()).value : nullptr;
}

// Reads a text, or texts by language: { "en": [ "…" ] }.
void ReadLabel(JsonReader& reader, const JsonValue& object, Note& note)
{
  const JsonValue* label = reader.Find(object, "label");
  if (!label)
  {
    return;
  }
  const JsonValue* title = label;
  if (label->IsObject())
  {
    title = FindLanguage(*label, note.language);
    title = title && title->IsArray() && title->Size() > 0 ? &(*title)[0] : title;
  }
  if (!title || !title->IsString())
  {
    reader.Fail("\"label\" must contain a text");
    return;
  }
  note.title = ReadText(reader, *title, "label", Note::longestTitle);
  if (note.title.find_first_not_of(" \t\r\n") == std::string::npos)
  {
    reader.Fail("\"label\" is empty");
  }
}

void ReadTarget(JsonReader& reader, const JsonValue& object, Note& note)
{
  const JsonValue* target = reader.Find(object, "target");
  const JsonValue* selector = target ? reader.Find(*target, "selector") : nullptr;
  if (selector)
  {
    note.link = reader.Text(*selector, "value", Note::longestLink);
  }
}

Note ReadNote(JsonReader& reader, const JsonValue& object)
{
  Note note;
  ReadType(reader, object, "Annotation");
  ReadBody(reader, object, note);
  ReadLabel(reader, object, note);
  ReadTarget(reader, object, note);
  return note;
}

void PutNote(JsonWriter& json, const Note& note)
{
  json.BeginObject().Member("type", "Annotation").Member("motivation", "commenting").Key("label");
  json.BeginObject()
    .Key(note.language.empty() ? "none" : note.language)
    .BeginArray()
    .Put(note.title)
    .EndArray()
    .EndObject();
  json.Key("body")
    .BeginObject()
    .Member("type", "TextualBody")
    .Member("format", "text/plain")
    .Member("value", note.text);
  if (!note.language.empty())
  {
    json.Member("language", note.language);
  }
  json.EndObject().Key("target").BeginObject().Member("type", "SpecificResource");
  json
    .Member("source", "model.json") // relative to where the file is served
    .Key("selector")
    .BeginObject()
    .Member("type", "FragmentSelector")
    .Member("value", note.link)
    .EndObject();
  json.EndObject().EndObject();
}

}

Result<std::vector<Note>> ParseNotes(std::string_view text)
{
  if (text.size() > maximumNotesBytes)
  {
    return Error{ ErrorCode::LimitExceeded,
      "the notes are too large: at most " + std::to_string(maximumNotesBytes) + " bytes together" };
  }
  const auto json = ParseJson(text);
  KDSTREAM_TRY(json);
  JsonReader page("notes");
  ReadType(page, *json, "AnnotationPage");
  const JsonValue* items = page.Array(*json, "items", mostNotes);
  if (!page.Good())
  {
    return Error{ ErrorCode::InvalidInput, page.Fault() };
  }
  std::vector<Note> notes;
  notes.reserve(items->Size());
  for (const JsonValue& item : items->GetArray())
  {
    JsonReader reader("note " + std::to_string(notes.size() + 1));
    notes.push_back(ReadNote(reader, item));
    if (!reader.Good())
    {
      return Error{ ErrorCode::InvalidInput, reader.Fault() };
    }
  }
  return notes;
}

std::string FormatNotes(const std::vector<Note>& notes)
{
  JsonWriter json({ 2 });
  json.BeginObject().Member("@context", context).Member("type", "AnnotationPage").Key("items");
  json.BeginArray();
  for (const Note& note : notes)
  {
    PutNote(json, note);
  }
  json.EndArray().EndObject();
  return json.Text() + "\n";
}

}
