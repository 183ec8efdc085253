// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/ErrorAt.h"
#include "filters/model/Notes.h"

#include "filters/core/Texts.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <random>

using namespace kdstream;

namespace
{

const std::vector<Note> threeNotes{ { "The crack", "It is from 1687.\nLook closely.",
                                      "model=dragon&view=AX9", "en" },
  { "<b>Bold</b>", "<script>alert(1)</script> & \"quotes\"", "model=dragon", "" },
  { "Der Schweif", "Größe: 3 µm \U0001F409", "model=other&view=%00", "de" } };

nlohmann::json Written(const std::vector<Note>& notes = threeNotes)
{
  return nlohmann::json::parse(FormatNotes(notes));
}

std::string ErrorOf(const nlohmann::json& json)
{
  const auto notes = ParseNotes(json.dump());
  return notes ? "" : notes.GetError().message;
}

// UTF-8 of up to `most` characters, of one to four bytes each.
std::string RandomText(std::mt19937_64& random, std::size_t most)
{
  static const char* const characters[] = { "a", "<", "\"", "\\", "\n", "&", "\x01", "ä", "ع", "€",
    "\U0001F409" };
  std::string text;
  for (std::size_t left = random() % (most + 1); left > 0; --left)
  {
    text += characters[random() % std::size(characters)];
  }
  return text;
}

}

TEST(Notes, ComeBackAsTheyWere)
{
  EXPECT_EQ(*ParseNotes(FormatNotes(threeNotes)), threeNotes);
  EXPECT_EQ(*ParseNotes(FormatNotes({})), std::vector<Note>());
  std::mt19937_64 random(1);
  for (int round = 0; round < 300; ++round)
  {
    std::vector<Note> notes(random() % 5);
    for (Note& note : notes)
    {
      note = { "t" + RandomText(random, 199), RandomText(random, round % 50 == 0 ? 4000 : 40),
        RandomText(random, 400), random() % 2 ? "de-AT" : "" };
    }
    const auto back = ParseNotes(FormatNotes(notes));
    ASSERT_TRUE(back) << back.GetError().message;
    EXPECT_EQ(*back, notes);
  }
}

TEST(Notes, AreAListOfAnnotations)
{
  const auto json = Written();
  EXPECT_EQ(json["@context"], "http://iiif.io/api/presentation/3/context.json");
  EXPECT_EQ(json["type"], "AnnotationPage");
  const auto& first = json["items"][0];
  EXPECT_EQ(first["type"], "Annotation");
  EXPECT_EQ(first["label"]["en"][0], "The crack");
  EXPECT_EQ(json["items"][1]["label"]["none"][0], "<b>Bold</b>");
  EXPECT_EQ(first["body"]["format"], "text/plain");
  EXPECT_EQ(first["body"]["value"], threeNotes[0].text);
  EXPECT_EQ(first["target"]["type"], "SpecificResource");
  EXPECT_EQ(first["target"]["selector"]["value"], threeNotes[0].link);
}

TEST(Notes, OfOtherAuthorsAreTaken)
{
  auto json = Written();
  json["items"][0]["creator"] = { { "name", "Ann" }, { "deep", { { { 1, 2 } } } } };
  json["seeAlso"] = nullptr;
  json["items"][0]["label"] = { { "fr", { "La fente" } }, { "en", { "The crack", "or fissure" } } };
  json["items"][1]["label"] = "<b>Bold</b>";
  json["items"][1]["body"]["format"] = "text/html"; // is read as plain text nevertheless
  EXPECT_EQ(*ParseNotes(json.dump()), threeNotes);
  json["items"][0]["body"].erase("language");
  EXPECT_EQ((*ParseNotes(json.dump()))[0].title, "The crack"); // the first one in the order in
                                                               // which nlohmann writes them
}

