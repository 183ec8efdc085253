// SPDX-License-Identifier: BSD-3-Clause
// A window on an X server: VTK's own window, with VTK's interactor. It reports mouse, keys and
// fingers as events. Fingers are read by the X Input Extension, because VTK 9.1 does not support
// them.
#pragma once

#include "filters/core/Result.h"
#include "viewer/desktop/window/WindowEvent.h"

#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkSmartPointer.h>

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

class vtkObject;
class vtkRenderWindowInteractor;

namespace kdstream
{

class DisplayWindow
{
public:
  // Errors: those of MakeScreenWindow.
  static Result<std::unique_ptr<DisplayWindow>> Make(
    int width, int height, const std::string& title);
  ~DisplayWindow();

  vtkRenderWindow& Window() { return *this->Shown; }
  int Width() const;  // pixels
  int Height() const; // pixels
  // Pixels per point of the screen, by the desktop's setting for fonts (Xft.dpi; 96 dpi give 1).
  double PixelRatio() const { return this->Ratio; }

  // Waits for input or another event of the window, but no longer than this.
  void Wait(std::chrono::milliseconds atMost);
  // The user's actions since the last call, in order.
  std::vector<WindowEvent> TakeEvents();
  // Whether the window has been resized or uncovered since the last call.
  bool TakeDamage();
  bool WantsToClose() const { return this->Closed; }

  // An empty title stands for the program's name.
  void SetTitle(const std::string& title);
  bool IsFullScreen() const { return this->FullScreen; }
  void SetFullScreen(bool full);

private:
  DisplayWindow() = default;

  void Listen();
  void ListenToFingers();
  void TakeFingers();
  void AddPinch(const void* data); // of the X Input Extension
  void Note(vtkObject* caller, unsigned long event, void* data);
  void Add(WindowEvent event);
  std::vector<double> TimesOf(const std::vector<unsigned long>& serverTimes);
  void NoteButtonTimes();
  void NoteKeyNames();

  vtkSmartPointer<vtkRenderWindow> Shown;
  vtkSmartPointer<vtkRenderWindowInteractor> Interactor;
  std::vector<WindowEvent> Events;
  double Ratio = 1;
  std::deque<double> ButtonTimes;      // of presses and releases that VTK has not reported yet
  std::deque<std::string> KeyNames;    // of pressed keys that VTK has not reported yet
  std::uint32_t LastServerTime = 0;    // ms
  std::optional<double> ServerSeconds; // LastServerTime by our clock
  double LastTime = 0;
  int FingersOpcode = 0; // of the X Input Extension; 0 if the server lacks it
  double PinchScale = 1; // since the trackpad's pinch began
  bool Damaged = true, Closed = false, FullScreen = false;
  // Position and size before full screen.
  int PlainX = 0, PlainY = 0, PlainWidth = 0, PlainHeight = 0;
};

}
