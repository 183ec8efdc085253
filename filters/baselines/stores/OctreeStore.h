// SPDX-License-Identifier: BSD-3-Clause
// A store by an octree, built out of core: its tree, its blocks of whole partitions, and the phase
// "edges" in place of levels.
#pragma once

#include "filters/build/ExternalMethod.h"

namespace kdstream
{

const ExternalMethod& ExternalOctreeMethod();

}
