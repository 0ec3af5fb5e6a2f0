// Edges and faces in the words of the model format.
#pragma once

#include "geometry.h"
#include "text.h"

#include <Standard_Failure.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>

#include <string>
#include <vector>

/// The record of an edge.
Text edge_record(const TopoDS_Edge& edge, Approximation& approximation);

/// Writes what follows the tolerance and the colour of a face. `numbers` are those of the edges in the model.
void write_face_shape(Text& text, const TopoDS_Face& face, const TopTools_IndexedMapOfShape& edges,
                      const std::vector<int>& numbers, Approximation& approximation);

/// The message of an exception, or its name if it has none.
std::string message_of(const Standard_Failure& failure);
