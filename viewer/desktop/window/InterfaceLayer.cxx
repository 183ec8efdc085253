// SPDX-License-Identifier: BSD-3-Clause
// Dear ImGui in a VTK window: see InterfaceLayer.h.
#include "viewer/desktop/window/InterfaceLayer.h"

#include <vtkObjectFactory.h>
#include <vtkProp.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>

#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>
#include <imgui_internal.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <string_view>
#include <utility>

namespace kdstream
{
namespace
{

constexpr double textHeight = 15; // points

// Since 1.87, ImGui takes keys as events; before, it read a table of the pressed keys.
#define KDSTREAM_IMGUI_KEY_EVENTS (IMGUI_VERSION_NUM >= 18700)
#if KDSTREAM_IMGUI_KEY_EVENTS
constexpr auto keypadEnter = ImGuiKey_KeypadEnter;
#else
constexpr auto keypadEnter = ImGuiKey_KeyPadEnter;
#endif
#if IMGUI_VERSION_NUM >= 18900
constexpr auto controlKey = ImGuiMod_Ctrl;
constexpr auto shiftKey = ImGuiMod_Shift;
#elif KDSTREAM_IMGUI_KEY_EVENTS
constexpr auto controlKey = ImGuiKey_ModCtrl;
constexpr auto shiftKey = ImGuiKey_ModShift;
#endif

// The keys that text fields use, and X's names for these keys.
constexpr std::array<std::pair<decltype(ImGuiKey_Tab), std::string_view>, 16> keys{
  { { ImGuiKey_Tab, "Tab" }, { ImGuiKey_LeftArrow, "Left" }, { ImGuiKey_RightArrow, "Right" },
    { ImGuiKey_UpArrow, "Up" }, { ImGuiKey_DownArrow, "Down" }, { ImGuiKey_Home, "Home" },
    { ImGuiKey_End, "End" }, { ImGuiKey_Delete, "Delete" }, { ImGuiKey_Backspace, "BackSpace" },
    { ImGuiKey_Enter, "Return" }, { keypadEnter, "KP_Enter" }, { ImGuiKey_A, "a" },
    { ImGuiKey_C, "c" }, { ImGuiKey_V, "v" }, { ImGuiKey_X, "x" }, { ImGuiKey_Z, "z" } }
};

void SetKey(ImGuiIO& io, decltype(ImGuiKey_Tab) key, bool isDown)
{
#if KDSTREAM_IMGUI_KEY_EVENTS
  io.AddKeyEvent(key, isDown);
#else
  io.KeysDown[key] = isDown;
#endif
}

void SetModifiers(ImGuiIO& io, bool control, bool shift)
{
#if KDSTREAM_IMGUI_KEY_EVENTS
  io.AddKeyEvent(controlKey, control);
  io.AddKeyEvent(shiftKey, shift);
#else
  io.KeyCtrl = control;
  io.KeyShift = shift;
#endif
}

// Whether there is typed text that ImGui takes only in the next frame.
bool TextWaits([[maybe_unused]] const ImGuiIO& io)
{
#if KDSTREAM_IMGUI_KEY_EVENTS
  const auto& events = ImGui::GetCurrentContext()->InputEventsQueue;
  return std::any_of(events.begin(), events.end(),
    [](const ImGuiInputEvent& event) { return event.Type == ImGuiInputEventType_Text; });
#else
  return !io.InputQueueCharacters.empty();
#endif
}

// Draws ImGui's last output, after everything else in the window.
class InterfaceProp : public vtkProp
{
public:
  static InterfaceProp* New();
  vtkTypeMacro(InterfaceProp, vtkProp);

  double* GetBounds() override { return nullptr; }

  InterfaceLayer::Part Part = InterfaceLayer::Part::Shown;

