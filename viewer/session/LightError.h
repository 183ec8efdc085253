// SPDX-License-Identifier: BSD-3-Clause
// What light and paint need beside the shape: under step "choose" of the README's picture.
//
// They come from values at the vertices and are interpolated between these: what varies from one to
// the next is lost, however near the surface is. So the deviation of a piece counts as at least a
// part of the distance between its vertices (decision 6).
#pragma once

#include "filters/core/Attribute.h"
#include "filters/model/ModelDescription.h"
#include "viewer/session/Geometry.h"

#include <algorithm>
#include <cmath>

namespace kdstream
{

// A sixth for the normals; a third if the model is painted.
inline double LightPartOf(const ModelDescription& model)
{
  const bool painted = std::any_of(model.attributes.begin(), model.attributes.end(),
    [](const AttributeInfo& array) { return RoleOf(array) == AttributeRole::Colors; });
  return painted ? 1.0 / 3 : 1.0 / 6;
}

// About how far apart the vertices of a surface in a box are, spread over half the box's surface.
// Model units.
inline double VertexSpacing(const Box& box, double vertices)
{
  const Vec3 s = box.hi - box.lo;
  const double area = s[0] * s[1] + s[1] * s[2] + s[2] * s[0];
  return std::sqrt(area / std::max(vertices, 1.0));
}

}
