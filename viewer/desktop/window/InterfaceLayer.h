// SPDX-License-Identifier: BSD-3-Clause
// Dear ImGui in a VTK window: a renderer on top of the others, and the way of mouse and keys to the
// widgets.
#pragma once

#include "viewer/desktop/window/WindowEvent.h"

#include <vtkNew.h>
#include <vtkSmartPointer.h>

#include <deque>
#include <set>
#include <string>
#include <string_view>
#include <vector>

struct ImFontAtlas;
class vtkProp;
class vtkRenderWindow;
class vtkRenderer;

namespace kdstream
{

// One at a time.
class InterfaceLayer
{
public:
  // layer: of the window, on top of which this is.
  InterfaceLayer(vtkRenderWindow& window, int layer, double pixelRatio);
  ~InterfaceLayer();
  InterfaceLayer(const InterfaceLayer&) = delete;
  InterfaceLayer& operator=(const InterfaceLayer&) = delete;

  // That these letters may be drawn.
  void KnowText(std::string_view text);

  // Of the mouse, and of fingers as if they were one; of keys where text is written.
  void Handle(const WindowEvent& event);
  // Whether keys belong into a field that is written into.
  bool TakesKeys() const;
  // Whether widgets were drawn at this pixel.
  bool IsOver(double x, double y) const;

  // Widgets are described between these two. End returns whether they have to be once more: mouse
  // and keys have done more than can be told at a time, or windows do not stand where they did
  // before (a new one is measured first, unseen).
  void Begin(int width, int height, double seconds);
  bool End();

  // Whether it is settled which field keys belong into: nothing of the mouse is left to be told to
  // the widgets, and no key but letters, which may have led to another field.
  bool IsSettled() const;

  // What is drawn of what was described. Pictures of the model have what lies behind the widgets
  // (ImGui's background), and what was drawn in front of them (its foreground), which is not shown.
  enum class Part
  {
    Shown, // all but the foreground
    Background,
    Foreground,
    None
  };
  void Draw(Part part);

private:
  // Of a window of widgets.
  struct Shape
  {
    unsigned id;
    bool isNew; // or not seen yet
    float left, top, width, height;
    bool operator==(const Shape&) const = default;
  };

  void TakeEvents();
  bool TakeKey(const WindowEvent& event);

  vtkRenderWindow& Window;
  vtkNew<vtkRenderer> Renderer;
  vtkSmartPointer<vtkProp> Prop;
  double Ratio;
  std::set<char32_t> Letters;
  bool FontsAreDue = true;
  std::deque<WindowEvent> Events;
  bool KeyIsDown = false, KeyWasDown = false; // in this frame, in the last one
  std::vector<Shape> Shapes;                  // when they were described last
};

// ---- The letters of the window's words: the desktop's fonts, by fontconfig (InterfaceFonts.cxx).

// The code points of a UTF-8 text; what is no UTF-8 is passed over.
std::set<char32_t> LettersOf(std::string_view text);

// Fills the atlas with the desktop's sans serif font, of this height in pixels, and with other
// fonts that have the missing `letters`. Where the desktop has no font: the library's own small
// one.
void LoadFonts(ImFontAtlas& atlas, double height, const std::set<char32_t>& letters);

}
