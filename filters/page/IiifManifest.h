// SPDX-License-Identifier: BSD-3-Clause
// A model and its notes as a manifest of IIIF Presentation 4 (a draft:
// https://iiif.io/api/presentation/4.0): a scene with the model, and annotations on it.
#pragma once

#include "filters/model/ModelDescription.h"
#include "filters/model/Notes.h"
#include "filters/page/PagePlace.h"

#include <span>
#include <string>

namespace kdstream
{

// place: of the manifest; `up` leads from the manifest's folder. If the root is not known,
// addresses are relative to the manifest.
std::string WriteIiifManifest(
  const ModelDescription& model, const PagePlace& place, std::span<const Note> notes);

}
