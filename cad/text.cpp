#include "text.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <stdexcept>

/// The longest text that is written in quotes, in bytes; the format allows 4,096 with all escapes.
static const size_t MAX_TEXT = 1000;

/// The largest number of the format.
static const double MAX_NUMBER = 1e15;

Text& Text::operator<<(const char* word) {
    if (!text.empty() && text.back() != '\n') text += ' ';
    text += word;
    return *this;
}

Text& Text::operator<<(int number) {
    return *this << std::to_string(number).c_str();
}

Text& Text::operator<<(double number) {
    if (!(std::abs(number) <= MAX_NUMBER)) throw std::domain_error("a number is not finite or above 1e15");
    char digits[32];
    *std::to_chars(digits, digits + sizeof digits - 1, number).ptr = 0;
    return *this << digits;
}

Text& Text::operator<<(const gp_XYZ& vector) {
    return *this << vector.X() << vector.Y() << vector.Z();
}

Text& Text::operator<<(const gp_Ax3& frame) {
    return *this << "origin" << frame.Location().XYZ() << "x" << frame.XDirection().XYZ() << "y"
                 << frame.YDirection().XYZ() << "z" << frame.Direction().XYZ();
}

Text& Text::quoted(const std::string& value) {
    size_t length = value.size();
    if (length > MAX_TEXT) {
        length = MAX_TEXT;
        // Not within a character: its further bytes begin with the bits 10.
        while (length > 0 && (value[length] & 0xC0) == 0x80) --length;
    }
    std::string word = "\"";
    for (const char byte : value.substr(0, length)) {
        if (byte == '"' || byte == '\\') {
            word += '\\';
            word += byte;
        } else if (byte == '\n') {
            word += "\\n";
        } else {
            word += static_cast<unsigned char>(byte) < ' ' || byte == 0x7F ? ' ' : byte;
        }
    }
    return *this << (word + '"').c_str();
}

Text& Text::line() {
    text += '\n';
    return *this;
}

void log(const std::string& line) {
    std::fprintf(stderr, "%s\n", line.c_str());
}

std::string rounded(double number) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.3g", number);
    return digits;
}
