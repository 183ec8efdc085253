// SPDX-License-Identifier: BSD-3-Clause
// How far an eye may go through a model, and where it is lost: under step "look" of the pipeline
// picture.
#pragma once

#include "viewer/session/Camera.h"
#include "viewer/session/model/ShownModel.h"

namespace kdstream
{

// How much of the straight way from one eye to another may be gone, 0-1: not up to the shown
// surface or, where none is shown, the box. All of it leads away where it ends outside of the box.
// slack: of a cloud's points, as PickSurface. REQUIRES (all of these): a model that is open.
double FreePart(const ShownModel& model, const Camera& from, const Camera& to, double slack);

// The focal point comes so near to some of the shown surface that this is on the screen whichever
// way one turns. The camera itself knows no more than a box, of which most may be empty.
void KeepInSight(const ShownModel& model, Camera& camera);

// Whether the surface, which is closed, is around the eye.
bool IsInside(const ShownModel& model, const Camera& camera);

}
