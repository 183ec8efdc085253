// SPDX-License-Identifier: BSD-3-Clause
// Guesses how a model stands if the user does not say: which direction is up, and from where it is
// seen first. All builders guess from the preview as the store has it, so they agree.
#pragma once

#include "filters/build/Builder.h"
#include "filters/core/Types.h"
#include "filters/store/StoreWriter.h"

#include <optional>
#include <span>
#include <string_view>

namespace kdstream
{

// The home view of a surface or cloud whose input had this extension (".stl"). A given direction
// stays.
//
// Up is one of the six axes:
// 1. glTF says that y is up, +z in front. VRML says that y is up.
// 2. A flat shape (one side of the box, along y or z, is below a fifth of the next) lies, and is
//    seen from above. But a shape that is flat along y and faces -y nearly everywhere is a wall: z
//    is up, and -y in front.
// 3. Else the axis whose ends differ most is up: in support, and in shape. An end's support is the
//    part of the box's face that its points span: those within a fiftieth of the box's diagonal of
//    the face. It is 0 if the middle of the surface is not above it. For a surface it is multiplied
//    by the side of the box along the axis, of its longest one: what lies is stable, too. Half of
//    the part of a surface that is not on its mirror image across the axis is added. y has up to
//    0.3 more where the relief towards +z is more than towards -z: a face would be there; and 0.1
//    more for .obj and .off. x has 0.1 less. These are the static stability and the symmetry of Fu,
//    Cohen-Or, Dror and Sheffer, "Upright Orientation of Man-Made Objects" (SIGGRAPH 2008), for
//    axes only; they learn from several features. The end with more support is the bottom if it is
//    the lower one, or has 0.3 more.
// 4. Where no axis has 0.1 more than the next: y for .obj and .off, else z.
//
// The view is level. A shape that is symmetric across one horizontal axis, as a head is, is seen
// along the other one, unless it is 1.6 times as long as wide, as animals are. Any other is seen on
// the wider of the two sides; if neither is wider (by a fifth), in front (FrontOf). The back
// becomes the front if it has 1.5 times as much relief, or 1.2 times where left and right are
// mirror images. Relief is the sum over the edges of the triangles that face the eye, of length
// times bend. A shape lower than half of its narrower side is seen from 30 degrees above.
//
// O(n log n) for n points and triangles. REQUIRES: given directions are of length 1 (DirectionOf).
HomeView GuessHomeView(std::span<const Vec3> points, std::span<const Triangle> triangles,
  std::string_view ending, const std::optional<Vec3>& up, const std::optional<Vec3>& view);

// Writes the home view into the store that is being written: as far as the options give it, and the
// rest as guessed from the store's preview. A store without levels gets only what the options give.
// REQUIRES: all pieces are written. Errors: Damaged.
Status TellHomeView(
  const BuildOptions& options, const ModelDescription& description, StoreWriter& writer);

}
