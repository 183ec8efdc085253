// SPDX-License-Identifier: BSD-3-Clause
#include "viewer/desktop/window/NotesPanel.h"

#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <utility>

namespace kdstream
{
namespace
{

constexpr double panelWidth = 300; // points

void Wrapped(const std::string& text)
{
  ImGui::PushTextWrapPos(0);
  ImGui::TextUnformatted(text.data(), text.data() + text.size());
  ImGui::PopTextWrapPos();
}

bool ButtonUnless(bool disabled, const char* label)
{
  ImGui::BeginDisabled(disabled);
  const bool pressed = ImGui::Button(label);
  ImGui::EndDisabled();
  return pressed;
}

}

NotesWishes NotesPanel::Draw(const NotesBook& book, int width, double ratio)
{
  NotesWishes wishes;
  this->Ratio = ratio;
  const auto draft = this->Drafts.find(book.Model());
  const auto scaled = [&](double points) { return static_cast<float>(points * ratio); };
  ImGui::SetNextWindowPos(
    { static_cast<float>(width) - scaled(10), scaled(64) }, ImGuiCond_Appearing, { 1, 0 });
  ImGui::SetNextWindowSize({ scaled(panelWidth), scaled(360) }, ImGuiCond_Appearing);
  if (ImGui::Begin("Notes", &this->isOpen,
        ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoCollapse)) // Tab stays in fields
  {
    if (draft != this->Drafts.end())
    {
      this->DrawFields(draft->second, book.Model(), wishes);
    }
    else if (book.Shown())
    {
      this->DrawShown(book, wishes);
    }
    else
    {
      this->DrawList(book, wishes);
    }
  }
  ImGui::End();
  return wishes;
}

void NotesPanel::DrawShown(const NotesBook& book, NotesWishes& wishes) const
{
  const std::size_t at = *book.Shown();
  const std::size_t all = book.Notes().size();
  if (ButtonUnless(at == 0, "Previous"))
  {
    wishes.show = at - 1;
  }
  ImGui::SameLine();
  if (ButtonUnless(at + 1 == all, "Next"))
  {
    wishes.show = at + 1;
  }
  ImGui::SameLine();
  wishes.list = ImGui::Button("All notes");
  ImGui::SameLine();
  ImGui::TextDisabled("%zu of %zu", at + 1, all);
  ImGui::Separator();
  Wrapped(book.Notes()[at].title);
  ImGui::Spacing();
  Wrapped(book.Notes()[at].text);
}

void NotesPanel::DrawList(const NotesBook& book, NotesWishes& wishes)
{
  const std::vector<Note>& notes = book.Notes();
  if (notes.empty())
  {
    Wrapped(
      "This model has no notes yet. A note stores the current view, with a title and a text.");
  }
  for (std::size_t i = 0; i < notes.size(); ++i)
  {
    ImGui::PushID(static_cast<int>(i));
    // ImGui does not show what follows ## in a label. So titles are no labels: they are shown
    // whole.
    if (ImGui::Selectable("##note"))
    {
      wishes.show = i;
    }
    ImGui::SameLine(0, 0);
    Wrapped(std::to_string(i + 1) + ". " + notes[i].title);
    if (ImGui::SmallButton("Edit"))
    {
      this->Edit(book.Model(), i, notes[i]);
    }
    for (const auto& [label, step] : { std::pair{ "Up", -1 }, { "Down", 1 } })
    {
      ImGui::SameLine();
      if (ImGui::SmallButton(label))
      {
        wishes.move = { i, step };
      }
    }
    ImGui::SameLine();
    if (ImGui::SmallButton("Remove"))
    {
      wishes.remove = i;
    }
    ImGui::PopID();
  }
  ImGui::Separator();
  if (ImGui::Button("Add a note here"))
  {
    this->Edit(book.Model(), {}, {});
  }
  ImGui::SameLine();
  wishes.save = ButtonUnless(!book.IsUnsaved(), "Save notes");
}

void NotesPanel::DrawFields(Fields& fields, const std::string& model, NotesWishes& wishes)
{
  ImGui::TextUnformatted("Title");
  ImGui::SetNextItemWidth(-1);
  if (std::exchange(fields.isNew, false))
  {
    ImGui::SetKeyboardFocusHere();
  }
  const bool goesOn =
    ImGui::InputText("##title", &fields.title, ImGuiInputTextFlags_EnterReturnsTrue);
  ImGui::TextUnformatted("Text");
  const float buttons = 2 * ImGui::GetFrameHeightWithSpacing();
  const float room = ImGui::GetContentRegionAvail().y - buttons;
  if (goesOn)
  {
    ImGui::SetKeyboardFocusHere();
  }
  ImGui::InputTextMultiline(
    "##text", &fields.text, { -1, std::max(room, static_cast<float>(60 * this->Ratio)) });
  if (ImGui::Button("Keep this note"))
  {
    wishes.keep = { fields.index, fields.title, fields.text };
  }
  ImGui::SameLine();
  if (ImGui::Button("Cancel"))
  {
    this->EndEdit(model);
  }
}

void NotesPanel::Edit(const std::string& model, std::optional<std::size_t> index, const Note& note)
{
  this->Drafts[model] = { index, note.title, note.text, note.title, note.text };
}

bool NotesPanel::HasDraft() const
{
  return std::any_of(this->Drafts.begin(), this->Drafts.end(),
    [](const auto& draft)
    {
      const Fields& fields = draft.second;
      return fields.title != fields.oldTitle || fields.text != fields.oldText;
    });
}

}
