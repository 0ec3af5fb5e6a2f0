// The parts and assemblies of a document as a model of the format.
#pragma once

#include "text.h"

#include <NCollection_DataMap.hxx>
#include <Quantity_Color.hxx>
#include <TDF_Label.hxx>
#include <TDF_LabelSequence.hxx>
#include <TDocStd_Document.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopTools_ShapeMapHasher.hxx>
#include <TopoDS_Face.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>

#include <cstdio>
#include <map>
#include <optional>
#include <string>
#include <vector>

/// What is written.
enum class Content {
    /// The model.
    Model,
    /// The area of each face, and their sum.
    Areas,
};

/// Writes the model of a document, record by record.
class ModelWriter {
public:
    ModelWriter(const Handle(TDocStd_Document)& document, Content content, std::FILE* output);

    /// Writes everything. Throws if there is no face at all.
    void write();

private:
    /// A colour, linear.
    using Color = std::optional<Quantity_Color>;

    /// Colours and names of a product's faces.
    struct Looks {
        NCollection_DataMap<TopoDS_Shape, Quantity_Color, TopTools_ShapeMapHasher> colors;
        NCollection_DataMap<TopoDS_Shape, std::string, TopTools_ShapeMapHasher> names;
    };

    int product(const TDF_Label& label);
    int product(const std::string& name, const Color& color, const std::vector<TDF_Label>& own,
                const TDF_LabelSequence& used);
    void write_use(Text& text, const TDF_Label& label, int product) const;
    std::vector<int> write_edges(const TopTools_IndexedMapOfShape& edges);
    void write_face(const TopoDS_Face& face, const TopTools_IndexedMapOfShape& edges,
                    const std::vector<int>& numbers, const Looks& looks);
    void write_area(const TopoDS_Face& face);
    double tolerance();
    void put(const Text& text);

    Color color_of(const TDF_Label& label) const;
    static void color_faces(const TopoDS_Shape& shape, const Color& color, Looks& looks);
    void add_looks(const TDF_Label& label, Looks& looks) const;

    Handle(TDocStd_Document) document;
    Handle(XCAFDoc_ShapeTool) shapes;
    Handle(XCAFDoc_ColorTool) colors;
    Content content;
    std::FILE* output;
    int edge_count = 0;
    int face_count = 0;
    int product_count = 0;
    double area = 0.0;
    /// 0 until it is needed.
    double known_tolerance = 0.0;
    /// The numbers of the products that are written, by the entries of their labels.
    std::map<std::string, int> written;
};