  int RenderOverlay(vtkViewport* /*viewport*/) override
  {
    const ImDrawData* drawing = ImGui::GetDrawData();
    if (!drawing)
    {
      return 1;
    }
    ImDrawData drawn = *drawing;
#if IMGUI_VERSION_NUM >= 18980 // CmdLists is a vector
    drawn.CmdLists.resize(0);
    for (ImDrawList* const list : drawing->CmdLists)
    {
      if (this->Has(list))
      {
        drawn.CmdLists.push_back(list);
      }
    }
    drawn.CmdListsCount = drawn.CmdLists.Size;
#else
    std::vector<ImDrawList*> lists;
    std::copy_if(drawing->CmdLists, drawing->CmdLists + drawing->CmdListsCount,
      std::back_inserter(lists), [this](const ImDrawList* list) { return this->Has(list); });
    drawn.CmdLists = lists.data();
    drawn.CmdListsCount = static_cast<int>(lists.size());
#endif
    ImGui_ImplOpenGL3_RenderDrawData(&drawn);
    return 1;
  }

protected:
  InterfaceProp() = default;

private:
  bool Has(const ImDrawList* list) const
  {
    using P = InterfaceLayer::Part;
    const bool isFront = list == ImGui::GetForegroundDrawList();
    const bool isBack = list == ImGui::GetBackgroundDrawList();
    return this->Part == P::Shown        ? !isFront
           : this->Part == P::Foreground ? isFront
                                         : this->Part == P::Background && isBack;
  }
};
vtkStandardNewMacro(InterfaceProp);

ImVec4 Rgba(int hex, float opacity)
{
  const auto part = [hex](int shift) { return static_cast<float>((hex >> shift) & 255) / 255.0f; };
  return { part(16), part(8), part(0), opacity };
}

// The colours of the web page: stone on slate.
void SetColors(ImGuiStyle& style)
{
  ImGui::StyleColorsDark(&style);
  constexpr int stone = 0xd9d0c0;
  constexpr int slate = 0x1a1c20;
  style.Colors[ImGuiCol_Text] = Rgba(0xf0ece4, 1);
  style.Colors[ImGuiCol_WindowBg] = Rgba(slate, 0.93f);
  style.Colors[ImGuiCol_PopupBg] = Rgba(slate, 0.95f);
  style.Colors[ImGuiCol_Border] = Rgba(stone, 0.16f);
  style.Colors[ImGuiCol_Button] = Rgba(stone, 0.14f);
  style.Colors[ImGuiCol_ButtonHovered] = Rgba(stone, 0.3f);
  style.Colors[ImGuiCol_ButtonActive] = Rgba(stone, 0.45f);
  style.Colors[ImGuiCol_FrameBg] = Rgba(stone, 0.12f);
  style.Colors[ImGuiCol_FrameBgHovered] = Rgba(stone, 0.22f);
  style.Colors[ImGuiCol_FrameBgActive] = Rgba(stone, 0.32f);
  style.Colors[ImGuiCol_CheckMark] = Rgba(stone, 1);
  style.Colors[ImGuiCol_SliderGrab] = Rgba(stone, 0.7f);
  style.Colors[ImGuiCol_SliderGrabActive] = Rgba(stone, 1);
  style.Colors[ImGuiCol_PlotHistogram] = Rgba(stone, 0.9f);
  style.Colors[ImGuiCol_TitleBg] = style.Colors[ImGuiCol_TitleBgActive] = Rgba(0x24272c, 1);
  style.Colors[ImGuiCol_Header] = Rgba(stone, 0.2f);
  style.Colors[ImGuiCol_HeaderHovered] = Rgba(stone, 0.3f);
  style.Colors[ImGuiCol_HeaderActive] = Rgba(stone, 0.4f);
}

void SetShapes(ImGuiStyle& style, double ratio)
{
  style.WindowRounding = 8;
  style.FrameRounding = 6;
  style.GrabRounding = 6;
  style.PopupRounding = 6;
  style.WindowPadding = { 12, 10 };
  style.FramePadding = { 9, 5 };
  style.ItemSpacing = { 8, 6 };
  style.WindowBorderSize = 0;
  style.ScaleAllSizes(static_cast<float>(ratio));
}

}

InterfaceLayer::InterfaceLayer(vtkRenderWindow& window, int layer, double pixelRatio)
  : Window(window)
  , Prop(vtkSmartPointer<InterfaceProp>::New())
  , Ratio(pixelRatio)
{
  for (char32_t letter = 0x20; letter < 0x180; ++letter) // Latin
  {
    this->Letters.insert(letter);
  }
  this->KnowText("–·×…–");
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
#if KDSTREAM_IMGUI_KEY_EVENTS
  io.ConfigInputTrickleEventQueue = false; // TakeEvents decides what comes in one frame
#else
  for (const auto& [key, name] : keys)
  {
    io.KeyMap[key] = key;
  }
#endif
  io.IniFilename = nullptr;
  io.LogFilename = nullptr;
  SetColors(ImGui::GetStyle());
  SetShapes(ImGui::GetStyle(), pixelRatio);
  window.MakeCurrent();
  ImGui_ImplOpenGL3_Init("#version 150");
  this->Renderer->SetLayer(layer);
  this->Renderer->InteractiveOff();
  this->Renderer->AddViewProp(this->Prop);
  window.AddRenderer(this->Renderer);
}

InterfaceLayer::~InterfaceLayer()
{
  this->Window.RemoveRenderer(this->Renderer);
  this->Window.MakeCurrent();
  ImGui_ImplOpenGL3_Shutdown();
  ImGui::DestroyContext();
}

void InterfaceLayer::KnowText(std::string_view text)
{
  for (const char32_t letter : LettersOf(text))
  {
    this->FontsAreDue |= this->Letters.insert(letter).second;
  }
}

void InterfaceLayer::Handle(const WindowEvent& event)
{
  this->KnowText(event.text);
  this->Events.push_back(event);
}

bool InterfaceLayer::IsOver(double x, double y) const
{
  const ImVec2 place(static_cast<float>(x), static_cast<float>(y));
  const auto& windows = ImGui::GetCurrentContext()->Windows;
  return std::any_of(windows.begin(), windows.end(),
    [&place](const ImGuiWindow* window)
    {
      return window->WasActive && !window->Hidden &&
             (window->Flags & ImGuiWindowFlags_NoMouseInputs) == 0 &&
             window->Rect().Contains(place);
    });
}

bool InterfaceLayer::IsSettled() const
{
  const auto writes = [](const WindowEvent& event)
  { return event.kind == WindowEvent::Kind::Key && !event.control && !event.text.empty(); };
  return !this->KeyIsDown && !this->KeyWasDown &&
         std::all_of(this->Events.begin(), this->Events.end(), writes);
}

bool InterfaceLayer::TakesKeys() const
{
  return ImGui::GetIO().WantTextInput;
}

// Passes a key to ImGui: the text that it types or, if it types none, the key itself. Returns false
// if the key must wait for the next frame. A field takes text before keys, and recognizes a second
// press of a key only after a frame in which the key was up.
bool InterfaceLayer::TakeKey(const WindowEvent& event)
{
  ImGuiIO& io = ImGui::GetIO();
  if (!event.control && !event.text.empty())
  {
    if (this->KeyIsDown)
    {
      return false;
    }
    io.AddInputCharactersUTF8(event.text.c_str());
    return true;
  }
  if (event.key == "Escape") // ImGui's Escape would undo what was typed
  {
    const bool isWritten = !TextWaits(io);
    if (isWritten)
    {
      ImGui::ClearActiveID();
    }
    return isWritten;
  }
  const auto key = std::find_if(
    keys.begin(), keys.end(), [&](const auto& each) { return each.second == event.key; });
  if (key == keys.end())
  {
    return true; // no text field uses this key
  }
  if (this->KeyIsDown || this->KeyWasDown)
  {
    return false;
  }
  this->KeyIsDown = true;
  SetKey(io, key->first, true);
  SetModifiers(io, event.control, event.shift);
  return true;
}

// Takes as many events as fit into one frame: one change of each button, one press of a key.
void InterfaceLayer::TakeEvents()
{
  using Kind = WindowEvent::Kind;
  ImGuiIO& io = ImGui::GetIO();
  this->KeyWasDown = std::exchange(this->KeyIsDown, false);
  for (const auto& [key, name] : keys)
  {
    SetKey(io, key, false);
  }
  SetModifiers(io, false, false);
  std::array<bool, 3> changed{};
  while (!this->Events.empty())
  {
    const WindowEvent& event = this->Events.front();
    if (event.kind == Kind::Key)
    {
      if (!this->TakeKey(event))
      {
        return;
      }
      this->Events.pop_front();
      continue;
    }
    const bool isDown = event.kind == Kind::Press || event.kind == Kind::TouchBegin;
    const bool isUp = event.kind == Kind::Release || event.kind == Kind::TouchEnd;
    const auto button = static_cast<std::size_t>(event.button);
    const bool moves = event.kind == Kind::Move || event.kind == Kind::TouchMove;
    if ((isDown || isUp) && changed[button])
    {
      return;
    }
    if (moves && std::find(changed.begin(), changed.end(), true) != changed.end())
    {
      return; // a press counts where it happened: later moves wait
    }
    io.MousePos = { static_cast<float>(event.x), static_cast<float>(event.y) };
    if (isDown || isUp)
    {
      io.MouseDown[button] = isDown;
      changed[button] = true;
    }
    if (event.kind == Kind::Wheel)
    {
      io.MouseWheel += static_cast<float>(event.notches);
    }
    this->Events.pop_front();
  }
}

void InterfaceLayer::Begin(int width, int height, double seconds)
{
  ImGuiIO& io = ImGui::GetIO();
  this->Window.MakeCurrent();
  if (this->FontsAreDue)
  {
    this->FontsAreDue = false;
    LoadFonts(*io.Fonts, textHeight * this->Ratio, this->Letters);
#if IMGUI_VERSION_NUM < 19200 // later versions make font textures themselves
    ImGui_ImplOpenGL3_DestroyFontsTexture();
    ImGui_ImplOpenGL3_CreateFontsTexture();
#endif
  }
  io.DisplaySize = { static_cast<float>(width), static_cast<float>(height) };
  io.DeltaTime = std::max(static_cast<float>(seconds), 1e-4f);
  this->TakeEvents();
  ImGui_ImplOpenGL3_NewFrame();
  ImGui::NewFrame();
}

bool InterfaceLayer::End()
{
  ImGui::Render();
  std::vector<Shape> shapes;
  for (const ImGuiWindow* window : ImGui::GetCurrentContext()->Windows)
  {
    if (window->Active)
    {
      shapes.push_back({ window->ID, window->Hidden || window->Appearing, window->Pos.x,
        window->Pos.y, window->Size.x, window->Size.y });
    }
  }
  const bool settles = shapes != this->Shapes;
  this->Shapes = std::move(shapes);
  return settles || !this->Events.empty() || this->KeyIsDown;
}

void InterfaceLayer::Draw(Part part)
{
  static_cast<InterfaceProp*>(this->Prop.GetPointer())->Part = part;
}

}
