#include "model.h"

#include "face.h"

#include <BRepBndLib.hxx>
#include <BRepGProp.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <GProp_GProps.hxx>
#include <TDF_Tool.hxx>
#include <TDataStd_Name.hxx>
#include <TopExp.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <XCAFDoc_DocumentTool.hxx>

#include <algorithm>
#include <cmath>
#include <stdexcept>

/// The greatest distance of an approximation from the original, as a part of the model's diagonal.
static const double APPROXIMATION = 1e-7;

/// The length of a unit where the document does not say it: the readers convert to millimetres.
static const double MILLIMETRE = 0.001;

static std::string entry_of(const TDF_Label& label) {
    TCollection_AsciiString entry;
    TDF_Tool::Entry(label, entry);
    return entry.ToCString();
}

static std::string name_of(const TDF_Label& label) {
    Handle(TDataStd_Name) name;
    if (!label.FindAttribute(TDataStd_Name::GetID(), name)) return "";
    // UTF-8.
    return TCollection_AsciiString(name->Get()).ToCString();
}

/// The label of the product that a component places; other labels are products themselves.
static TDF_Label product_of(const TDF_Label& label) {
    TDF_Label referred;
    return XCAFDoc_ShapeTool::GetReferredShape(label, referred) ? referred : label;
}

/// Whether the shape is part of a product rather than one: faces and shells that belong to no solid.
static bool is_loose(const TDF_Label& label) {
    if (!XCAFDoc_ShapeTool::IsSimpleShape(label)) return false;
    return XCAFDoc_ShapeTool::GetShape(label).ShapeType() >= TopAbs_SHELL;
}

static void write_color(Text& text, const Quantity_Color& color) {
    double red = 0.0, green = 0.0, blue = 0.0;
    color.Values(red, green, blue, Quantity_TOC_sRGB);
    text << "color";
    // Colours have the precision of 32-bit floats.
    for (const double component : {red, green, blue}) {
        text << std::clamp(std::round(component * 1e6) / 1e6, 0.0, 1.0);
    }
}

ModelWriter::ModelWriter(const Handle(TDocStd_Document)& document, Content content, std::FILE* output)
    : document(document),
      shapes(XCAFDoc_DocumentTool::ShapeTool(document->Main())),
      colors(XCAFDoc_DocumentTool::ColorTool(document->Main())),
      content(content),
      output(output) {}

void ModelWriter::write() {
    TDF_LabelSequence free;
    shapes->GetFreeShapes(free);
    if (free.IsEmpty()) throw std::runtime_error("it has no shapes that OCCT can read");
    const bool has_root = free.Length() == 1 && !XCAFDoc_ShapeTool::IsReference(free.First());
    const std::string name = has_root ? name_of(free.First()) : "";
    double unit = MILLIMETRE;
    if (!XCAFDoc_DocumentTool::GetLengthUnit(document, unit)) unit = MILLIMETRE;
    Text head;
    head << "freeform-model" << 1;
    if (!name.empty()) (head << "name").quoted(name);
    put((head << "unit" << unit).line());
    if (has_root) {
        product(free.First());
    } else {
        std::vector<TDF_Label> own;
        TDF_LabelSequence used;
        for (const TDF_Label& label : free) {
            if (is_loose(label)) own.push_back(label);
            else used.Append(label);
        }
        product(name, Color(), own, used);
    }
    if (face_count == 0) throw std::runtime_error("it has no faces");
    Text end;
    put((end << "end").line());
    if (content == Content::Areas) {
        Text total;
        const std::string line = (total << "total" << area).line().str();
        std::fwrite(line.data(), 1, line.size(), output);
    }
}

/// Writes the product of a label, if it is not yet written. Returns its number.
int ModelWriter::product(const TDF_Label& label) {
    const std::string entry = entry_of(label);
    if (const auto known = written.find(entry); known != written.end()) return known->second;
    TDF_LabelSequence components;
    std::vector<TDF_Label> own;
    if (XCAFDoc_ShapeTool::IsAssembly(label)) XCAFDoc_ShapeTool::GetComponents(label, components);
    else own.push_back(label);
    const int number = product(name_of(label), color_of(label), own, components);
    written[entry] = number;
    return number;
}

/// Writes a product of the faces of some labels and of others that it uses. Returns its number.
int ModelWriter::product(const std::string& name, const Color& color, const std::vector<TDF_Label>& own,
                         const TDF_LabelSequence& used) {
    Text record;
    record << "product";
    if (!name.empty()) (record << "name").quoted(name);
    if (color) write_color(record, *color);
    Text uses;
    for (const TDF_Label& label : used) {
        const int number = product(product_of(label));
        try {
            Text use;
            write_use(use, label, number);
            uses << use.str().c_str();
        } catch (const std::exception& error) {
            log("warning: a use of product " + std::to_string(number) + " is left out: " + error.what());
        }
    }

    TopTools_IndexedMapOfShape faces, edges;
    Looks looks;
    for (const TDF_Label& label : own) {
        const TopoDS_Shape shape = XCAFDoc_ShapeTool::GetShape(label);
        TopExp::MapShapes(shape, TopAbs_FACE, faces);
        // Several labels share a product that has no colour.
        if (own.size() > 1) color_faces(shape, color_of(label), looks);
        add_looks(label, looks);
    }
    for (int index = 1; index <= faces.Extent(); ++index) TopExp::MapShapes(faces(index), TopAbs_EDGE, edges);
    const std::vector<int> numbers = write_edges(edges);
    const int first = face_count;
    for (int index = 1; index <= faces.Extent(); ++index) {
        const std::string place = "face " + std::to_string(index - 1) + (name.empty() ? "" : " of \"" + name + "\"");
        try {
            write_face(TopoDS::Face(faces(index)), edges, numbers, looks);
        } catch (const Standard_Failure& failure) {
            log("warning: " + place + " is left out: " + message_of(failure));
        } catch (const std::exception& error) {
            log("warning: " + place + " is left out: " + error.what());
        }
    }
    put((record << "faces" << first << face_count - first).line());
    put(uses);
    return product_count++;
}

