#include "iges.h"
#include "text.h"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <vector>

/// The column of the letter of a line's section; T is the last section.
static const size_t SECTION = 72;
/// The width of the fields of the directory, and of the number of a line.
static const size_t FIELD = 8, NUMBER = 7;
/// The columns of the status of an entity, and of the directory's entry that a line of parameters belongs to.
static const size_t STATUS = 64, ENTRY = 64;

/// A global section in millimetres, for files without one.
static const char* const GLOBAL[] = {
    "1H,,1H;,4Hnone,4Hnone,4Hnone,4Hnone,32,38,6,308,15,4Hnone,1.,2,2HMM,1,",
    "0.01,15H20000101.000000,1E-07,0.,4Hnone,4Hnone,11,0,15H20000101.000000;",
};
/// A global section that is shorter has no unit.
static const size_t SHORTEST_GLOBAL = 60;

/// The first 72 columns of the lines of each section.
struct Sections {
    std::vector<std::string> start, global, directory, parameters;
    /// Whether the lines of the directory are numbered from 1 on.
    bool is_numbered = true;
};

void check_is_complete(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::string line, last;
    while (std::getline(file, line)) {
        if (line.find_first_not_of(" \r") != std::string::npos) last.swap(line);
    }
    const bool is_complete = last.size() > SECTION && last[SECTION] == 'T';
    if (!is_complete) throw std::runtime_error("it is no complete IGES file");
}

static Sections sections_of(const std::string& path) {
    Sections sections;
    std::ifstream file(path, std::ios::binary);
    std::string line;
    while (std::getline(file, line)) {
        if (line.size() <= SECTION) continue;
        const std::string text = line.substr(0, SECTION);
        switch (line[SECTION]) {
        case 'S': sections.start.push_back(text); break;
        case 'G': sections.global.push_back(text); break;
        case 'P': sections.parameters.push_back(text); break;
        case 'D': {
            sections.directory.push_back(text);
            const long number = std::atol(line.c_str() + SECTION + 1);
            sections.is_numbered &= number == static_cast<long>(sections.directory.size());
            break;
        }
        default: break;
        }
    }
    return sections;
}

static std::string right_aligned(long number, size_t width) {
    std::string text = std::to_string(number);
    return text.size() < width ? std::string(width - text.size(), ' ') + text : text;
}

static void write_section(std::FILE* file, char letter, const std::vector<std::string>& lines) {
    long number = 0;
    for (const std::string& line : lines) {
        std::fprintf(file, "%s%c%s\n", line.c_str(), letter, right_aligned(++number, NUMBER).c_str());
    }
}

/// Sets the fields of the directory and of the parameters that depend on the numbers of lines.
static void renumber(Sections& sections) {
    std::vector<std::string>&directory = sections.directory, &parameters = sections.parameters;
    // The second field of an entry is the line where its parameters begin.
    const auto first_line = [&](size_t entry) { return std::atol(directory[entry].substr(FIELD, FIELD).c_str()); };
    for (size_t entry = 0; entry + 1 < directory.size(); entry += 2) {
        const long first = first_line(entry);
        const long next = entry + 2 < directory.size() ? first_line(entry + 2) : static_cast<long>(parameters.size()) + 1;
        if (first < 1 || next <= first || next > static_cast<long>(parameters.size()) + 1) {
            throw std::runtime_error("its directory is not in order");
        }
        directory[entry].replace(STATUS, FIELD, "00000000");
        directory[entry + 1].replace(3 * FIELD, FIELD, right_aligned(next - first, FIELD));
        const std::string back = right_aligned(static_cast<long>(entry) + 1, FIELD);
        for (long line = first; line < next; ++line) parameters[line - 1].replace(ENTRY, FIELD, back);
    }
}

std::string TemporaryFile::renumbered(const std::string& path) {
    Sections sections = sections_of(path);
    if (sections.is_numbered) return path;
    renumber(sections);
    size_t length = 0;
    for (const std::string& line : sections.global) length += line.find_last_not_of(' ') + 1;
    if (length < SHORTEST_GLOBAL) {
        sections.global.clear();
        for (const char* line : GLOBAL) sections.global.push_back(line + std::string(SECTION - std::string(line).size(), ' '));
    }
    const char* folder = std::getenv("TMPDIR");
    name = std::string(folder != nullptr ? folder : "/tmp") + "/freeform-XXXXXX";
    const int descriptor = mkstemp(&name[0]);
    std::FILE* file = descriptor < 0 ? nullptr : fdopen(descriptor, "w");
    if (file == nullptr) throw std::runtime_error("a temporary file cannot be written");
    write_section(file, 'S', sections.start);
    write_section(file, 'G', sections.global);
    write_section(file, 'D', sections.directory);
    write_section(file, 'P', sections.parameters);
    std::fprintf(file, "S%sG%sD%sP%s%40sT%s\n", right_aligned(static_cast<long>(sections.start.size()), NUMBER).c_str(),
                 right_aligned(static_cast<long>(sections.global.size()), NUMBER).c_str(),
                 right_aligned(static_cast<long>(sections.directory.size()), NUMBER).c_str(),
                 right_aligned(static_cast<long>(sections.parameters.size()), NUMBER).c_str(), "",
                 right_aligned(1, NUMBER).c_str());
    if (std::fclose(file) != 0) throw std::runtime_error("a temporary file cannot be written");
    log("warning: the entries of its directory are numbered anew");
    return name;
}

TemporaryFile::~TemporaryFile() {
    if (!name.empty()) std::remove(name.c_str());
}
