// SPDX-License-Identifier: BSD-3-Clause
// A window on an X server: see DisplayWindow.h.
#include "viewer/desktop/window/DisplayWindow.h"

#include "viewer/offscreen/ScreenWindow.h"

#include <vtkCommand.h>
#include <vtkRenderWindowInteractor.h>

#include <poll.h>
#include <xkbcommon/xkbcommon.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <utility>

// These are included after our headers, because X11 defines words such as Status as macros.
#include <X11/Xatom.h>
#include <X11/Xutil.h>
#include <X11/extensions/XInput2.h>
#undef None
#undef Status

namespace kdstream
{
namespace
{

constexpr double usualDpi = 96;

double Seconds()
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Display* DisplayOf(vtkRenderWindow& window)
{
  return static_cast<Display*>(window.GetGenericDisplayId());
}

::Window IdOf(vtkRenderWindow& window)
{
  return reinterpret_cast<::Window>(window.GetGenericWindowId());
}

// The text that a key types; empty for control characters.
std::string TextOfKey(const std::string& key)
{
  std::array<char, 8> text{};
  const xkb_keysym_t symbol = xkb_keysym_from_name(key.c_str(), XKB_KEYSYM_NO_FLAGS);
  const bool writes = xkb_keysym_to_utf8(symbol, text.data(), text.size()) > 0;
  return writes && static_cast<unsigned char>(text[0]) >= ' ' && text[0] != '\x7f' ? text.data()
                                                                                   : "";
}

// The desktop's scale, by its settings; 1 if nothing is set.
double RatioOf(Display* display)
{
  const char* dpi = XGetDefault(display, "Xft", "dpi");
  const double value = dpi ? std::strtod(dpi, nullptr) : 0;
  return value >= usualDpi / 2 && value <= usualDpi * 8 ? value / usualDpi : 1;
}

bool HasWindowManager(Display* display)
{
  const Atom check = XInternAtom(display, "_NET_SUPPORTING_WM_CHECK", True);
  Atom type = 0;
  int format = 0;
  unsigned long items = 0;
  unsigned long rest = 0;
  unsigned char* value = nullptr;
  if (check == 0 || XGetWindowProperty(display, DefaultRootWindow(display), check, 0, 1, False,
                      XA_WINDOW, &type, &format, &items, &rest, &value) != Success)
  {
    return false;
  }
  if (value)
  {
    XFree(value);
  }
  return items == 1;
}

// Asks the window manager to switch full screen on or off.
void AskForFullScreen(Display* display, ::Window window, bool full)
{
  XEvent event{};
  event.xclient.type = ClientMessage;
  event.xclient.window = window;
  event.xclient.message_type = XInternAtom(display, "_NET_WM_STATE", False);
  event.xclient.format = 32;
  event.xclient.data.l[0] = full ? 1 : 0;
  event.xclient.data.l[1] =
    static_cast<long>(XInternAtom(display, "_NET_WM_STATE_FULLSCREEN", False));
  event.xclient.data.l[3] = 1; // the request comes from an ordinary application
  XSendEvent(display, DefaultRootWindow(display), False,
    SubstructureNotifyMask | SubstructureRedirectMask, &event);
}

WindowEvent TouchOf(const XGenericEventCookie& cookie)
{
  const auto& touch = *static_cast<const XIDeviceEvent*>(cookie.data);
  WindowEvent translated;
  translated.kind = cookie.evtype == XI_TouchBegin ? WindowEvent::Kind::TouchBegin
                    : cookie.evtype == XI_TouchEnd ? WindowEvent::Kind::TouchEnd
                                                   : WindowEvent::Kind::TouchMove;
  translated.x = touch.event_x;
  translated.y = touch.event_y;
  translated.finger = touch.detail;
  return translated;
}

// Sets the class by which desktops match a window with the program's entry in their menus.
void SetWindowClass(Display* display, ::Window window)
{
  std::array<char, 14> name{ "kdstream-view" };
  XClassHint hint{ name.data(), name.data() };
  XSetClassHint(display, window, &hint);
}

}

Result<std::unique_ptr<DisplayWindow>> DisplayWindow::Make(
  int width, int height, const std::string& title)
{
  auto window = MakeScreenWindow(width, height, title);
  KDSTREAM_TRY(window);
  std::unique_ptr<DisplayWindow> made(new DisplayWindow);
  made->Shown = *window;
  // VTK would warn that no default style is linked. The style would cost 6 MB, and we want none.
  vtkObject::GlobalWarningDisplayOff();
  made->Interactor = vtkSmartPointer<vtkRenderWindowInteractor>::New();
  vtkObject::GlobalWarningDisplayOn();
  made->Interactor->SetInteractorStyle(nullptr);
  made->Interactor->SetRenderWindow(made->Shown);
  made->Interactor->EnableRenderOff(); // WindowController draws the frames
  made->Interactor->Initialize();
  Display* display = DisplayOf(*made->Shown);
  made->Ratio = RatioOf(display);
  SetWindowClass(display, IdOf(*made->Shown));
  made->Listen();
  made->ListenToFingers();
  return made;
}

DisplayWindow::~DisplayWindow()
{
  if (this->Interactor)
  {
    this->Interactor->RemoveAllObservers();
  }
}

int DisplayWindow::Width() const
{
  return this->Shown->GetSize()[0];
}

int DisplayWindow::Height() const
{
  return this->Shown->GetSize()[1];
}

void DisplayWindow::Listen()
{
  for (const auto event : { vtkCommand::LeftButtonPressEvent, vtkCommand::LeftButtonReleaseEvent,
         vtkCommand::MiddleButtonPressEvent, vtkCommand::MiddleButtonReleaseEvent,
         vtkCommand::RightButtonPressEvent, vtkCommand::RightButtonReleaseEvent,
         vtkCommand::MouseMoveEvent, vtkCommand::MouseWheelForwardEvent,
         vtkCommand::MouseWheelBackwardEvent, vtkCommand::KeyPressEvent, vtkCommand::ConfigureEvent,
         vtkCommand::RenderEvent, vtkCommand::ExposeEvent, vtkCommand::ExitEvent })
  {
    this->Interactor->AddObserver(event, this, &DisplayWindow::Note);
  }
}

void DisplayWindow::Add(WindowEvent event)
{
  const bool isButton =
    event.kind == WindowEvent::Kind::Press || event.kind == WindowEvent::Kind::Release;
  // Events that precede a button event in the queue are not later than it.
  event.time = this->ButtonTimes.empty() ? Seconds() : this->ButtonTimes.front();
  if (isButton && !this->ButtonTimes.empty())
  {
    this->ButtonTimes.pop_front();
  }
  const int* position = this->Interactor->GetEventPosition(); // from the lower left corner
  event.x = position[0];
  event.y = this->Height() - 1 - position[1];
  event.shift = this->Interactor->GetShiftKey() != 0;
  event.control = this->Interactor->GetControlKey() != 0;
  this->Events.push_back(std::move(event));
}

void DisplayWindow::Note(vtkObject* /*caller*/, unsigned long event, void* /*data*/)
{
  using Kind = WindowEvent::Kind;
  using Button = WindowEvent::Button;
  const auto button = [this](Kind kind, Button which)
  {
    WindowEvent translated;
    translated.kind = kind;
    translated.button = which;
    this->Add(translated);
  };
  const auto wheel = [this](double notches)
  {
    WindowEvent translated;
    translated.kind = Kind::Wheel;
    translated.notches = notches;
    this->Add(translated);
  };
  switch (event)
  {
    case vtkCommand::LeftButtonPressEvent:
      return button(Kind::Press, Button::Left);
    case vtkCommand::LeftButtonReleaseEvent:
      return button(Kind::Release, Button::Left);
    case vtkCommand::MiddleButtonPressEvent:
      return button(Kind::Press, Button::Middle);
    case vtkCommand::MiddleButtonReleaseEvent:
      return button(Kind::Release, Button::Middle);
    case vtkCommand::RightButtonPressEvent:
      return button(Kind::Press, Button::Right);
    case vtkCommand::RightButtonReleaseEvent:
      return button(Kind::Release, Button::Right);
    case vtkCommand::MouseMoveEvent:
      return button(Kind::Move, Button::Left);
    case vtkCommand::MouseWheelForwardEvent:
      return wheel(1);
    case vtkCommand::MouseWheelBackwardEvent:
      return wheel(-1);
    case vtkCommand::KeyPressEvent:
    {
      WindowEvent translated;
      translated.kind = Kind::Key;
      const char* key = this->Interactor->GetKeySym(); // from VTK 9.2 on without Shift and others
      translated.key = key ? key : "";
      if (!this->KeyNames.empty())
      {
        translated.key = std::move(this->KeyNames.front());
        this->KeyNames.pop_front();
      }
      translated.text = TextOfKey(translated.key);
      return this->Add(translated);
    }
    case vtkCommand::ExitEvent:
      this->Closed = true;
      return;
    default:
      this->Damaged = true;
  }
}

// Without this, fingers would come to the window as a mouse, one at a time. Servers that support
// gestures (version 2.4 of the extension) also report pinches of trackpads.
void DisplayWindow::ListenToFingers()
{
  Display* display = DisplayOf(*this->Shown);
  int event = 0;
  int error = 0;
  int major = 2;
  int minor = 4;
  if (!XQueryExtension(display, "XInputExtension", &this->FingersOpcode, &event, &error) ||
      XIQueryVersion(display, &major, &minor) != Success || major * 10 + minor < 22)
  {
    this->FingersOpcode = 0;
    return;
  }
  std::array<unsigned char, XIMaskLen(XI_LASTEVENT)> bits{};
  XISetMask(bits.data(), XI_TouchBegin);
  XISetMask(bits.data(), XI_TouchUpdate);
  XISetMask(bits.data(), XI_TouchEnd);
#ifdef XI_GesturePinchBegin
  if (major * 10 + minor >= 24)
  {
    XISetMask(bits.data(), XI_GesturePinchBegin);
    XISetMask(bits.data(), XI_GesturePinchUpdate);
    XISetMask(bits.data(), XI_GesturePinchEnd);
  }
#endif
  XIEventMask mask{ XIAllMasterDevices, static_cast<int>(bits.size()), bits.data() };
  XISelectEvents(display, IdOf(*this->Shown), &mask, 1);
}

// Takes the events of fingers from the queue, because VTK's interactor would discard them.
void DisplayWindow::TakeFingers()
{
  Display* display = DisplayOf(*this->Shown);
  XEvent event;
  while (this->FingersOpcode != 0 && XCheckTypedEvent(display, GenericEvent, &event))
  {
    XGenericEventCookie& cookie = event.xcookie;
    if (cookie.extension != this->FingersOpcode || !XGetEventData(display, &cookie))
    {
      continue;
    }
    switch (cookie.evtype)
    {
      case XI_TouchBegin:
      case XI_TouchUpdate:
      case XI_TouchEnd:
        this->Events.push_back(TouchOf(cookie));
        this->Events.back().time =
          this->TimesOf({ static_cast<const XIDeviceEvent*>(cookie.data)->time }).front();
        break;
#ifdef XI_GesturePinchBegin
      case XI_GesturePinchBegin:
        this->PinchScale = 1;
        break;
      case XI_GesturePinchUpdate:
        this->AddPinch(cookie.data);
        break;
#endif
      default:
        break;
    }
    XFreeEventData(display, &cookie);
  }
}

// Servers report the total scale since the pinch began; an event has the change since the last.
void DisplayWindow::AddPinch([[maybe_unused]] const void* data)
{
#ifdef XI_GesturePinchBegin
  const auto& pinch = *static_cast<const XIGesturePinchEvent*>(data);
  if (!(pinch.scale > 0))
  {
    return;
  }
  WindowEvent translated;
  translated.kind = WindowEvent::Kind::Pinch;
  translated.time = Seconds();
  translated.x = pinch.event_x;
  translated.y = pinch.event_y;
  translated.scale = pinch.scale / std::exchange(this->PinchScale, pinch.scale);
  this->Events.push_back(translated);
#endif
}

void DisplayWindow::Wait(std::chrono::milliseconds atMost)
{
  Display* display = DisplayOf(*this->Shown);
  if (XPending(display) == 0)
  {
    pollfd waiting{ ConnectionNumber(display), POLLIN, 0 };
    ::poll(&waiting, 1, static_cast<int>(atMost.count()));
  }
}

// Converts the times of the server's events, in order, to our clock. These are the times when the
// events happened, not when a slow frame received them. The difference of the two clocks is that of
// the event with the shortest delay.
std::vector<double> DisplayWindow::TimesOf(const std::vector<unsigned long>& serverTimes)
{
  std::vector<double> times;
  if (serverTimes.empty())
  {
    return times;
  }
  // Server times are milliseconds in 32 bits, which start again from 0 after 49 days.
  const auto last = static_cast<std::uint32_t>(serverTimes.back());
  const auto passed = static_cast<std::int32_t>(last - this->LastServerTime);
  const double seen = Seconds();
  this->ServerSeconds = std::min(this->ServerSeconds.value_or(seen) + 1e-3 * passed, seen);
  this->LastServerTime = last;
  for (const unsigned long time : serverTimes)
  {
    const auto before = static_cast<std::int32_t>(last - static_cast<std::uint32_t>(time));
    this->LastTime = std::max(this->LastTime, *this->ServerSeconds - 1e-3 * before);
    times.push_back(this->LastTime);
  }
  return times;
}

// Notes the times of button events, because VTK's interactor does not report them.
void DisplayWindow::NoteButtonTimes()
{
  std::vector<unsigned long> serverTimes;
  const auto note = [](Display* /*display*/, XEvent* event, XPointer noted) -> Bool
  {
    const bool isButton = (event->type == ButtonPress || event->type == ButtonRelease) &&
                          event->xbutton.button <= Button3; // higher numbers are the wheel
    if (isButton)
    {
      reinterpret_cast<std::vector<unsigned long>*>(noted)->push_back(event->xbutton.time);
    }
    return False; // the event stays in the queue
  };
  XEvent unused;
  XCheckIfEvent(DisplayOf(*this->Shown), &unused, note, reinterpret_cast<XPointer>(&serverTimes));
  const auto times = this->TimesOf(serverTimes);
  this->ButtonTimes.assign(times.begin(), times.end());
}

// Notes what pressed keys mean together with Shift, Caps Lock and the keyboard's layout: "A",
// "plus".
void DisplayWindow::NoteKeyNames()
{
  std::vector<XKeyEvent> keys;
  const auto note = [](Display* /*display*/, XEvent* event, XPointer noted) -> Bool
  {
    if (event->type == KeyPress)
    {
      reinterpret_cast<std::vector<XKeyEvent>*>(noted)->push_back(event->xkey);
    }
    return False; // the event stays in the queue
  };
  XEvent unused;
  XCheckIfEvent(DisplayOf(*this->Shown), &unused, note, reinterpret_cast<XPointer>(&keys));
  this->KeyNames.clear();
  for (XKeyEvent& key : keys)
  {
    KeySym symbol = NoSymbol;
    XLookupString(&key, nullptr, 0, &symbol, nullptr);
    const char* name = XKeysymToString(symbol);
    this->KeyNames.emplace_back(name ? name : "");
  }
}

std::vector<WindowEvent> DisplayWindow::TakeEvents()
{
  XPending(DisplayOf(*this->Shown)); // reads what has arrived
  this->TakeFingers();
  this->NoteButtonTimes();
  this->NoteKeyNames();
  this->Interactor->ProcessEvents();
  return std::exchange(this->Events, {});
}

bool DisplayWindow::TakeDamage()
{
  return std::exchange(this->Damaged, false);
}

void DisplayWindow::SetTitle(const std::string& title)
{
  const std::string whole = title.empty() ? "KdStream" : title + " – KdStream";
  Display* display = DisplayOf(*this->Shown);
  const ::Window window = IdOf(*this->Shown);
  this->Shown->SetWindowName(whole.c_str());
  // VTK sets only the old property, which is limited to Latin letters.
  XChangeProperty(display, window, XInternAtom(display, "_NET_WM_NAME", False),
    XInternAtom(display, "UTF8_STRING", False), 8, PropModeReplace,
    reinterpret_cast<const unsigned char*>(whole.data()), static_cast<int>(whole.size()));
}

// VTK's own way would make another window, and upload everything to graphics memory again.
void DisplayWindow::SetFullScreen(bool full)
{
  if (full == this->FullScreen)
  {
    return;
  }
  this->FullScreen = full;
  Display* display = DisplayOf(*this->Shown);
  const ::Window window = IdOf(*this->Shown);
  if (HasWindowManager(display))
  {
    AskForFullScreen(display, window, full);
    return;
  }
  if (full)
  {
    XWindowAttributes now{};
    XGetWindowAttributes(display, window, &now);
    this->PlainX = now.x;
    this->PlainY = now.y;
    this->PlainWidth = now.width;
    this->PlainHeight = now.height;
    XMoveResizeWindow(display, window, 0, 0,
      static_cast<unsigned>(DisplayWidth(display, DefaultScreen(display))),
      static_cast<unsigned>(DisplayHeight(display, DefaultScreen(display))));
  }
  else
  {
    XMoveResizeWindow(display, window, this->PlainX, this->PlainY,
      static_cast<unsigned>(this->PlainWidth), static_cast<unsigned>(this->PlainHeight));
  }
}

}
