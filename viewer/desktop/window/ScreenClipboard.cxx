// SPDX-License-Identifier: BSD-3-Clause
// Copies texts for other programs to paste: see ScreenClipboard.h.
//
// Uses a connection and an invisible window of its own, because VTK's event loop would drop the
// requests of other programs.
#include "viewer/desktop/window/ScreenClipboard.h"

#include <array>
#include <utility>

#include <X11/Xatom.h>
#include <X11/Xlib.h>

namespace kdstream
{
namespace
{
constexpr std::size_t mostBytes = std::size_t{ 64 } << 10; // longer texts must be sent in parts
}

struct ScreenClipboard::State
{
  explicit State(::Display* opened)
    : Connection(opened)
    , Window(XCreateSimpleWindow(opened, DefaultRootWindow(opened), 0, 0, 1, 1, 0, 0, 0))
    , Clipboard(XInternAtom(opened, "CLIPBOARD", False))
    , Targets(XInternAtom(opened, "TARGETS", False))
    , Utf8(XInternAtom(opened, "UTF8_STRING", False))
  {
  }
  ~State() { XCloseDisplay(this->Connection); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  void Answer(const XSelectionRequestEvent& asked) const;

  ::Display* Connection;
  ::Window Window;
  Atom Clipboard, Targets, Utf8;
  std::string Text;
};

ScreenClipboard::ScreenClipboard()
{
  if (::Display* display = XOpenDisplay(nullptr))
  {
    this->Own = std::make_unique<State>(display);
  }
}

ScreenClipboard::~ScreenClipboard() = default;

bool ScreenClipboard::Put(std::string text)
{
  if (!this->Own || text.size() > mostBytes)
  {
    return false;
  }
  this->Own->Text = std::move(text);
  XSetSelectionOwner(this->Own->Connection, this->Own->Clipboard, this->Own->Window, CurrentTime);
  XFlush(this->Own->Connection);
  return true;
}

void ScreenClipboard::Serve()
{
  while (this->Own && XPending(this->Own->Connection) > 0)
  {
    XEvent event;
    XNextEvent(this->Own->Connection, &event);
    if (event.type == SelectionRequest)
    {
      this->Own->Answer(event.xselectionrequest);
    }
  }
}

// Answers with the text or with the list of available formats; with None for other formats.
void ScreenClipboard::State::Answer(const XSelectionRequestEvent& asked) const
{
  XEvent answer{};
  XSelectionEvent& notification = answer.xselection;
  notification.type = SelectionNotify;
  notification.requestor = asked.requestor;
  notification.selection = asked.selection;
  notification.target = asked.target;
  notification.time = asked.time;
  notification.property = asked.property != None ? asked.property : asked.target;
  if (asked.target == this->Targets)
  {
    const std::array<Atom, 2> forms{ this->Targets, this->Utf8 };
    XChangeProperty(this->Connection, asked.requestor, notification.property, XA_ATOM, 32,
      PropModeReplace, reinterpret_cast<const unsigned char*>(forms.data()),
      static_cast<int>(forms.size()));
  }
  else if (asked.target == this->Utf8 || asked.target == XA_STRING)
  {
    XChangeProperty(this->Connection, asked.requestor, notification.property, asked.target, 8,
      PropModeReplace, reinterpret_cast<const unsigned char*>(this->Text.data()),
      static_cast<int>(this->Text.size()));
  }
  else
  {
    notification.property = None;
  }
  XSendEvent(this->Connection, asked.requestor, False, NoEventMask, &answer);
  XFlush(this->Connection);
}

}
