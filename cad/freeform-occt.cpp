// freeform-occt: reads a STEP, IGES or BREP file with OCCT and writes it to standard output as a model in the format of
// docs/model-format.md. Lines on standard error:
//
//   progress PERCENT    how much of the file is read
//   warning: TEXT       something is left out
//   error: TEXT         the last line, before exit status 1
//   TEXT                anything else worth knowing

#include "face.h"
#include "iges.h"
#include "mesh.h"
#include "model.h"
#include "text.h"

#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <IGESCAFControl_Reader.hxx>
#include <IGESData_IGESEntity.hxx>
#include <Interface_Check.hxx>
#include <Interface_CheckIterator.hxx>
#include <Interface_InterfaceModel.hxx>
#include <Interface_ReportEntity.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_Printer.hxx>
#include <Message_ProgressIndicator.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <StepShape_TopologicalRepresentationItem.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopTools_MapOfShape.hxx>
#include <XCAFApp_Application.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string>

static const char USAGE[] =
    "usage: freeform-occt [--area | --mesh DEFLECTION] FILE\n"
    "Writes a .step, .stp, .p21, .iges, .igs, .brep or .brp file as a model (docs/model-format.md);\n"
    "with --area, the area of each face and their sum instead; with --mesh, how OCCT meshes it.\n";

/// A message of OCCT without the asterisks and line ends around it.
static std::string one_line(std::string message) {
    std::replace(message.begin(), message.end(), '\n', ' ');
    const size_t first = message.find_first_not_of(" *"), last = message.find_last_not_of(" *");
    return first == std::string::npos ? "" : message.substr(first, last + 1 - first);
}

/// Keeps the first error message of the readers, for ours.
class FirstError : public Message_Printer {
    DEFINE_STANDARD_RTTI_INLINE(FirstError, Message_Printer)

public:
    mutable std::string text;

protected:
    void send(const TCollection_AsciiString& message, const Message_Gravity gravity) const override {
        if (gravity < Message_Fail || !text.empty()) return;
        text = one_line(message.ToCString());
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

static const char NO_SHAPES[] = "it has no shapes that OCCT can read";

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

/// Whether a fault of an entity may cost a face. STEP files have many faults that do not matter.
static bool matters(const Handle(Standard_Transient)& entity) {
    return entity->IsKind(STANDARD_TYPE(StepShape_TopologicalRepresentationItem)) ||
           entity->IsKind(STANDARD_TYPE(IGESData_IGESEntity));
}

/// Says how many entities of the file have faults, and the first fault.
static void log_faults(const Handle(Interface_InterfaceModel)& model) {
    int count = 0;
    std::string first;
    for (int index = 1; index <= model->NbEntities(); ++index) {
        if (!model->IsErrorEntity(index) || !matters(model->Value(index))) continue;
        const Handle(Interface_Check) check = model->ReportEntity(index)->Check();
        if (count++ == 0 && check->NbFails() > 0) first = one_line(check->CFail(1));
    }
    if (count > 0) log("warning: faulty entities in the file: " + std::to_string(count) + "; the first: " + first);
}

/// Says how many entities were not read, and why the first was not.
static void log_unread(const Interface_CheckIterator& checks) {
    int count = 0;
    std::string first;
    for (checks.Start(); checks.More(); checks.Next()) {
        if (!checks.Value()->HasFailed()) continue;
        if (count++ == 0) first = one_line(checks.Value()->CFail(1));
    }
    if (count > 0) log("warning: entities that were not read: " + std::to_string(count) + "; the first: " + first);
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
        log_faults(reader.Reader().WS()->Model());
        if (!reader.Transfer(document, progress->Start())) throw std::runtime_error(NO_SHAPES);
        log_unread(reader.Reader().WS()->TransferReader()->LastCheckList());
        break;
    }
    case Kind::Iges: {
        check_is_complete(path);
        IGESCAFControl_Reader reader;
        // B-splines as they are in the file.
        Interface_Static::SetIVal("read.iges.bspline.continuity", 0);
        reader.SetColorMode(true);
        reader.SetNameMode(true);
        reader.SetLayerMode(false);
        TemporaryFile copy;
        check_status(reader.ReadFile(copy.renumbered(path).c_str()), "IGES");
        log_faults(reader.WS()->Model());
        if (!reader.Transfer(document, progress->Start())) throw std::runtime_error(NO_SHAPES);
        log_unread(reader.WS()->TransferReader()->LastCheckList());
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

static void run(const std::string& path, Content content, double deflection, std::FILE* output) {
    kind_of(path);
    check_readable(path);
    // Names that OCCT makes up are worth nothing.
    XCAFDoc_ShapeTool::SetAutoNaming(false);
    Handle(TDocStd_Document) document;
    XCAFApp_Application::GetApplication()->NewDocument("MDTV-XCAF", document);
    read(path, document);
    log("progress 100");
    if (deflection > 0.0) write_mesh(document, deflection, output);
    else ModelWriter(document, content, output).write();
    if (std::fflush(output) != 0) throw std::runtime_error("the model cannot be written");
}

int main(int argc, char** argv) {
    Content content = Content::Model;
    // Above 0 if the file is to be meshed.
    double deflection = 0.0;
    std::string path;
    for (int index = 1; index < argc; ++index) {
        if (std::strcmp(argv[index], "--area") == 0) content = Content::Areas;
        else if (std::strcmp(argv[index], "--mesh") == 0 && index + 2 < argc) {
            deflection = std::strtod(argv[++index], nullptr);
            if (!(deflection > 0.0 && std::isfinite(deflection))) path.clear(), index = argc;
        } else if (path.empty()) path = argv[index];
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
        run(path, content, deflection, output);
    } catch (const Standard_Failure& failure) {
        error = message_of(failure);
    } catch (const std::exception& failure) {
        error = failure.what();
    }
    if (error.empty()) return 0;
    log("error: " + error + (first_error->text.empty() ? "" : " (" + first_error->text + ")"));
    return 1;
}
