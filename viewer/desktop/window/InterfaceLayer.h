// SPDX-License-Identifier: BSD-3-Clause
// Dear ImGui in a VTK window: draws in a renderer on top of the others, and passes mouse and keys
// to the widgets.
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
  // layer: the layer of the window that ImGui draws in, on top of the lower ones.
  InterfaceLayer(vtkRenderWindow& window, int layer, double pixelRatio);
  ~InterfaceLayer();
  InterfaceLayer(const InterfaceLayer&) = delete;
  InterfaceLayer& operator=(const InterfaceLayer&) = delete;

  // Makes sure that the letters of this text can be drawn.
  void KnowText(std::string_view text);

  // Takes mouse events, fingers as if they were a mouse, and keys while the user types text.
  void Handle(const WindowEvent& event);
  // Whether keys go to a text field that is being edited.
  bool TakesKeys() const;
  // Whether widgets were drawn at this pixel.
  bool IsOver(double x, double y) const;

  // Describe the widgets between these two calls. End returns whether they must be described again:
  // because one pass cannot take all mouse and key events, or because windows have moved (a new
  // window is first measured, invisibly).
  void Begin(int width, int height, double seconds);
  bool End();

  // Whether it is certain which field gets the keys. It is certain when the widgets have received
  // all events except typed letters; other events could have changed the field.
  bool IsSettled() const;

  // Which part of the interface is drawn. Pictures of the model include ImGui's background, which
  // is behind the widgets. They also include ImGui's foreground, which is not shown on the screen.
  enum class Part
  {
    Shown, // all except the foreground
    Background,
    Foreground,
    None
  };
  void Draw(Part part);

private:
  // A window of widgets: its place and size.
  struct Shape
  {
    unsigned id;
    bool isNew; // or has not been seen yet
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
  bool KeyIsDown = false, KeyWasDown = false; // in this frame; in the last one
  std::vector<Shape> Shapes;                  // the shapes of the last frame
};

// ---- Letters for the window's texts, from the desktop's fonts, by fontconfig
// (InterfaceFonts.cxx).

// The code points of a UTF-8 text; other bytes are skipped.
std::set<char32_t> LettersOf(std::string_view text);

// Fills the atlas with the desktop's sans serif font at this height in pixels. Takes letters that
// this font lacks from other fonts. If the desktop has no font, takes the small one of Dear ImGui.
void LoadFonts(ImFontAtlas& atlas, double height, const std::set<char32_t>& letters);

}
