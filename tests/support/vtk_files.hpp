/// VTK files in all their encodings.
#pragma once

#include <zlib.h>

#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "support/bytes.hpp"

namespace support::vtk {

inline std::string base64(std::string_view bytes) {
    constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        unsigned bits = 0;
        for (std::size_t k = 0; k < 3; ++k)
            bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : kLetters[bits >> (18 - 6 * k) & 63];
    }
    return text;
}

inline std::string deflated(std::string_view bytes) {
    uLongf size = compressBound(bytes.size());
    std::string packed(size, '\0');
    if (compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                 bytes.size()) != Z_OK)
        throw std::runtime_error("zlib does not pack");
    packed.resize(size);
    return packed;
}

enum class Format { Inline, AppendedRaw, AppendedBase64 };

/// A writer of VTK files in all their encodings.
class Writer {
  public:
    Writer(Format format, bool big, bool wide, bool compressed)
        : format_(format), big_(big), wide_(wide), compressed_(compressed) {}

    template <class Number>
    std::string array(const std::string& type, const std::string& name, int components,
                      const std::vector<Number>& values) {
        std::string bytes;
        for (const Number value : values) put(bytes, value, big_);
        std::string xml = "<DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
                          std::to_string(components) + "\" format=\"";
        if (format_ == Format::Inline) return xml + "binary\">\n  " + encoded(bytes) + "\n</DataArray>\n";
        xml += "appended\" offset=\"" + std::to_string(appended_.size()) + "\"/>\n";
        appended_ += encoded(bytes);
        return xml;
    }

    std::string file(const std::string& kind, const std::string& piece) const {
        std::string text = "<?xml version=\"1.0\"?>\n<!-- made up -->\n<VTKFile type=\"" + kind +
                           "\" version=\"1.0\" byte_order=\"" + (big_ ? "BigEndian" : "LittleEndian") + "\"" +
                           (wide_ ? " header_type=\"UInt64\"" : "") +
                           (compressed_ ? " compressor=\"vtkZLibDataCompressor\"" : "") + ">\n<" + kind + ">\n" +
                           piece + "</" + kind + ">\n";
        if (format_ != Format::Inline)
            text += std::string("<AppendedData encoding=\"") + (format_ == Format::AppendedRaw ? "raw" : "base64") +
                    "\">\n _" + appended_ + "\n</AppendedData>\n";
        return text + "</VTKFile>\n";
    }

  private:
    void header(std::string& bytes, std::size_t number) const {
        if (wide_)
            put(bytes, static_cast<std::uint64_t>(number), big_);
        else
            put(bytes, static_cast<std::uint32_t>(number), big_);
    }
    std::string encoded(const std::string& bytes) const {
        std::string head, body = bytes;
        if (compressed_) {
            constexpr std::size_t kBlock = 64;  // so small that arrays have several
            const std::size_t blocks = (bytes.size() + kBlock - 1) / kBlock;
            header(head, blocks);
            header(head, kBlock);
            header(head, bytes.size() % kBlock);
            body.clear();
            for (std::size_t b = 0; b < blocks; ++b) {
                const std::string packed = deflated(std::string_view(bytes).substr(b * kBlock, kBlock));
                header(head, packed.size());
                body += packed;
            }
        } else {
            header(head, bytes.size());
        }
        if (format_ == Format::AppendedRaw) return head + body;
        // Compressed: the header is encoded on its own, uncompressed: with the data.
        return compressed_ ? base64(head) + base64(body) : base64(head + body);
    }

    Format format_;
    bool big_, wide_, compressed_;
    std::string appended_;
};

/// Two pieces: a triangle, a quadrilateral and a line; then a polygon. With fields.
inline std::string two_pieces(Writer writer) {
    std::string piece = "<Piece NumberOfPoints=\"5\" NumberOfCells=\"3\">\n<PointData>\n";
    piece +=
        writer.array<double>("Float64", "size", 1, {0.1, 1e300, std::numeric_limits<double>::infinity(), 5e-324, -0.0});
    piece += writer.array<float>("Float32", "only here", 1, {1, 2, 3, 4, 5});
    piece += "</PointData>\n<CellData>\n";
    piece += writer.array<std::int8_t>("Int8", "level", 1, {-1, 7, 9});
    piece += writer.array<std::uint64_t>("UInt64", "pair", 2, {1, 2, 1ull << 53, 4, 5, 6});
    piece += writer.array<std::int16_t>("Int16", "label", 1, {3, -4, 0});
    piece += "</CellData>\n<Points>\n";
    piece += writer.array<double>("Float64", "Points", 3, {0, 0, 0, 1, 0, 0, 1, 1, 0.1, 0, 1, 0, 1.0 / 3, 2, 0});
    piece += "</Points>\n<Cells>\n";
    piece += writer.array<std::int32_t>("Int32", "connectivity", 1, {3, 2, 4, 0, 1, 2, 3, 0, 1});
    piece += writer.array<std::int64_t>("Int64", "offsets", 1, {3, 7, 9});
    piece += writer.array<std::uint8_t>("UInt8", "types", 1, {5, 9, 3});
    piece += "</Cells>\n</Piece>\n<Piece NumberOfPoints=\"5\" NumberOfCells=\"1\">\n<PointData>\n";
    piece += writer.array<float>("Float32", "size", 1, {1, 2, 3, 4, 5});
    piece += "</PointData>\n<CellData>\n";
    piece += writer.array<std::uint16_t>("UInt16", "level", 1, {65535});
    piece += writer.array<double>("Float64", "pair", 2, {0.5, 0.25});
    piece += writer.array<std::int32_t>("Int32", "label", 1, {8});
    piece += "</CellData>\n<Points>\n";
    piece += writer.array<float>("Float32", "Points", 3, {0, 0, 9, 1, 0, 9, 2, 1, 9, 1, 2, 9, 0, 1, 9});
    piece += "</Points>\n<Cells>\n";
    piece += writer.array<std::uint32_t>("UInt32", "connectivity", 1, {0, 1, 2, 3, 4});
    piece += writer.array<std::int8_t>("Int8", "offsets", 1, {5});
    piece += writer.array<std::int64_t>("Int64", "types", 1, {7});
    piece += "</Cells>\n</Piece>\n";
    return writer.file("UnstructuredGrid", piece);
}

}  // namespace support::vtk
