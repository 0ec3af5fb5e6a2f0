#include "geometry.h"

#include <Geom2dConvert.hxx>
#include <Geom2d_BSplineCurve.hxx>
#include <Geom2d_OffsetCurve.hxx>
#include <Geom2d_TrimmedCurve.hxx>
#include <GeomConvert.hxx>
#include <GeomConvert_ApproxCurve.hxx>
#include <GeomConvert_ApproxSurface.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_BezierCurve.hxx>
#include <Geom_BezierSurface.hxx>
#include <Geom_Circle.hxx>
#include <Geom_Conic.hxx>
#include <Geom_ConicalSurface.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_Ellipse.hxx>
#include <Geom_Line.hxx>
#include <Geom_OffsetSurface.hxx>
#include <Geom_Parabola.hxx>
#include <Geom_Plane.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Geom_SurfaceOfLinearExtrusion.hxx>
#include <Geom_SurfaceOfRevolution.hxx>
#include <Geom_ToroidalSurface.hxx>
#include <Geom_TrimmedCurve.hxx>
#include <Precision.hxx>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

/// The largest degree of the format.
static const int MAX_DEGREE = 15;

/// The degree of approximations.
static const int APPROXIMATION_DEGREE = 8;

/// The largest number of spans of an approximation along each axis.
static const int MAX_SPANS = 1000;

/// A part of a domain or of a period that is rounding.
static const double ROUNDING = 1e-9;

/// The part of a range that lies within a domain.
static Range clamp(Range range, Range domain) {
    return {std::clamp(range.first, domain.first, domain.last), std::clamp(range.last, domain.first, domain.last)};
}

/// Whether a range begins or ends outside of the domain of a periodic curve, so that the curve must be cut elsewhere.
static bool crosses(Range range, Range domain) {
    const double rounding = ROUNDING * domain.length();
    const bool outside = range.first < domain.first - rounding || range.last > domain.last + rounding;
    return outside && range.length() <= domain.length() + rounding;
}

/// The parameter plus or minus whole periods, within a domain that is one period.
static double within(double parameter, Range domain) {
    return parameter - std::floor((parameter - domain.first) / domain.length()) * domain.length();
}

/// The smallest and the largest weight of the format.
static const double MIN_WEIGHT = 1e-9, MAX_WEIGHT = 1e9;

static double radius(double value) {
    if (!(value > 0.0)) throw std::runtime_error("a radius is not above 0");
    return value;
}

static double weight(double value) {
    if (!(value >= MIN_WEIGHT && value <= MAX_WEIGHT)) throw std::runtime_error("a weight is not from 1e-9 to 1e9");
    return value;
}

/// An angle's range, cut to one turn where rounding makes it longer.
static Range turn(Range range) {
    const double longest = 2.0 * M_PI;
    if (range.length() > longest * (1.0 + 1e-3)) throw std::runtime_error("a range of more than one turn");
    return {range.first, std::min(range.last, range.first + longest)};
}

static void write_knots(Text& text, const TColStd_Array1OfReal& knots, double shift) {
    text << "knots" << knots.Length();
    for (const double knot : knots) text << knot + shift;
}

/// Opens a periodic curve. Where the range crosses its seam, the curve is cut at the range's beginning. Returns what
/// must be added to the curve's parameters: some periods.
static double open(const Handle(Geom_BSplineCurve)& curve, Range range) {
    const Range domain{curve->FirstParameter(), curve->LastParameter()};
    double shift = 0.0;
    if (crosses(range, domain)) {
        const double cut = within(range.first, domain);
        curve->InsertKnot(cut, 1, ROUNDING * domain.length(), false);
        int index = curve->FirstUKnotIndex();
        while (curve->Knot(index) < cut - ROUNDING * domain.length()) ++index;
        curve->SetOrigin(index);
        shift = range.first - cut;
    }
    curve->SetNotPeriodic();
    return shift;
}

static Handle(Geom_BSplineCurve) approximated(const Handle(Geom_Curve)& curve, Range range, Approximation& to) {
    const Handle(Geom_TrimmedCurve) part = new Geom_TrimmedCurve(curve, range.first, range.last);
    GeomConvert_ApproxCurve result(part, to.tolerance, GeomAbs_C1, MAX_SPANS, APPROXIMATION_DEGREE);
    if (!result.HasResult()) throw std::runtime_error("a curve cannot be approximated by a B-spline");
    to.notes.push_back(std::string(curve->DynamicType()->Name()) + " as B-spline curve, " +
                       rounded(result.MaxError()) + " off");
    return result.Curve();
}

