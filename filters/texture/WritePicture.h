// SPDX-License-Identifier: BSD-3-Clause
// Pictures as files: for kdstream-generate and tests.
#pragma once

#include "filters/texture/Picture.h"

#include <cstdint>
#include <vector>

namespace kdstream
{

// The picture as a PNG, a WebP (both lossless, of 1-4 components) or a JPEG (of 1 or 3, the quality
// 90). The same bytes for the same picture and versions of the libraries. REQUIRES: a known type;
// what it can hold.
std::vector<std::uint8_t> EncodePicture(const Picture& picture, PictureType type);

}
