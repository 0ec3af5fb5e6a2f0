// Curves and surfaces in the words of the model format.
#pragma once

#include "text.h"

#include <Geom2d_Curve.hxx>
#include <Geom_Curve.hxx>
#include <Geom_Surface.hxx>

#include <string>
#include <vector>

/// How curves and surfaces that the format lacks are approximated.
struct Approximation {
    /// The greatest distance.
    double tolerance;
    /// What the log should say of the edge or the face: what was approximated, above all.
    std::vector<std::string> notes;
};

/// The least and the greatest parameter.
struct Range {
    double first;
    double last;

    double length() const { return last - first; }
};

/// Writes "range" and a curve that keeps its parameters.
void write_curve(Text& text, const Handle(Geom_Curve)& curve, Range range, Approximation& approximation);

/// Writes a surface that keeps its parameters. The bounds are those of its face; they are reduced to the domain of a
/// B-spline surface.
void write_surface(Text& text, const Handle(Geom_Surface)& surface, Range& u, Range& v,
                   Approximation& approximation);

/// Writes "pcurve" and a part of a curve in the plane. Throws if it has no length.
void write_pcurve(Text& text, const Handle(Geom2d_Curve)& curve, Range range);
