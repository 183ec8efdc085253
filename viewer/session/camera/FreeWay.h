// SPDX-License-Identifier: BSD-3-Clause
// How far the eye may move without going through the surface of a model, and how some of the
// surface stays in sight: below step "navigate" of the pipeline picture.
#pragma once

#include "viewer/session/Camera.h"
#include "viewer/session/model/ShownModel.h"

namespace kdstream
{

// How much of the straight way from one eye to another is free, 0-1: it ends before the shown
// surface, or, if none is shown, before the box. The whole way is free if it leads away from the
// model and ends outside the box. slack: for a cloud's points, as PickSurface. REQUIRES (all of
// these): an open model.
double FreePart(const ShownModel& model, const Camera& from, const Camera& to, double slack);

// Moves the focal point near enough to the shown surface for some of it to stay on the screen,
// however the model is turned. The camera itself knows only a box, most of which may be empty.
void KeepInSight(const ShownModel& model, Camera& camera);

// Whether the shown surface surrounds the eye. REQUIRES: a closed surface.
bool IsInside(const ShownModel& model, const Camera& camera);

}