/// The curve as a B-spline curve that is not periodic. The shift must be added to its parameters.
static Handle(Geom_BSplineCurve) to_bspline(const Handle(Geom_Curve)& curve, Range range, Approximation& to,
                                            double& shift) {
    Handle(Geom_BSplineCurve) result = Handle(Geom_BSplineCurve)::DownCast(curve->Copy());
    if (result.IsNull()) {
        if (curve->IsKind(STANDARD_TYPE(Geom_BezierCurve))) {
            result = GeomConvert::CurveToBSplineCurve(curve);
        } else if (curve->IsKind(STANDARD_TYPE(Geom_Parabola))) {
            result = GeomConvert::CurveToBSplineCurve(new Geom_TrimmedCurve(curve, range.first, range.last));
        }
    }
    if (result.IsNull() || result->Degree() > MAX_DEGREE) {
        result = approximated(curve, range, to);
        // A part of a periodic curve begins within its first period.
        shift = curve->IsPeriodic() ? range.first - result->FirstParameter() : 0.0;
    } else if (result->IsPeriodic()) {
        shift = open(result, range);
    }
    return result;
}

void write_curve(Text& text, const Handle(Geom_Curve)& curve, Range range, Approximation& approximation) {
    if (const auto trimmed = Handle(Geom_TrimmedCurve)::DownCast(curve); !trimmed.IsNull()) {
        return write_curve(text, trimmed->BasisCurve(), range, approximation);
    }
    if (Precision::IsInfinite(range.first) || Precision::IsInfinite(range.last)) {
        throw std::runtime_error("a curve without ends");
    }
    if (!(range.first < range.last)) throw std::runtime_error("a curve without length");
    if (curve->IsKind(STANDARD_TYPE(Geom_Conic)) && curve->IsPeriodic()) range = turn(range);
    if (const auto line = Handle(Geom_Line)::DownCast(curve); !line.IsNull()) {
        const gp_Ax1& axis = line->Position();
        text << "range" << range.first << range.last << "line" << axis.Location().XYZ() << axis.Direction().XYZ();
    } else if (const auto circle = Handle(Geom_Circle)::DownCast(curve); !circle.IsNull()) {
        text << "range" << range.first << range.last << "circle" << gp_Ax3(circle->Position())
             << radius(circle->Radius());
    } else if (const auto ellipse = Handle(Geom_Ellipse)::DownCast(curve); !ellipse.IsNull()) {
        text << "range" << range.first << range.last << "ellipse" << gp_Ax3(ellipse->Position())
             << radius(ellipse->MajorRadius()) << radius(ellipse->MinorRadius());
    } else {
        double shift = 0.0;
        const Handle(Geom_BSplineCurve) bspline = to_bspline(curve, range, approximation, shift);
        const Range part = clamp(range, {bspline->FirstParameter() + shift, bspline->LastParameter() + shift});
        if (!(part.first < part.last)) throw std::runtime_error("a curve without length");
        if (part.length() < (1.0 - ROUNDING) * range.length()) {
            approximation.notes.push_back("its B-spline curve ends before it");
        }
        text << "range" << part.first << part.last << "nurbs" << "degree" << bspline->Degree();
        write_knots(text, bspline->KnotSequence(), shift);
        text << "points" << bspline->NbPoles();
        for (int index = 1; index <= bspline->NbPoles(); ++index) {
            text << bspline->Pole(index).XYZ() << weight(bspline->Weight(index));
        }
    }
}

/// The part of the curve that a surface with these bounds along it needs: all of it, or the bounds, if it has no ends
/// or they need not be where the bounds are.
static Range part_of(const Handle(Geom_Curve)& curve, Range bounds) {
    const bool has_ends = !Precision::IsInfinite(curve->FirstParameter()) &&
                          !Precision::IsInfinite(curve->LastParameter()) && !curve->IsPeriodic();
    return has_ends ? Range{curve->FirstParameter(), curve->LastParameter()} : bounds;
}

/// A B-spline surface, and what must be added to its parameters: periods, or nothing.
struct Spline {
    Handle(Geom_BSplineSurface) surface;
    double shift_u;
    double shift_v;

