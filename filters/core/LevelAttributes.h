// Normals and colours of the levels: the last part of step "levels" of the README's picture.
#pragma once

#include "filters/core/ClusterLevels.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"

namespace kdstream
{

// Gives every level the mean of the mesh's normals and of its colours (RoleOf), under the name and
// type that they have in the mesh; other arrays are the original's alone.
//
// Colours: each component's mean over the cluster's original vertices, alpha like the others,
// rounded to the nearest value (halves upwards).
// Normals: the mean of the directions of the cluster's normals, of length 1. Tuples without a
// direction (all zero, or a component that is NaN or infinite) are left out. Where the directions
// cancel each other (their sum is shorter than 10^-9 of their number) it is the direction of the
// lowest original vertex that has one; where none has one it is (0, 0, 0).
//
// Sums are in double, over original vertices ascending at the finest level and over children by
// lowest vertex above. Serial; O(n + c log c) for c clusters; 64 bytes a cluster of the finest
// level. REQUIRES: CheckAttributes(mesh.attributes, …), levels of this mesh.
// Source: DESIGN section 4 "Attributes"; the paper has none.
void AddLevelAttributes(const Mesh& mesh, ClusterLevels& levels);

}