void ModelWriter::write_use(Text& text, const TDF_Label& label, int product) const {
    text << "use" << product;
    if (product_of(label) != label) {
        if (const Color color = color_of(label)) write_color(text, *color);
    }
    const gp_Trsf placement = XCAFDoc_ShapeTool::GetLocation(label).Transformation();
    text << "columns";
    for (int column = 1; column <= 4; ++column) {
        text << gp_XYZ(placement.Value(1, column), placement.Value(2, column), placement.Value(3, column));
    }
    text.line();
}

/// Writes edges. Returns their numbers, -1 for those that cannot be written.
std::vector<int> ModelWriter::write_edges(const TopTools_IndexedMapOfShape& edges) {
    std::vector<int> numbers;
    for (int index = 1; index <= edges.Extent(); ++index) {
        Approximation approximation{tolerance(), {}};
        try {
            put(edge_record(TopoDS::Edge(edges(index)), approximation));
            numbers.push_back(edge_count++);
        } catch (const Standard_Failure& failure) {
            log("warning: an edge is left out: " + message_of(failure));
            numbers.push_back(-1);
        } catch (const std::exception& error) {
            log(std::string("warning: an edge is left out: ") + error.what());
            numbers.push_back(-1);
        }
        for (const std::string& note : approximation.notes) {
            log("edge " + std::to_string(edge_count - 1) + ": " + note);
        }
    }
    return numbers;
}

void ModelWriter::write_face(const TopoDS_Face& face, const TopTools_IndexedMapOfShape& edges,
                             const std::vector<int>& numbers, const Looks& looks) {
    Text text;
    text << "face";
    if (looks.names.IsBound(face)) (text << "name").quoted(looks.names.Find(face));
    text << "tolerance" << BRep_Tool::Tolerance(face);
    if (looks.colors.IsBound(face)) write_color(text, looks.colors.Find(face));
    Approximation approximation{tolerance(), {}};
    write_face_shape(text, face, edges, numbers, approximation);
    put(text);
    for (const std::string& note : approximation.notes) log("face " + std::to_string(face_count) + ": " + note);
    if (content == Content::Areas) write_area(face);
    ++face_count;
}

void ModelWriter::write_area(const TopoDS_Face& face) {
    GProp_GProps properties;
    // By adaptive quadrature: without a bound, areas of trimmed faces are up to 1 % off.
    BRepGProp::SurfaceProperties(face.Oriented(TopAbs_FORWARD), properties, 1e-7);
    Text text;
    const std::string line = (text << properties.Mass()).line().str();
    std::fwrite(line.data(), 1, line.size(), output);
    area += properties.Mass();
}

/// The greatest distance of an approximation from the original.
double ModelWriter::tolerance() {
    if (known_tolerance == 0.0) {
        TDF_LabelSequence free;
        shapes->GetFreeShapes(free);
        Bnd_Box box;
        for (const TDF_Label& label : free) BRepBndLib::Add(XCAFDoc_ShapeTool::GetShape(label), box, false);
        const double diagonal = box.IsVoid() || box.IsOpen() ? 1.0 : std::sqrt(box.SquareExtent());
        known_tolerance = APPROXIMATION * diagonal;
    }
    return known_tolerance;
}

/// Writes a record of the model.
void ModelWriter::put(const Text& text) {
    if (content == Content::Model) std::fwrite(text.str().data(), 1, text.str().size(), output);
}

ModelWriter::Color ModelWriter::color_of(const TDF_Label& label) const {
    Quantity_Color color;
    for (const XCAFDoc_ColorType type : {XCAFDoc_ColorSurf, XCAFDoc_ColorGen}) {
        if (colors->GetColor(label, type, color)) return color;
    }
    return std::nullopt;
}

/// Gives all faces of a shape a colour.
void ModelWriter::color_faces(const TopoDS_Shape& shape, const Color& color, Looks& looks) {
    if (!color) return;
    TopTools_IndexedMapOfShape faces;
    TopExp::MapShapes(shape, TopAbs_FACE, faces);
    for (int index = 1; index <= faces.Extent(); ++index) looks.colors.Bind(faces(index), *color);
}

/// Adds the colours and names of the faces of a label. The colour of a solid or a shell is that of its faces that have
/// none.
void ModelWriter::add_looks(const TDF_Label& label, Looks& looks) const {
    TDF_LabelSequence parts;
    XCAFDoc_ShapeTool::GetSubShapes(label, parts);
    std::vector<std::pair<TopoDS_Shape, Quantity_Color>> colored;
    for (const TDF_Label& part : parts) {
        const TopoDS_Shape shape = XCAFDoc_ShapeTool::GetShape(part);
        if (shape.IsNull() || shape.ShapeType() > TopAbs_FACE) continue;
        if (const Color color = color_of(part)) colored.emplace_back(shape, *color);
        const std::string name = name_of(part);
        if (shape.ShapeType() == TopAbs_FACE && !name.empty()) looks.names.Bind(shape, name);
    }
    // From solids to faces.
    std::stable_sort(colored.begin(), colored.end(),
                     [](const auto& a, const auto& b) { return a.first.ShapeType() < b.first.ShapeType(); });
    for (const auto& [shape, color] : colored) color_faces(shape, color, looks);
}
