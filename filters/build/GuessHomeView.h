// SPDX-License-Identifier: BSD-3-Clause
// Guesses how a model stands if the user does not say: which direction is up, and from where it is
// seen first. All builders guess from the preview as it is in the store, so their guesses agree.
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
// 1. glTF says that y is up and +z in front. VRML says that y is up.
// 2. A flat shape (one side of the box, along y or z, is shorter than a fifth of the next) lies,
//    and is seen from above. But a shape that is flat along y and faces -y nearly everywhere is a
//    wall: z is up, and -y in front.
// 3. Otherwise the axis whose ends differ most, in support and in shape, is up. The points of an
//    end are those within a fiftieth of the box's diagonal of the box's face. The support of an end
//    is the part of the face that its points span; it is 0 if the middle of the surface is not
//    above them. For a surface, the support is multiplied by the box's side along the axis, divided
//    by its longest side: a shape that lies is stable, too. The part of a surface that is not on
//    its mirror image across the axis, divided by two, is added. y gets up to 0.3 more if the
//    relief towards +z is larger than that towards -z (a face would be there), and 0.1 more for
//    .obj and .off. x gets 0.1 less. These are the static stability and the symmetry of Fu,
//    Cohen-Or, Dror and Sheffer, "Upright Orientation of Man-Made Objects" (SIGGRAPH 2008), for
//    axes only; they learn from several features. The end with more support is the bottom if it is
//    the lower end, or if its support is 0.3 more.
// 4. If no axis has 0.1 more than the next: y for .obj and .off, else z.
//
// The view is level. A shape that is symmetric across one horizontal axis, such as a head, is seen
// along the other one, unless it is 1.6 times as long as wide, as animals are. Any other shape is
// seen from the wider of the two sides; if neither is wider (by a fifth), from the front (FrontOf).
// The back becomes the front if it has 1.5 times as much relief, or 1.2 times if left and right are
// mirror images. Relief is the sum, over the edges of the triangles that face the eye, of length
// times bend. A shape lower than half of its narrower side is seen from 30 degrees above.
//
// O(n log n) for n points and triangles. REQUIRES: given directions are of length 1 (DirectionOf).
HomeView GuessHomeView(std::span<const Vec3> points, std::span<const Triangle> triangles,
  std::string_view ending, const std::optional<Vec3>& up, const std::optional<Vec3>& view);

// Sets the home view of the store that is being written: the directions in the options, and the
// others guessed from the store's preview. A store without levels gets a home view only if the
// options give a direction. REQUIRES: all pieces are written. Errors: Damaged.
Status TellHomeView(
  const BuildOptions& options, const ModelDescription& description, StoreWriter& writer);

}
