// IGES files whose directory is not numbered as the format asks for.
#pragma once

#include <string>

/// Refuses an IGES file whose last section is missing.
void check_is_complete(const std::string& path);

/// A file that is deleted at the end.
class TemporaryFile {
public:
    TemporaryFile() = default;
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;
    ~TemporaryFile();

    /// Writes a copy of an IGES file in which the entries of the directory, the lines and their references to entries
    /// are numbered as they should be, entities of which others are said to consist stand on their own, and a global
    /// section without values has the usual ones. Returns its path; that of the file itself if its directory is in
    /// order.
    std::string renumbered(const std::string& path);

private:
    std::string name;
};
