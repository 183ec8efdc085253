// SPDX-License-Identifier: BSD-3-Clause
// Reads STL files in chunks: step "read" of the pipeline picture.
#pragma once

#include "filters/core/Execution.h"
#include "filters/meshio/ByteSource.h"
#include "filters/meshio/MeshReader.h"

namespace kdstream
{

// ASCII and binary STL. An STL file is a soup: triangle i has the vertices 3i, 3i + 1 and 3i + 2.
// Info().soup says so; the builder then welds the vertices. Memory: one block of the file, and the
// vectors that the caller passes.
//
// Binary or text? The first rule that applies decides:
// 1. Binary if the file has exactly the size that its count of triangles requires, whatever it
//    begins with. (Many programs begin the header of a binary file with "solid".)
// 2. Text if the file begins with "solid" and has no control characters where a binary file has its
//    header.
// 3. Binary if the first triangle is plausible, and either the file is larger than its count
//    requires, or the count is 0 or 2^32 - 1 and whole triangles follow. Bytes after the last
//    triangle are counted; as triangles if they can be triangles.
//
// Binary: floats, little endian. A count of 0 or 2^32 - 1 means that the writing program did not
// know the number: all triangles are read, and a warning says that the header does not count them.
// Normals are not read, and neither are the two bytes after each triangle; if one of these is not
// 0, Info().ignoredAttributes names them.
//
// Text: any number of solids. The words may be in small or capital letters and separated by any
// blanks; one line may hold everything.
// - A loop of more than three vertices is a polygon, whose triangles are read (core/CutPolygon.h).
//   A loop of fewer than three is dropped and counted.
// - A missing "endsolid" is counted (Lapse::EndMissing).
// - Unknown words between facets, such as a colour, are named in Info().ignoredAttributes. They are
//   skipped to the end of their line, unless words of a facet follow them.
// - Opening reads the whole text once: it counts, checks everything except the numbers, and finds
//   out whether floats keep the decimals distinct. If they do not, coordinates are doubles.
//
// If one vertex of a facet is not finite, all its vertices become NaN, so that the whole facet is
// dropped (FiniteReader.h). Only the vertices that are not finite in the file are counted.
//
// Errors: InvalidInput for a file that is not STL, a size other than the header claims, a wrong
// word or number ("facet 17: …"), text that does not end properly, text in UTF-16; LimitExceeded
// for more than 2^32 - 2 vertices; InputOutput; Cancelled. The execution sees the pass at opening
// as step "read".
Result<std::unique_ptr<MeshReader>> OpenStlReader(ByteSource source, const Execution& execution);

}
