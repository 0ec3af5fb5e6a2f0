// The words and numbers of the model format, and the lines of the log.
#pragma once

#include <gp_Ax3.hxx>
#include <gp_XYZ.hxx>

#include <string>
#include <string_view>

/// Text of the model format, word by word.
class Text {
public:
    /// A word of the grammar.
    Text& operator<<(const char* word);
    Text& operator<<(int number);
    /// The shortest decimal number that gives the same value. Throws if it is not finite or above 1e15.
    Text& operator<<(double number);
    /// Three numbers.
    Text& operator<<(const gp_XYZ& vector);
    /// "origin", "x", "y" and "z".
    Text& operator<<(const gp_Ax3& frame);
    /// A text in quotes. It is cut off where it would be too long for the format.
    Text& quoted(const std::string& text);
    /// Begins a new line.
    Text& line();

    const std::string& str() const { return text; }

private:
    std::string text;
};

/// Writes a line of the log.
void log(const std::string& line);

/// A number for the log, with three digits.
std::string rounded(double number);
