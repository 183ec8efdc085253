// SPDX-License-Identifier: BSD-3-Clause
// A store by an octree, built out of core: its tree, its blocks of whole partitions, and instead of
// levels the phase "edges".
#pragma once

#include "filters/build/ExternalMethod.h"

namespace kdstream
{

const ExternalMethod& ExternalOctreeMethod();

}
