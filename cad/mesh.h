// OCCT's triangles of a document, for comparison.
#pragma once

#include <TDocStd_Document.hxx>

#include <cstdio>

/// Meshes the shapes of a document with an absolute deflection, in the model's unit. Writes the time of meshing, the
/// number of triangles in all places, and their largest distance from the surfaces and the edges.
void write_mesh(const Handle(TDocStd_Document)& document, double deflection, std::FILE* output);
