// SPDX-License-Identifier: BSD-3-Clause
// Encodes pictures as files: for texture tiles, kdstream-generate and tests.
#pragma once

#include "filters/core/Result.h"
#include "filters/texture/Picture.h"

#include <cstdint>
#include <vector>

namespace kdstream
{

// Encodes the picture as a PNG or a WebP (both lossless, of 1-4 components), or as a JPEG (of 1 or
// 3 components, with quality 90). The same picture and versions of the libraries give the same
// bytes. REQUIRES: a known type that can hold the picture.
std::vector<std::uint8_t> EncodePicture(const Picture& picture, PictureType type);

// Encodes an RGBA picture as WebP, with a quality of 1-100, or lossless (0). alpha: whether alpha
// is kept; if not, the result is RGB. A lossless picture with alpha keeps all texels bit for bit,
// even those of alpha 0. effort: WebP's method, 0-6; the more, the fewer bytes and the slower: 4
// takes 4 % fewer bytes than 2, and half as much time again. Errors: LimitExceeded for sides above
// 16383, or for lack of memory.
Result<std::vector<std::uint8_t>> EncodeWebp(
  Picture picture, unsigned quality, bool alpha, int effort = 2);

}
