// SPDX-License-Identifier: BSD-3-Clause
#include "filters/page/IiifManifest.h"

#include "filters/model/JsonWriter.h"
#include "filters/page/ModelPage.h"
#include "filters/page/ModelPicture.h"
#include "filters/page/PageTexts.h"
#include "filters/page/PreviewGlb.h"
#include "filters/protocol/ResourcePath.h"

namespace kdstream
{

namespace
{

// Writes a text in one language: { "de": ["…"] }, or "none". Viewers take a text from < to > for
// HTML, unless a space follows.
void PutInLanguage(
  JsonWriter& json, std::string_view key, const std::string& text, const std::string& language)
{
  json.Key(key)
    .BeginObject()
    .Key(language.empty() ? "none" : language)
    .BeginArray()
    .Put(text.starts_with('<') && text.ends_with('>') ? text + ' ' : text)
    .EndArray()
    .EndObject();
}

class ManifestWriter
{
public:
  ManifestWriter(const ModelDescription& model, const PagePlace& place)
    : Model(model)
    , Place(place)
    , Id(place.Manifest(model.id))
  {
  }

  std::string Write(std::span<const Note> notes)
  {
    const auto texts = TextsOf(this->Model);
    this->Json.BeginObject()
      .Member("@context", "http://iiif.io/api/presentation/4/context.json")
      .Member("id", this->Id)
      .Member("type", "Manifest");
    PutInLanguage(this->Json, "label", texts.title, "");
    PutInLanguage(this->Json, "summary", texts.summary, "");
    this->PutRights();
    this->PutPlaces();
    this->Json.Key("items").BeginArray();
    this->PutScene(texts.title, notes);
    this->Json.EndArray().EndObject();
    return this->Json.Text();
  }

private:
  void PutRights()
  {
    if (!this->Model.credit.empty())
    {
      this->Json.Key("requiredStatement").BeginObject();
      PutInLanguage(this->Json, "label", "Attribution", "en");
      PutInLanguage(this->Json, "value", this->Model.credit, "");
      this->Json.EndObject();
    }
    if (IsWebAddress(this->Model.license))
    {
      this->Json.Member("rights", this->Model.license);
    }
    else if (!this->Model.license.empty())
    {
      this->Json.Key("metadata").BeginArray().BeginObject();
      PutInLanguage(this->Json, "label", "License", "en");
      PutInLanguage(this->Json, "value", this->Model.license, "");
      this->Json.EndObject().EndArray();
    }
  }

  void PutPlaces()
  {
    if (HasPicture(this->Model))
    {
      this->Json.Key("thumbnail")
        .BeginArray()
        .BeginObject()
        .Member("id", this->Place.Picture(this->Model.id))
        .Member("type", "Image")
        .Member("format", "image/jpeg")
        .Member("width", pictureWidth)
        .Member("height", pictureHeight)
        .EndObject()
        .EndArray();
    }
    this->Json.Key("homepage")
      .BeginArray()
      .BeginObject()
      .Member("id", this->Place.Page(this->Model.id))
      .Member("type", "Text")
      .Member("format", "text/html");
    PutInLanguage(this->Json, "label", TextsOf(this->Model).title, "");
    this->Json.EndObject().EndArray();
  }

  void PutScene(const std::string& title, std::span<const Note> notes)
  {
    this->Json.BeginObject().Member("id", this->Scene()).Member("type", "Scene");
    PutInLanguage(this->Json, "label", title, "");
    this->Json.Key("items").BeginArray();
    this->BeginPage("#content");
    this->BeginAnnotation("#model", "painting");
    const bool isGlb = HasPreviewGlb(this->Model); // otherwise the address that our viewers open
    this->Json.Key("body")
      .BeginObject()
      .Member("id", isGlb ? this->Place.Preview(this->Model.id, this->Model.digest)
                          : this->Place.Base() + protocol::ModelPath(this->Model.id).substr(1))
      .Member("type", "Model")
      .Member("format", isGlb ? "model/gltf-binary" : "application/json")
      .EndObject();
    this->PutTarget("");
    this->Json.EndObject();
    this->EndPage();
    this->Json.EndArray();
    if (!notes.empty())
    {
      this->Json.Key("annotations").BeginArray();
      this->BeginPage("#notes");
      for (std::size_t i = 0; i < notes.size(); ++i)
      {
        this->PutNote(notes[i], i + 1);
      }
      this->EndPage();
      this->Json.EndArray();
    }
    this->Json.EndObject();
  }

  void PutNote(const Note& note, std::size_t number)
  {
    this->BeginAnnotation("#note-" + std::to_string(number), "commenting");
    PutInLanguage(this->Json, "label", note.title, note.language);
    this->Json.Key("body")
      .BeginObject()
      .Member("type", "TextualBody")
      .Member("format", "text/plain");
    if (!note.language.empty())
    {
      this->Json.Member("language", note.language);
    }
    this->Json.Member("value", note.text.empty() ? note.title : note.text).EndObject();
    this->PutTarget(note.link);
    this->Json.EndObject();
  }

  // Writes the scene, or a view of it in the form used in links.
  void PutTarget(const std::string& view)
  {
    this->Json.Key("target");
    if (view.empty())
    {
      this->Json.BeginObject().Member("id", this->Scene()).Member("type", "Scene").EndObject();
      return;
    }
    this->Json.BeginObject().Member("type", "SpecificResource").Key("source");
    this->Json.BeginObject().Member("id", this->Scene()).Member("type", "Scene").EndObject();
    this->Json.Key("selector")
      .BeginObject()
      .Member("type", "FragmentSelector")
      .Member("value", view)
      .EndObject()
      .EndObject();
  }

  std::string Scene() const { return this->Id + "#scene"; }
  void BeginPage(const std::string& name)
  {
    this->Json.BeginObject()
      .Member("id", this->Id + name)
      .Member("type", "AnnotationPage")
      .Key("items")
      .BeginArray();
  }
  void EndPage() { this->Json.EndArray().EndObject(); }
  void BeginAnnotation(const std::string& name, const std::string& motivation)
  {
    this->Json.BeginObject()
      .Member("id", this->Id + name)
      .Member("type", "Annotation")
      .Key("motivation")
      .BeginArray()
      .Put(motivation)
      .EndArray();
  }

  const ModelDescription& Model;
  const PagePlace& Place;
  const std::string Id;
  JsonWriter Json;
};

}

std::string WriteIiifManifest(
  const ModelDescription& model, const PagePlace& place, std::span<const Note> notes)
{
  return ManifestWriter(model, place).Write(notes);
}

}
