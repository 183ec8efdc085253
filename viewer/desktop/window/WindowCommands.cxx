// SPDX-License-Identifier: BSD-3-Clause
// The user's commands in a window: keys, buttons, settings. See WindowController.h.
#include "viewer/desktop/window/ColorPanel.h"
#include "viewer/desktop/window/WindowController.h"

#include <array>
#include <utility>

namespace kdstream
{

void WindowController::TakeEvents()
{
  for (WindowEvent& event : this->Display->TakeEvents())
  {
    this->Events.push_back(std::move(event));
  }
  // Even if frames are slow, a key must apply to the state after the clicks before it, and a click
  // to what is visible after the key before it.
  bool wasCommand = false;
  while (!this->Events.empty() && !wasCommand)
  {
    const bool isKey = this->Events.front().kind == WindowEvent::Kind::Key;
    if (isKey && !this->Interface.IsSettled())
    {
      break;
    }
    wasCommand = this->Handle(this->Events.front());
    this->Events.pop_front();
    this->FramesLeft = 2;
  }
  this->WakeIf(!this->Events.empty());
}

// Returns whether the event was a key that is a command of the window.
bool WindowController::Handle(const WindowEvent& event)
{
  using Kind = WindowEvent::Kind;
  const bool begins = event.kind == Kind::Press || event.kind == Kind::TouchBegin;
  const bool isOverPanels = this->Interface.IsOver(event.x, event.y);
  const bool isEnd = event.control && event.key == "q";
  if (event.kind == Kind::Key && this->Interface.TakesKeys() && !isEnd)
  {
    this->Interface.Handle(event);
    return false;
  }
  if (event.kind == Kind::Key && this->HandleKey(event))
  {
    return true;
  }
  if (begins && !this->Input.Touching())
  {
    this->PressIsOfPanels = isOverPanels;
  }
  // Fingers that began on the panels act as a mouse there.
  const bool isFinger =
    event.kind == Kind::TouchBegin || event.kind == Kind::TouchMove || event.kind == Kind::TouchEnd;
  if (event.kind != Kind::Key && (!isFinger || this->PressIsOfPanels))
  {
    this->Interface.Handle(event);
  }
  const bool isZoom = event.kind == Kind::Wheel || event.kind == Kind::Pinch;
  const bool isOfPanels = isZoom ? isOverPanels : this->PressIsOfPanels;
  if (!this->Session.IsOpen() || (isOfPanels && event.kind != Kind::Key))
  {
    return false;
  }
  for (const SessionStep& step : this->Input.Handle(event))
  {
    this->Session.Do(step);
  }
  return false;
}

// Performs a key that is a command of the window; returns false for keys of the model.
bool WindowController::HandleKey(const WindowEvent& event)
{
  const std::string& key = event.key;
  if (event.control)
  {
    if (key == "q")
    {
      this->End();
    }
    return true;
  }
  if (key == "b")
  {
    ViewSettings settings = this->Settings;
    settings.scene.boxes = !settings.scene.boxes;
    this->Apply(settings);
    return true;
  }
  if (key == "k")
  {
    ViewSettings settings = this->Settings;
    settings.scene.colors = NextColors(settings.scene.colors, this->Session.Model());
    this->Apply(settings);
    return true;
  }
  bool* const toggled = key == "o"                         ? &this->Words.settingsOpen
                        : key == "d"                       ? &this->Words.detailsOpen
                        : key == "F1" || key == "question" ? &this->Words.helpOpen
                        : key == "t"                       ? &this->Words.toolsOpen
                        : key == "n"                       ? &this->Words.notes.isOpen
                        : key == "m"                       ? &this->Words.popUp
                        : key == "Tab"                     ? &this->Words.bare
                                                           : nullptr;
  if (toggled)
  {
    *toggled = !*toggled;
  }
  else if (key == "Escape")
  {
    this->GoBack();
  }
  else if (key == "f" || key == "F11")
  {
    this->Display->SetFullScreen(!this->Display->IsFullScreen());
  }
  else if (key == "s" || key == "F12")
  {
    this->AskForPicture();
  }
  else if (key == "q")
  {
    this->End();
  }
  else if (key == "Next" || key == "Prior")
  {
    this->Session.OpenNext(key == "Next" ? 1 : -1);
  }
  else
  {
    return this->HandleToolKey(key);
  }
  return true;
}

bool WindowController::HandleToolKey(const std::string& key)
{
  if (key == "l")
  {
    this->CopyLink();
  }
  else if ((key == "r" || key == "c" || key == "i") && this->Session.IsOpen())
  {
    this->TakeTool(key == "r" ? Tool::Measure : key == "c" ? Tool::Section : Tool::Light);
  }
  else if (key.size() == 1 && key[0] >= '1' && key[0] <= '6' && this->Session.IsOpen())
  {
    static constexpr std::array<const char*, 6> sides{ "front", "back", "left", "right", "top",
      "bottom" };
    this->Session.Do(
      { SessionStep::Kind::Side, {}, sides[static_cast<std::size_t>(key[0] - '1')] });
  }
  else
  {
    return false;
  }
  return true;
}

// Takes a tool or, if it is the current one, puts it away.
void WindowController::TakeTool(Tool tool)
{
  const bool has = this->Session.Viewer().GetTool() == tool;
  const char* word = tool == Tool::Measure   ? "measure"
                     : tool == Tool::Section ? "section"
                                             : "light";
  if (tool == Tool::Section && !has && !this->Session.Viewer().GetSection().Plane())
  {
    this->Session.Do({ SessionStep::Kind::Section, {}, "view" });
  }
  this->Session.Do({ SessionStep::Kind::Tool, {}, has ? "none" : word });
  this->Tell(has                     ? "Mouse and fingers turn the model again."
             : tool == Tool::Measure ? "Click two points on the surface."
             : tool == Tool::Section ? "Drag to move the section. Right-drag to turn it."
                                     : "Drag to move the light.");
}

// Closes one thing at each call.
void WindowController::GoBack()
{
  for (bool* const open : { &this->Words.helpOpen, &this->Words.popUp, &this->Words.settingsOpen,
         &this->Words.detailsOpen, &this->Words.toolsOpen, &this->Words.notes.isOpen,
         &this->Words.bare })
  {
    if (*open)
    {
      *open = false;
      return;
    }
  }
  if (this->Display->IsFullScreen())
  {
    this->Display->SetFullScreen(false);
  }
  else if (this->Session.IsOpen() && this->Session.Models()->size() > 1)
  {
    this->Session.Do({ SessionStep::Kind::Go, {}, "back" });
  }
}

void WindowController::Apply(const ViewSettings& settings)
{
  const ViewSettings before = std::exchange(this->Settings, settings);
  if (before == settings)
  {
    return;
  }
  if (before.detail != settings.detail)
  {
    this->Session.Do(DetailStep(settings.detail));
  }
  if (before.turning != settings.turning)
  {
    this->Session.Do(
      { SessionStep::Kind::Turning, {}, settings.turning == Turning::Free ? "free" : "upright" });
  }
  if (before.rings != settings.rings)
  {
    this->Session.Do(RingsStep(settings.rings));
  }
  if (before.triangles != settings.triangles || before.memory != settings.memory)
  {
    this->Session.Do(BudgetsStep(settings.triangles, settings.memory));
  }
  this->Apply(before.scene);
  this->Session.SetPrefetch(settings.prefetch ? windowPrefetchBytes : 0);
  this->FramesLeft = 2;
}

// Frames are drawn with the current settings; this records those that have changed.
void WindowController::Apply(const SceneSettings& before)
{
  const SceneSettings& now = this->Settings.scene;
  if (before.colors != now.colors)
  {
    this->Session.Do(ColorsStep(now.colors));
  }
  if (before.occlusion != now.occlusion)
  {
    this->Session.Do(LightStep(now.occlusion));
  }
  if (before.boxes != now.boxes)
  {
    this->Session.Do(BoxesStep(now.boxes));
  }
}

void WindowController::Fulfil(const PanelWishes& wishes)
{
  for (const SessionStep& step : wishes.steps)
  {
    this->Session.Do(step);
  }
  if (wishes.open)
  {
    this->Session.Open(*wishes.open);
  }
  if (wishes.fullScreen)
  {
    this->Display->SetFullScreen(!this->Display->IsFullScreen());
  }
  if (wishes.screenshot)
  {
    this->AskForPicture();
  }
  if (wishes.spin)
  {
    this->Session.SetSpinning(*wishes.spin);
  }
  if (wishes.removeMeasurement)
  {
    this->Session.RemoveMeasurement(*wishes.removeMeasurement);
    this->FramesLeft = 2;
  }
  if (wishes.nameMeasurement)
  {
    this->Session.NameMeasurement(wishes.nameMeasurement->first, wishes.nameMeasurement->second);
  }
  if (wishes.saveOutline)
  {
    this->SaveOutline();
  }
  if (wishes.copyLink)
  {
    this->CopyLink();
  }
  if (wishes.copyMeasurements)
  {
    this->CopyMeasurements();
  }
  if (wishes.retry)
  {
    this->Session.Retry();
  }
  this->Fulfil(wishes.notes);
  this->Ended |= wishes.quit;
}

}
