// SPDX-License-Identifier: BSD-3-Clause
// Pictures as files: of texture tiles, and for kdstream-generate and tests.
#pragma once

#include "filters/core/Result.h"
#include "filters/texture/Picture.h"

#include <cstdint>
#include <vector>

namespace kdstream
{

// The picture as a PNG, a WebP (both lossless, of 1-4 components) or a JPEG (of 1 or 3, with
// quality 90). The same bytes for the same picture and versions of the libraries. REQUIRES: a known
// type that can hold the picture.
std::vector<std::uint8_t> EncodePicture(const Picture& picture, PictureType type);

// Encodes an RGBA picture as WebP, with a quality of 1-100, or lossless (0). alpha: whether alpha
// is kept (if lossless, all texels bit for bit, also those of alpha 0); else the result is RGB.
// Errors: LimitExceeded for sides above 16383, or a lack of memory.
Result<std::vector<std::uint8_t>> EncodeWebp(Picture picture, unsigned quality, bool alpha);

}
