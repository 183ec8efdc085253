// SPDX-License-Identifier: BSD-3-Clause
// Dear ImGui in a VTK window: a renderer on top of the others, and passing mouse and keys to the
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

// Only one object may exist at a time.
class InterfaceLayer
{
public:
  // layer: of the window, on top of which this is.
  InterfaceLayer(vtkRenderWindow& window, int layer, double pixelRatio);
  ~InterfaceLayer();
  InterfaceLayer(const InterfaceLayer&) = delete;
  InterfaceLayer& operator=(const InterfaceLayer&) = delete;

  // Makes sure that these letters can be drawn.
  void KnowText(std::string_view text);

  // Takes the mouse, fingers as if they were a mouse, and keys while text is written.
  void Handle(const WindowEvent& event);
  // Whether keys belong into a field that is written into.
  bool TakesKeys() const;
  // Whether widgets were drawn at this pixel.
  bool IsOver(double x, double y) const;

  // Widgets are described between these two calls. End returns whether they must be described
  // again: there are more mouse and key events than one pass can take, or windows have moved (a new
  // window is first measured, invisibly).
  void Begin(int width, int height, double seconds);
  bool End();

  // Whether it is certain which field gets the keys: all mouse events have been passed to the
  // widgets, and all keys except letters, which may have changed the field.
  bool IsSettled() const;

  // Which part of the interface is drawn. Pictures of the model include what is behind the widgets
  // (ImGui's background), and a part in front of them that is not shown on the screen (its
  // foreground).
  enum class Part
  {
    Shown, // all but the foreground
    Background,
    Foreground,
    None
  };
  void Draw(Part part);

private:
  // The shape of a window of widgets.
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
  std::vector<Shape> Shapes;                  // the shapes of the last frame
};

// ---- The letters of the window's texts: the desktop's fonts, by fontconfig (InterfaceFonts.cxx).

// The code points of a UTF-8 text; other bytes are skipped.
std::set<char32_t> LettersOf(std::string_view text);

// Fills the atlas with the desktop's sans serif font, at this height in pixels, and with other
// fonts for the missing `letters`. If the desktop has no font: the library's own small one.
void LoadFonts(ImFontAtlas& atlas, double height, const std::set<char32_t>& letters);

}
