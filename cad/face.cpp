#include "face.h"

#include <BRepLib.hxx>
#include <BRepTools.hxx>
#include <BRepTools_WireExplorer.hxx>
#include <BRep_Tool.hxx>
#include <Geom_Plane.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <Precision.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Iterator.hxx>
#include <TopoDS_Wire.hxx>

#include <cmath>
#include <stdexcept>

/// Whether an edge or a loop bounds its face.
static bool bounds(const TopoDS_Shape& shape) {
    return shape.Orientation() == TopAbs_FORWARD || shape.Orientation() == TopAbs_REVERSED;
}

Text edge_record(const TopoDS_Edge& edge, Approximation& approximation) {
    Text text;
    text << "edge" << "tolerance" << BRep_Tool::Tolerance(edge);
    if (BRep_Tool::Degenerated(edge)) {
        text << "point";
    } else {
        Range range{0.0, 0.0};
        Handle(Geom_Curve) curve = BRep_Tool::Curve(edge, range.first, range.last);
        if (curve.IsNull()) {
            if (!BRepLib::BuildCurve3d(edge)) throw std::runtime_error("it has no curve");
            curve = BRep_Tool::Curve(edge, range.first, range.last);
        }
        write_curve(text, curve, range, approximation);
    }
    return text.line();
}

/// The edges of a loop in their order.
static std::vector<TopoDS_Edge> edges_of(const TopoDS_Wire& wire, const TopoDS_Face& face,
                                         std::vector<std::string>& notes) {
    std::vector<TopoDS_Edge> stored, chain;
    for (TopoDS_Iterator edge(wire); edge.More(); edge.Next()) {
        if (bounds(edge.Value())) stored.push_back(TopoDS::Edge(edge.Value()));
    }
    for (BRepTools_WireExplorer edge(wire, face); edge.More(); edge.Next()) {
        if (bounds(edge.Current())) chain.push_back(edge.Current());
    }
    if (chain.size() == stored.size()) return chain;
    // The explorer stops where an edge does not begin at the end of the one before.
    notes.push_back("a loop whose edges are no chain is left in the order of the file");
    return stored;
}

static void write_coedge(Text& text, const TopoDS_Edge& edge, const TopoDS_Face& face,
                         const TopTools_IndexedMapOfShape& edges, const std::vector<int>& numbers, bool is_plane) {
    const int index = edges.FindIndex(edge);
    const int number = index == 0 ? -1 : numbers[static_cast<size_t>(index - 1)];
    if (number < 0) throw std::runtime_error("one of its edges is left out");
    text << (edge.Orientation() == TopAbs_FORWARD ? "+" : "-") << number;
    if (is_plane) return;
    Range range{0.0, 0.0};
    const Handle(Geom2d_Curve) curve = BRep_Tool::CurveOnSurface(edge, face, range.first, range.last);
    if (curve.IsNull()) return;
    // A curve without length has no B-spline; the edge is then projected onto the surface.
    try {
        Text pcurve;
        write_pcurve(pcurve, curve, range);
        text << pcurve.str().c_str();
    } catch (const Standard_Failure&) {
    } catch (const std::exception&) {
    }
}

void write_face_shape(Text& text, const TopoDS_Face& face, const TopTools_IndexedMapOfShape& edges,
                      const std::vector<int>& numbers, Approximation& approximation) {
    // Of the two parameter curves along a seam, a forward face gives the right one.
    const TopoDS_Face forward = TopoDS::Face(face.Oriented(TopAbs_FORWARD));
    TopLoc_Location location;
    BRep_Tool::Surface(face, location);
    const gp_Trsf place = location.Transformation();
    if (std::abs(std::abs(place.ScaleFactor()) - 1.0) > 1e-12) {
        throw std::runtime_error("its place in the part has a scale");
    }
    Handle(Geom_Surface) surface = BRep_Tool::Surface(face);
    if (surface.IsNull()) throw std::runtime_error("it has no surface");
    if (const auto trimmed = Handle(Geom_RectangularTrimmedSurface)::DownCast(surface)) {
        surface = trimmed->BasisSurface();
    }
    Range u{0.0, 0.0}, v{0.0, 0.0};
    BRepTools::UVBounds(forward, u.first, u.last, v.first, v.last);
    if (!(u.first < u.last && v.first < v.last)) surface->Bounds(u.first, u.last, v.first, v.last);
    for (const double bound : {u.first, u.last, v.first, v.last}) {
        if (Precision::IsInfinite(bound)) throw std::runtime_error("it has no bounds");
    }
    Text shape;
    write_surface(shape, surface, u, v, approximation);
    // A place that mirrors turns ∂u × ∂v against the outside.
    const bool reversed = (face.Orientation() == TopAbs_REVERSED) != place.IsNegative();
    text << (reversed ? "reversed" : "forward") << "bounds" << u.first << u.last << v.first << v.last
         << shape.str().c_str();
    const bool is_plane = surface->IsKind(STANDARD_TYPE(Geom_Plane));
    for (TopoDS_Iterator wire(forward); wire.More(); wire.Next()) {
        if (wire.Value().ShapeType() != TopAbs_WIRE || !bounds(wire.Value())) continue;
        const std::vector<TopoDS_Edge> chain = edges_of(TopoDS::Wire(wire.Value()), forward, approximation.notes);
        if (chain.empty()) continue;
        text.line() << "  loop" << static_cast<int>(chain.size());
        for (const TopoDS_Edge& edge : chain) write_coedge(text, edge, forward, edges, numbers, is_plane);
    }
    text.line();
}

std::string message_of(const Standard_Failure& failure) {
    const char* message = failure.GetMessageString();
    return message != nullptr && *message != 0 ? message : failure.DynamicType()->Name();
}
