// SPDX-License-Identifier: BSD-3-Clause
// Reads STL files in chunks: step "read" of the pipeline picture.
#pragma once

#include "filters/core/Execution.h"
#include "filters/meshio/ByteSource.h"
#include "filters/meshio/MeshReader.h"

namespace kdstream
{

// ASCII and binary STL. An STL file is a soup: triangle i has the vertices 3i, 3i + 1 and 3i + 2 of
// its own, and Info().soup says so; whoever builds from it welds. Memory: one block of the file and
// what is appended to the caller's vectors.
//
// A file is binary if its size is the one that its count of triangles gives, whatever it begins
// with (many writers begin the header of a binary file with "solid"); else it is text if it begins
// with that word and holds no control characters where a binary file has its header; else it is
// binary too if it is larger than its count gives, and its first triangle can be one: bytes behind
// the last are counted, as triangles where they can be some. Where it counts none, or 2^32 - 1, as
// programs write that do not know the number yet, all triangles are read and counted as not
// counted. All vertices of a facet that has one that is not finite are given as NaN, so that it
// goes whole (FiniteReader.h); only those of the file are counted. Binary: floats, little endian.
// The normals are not read, nor the two bytes after each triangle; where one is not 0,
// Info().ignoredAttributes names them. Text: any number of solids, one after the other, their words
// apart by any blanks, in small or capital letters, also all in one line. A loop of more than three
// vertices is a polygon, of which the triangles are read (core/CutPolygon.h); of fewer than three
// it is dropped and counted. Where the word that ends a solid is missing, that is counted
// (Lapse::EndMissing); words between facets that are none of the format's, such as a colour's, are
// passed over up to the end of their line and named in Info().ignoredAttributes, unless there are a
// facet's words behind them. Opening goes through the whole text once: it counts, and finds out
// whether floats tell its decimals apart, else coordinates are doubles. What was opened is well
// formed but for its numbers.
//
// Errors: InvalidInput: no STL file; a size other than the header claims; "facet 17: …" for a word
// or number that should be another, a text without its end; text in UTF-16;
// LimitExceeded for more than 2^32 - 2 vertices; InputOutput; Cancelled by the execution, to which
// the pass of opening is reported as "read".
Result<std::unique_ptr<MeshReader>> OpenStlReader(ByteSource source, const Execution& execution);

}
