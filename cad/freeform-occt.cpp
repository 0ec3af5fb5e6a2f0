// freeform-occt: reads a STEP, IGES or BREP file with OCCT and writes it to standard output as a model in the format of
// docs/model-format.md. Lines on standard error:
//
//   progress PERCENT    how much of the file is read
//   warning: TEXT       something is left out
//   error: TEXT         the last line, before exit status 1
//   TEXT                anything else worth knowing

#include "face.h"
#include "model.h"
#include "text.h"

#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <IGESCAFControl_Reader.hxx>
#include <IGESData_IGESEntity.hxx>
#include <IGESData_IGESModel.hxx>
#include <Interface_Protocol.hxx>
#include <Interface_ShareFlags.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_Printer.hxx>
#include <Message_ProgressIndicator.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopTools_MapOfShape.hxx>
#include <XCAFApp_Application.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string>

static const char USAGE[] =
    "usage: freeform-occt [--area] FILE\n"
    "Writes a .step, .stp, .p21, .iges, .igs, .brep or .brp file as a model (docs/model-format.md);\n"
    "with --area, the area of each face and their sum instead.\n";

/// Keeps the first error message of the readers, for ours.
class FirstError : public Message_Printer {
    DEFINE_STANDARD_RTTI_INLINE(FirstError, Message_Printer)

public:
    std::string text;

protected:
    void send(const TCollection_AsciiString& message, const Message_Gravity gravity) const override {
        if (gravity < Message_Fail || !text.empty()) return;
        auto& first = const_cast<FirstError*>(this)->text;
        first = message.ToCString();
        std::replace(first.begin(), first.end(), '\n', ' ');
    }
};

/// Writes "progress" and a percentage whenever it grows.
class Progress : public Message_ProgressIndicator {
    DEFINE_STANDARD_RTTI_INLINE(Progress, Message_ProgressIndicator)

protected:
    void Show(const Message_ProgressScope&, const Standard_Boolean) override {
        const int now = static_cast<int>(100.0 * GetPosition());
        if (now > percent) log("progress " + std::to_string(percent = now));
    }

private:
    int percent = 0;
};

enum class Kind { Step, Iges, Brep };

static Kind kind_of(const std::string& path) {
    const size_t dot = path.find_last_of("./");
    std::string extension = dot == std::string::npos || path[dot] == '/' ? "" : path.substr(dot + 1);
    for (char& letter : extension) letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
    if (extension == "step" || extension == "stp" || extension == "p21") return Kind::Step;
    if (extension == "iges" || extension == "igs") return Kind::Iges;
    if (extension == "brep" || extension == "brp") return Kind::Brep;
    throw std::runtime_error("its name does not end with .step, .stp, .p21, .iges, .igs, .brep or .brp");
}

static void check_readable(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw std::runtime_error(std::strerror(errno));
    if (file.get() == std::ifstream::traits_type::eof()) throw std::runtime_error("it is empty");
}

static void check_status(IFSelect_ReturnStatus status, const char* kind) {
    if (status != IFSelect_RetDone) throw std::runtime_error(std::string("it is no complete ") + kind + " file");
}

/// Whether a shape has solids that are the same in several places.
static bool has_instances(const TopoDS_Shape& shape) {
    TopTools_IndexedMapOfShape solids;
    TopExp::MapShapes(shape, TopAbs_SOLID, solids);
    TopTools_MapOfShape parts;
    for (int index = 1; index <= solids.Extent(); ++index) parts.Add(solids(index).Located(TopLoc_Location()));
    return parts.Extent() < solids.Extent();
}

/// Makes entities that nothing refers to independent if none is: else there is nothing to begin with.
static void free_entities(const Handle(IGESData_IGESModel)& model) {
    for (int index = 1; index <= model->NbEntities(); ++index) {
        if (model->Entity(index)->SubordinateStatus() == 0) return;
    }
    const Interface_ShareFlags flags(model, model->Protocol());
    for (int index = 1; index <= model->NbEntities(); ++index) {
        const Handle(IGESData_IGESEntity) entity = model->Entity(index);
        if (flags.IsShared(entity)) continue;
        entity->InitStatus(entity->BlankStatus(), 0, entity->UseFlag(), entity->HierarchyStatus());
    }
}

static void read(const std::string& path, const Handle(TDocStd_Document)& to) {
    Handle(TDocStd_Document) document = to;
    const Handle(Progress) progress = new Progress;
    switch (kind_of(path)) {
    case Kind::Step: {
        STEPCAFControl_Reader reader;
        reader.SetColorMode(true);
        reader.SetNameMode(true);
        reader.SetLayerMode(false);
        reader.SetPropsMode(false);
        check_status(reader.ReadFile(path.c_str()), "STEP");
        if (!reader.Transfer(document, progress->Start())) throw std::runtime_error("it has no shapes");
        break;
    }
    case Kind::Iges: {
        IGESCAFControl_Reader reader;
        // B-splines as they are in the file.
        Interface_Static::SetIVal("read.iges.bspline.continuity", 0);
        reader.SetColorMode(true);
        reader.SetNameMode(true);
        reader.SetLayerMode(false);
        check_status(reader.ReadFile(path.c_str()), "IGES");
        free_entities(reader.IGESModel());
        if (!reader.Transfer(document, progress->Start())) throw std::runtime_error("it has no shapes");
        break;
    }
    case Kind::Brep: {
        TopoDS_Shape shape;
        const bool is_read = BRepTools::Read(shape, path.c_str(), BRep_Builder(), progress->Start());
        if (!is_read || shape.IsNull()) throw std::runtime_error("it is no complete BREP file");
        XCAFDoc_DocumentTool::ShapeTool(document->Main())->AddShape(shape, has_instances(shape));
        break;
    }
    }
}

static void run(const std::string& path, Content content, std::FILE* output) {
    kind_of(path);
    check_readable(path);
    // Names that OCCT makes up are worth nothing.
    XCAFDoc_ShapeTool::SetAutoNaming(false);
    Handle(TDocStd_Document) document;
    XCAFApp_Application::GetApplication()->NewDocument("MDTV-XCAF", document);
    read(path, document);
    log("progress 100");
    ModelWriter(document, content, output).write();
    if (std::fflush(output) != 0) throw std::runtime_error("the model cannot be written");
}

int main(int argc, char** argv) {
    Content content = Content::Model;
    std::string path;
    for (int index = 1; index < argc; ++index) {
        if (std::strcmp(argv[index], "--area") == 0) content = Content::Areas;
        else if (path.empty()) path = argv[index];
        else path.clear(), index = argc;
    }
    if (path.empty()) {
        std::fputs(USAGE, stderr);
        return 2;
    }
    // OCCT also writes to standard output; only the model may.
    std::FILE* output = fdopen(dup(STDOUT_FILENO), "w");
    const int nothing = open("/dev/null", O_WRONLY);
    if (output == nullptr || nothing < 0 || dup2(nothing, STDOUT_FILENO) < 0) {
        log("error: standard output cannot be used");
        return 1;
    }
    const Handle(FirstError) first_error = new FirstError;
    Message::DefaultMessenger()->ChangePrinters().Clear();
    Message::DefaultMessenger()->AddPrinter(first_error);
    std::string error;
    try {
        run(path, content, output);
    } catch (const Standard_Failure& failure) {
        error = message_of(failure);
    } catch (const std::exception& failure) {
        error = failure.what();
    }
    if (error.empty()) return 0;
    log("error: " + error + (first_error->text.empty() ? "" : " (" + first_error->text + ")"));
    return 1;
}