TEST(Notes, WhatIsWrongIsNamed)
{
  const auto with = [](const std::string& pointer, const nlohmann::json& value)
  {
    auto json = Written();
    json[nlohmann::json::json_pointer(pointer)] = value;
    return ErrorOf(json);
  };
  EXPECT_EQ(with("/type", "Manifest"), "notes: \"type\" is not AnnotationPage");
  EXPECT_EQ(with("/items", 7), "notes: \"items\" must be an array of at most 100 values");
  EXPECT_EQ(with("/items/1", "x"), "note 2: an object was expected, not \"x\"");
  EXPECT_EQ(with("/items/1/type", "Canvas"), "note 2: \"type\" is not Annotation");
  EXPECT_EQ(with("/items/2/body", nullptr), "note 3: an object was expected, not null");
  EXPECT_EQ(with("/items/2/body/type", "Image"), "note 3: \"type\" is not TextualBody");
  EXPECT_EQ(with("/items/2/body/value", 3), "note 3: \"value\" is \"3\", not a string");
  EXPECT_EQ(with("/items/2/body/language", "d\"e"), "note 3: \"language\" is not a language code");
  EXPECT_EQ(with("/items/0/label", 3), "note 1: \"label\" must contain a text");
  EXPECT_EQ(
    with("/items/0/label", nlohmann::json::object()), "note 1: \"label\" must contain a text");
  EXPECT_EQ(
    with("/items/0/label/en", nlohmann::json::array()), "note 1: \"label\" must contain a text");
  EXPECT_EQ(with("/items/0/label/en", { " \n" }), "note 1: \"label\" is empty");
  EXPECT_EQ(with("/items/0/target", "dragon"), "note 1: an object was expected, not \"dragon\"");
  EXPECT_EQ(with("/items/0/target/selector", nlohmann::json::array()),
    "note 1: an object was expected, not an array");
  auto json = Written();
  json["items"][1].erase("target");
  EXPECT_EQ(ErrorOf(json), "note 2: \"target\" is missing");
}

TEST(Notes, AreBounded)
{
  const std::string dragon = "\U0001F409";
  const auto repeated = [](const std::string& text, std::size_t times)
  {
    std::string all;
    for (; times > 0; --times)
    {
      all += text;
    }
    return all;
  };
  const auto errorWith = [](const Note& note) { return ErrorOf(Written({ note })); };
  EXPECT_EQ(
    errorWith({ repeated(dragon, 200), repeated(dragon, 4000), std::string(2048, 'x') }), "");
  EXPECT_EQ(
    errorWith({ repeated("a", 201), "", "" }), "note 1: \"label\" is longer than 200 characters");
  EXPECT_EQ(errorWith({ "a", repeated("b", 4001), "" }),
    "note 1: \"value\" is longer than 4000 characters");
  EXPECT_EQ(
    errorWith({ "a", "", std::string(2049, 'x') }), "note 1: \"value\" is longer than 2048 bytes");
  const Note note{ "a", "", "" };
  EXPECT_EQ(ParseNotes(FormatNotes(std::vector(100, note)))->size(), 100u);
  EXPECT_EQ(ErrorOf(Written(std::vector(101, note))),
    "notes: \"items\" must be an array of at most 100 values");
  auto text = FormatNotes({ note });
  text.resize(maximumNotesBytes, ' ');
  EXPECT_TRUE(ParseNotes(text));
  text += ' ';
  ASSERT_FALSE(ParseNotes(text));
  EXPECT_EQ(ParseNotes(text).GetError().code, ErrorCode::LimitExceeded);
}

TEST(Notes, HostileFilesAreRefusedWithAReason)
{
  EXPECT_TRUE(fixtures::FailsAt(ParseNotes(""), ErrorCode::InvalidInput, "byte 0"));
  EXPECT_FALSE(ParseNotes("[]"));
  EXPECT_FALSE(ParseNotes(std::string(maximumNotesBytes, '[')));
  EXPECT_FALSE(ParseNotes("\xff\xfe{}"));
  const std::string half =
    R"({"type":"AnnotationPage","items":[{"type":"Annotation","label":")"
    "\\udc00"
    R"(","body":{"type":"TextualBody","value":""},"target":{"selector":{"value":""}}}]})";
  EXPECT_EQ(
    ParseNotes(half).GetError().message, "note 1: \"label\" contains an unpaired surrogate");
}

// Damage as caused by a disk, or by an author's editor.
TEST(Notes, DamageIsRefusedOrHarmless)
{
  const auto whole = FormatNotes(threeNotes);
  std::mt19937_64 random(2);
  int taken = 0;
  for (int round = 0; round < 20000; ++round)
  {
    std::string text = whole;
    for (auto changes = 1 + random() % 3; changes > 0; --changes)
    {
      const auto at = random() % text.size();
      random() % 4 == 0 ? text.erase(at, 1 + random() % 40)
                        : text.replace(at, 1, 1, static_cast<char>(random()));
    }
    const auto notes = ParseNotes(text);
    if (!notes)
    {
      EXPECT_FALSE(notes.GetError().message.empty());
      continue;
    }
    ++taken;
    for (const Note& note : *notes)
    {
      EXPECT_TRUE(IsUtf8(note.title) && IsUtf8(note.text) && IsUtf8(note.link));
      EXPECT_TRUE(!note.title.empty() && note.title.size() <= 800 && note.text.size() <= 16000);
    }
    EXPECT_EQ(*ParseNotes(FormatNotes(*notes)), *notes);
  }
  EXPECT_GT(taken, 1000);
}
