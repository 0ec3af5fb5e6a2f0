#include "mesh.h"

#include "text.h"

#include <BRepMesh_IncrementalMesh.hxx>
#include <BRep_Tool.hxx>
#include <Geom_Curve.hxx>
#include <Geom_Surface.hxx>
#include <Poly_PolygonOnTriangulation.hxx>
#include <Poly_Triangulation.hxx>
#include <TColStd_HArray1OfReal.hxx>
#include <TDF_LabelSequence.hxx>
#include <TopExp_Explorer.hxx>
#include <TopLoc_Location.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <gp_Pnt2d.hxx>
#include <gp_Vec.hxx>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

/// The angle between the normals of neighbouring triangles.
static const double ANGLE = 0.5;

/// The triangles of a shape in all places.
struct Triangles {
    long count = 0;
    long faces = 0;
    /// Faces that the mesher left out.
    long missing = 0;
    /// The largest distance of a point of a surface from the plane of its triangle. The points have the mean parameters
    /// of the triangle's corners and of the ends of its sides.
    double surface = 0.0;
    /// The largest distance of a point of an edge's curve from the line through the ends of its piece. The points have
    /// the mean parameters of the ends.
    double edge = 0.0;
};

/// The distance of a point from the line through two others.
static double line_distance(const gp_Pnt& point, const gp_Pnt& a, const gp_Pnt& b) {
    const gp_Vec along(a, b), to(a, point);
    const double length = along.Magnitude();
    return length > 0.0 ? to.Crossed(along).Magnitude() / length : to.Magnitude();
}

/// The distance of a point from the plane of a triangle, or from its longest side if it has no area.
static double plane_distance(const gp_Pnt& point, const gp_Pnt (&corners)[3]) {
    const gp_Vec normal = gp_Vec(corners[0], corners[1]).Crossed(gp_Vec(corners[0], corners[2]));
    const double area = normal.Magnitude();
    double longest = 0.0;
    int side = 0;
    for (int index = 0; index < 3; ++index) {
        const double length = corners[index].Distance(corners[(index + 1) % 3]);
        if (length > longest) longest = length, side = index;
    }
    if (area <= 1e-9 * longest * longest) return line_distance(point, corners[side], corners[(side + 1) % 3]);
    return std::abs(gp_Vec(corners[0], point).Dot(normal)) / area;
}

static void measure_edges(const TopoDS_Face& face, const Handle(Poly_Triangulation)& triangulation,
                          const TopLoc_Location& location, double scale, Triangles& all) {
    for (TopExp_Explorer explorer(face, TopAbs_EDGE); explorer.More(); explorer.Next()) {
        const TopoDS_Edge edge = TopoDS::Edge(explorer.Current());
        if (BRep_Tool::Degenerated(edge)) continue;
        const Handle(Poly_PolygonOnTriangulation) polygon =
            BRep_Tool::PolygonOnTriangulation(edge, triangulation, location);
        if (polygon.IsNull() || polygon->Parameters().IsNull()) continue;
        TopLoc_Location place;
        double first = 0.0, last = 0.0;
        const Handle(Geom_Curve) curve = BRep_Tool::Curve(edge, place, first, last);
        if (curve.IsNull()) continue;
        const Handle(TColStd_HArray1OfReal) parameters = polygon->Parameters();
        for (int index = parameters->Lower(); index < parameters->Upper(); ++index) {
            const double from = parameters->Value(index), to = parameters->Value(index + 1);
            const gp_Pnt middle = curve->Value(0.5 * (from + to));
            all.edge = std::max(all.edge, scale * line_distance(middle, curve->Value(from), curve->Value(to)));
        }
    }
}

static void measure_face(const TopoDS_Face& face, Triangles& all) {
    ++all.faces;
    TopLoc_Location location, place;
    const Handle(Poly_Triangulation) triangulation = BRep_Tool::Triangulation(face, location);
    if (triangulation.IsNull()) {
        ++all.missing;
        return;
    }
    all.count += triangulation->NbTriangles();
    const double scale = std::abs(location.Transformation().ScaleFactor());
    measure_edges(face, triangulation, location, scale, all);
    const Handle(Geom_Surface) surface = BRep_Tool::Surface(face, place);
    if (surface.IsNull() || !triangulation->HasUVNodes()) return;
    for (int index = 1; index <= triangulation->NbTriangles(); ++index) {
        int nodes[3];
        triangulation->Triangle(index).Get(nodes[0], nodes[1], nodes[2]);
        gp_Pnt corners[3];
        gp_XY uv[3];
        for (int corner = 0; corner < 3; ++corner) {
            corners[corner] = triangulation->Node(nodes[corner]);
            uv[corner] = triangulation->UVNode(nodes[corner]).XY();
        }
        const gp_XY middles[4] = {(uv[0] + uv[1] + uv[2]) / 3.0, 0.5 * (uv[0] + uv[1]), 0.5 * (uv[1] + uv[2]),
                                  0.5 * (uv[2] + uv[0])};
        for (const gp_XY& middle : middles) {
            const gp_Pnt point = surface->Value(middle.X(), middle.Y());
            all.surface = std::max(all.surface, scale * plane_distance(point, corners));
        }
    }
}

void write_mesh(const Handle(TDocStd_Document)& document, double deflection, std::FILE* output) {
    TDF_LabelSequence free;
    XCAFDoc_DocumentTool::ShapeTool(document->Main())->GetFreeShapes(free);
    std::vector<TopoDS_Shape> shapes;
    for (const TDF_Label& label : free) shapes.push_back(XCAFDoc_ShapeTool::GetShape(label));
    const auto start = std::chrono::steady_clock::now();
    for (const TopoDS_Shape& shape : shapes) BRepMesh_IncrementalMesh(shape, deflection, false, ANGLE, false);
    const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;
    Triangles all;
    for (const TopoDS_Shape& shape : shapes) {
        for (TopExp_Explorer face(shape, TopAbs_FACE); face.More(); face.Next()) {
            measure_face(TopoDS::Face(face.Current()), all);
        }
    }
    if (all.missing > 0) {
        log("warning: faces without triangles: " + std::to_string(all.missing) + " of " + std::to_string(all.faces));
    }
    Text text;
    (text << "milliseconds" << time.count()).line();
    (text << "triangles" << static_cast<double>(all.count)).line();
    (text << "surface" << all.surface).line();
    (text << "edge" << all.edge).line();
    std::fwrite(text.str().data(), 1, text.str().size(), output);
}