    Range u() const { return {domain(0) + shift_u, domain(1) + shift_u}; }
    Range v() const { return {domain(2) + shift_v, domain(3) + shift_v}; }

private:
    double domain(int index) const {
        double bounds[4];
        surface->Bounds(bounds[0], bounds[1], bounds[2], bounds[3]);
        return bounds[index];
    }
};

/// Opens a periodic surface. Where the bounds cross its seam, the surface is cut at the bounds' beginning.
static void open(Spline& spline, Range u, Range v) {
    const Handle(Geom_BSplineSurface)& surface = spline.surface;
    const Range domain_u = spline.u(), domain_v = spline.v();
    if (surface->IsUPeriodic()) {
        if (crosses(u, domain_u)) {
            const double cut = within(u.first, domain_u), rounding = ROUNDING * domain_u.length();
            surface->InsertUKnot(cut, 1, rounding, false);
            int index = surface->FirstUKnotIndex();
            while (surface->UKnot(index) < cut - rounding) ++index;
            surface->SetUOrigin(index);
            spline.shift_u = u.first - cut;
        }
        surface->SetUNotPeriodic();
    }
    if (surface->IsVPeriodic()) {
        if (crosses(v, domain_v)) {
            const double cut = within(v.first, domain_v), rounding = ROUNDING * domain_v.length();
            surface->InsertVKnot(cut, 1, rounding, false);
            int index = surface->FirstVKnotIndex();
            while (surface->VKnot(index) < cut - rounding) ++index;
            surface->SetVOrigin(index);
            spline.shift_v = v.first - cut;
        }
        surface->SetVNotPeriodic();
    }
}

static Handle(Geom_BSplineSurface) approximated(const Handle(Geom_Surface)& surface, Range u, Range v,
                                                Approximation& to) {
    const Handle(Geom_Surface) part =
        new Geom_RectangularTrimmedSurface(surface, u.first, u.last, v.first, v.last);
    GeomConvert_ApproxSurface result(part, to.tolerance, GeomAbs_C1, GeomAbs_C1, APPROXIMATION_DEGREE,
                                     APPROXIMATION_DEGREE, MAX_SPANS, 1);
    if (!result.HasResult()) throw std::runtime_error("its surface cannot be approximated by a B-spline");
    to.notes.push_back(std::string(surface->DynamicType()->Name()) + " as B-spline surface, " +
                       rounded(result.MaxError()) + " off");
    return result.Surface();
}

/// The surface as a B-spline surface that is not periodic.
static Spline to_bspline(const Handle(Geom_Surface)& surface, Range u, Range v, Approximation& to) {
    Spline result{Handle(Geom_BSplineSurface)::DownCast(surface->Copy()), 0.0, 0.0};
    if (result.surface.IsNull() && surface->IsKind(STANDARD_TYPE(Geom_BezierSurface))) {
        result.surface = GeomConvert::SurfaceToBSplineSurface(surface);
    }
    if (result.surface.IsNull() || std::max(result.surface->UDegree(), result.surface->VDegree()) > MAX_DEGREE) {
        result.surface = approximated(surface, u, v, to);
        // A part of a periodic surface begins within its first period.
        if (surface->IsUPeriodic()) result.shift_u = u.first - result.u().first;
        if (surface->IsVPeriodic()) result.shift_v = v.first - result.v().first;
    } else {
        open(result, u, v);
    }
    return result;
}

static void write_bspline(Text& text, const Spline& spline, Range& u, Range& v) {
    u = clamp(u, spline.u());
    v = clamp(v, spline.v());
    if (!(u.first < u.last && v.first < v.last)) throw std::runtime_error("its bounds are beside its surface");
    const Handle(Geom_BSplineSurface)& surface = spline.surface;
    text << "nurbs" << "degree" << surface->UDegree() << surface->VDegree();
    write_knots(text, surface->UKnotSequence(), spline.shift_u);
    write_knots(text, surface->VKnotSequence(), spline.shift_v);
    text << "points" << surface->NbUPoles() << surface->NbVPoles();
    for (int row = 1; row <= surface->NbVPoles(); ++row) {
        for (int column = 1; column <= surface->NbUPoles(); ++column) {
            text << surface->Pole(column, row).XYZ() << weight(surface->Weight(column, row));
        }
    }
}

/// Whether u and v of a surface are angles.
static std::pair<bool, bool> are_angles(const Handle(Geom_Surface)& surface) {
    const bool of_torus = surface->IsKind(STANDARD_TYPE(Geom_ToroidalSurface));
    const bool around = of_torus || surface->IsKind(STANDARD_TYPE(Geom_CylindricalSurface)) ||
                        surface->IsKind(STANDARD_TYPE(Geom_ConicalSurface)) ||
                        surface->IsKind(STANDARD_TYPE(Geom_SphericalSurface)) ||
                        surface->IsKind(STANDARD_TYPE(Geom_SurfaceOfRevolution));
    return {around, of_torus};
}

void write_surface(Text& text, const Handle(Geom_Surface)& surface, Range& u, Range& v,
                   Approximation& approximation) {
    const auto [u_is_angle, v_is_angle] = are_angles(surface);
    if (u_is_angle) u = turn(u);
    if (v_is_angle) v = turn(v);
    if (const auto trimmed = Handle(Geom_RectangularTrimmedSurface)::DownCast(surface); !trimmed.IsNull()) {
        write_surface(text, trimmed->BasisSurface(), u, v, approximation);
    } else if (const auto plane = Handle(Geom_Plane)::DownCast(surface); !plane.IsNull()) {
        text << "plane" << plane->Position();
    } else if (const auto cylinder = Handle(Geom_CylindricalSurface)::DownCast(surface); !cylinder.IsNull()) {
        text << "cylinder" << cylinder->Position() << radius(cylinder->Radius());
    } else if (const auto cone = Handle(Geom_ConicalSurface)::DownCast(surface); !cone.IsNull()) {
        text << "cone" << cone->Position() << cone->RefRadius() << cone->SemiAngle();
    } else if (const auto sphere = Handle(Geom_SphericalSurface)::DownCast(surface); !sphere.IsNull()) {
        text << "sphere" << sphere->Position() << radius(sphere->Radius());
    } else if (const auto torus = Handle(Geom_ToroidalSurface)::DownCast(surface); !torus.IsNull()) {
        text << "torus" << torus->Position() << torus->MajorRadius() << radius(torus->MinorRadius());
    } else if (const auto turned = Handle(Geom_SurfaceOfRevolution)::DownCast(surface); !turned.IsNull()) {
        const gp_Ax1 axis = turned->Axis();
        text << "revolution" << "origin" << axis.Location().XYZ() << "axis" << axis.Direction().XYZ();
        write_curve(text, turned->BasisCurve(), part_of(turned->BasisCurve(), v), approximation);
    } else if (const auto moved = Handle(Geom_SurfaceOfLinearExtrusion)::DownCast(surface); !moved.IsNull()) {
        text << "extrusion" << "direction" << moved->Direction().XYZ();
        write_curve(text, moved->BasisCurve(), part_of(moved->BasisCurve(), u), approximation);
    } else {
        // The offset of a plane, a cylinder and the like is of the same kind.
        const auto offset = Handle(Geom_OffsetSurface)::DownCast(surface);
        const Handle(Geom_Surface) same = offset.IsNull() ? Handle(Geom_Surface)() : offset->Surface();
        if (!same.IsNull()) return write_surface(text, same, u, v, approximation);
        write_bspline(text, to_bspline(surface, u, v, approximation), u, v);
    }
}

void write_pcurve(Text& text, const Handle(Geom2d_Curve)& curve, Range range) {
    Range part = range;
    if (!curve->IsPeriodic()) part = clamp(range, {curve->FirstParameter(), curve->LastParameter()});
    Handle(Geom2d_Curve) basis = curve;
    while (const auto trimmed = Handle(Geom2d_TrimmedCurve)::DownCast(basis)) basis = trimmed->BasisCurve();
    if (basis->IsKind(STANDARD_TYPE(Geom2d_OffsetCurve))) throw std::runtime_error("an offset curve");
    const Handle(Geom2d_TrimmedCurve) trimmed = new Geom2d_TrimmedCurve(basis, part.first, part.last);
    const Handle(Geom2d_BSplineCurve) bspline = Geom2dConvert::CurveToBSplineCurve(trimmed);
    if (bspline->IsPeriodic()) bspline->SetNotPeriodic();
    if (bspline->Degree() > MAX_DEGREE) throw std::runtime_error("a degree above 15");
    text << "pcurve" << "degree" << bspline->Degree();
    write_knots(text, bspline->KnotSequence(), 0.0);
    text << "points" << bspline->NbPoles();
    for (int index = 1; index <= bspline->NbPoles(); ++index) {
        const gp_Pnt2d pole = bspline->Pole(index);
        text << pole.X() << pole.Y() << weight(bspline->Weight(index));
    }
}
