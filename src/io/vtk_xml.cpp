// VTK's XML formats of unstructured grids (.vtu) and polygons (.vtp). The XML is parsed by expat up to the appended
// data, which is not XML; the arrays are then decoded from where they lie in the file.
#include <expat.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <exception>
#include <limits>
#include <memory>
#include <optional>

#include "budget.hpp"
#include "bytes.hpp"
#include "cells.hpp"
#include "formats.hpp"
#include "gradus/io/error.hpp"
#include "scanner.hpp"

namespace gradus::io {
namespace {

/// Cells by their number in the format; the corners come first in all of them.
constexpr CellKind kKinds[] = {
    {0, Shape::Nothing, 0, 0, "empty cells"},   {1, Shape::Nothing, 1, 1, "vertices"},
    {2, Shape::Nothing, 0, 0, "vertices"},      {3, Shape::Lines, 2, 2, "lines"},
    {4, Shape::Lines, 2, 0, "lines"},           {5, Shape::Polygon, 3, 3, "triangles"},
    {6, Shape::Strip, 3, 0, "triangle strips"}, {7, Shape::Polygon, 3, 0, "polygons"},
    {8, Shape::Pixel, 4, 4, "pixels"},          {9, Shape::Polygon, 4, 4, "quads"},
    {10, Shape::Volume, 4, 4, "tetrahedra"},    {11, Shape::Volume, 8, 8, "voxels"},
    {12, Shape::Volume, 8, 8, "hexahedra"},     {13, Shape::Volume, 6, 6, "wedges"},
    {14, Shape::Volume, 5, 5, "pyramids"},      {15, Shape::Volume, 10, 10, "prisms"},
    {16, Shape::Volume, 12, 12, "prisms"},      {21, Shape::Lines, 2, 3, "lines"},
    {22, Shape::Polygon, 3, 6, "triangles"},    {23, Shape::Polygon, 4, 8, "quads"},
    {24, Shape::Volume, 4, 10, "tetrahedra"},   {25, Shape::Volume, 8, 20, "hexahedra"},
    {26, Shape::Volume, 6, 15, "wedges"},       {27, Shape::Volume, 5, 13, "pyramids"},
    {28, Shape::Polygon, 4, 9, "quads"},        {29, Shape::Volume, 8, 27, "hexahedra"},
    {30, Shape::Polygon, 4, 6, "quads"},        {31, Shape::Volume, 6, 12, "wedges"},
    {32, Shape::Volume, 6, 18, "wedges"},       {33, Shape::Volume, 8, 24, "hexahedra"},
    {34, Shape::Polygon, 3, 7, "triangles"},    {37, Shape::Volume, 5, 19, "pyramids"},
    {41, Shape::Volume, 0, 0, "point sets"},    {42, Shape::Volume, 0, 0, "polyhedra"},
};
constexpr CellKind kVertices{2, Shape::Nothing, 0, 0, "vertices"}, kLines{4, Shape::Lines, 2, 0, "lines"},
    kPolygons{7, Shape::Polygon, 3, 0, "polygons"}, kStrips{6, Shape::Strip, 3, 0, "triangle strips"};

struct NumberType {
    std::string_view name;
    std::size_t size;
};
constexpr NumberType kTypes[] = {{"Int8", 1},   {"UInt8", 1}, {"Int16", 2},  {"UInt16", 2},  {"Int32", 4},
                                 {"UInt32", 4}, {"Int64", 8}, {"UInt64", 8}, {"Float32", 4}, {"Float64", 8}};

// The XML
// --------------------------------------------------------------------------------------------------------------

enum class Format { Text, Binary, Appended };

struct DataArray {
    int line = 0;
    std::string type, name;
    int components = 1;
    Format format = Format::Text;
    std::size_t offset = 0;          ///< in the appended data
    std::size_t begin = 0, end = 0;  ///< bytes of the file with the data, if it is not appended
};

/// The parts of a piece that hold arrays. Polygons come before strips, as VTK numbers cells.
enum class Part { PointData, CellData, Points, Cells, Verts, Lines, Polys, Strips };
constexpr std::array<std::string_view, 8> kParts{"PointData", "CellData", "Points", "Cells",
                                                 "Verts",     "Lines",    "Polys",  "Strips"};

struct Piece {
    int line = 0;
    std::array<std::size_t, kParts.size()> counts{};  ///< of the things the part has, given in the head of the piece
    std::array<std::vector<DataArray>, kParts.size()> arrays;

    std::size_t count(Part part) const { return counts[static_cast<std::size_t>(part)]; }
    const std::vector<DataArray>& of(Part part) const { return arrays[static_cast<std::size_t>(part)]; }
};

struct Document {
    bool polygons = false;  ///< PolyData, else UnstructuredGrid
    bool swapped = false, wide_headers = false, compressed = false;
    std::vector<Piece> pieces;
    bool appended = false, appended_raw = false;
    std::size_t appended_begin = 0, appended_end = 0;
};

class DocumentParser {
  public:
    DocumentParser(const std::string& path, std::string_view contents)
        : path_(path), contents_(contents), parser_(XML_ParserCreate(nullptr), &XML_ParserFree) {
        if (!parser_) throw std::bad_alloc();
        XML_SetUserData(parser_.get(), this);
        XML_SetElementHandler(parser_.get(), &on_start, &on_end);
        XML_SetStartDoctypeDeclHandler(parser_.get(), &on_doctype);
    }

    Document parse() {
        constexpr std::size_t kChunk = std::size_t{1} << 30;  // the length is an int
        for (std::size_t at = 0; at < contents_.size() && !stopped_;) {
            const std::size_t n = std::min(kChunk, contents_.size() - at);
            const bool last = at + n == contents_.size();
            const XML_Status status = XML_Parse(parser_.get(), contents_.data() + at, static_cast<int>(n), last);
            if (error_) std::rethrow_exception(error_);
            if (status == XML_STATUS_ERROR && !stopped_) fail(XML_ErrorString(XML_GetErrorCode(parser_.get())));
            at += n;
        }
        if (document_.appended_raw) find_raw_end();
        if (document_.pieces.empty()) fail("has no Piece");
        return std::move(document_);
    }

  private:
    static DocumentParser& self(void* data) { return *static_cast<DocumentParser*>(data); }
    static void on_start(void* data, const char* name, const char** attributes) {
        self(data).guard([&] { self(data).start(name, attributes); });
    }
    static void on_end(void* data, const char*) {
        self(data).guard([&] { self(data).end(); });
    }
    static void on_doctype(void* data, const char*, const char*, const char*, int) {
        self(data).guard([&] { self(data).fail("has a document type, which no VTK file has"); });
    }
    /// No exception may pass through expat.
    template <class Action>
    void guard(const Action& action) {
        if (stopped_) return;
        try {
            action();
        } catch (...) {
            error_ = std::current_exception();
            stop();
        }
    }
    void stop() {
        stopped_ = true;
        XML_StopParser(parser_.get(), XML_FALSE);
    }

    int line() const {
        return static_cast<int>(
            std::min<XML_Size>(XML_GetCurrentLineNumber(parser_.get()), std::numeric_limits<int>::max()));
    }
    [[noreturn]] void fail(const std::string& what) const { throw IoError(path_, line(), what); }
    std::size_t position() const { return static_cast<std::size_t>(XML_GetCurrentByteIndex(parser_.get())); }
    std::size_t position_behind() const {
        return position() + static_cast<std::size_t>(XML_GetCurrentByteCount(parser_.get()));
    }

    static std::optional<std::string_view> attribute(const char** attributes, std::string_view name) {
        for (; *attributes != nullptr; attributes += 2)
            if (name == *attributes) return attributes[1];
        return std::nullopt;
    }
    std::size_t number(const char** attributes, std::string_view name, std::size_t otherwise) const {
        const auto text = attribute(attributes, name);
        if (!text) return otherwise;
        std::size_t value = 0;
        const auto [last, error] = std::from_chars(text->data(), text->data() + text->size(), value);
        if (error != std::errc{} || last != text->data() + text->size())
            fail(std::string(name) + " is " + quoted(*text) + ", not a number");
        return value;
    }
    std::string_view one_of(const char** attributes, std::string_view name,
                            std::initializer_list<std::string_view> known) const {
        const std::string_view value = attribute(attributes, name).value_or(*known.begin());
        if (std::find(known.begin(), known.end(), value) == known.end())
            fail(std::string(name) + " " + quoted(value) + " is not supported");
        return value;
    }

    void start(const std::string& name, const char** attributes) {
        ++depth_;
        if (array_ != nullptr) {  // Keys with more about an array stand inside it.
            if (depth_ == array_depth_ + 1) close_text();
            return;
        }
        if (depth_ == 1) {
            start_file(name, attributes);
        } else if (name == "Piece") {
            start_piece(attributes);
        } else if (name == "AppendedData") {
            start_appended(attributes);
        } else if (name == "DataArray" && part_) {
            start_array(attributes);
        } else if (const auto part = std::find(kParts.begin(), kParts.end(), name);
                   part != kParts.end() && piece_depth_ == depth_ - 1) {
            part_ = static_cast<std::size_t>(part - kParts.begin());
            part_depth_ = depth_;
        }
    }

    void end() {
        if (array_ != nullptr) {
            if (depth_ == array_depth_) {
                close_text();
                array_ = nullptr;
            } else if (depth_ == array_depth_ + 1) {
                text_begin_ = position_behind();
            }
        }
        if (depth_ == part_depth_) part_.reset(), part_depth_ = 0;
        if (depth_ == piece_depth_) piece_depth_ = 0;
        if (depth_ == appended_depth_) end_appended();
        --depth_;
    }

    void start_file(const std::string& name, const char** attributes) {
        if (name != "VTKFile") fail("is not a VTK file: expected VTKFile, found " + quoted(name));
        document_.polygons = one_of(attributes, "type", {"UnstructuredGrid", "PolyData"}) == "PolyData";
        document_.swapped = one_of(attributes, "byte_order", {"LittleEndian", "BigEndian"}) == "BigEndian";
        document_.wide_headers = one_of(attributes, "header_type", {"UInt32", "UInt64"}) == "UInt64";
        document_.compressed = !one_of(attributes, "compressor", {"", "vtkZLibDataCompressor"}).empty();
    }

    void start_piece(const char** attributes) {
        Piece piece;
        piece.line = line();
        constexpr std::array<std::string_view, kParts.size()> kCounts{
            "NumberOfPoints", "NumberOfCells", "NumberOfPoints", "NumberOfCells",
            "NumberOfVerts",  "NumberOfLines", "NumberOfPolys",  "NumberOfStrips"};
        for (std::size_t i = 0; i < kCounts.size(); ++i) {
            piece.counts[i] = number(attributes, kCounts[i], 0);
            if (piece.counts[i] > static_cast<std::size_t>(std::numeric_limits<int>::max()))
                fail(std::string(kCounts[i]) + " is " + std::to_string(piece.counts[i]) +
                     ", more than any file can hold");
        }
        document_.pieces.push_back(std::move(piece));
        piece_depth_ = depth_;
    }

    void start_array(const char** attributes) {
        DataArray array;
        array.line = line();
        array.type = attribute(attributes, "type").value_or("");
        array.name = attribute(attributes, "Name").value_or("");
        array.components =
            static_cast<int>(std::clamp<std::size_t>(number(attributes, "NumberOfComponents", 1), 1, 1 << 20));
        const std::string_view format = one_of(attributes, "format", {"ascii", "binary", "appended"});
        array.format = format == "ascii" ? Format::Text : format == "binary" ? Format::Binary : Format::Appended;
        array.offset = number(attributes, "offset", 0);
        auto& arrays = document_.pieces.back().arrays[*part_];
        arrays.push_back(std::move(array));
        array_ = &arrays.back();
        array_depth_ = depth_;
        text_begin_ = position_behind();
    }

    /// The data is the first text inside the array that is not blank.
    void close_text() {
        const std::size_t here = position();
        if (array_->end == 0 && text_begin_ < here &&
            !std::all_of(contents_.begin() + static_cast<std::ptrdiff_t>(text_begin_),
                         contents_.begin() + static_cast<std::ptrdiff_t>(here), is_space)) {
            array_->begin = text_begin_;
            array_->end = here;
        }
    }

    /// The data starts behind an underscore.
    void start_appended(const char** attributes) {
        std::size_t at = position_behind();
        while (at < contents_.size() && is_space(contents_[at])) ++at;
        if (at == contents_.size() || contents_[at] != '_') fail("expected an underscore before the appended data");
        document_.appended = true;
        document_.appended_raw = one_of(attributes, "encoding", {"raw", "base64"}) == "raw";
        document_.appended_begin = at + 1;
        appended_depth_ = depth_;
        if (document_.appended_raw) stop();
    }

    void end_appended() {
        if (position() < document_.appended_begin) fail("AppendedData ends before its data");
        document_.appended_end = position();
        appended_depth_ = 0;
    }

    void find_raw_end() {
        const std::size_t end = contents_.rfind("</AppendedData");
        if (end == std::string_view::npos || end < document_.appended_begin)
            throw IoError(path_, 0,
                          "at byte " + std::to_string(contents_.size()) +
                              ": expected </AppendedData>, found the end of the file");
        document_.appended_end = end;
    }

    const std::string& path_;
    std::string_view contents_;
    std::unique_ptr<std::remove_pointer_t<XML_Parser>, void (*)(XML_Parser)> parser_;
    Document document_;
    std::exception_ptr error_;
    bool stopped_ = false;
    int depth_ = 0, piece_depth_ = 0, part_depth_ = 0, array_depth_ = 0, appended_depth_ = 0;
    std::optional<std::size_t> part_;
    DataArray* array_ = nullptr;
    std::size_t text_begin_ = 0;
};

// Encodings
// ------------------------------------------------------------------------------------------------------------

/// Value of a letter of base64, -1 for what is none.
int base64_value(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : -1;
}

/// Bytes one after another, raw or in base64. The latter may be in several pieces, each with its padding: headers are
/// often encoded on their own.
class ByteStream {
  public:
    ByteStream(std::string_view source, bool base64) : source_(source), base64_(base64) {}

    /// No more than this can follow.
    std::size_t at_most() const { return base64_ ? source_.size() / 4 * 3 + 3 + spare_.size() : source_.size(); }

    /// The next bytes, until the next call. Nothing if there are fewer.
    std::optional<std::string_view> take(std::size_t count) {
        if (count > at_most()) return std::nullopt;
        if (!base64_) {
            const std::string_view bytes = source_.substr(0, count);
            source_.remove_prefix(count);
            return bytes;
        }
        taken_ = std::exchange(spare_, {});
        taken_.reserve(count + 3);
        while (taken_.size() < count)
            if (!decode_group()) return std::nullopt;
        spare_ = taken_.substr(count);
        taken_.resize(count);
        return taken_;
    }

  private:
    bool decode_group() {
        unsigned bits = 0;
        int letters = 0, padding = 0;
        while (letters < 4) {
            if (source_.empty()) return false;
            const char c = source_.front();
            source_.remove_prefix(1);
            if (is_space(c)) continue;
            const int value = c == '=' ? 0 : base64_value(c);
            padding += c == '=';
            if (value < 0 || (padding > 0 && c != '=') || padding > 2) return false;
            bits = bits << 6 | static_cast<unsigned>(value);
            ++letters;
        }
        for (int i = 0; i < 3 - padding; ++i) taken_.push_back(static_cast<char>(bits >> (16 - 8 * i) & 255));
        return true;
    }

    std::string_view source_;
    bool base64_;
    std::string taken_, spare_;
};

/// Decodes the arrays of a document.
class Arrays {
  public:
    Arrays(const std::string& path, std::string_view contents, const Document& document, Budget& budget)
        : path_(path), contents_(contents), document_(document), budget_(budget) {}

    std::vector<double> reals(const DataArray& array) const { return numbers<double>(array); }
    std::vector<std::int64_t> integers(const DataArray& array) const {
        if (!is_integer(array)) fail(array, "must be of integers, not " + quoted(array.type));
        return numbers<std::int64_t>(array);
    }
    static bool is_known(const DataArray& array) {
        return std::any_of(std::begin(kTypes), std::end(kTypes),
                           [&](const NumberType& type) { return type.name == array.type; });
    }
    static bool is_integer(const DataArray& array) { return is_known(array) && !array.type.starts_with("Float"); }

    [[noreturn]] void fail(const DataArray& array, const std::string& what) const {
        throw IoError(path_, array.line, "array " + quoted(array.name) + " " + what);
    }

  private:
    template <class Number>
    std::vector<Number> numbers(const DataArray& array) const {
        const auto type = std::find_if(std::begin(kTypes), std::end(kTypes),
                                       [&](const NumberType& t) { return t.name == array.type; });
        if (type == std::end(kTypes)) fail(array, "has the unknown type " + quoted(array.type));
        if (array.format == Format::Text) return numbers_of_text<Number>(array);
        const std::string bytes = bytes_of(array);
        if (bytes.size() % type->size != 0)
            fail(array, "has " + std::to_string(bytes.size()) + " bytes, no multiple of " + std::to_string(type->size));
        budget_.take(bytes.size() / type->size);
        switch (type - std::begin(kTypes)) {
            case 0:
                return converted<std::int8_t, Number>(bytes);
            case 1:
                return converted<std::uint8_t, Number>(bytes);
            case 2:
                return converted<std::int16_t, Number>(bytes);
            case 3:
                return converted<std::uint16_t, Number>(bytes);
            case 4:
                return converted<std::int32_t, Number>(bytes);
            case 5:
                return converted<std::uint32_t, Number>(bytes);
            case 6:
                return converted<std::int64_t, Number>(bytes);
            case 7:
                return converted<std::uint64_t, Number>(bytes);
            case 8:
                return converted<float, Number>(bytes);
            default:
                return converted<double, Number>(bytes);
        }
    }

    template <class Number>
    std::vector<Number> numbers_of_text(const DataArray& array) const {
        std::vector<Number> result;
        Scanner in(path_, contents_.substr(0, array.end), '\0');
        if (array.end == 0) return result;
        in.advance(array.begin - static_cast<std::size_t>(in.position() - contents_.data()));
        while (!in.at_end()) {
            if constexpr (std::is_same_v<Number, double>)
                result.push_back(in.any_real("a number"));
            else
                result.push_back(in.integer("an integer"));
        }
        return result;
    }

    template <class Stored, class Number>
    std::vector<Number> converted(const std::string& bytes) const {
        ByteReader in(path_, bytes);
        if (document_.swapped) in.swap_bytes();
        std::vector<Number> result;
        result.reserve(bytes.size() / sizeof(Stored));
        while (in.remaining() > 0) result.push_back(static_cast<Number>(in.get<Stored>("a number")));
        return result;
    }

    std::string bytes_of(const DataArray& array) const {
        const bool appended = array.format == Format::Appended;
        if (appended && !document_.appended) fail(array, "is appended, but there is no appended data");
        const std::size_t size = document_.appended_end - document_.appended_begin;
        if (appended && array.offset > size)
            fail(array, "starts at " + std::to_string(array.offset) + " of " + std::to_string(size) +
                            " bytes of appended data");
        const std::string_view source =
            appended ? contents_.substr(document_.appended_begin + array.offset, size - array.offset)
                     : contents_.substr(array.begin, array.end - array.begin);
        ByteStream in(source, !appended || !document_.appended_raw);
        if (document_.compressed) return inflated(array, in);
        const std::size_t count = header_number(array, in);
        return std::string(taken(array, in, count));
    }

    std::string_view taken(const DataArray& array, ByteStream& in, std::size_t count) const {
        const auto bytes = in.take(count);
        if (!bytes) fail(array, "is shorter than its header says, or not in base64 where it should be");
        return *bytes;
    }

    std::size_t header_number(const DataArray& array, ByteStream& in) const {
        const std::string raw(taken(array, in, document_.wide_headers ? 8 : 4));
        ByteReader reader(path_, raw);
        if (document_.swapped) reader.swap_bytes();
        return document_.wide_headers ? reader.get<std::uint64_t>("a header") : reader.get<std::uint32_t>("a header");
    }

    /// Header: number of blocks, size of a block, of the last one if it is shorter, compressed size of each.
    std::string inflated(const DataArray& array, ByteStream& in) const {
        constexpr std::size_t kGreatestRatio = 1040,
                              kLeast = 64;  // zlib's best is 1032 to 1, plus some bytes of its own
        const std::size_t blocks = header_number(array, in);
        if (blocks == 0) return {};
        const std::size_t block_size = header_number(array, in), last_size = header_number(array, in);
        if (blocks > in.at_most() / 4)
            fail(array, "is said to have " + std::to_string(blocks) + " blocks, more than the file can hold");
        std::vector<std::size_t> compressed(blocks);
        for (std::size_t& size : compressed) size = header_number(array, in);
        std::string result;
        for (std::size_t b = 0; b < blocks; ++b) {
            const std::size_t size = b + 1 == blocks && last_size != 0 ? last_size : block_size;
            const std::string_view source = taken(array, in, compressed[b]);
            if (size > kLeast + kGreatestRatio * source.size())
                fail(array, "cannot be unpacked: block " + std::to_string(b) + " is too short");
            const std::size_t start = result.size();
            result.resize(start + size);
            uLongf got = size;
            const int status =
                ::uncompress(reinterpret_cast<Bytef*>(result.data() + start), &got,
                             reinterpret_cast<const Bytef*>(source.data()), static_cast<uLong>(source.size()));
            if (status != Z_OK || got != size)
                fail(array, "cannot be unpacked: block " + std::to_string(b) + " is damaged");
        }
        return result;
    }

    const std::string& path_;
    std::string_view contents_;
    const Document& document_;
    Budget& budget_;
};

// Meshes
// ---------------------------------------------------------------------------------------------------------------

class Reader {
  public:
    Reader(const std::string& path, std::string_view contents, const Document& document, Fields fields)
        : path_(path),
          document_(document),
          fields_(fields),
          budget_(path, (document.compressed ? kPackedNumbersPerByte : kNumbersPerByte) * contents.size()),
          arrays_(path, contents, document, budget_) {}

    MeshData read() {
        for (const Piece& piece : document_.pieces) read_piece(piece);
        for (const Field& field : cell_fields_) {
            budget_.take(data_.soup.triangles.size() * static_cast<std::size_t>(field.components));
            data_.cell_fields.push_back(cells_.on_triangles(field));
        }
        data_.point_fields = std::move(point_fields_);
        if (all_labelled_) {
            set_labels(data_.soup.labels, cells_.cell_of_triangle());
            set_labels(data_.soup.edge_labels, cells_.cell_of_edge());
        }
        cells_.drop_middles(data_);
        return std::move(data_);
    }

  private:
    void read_piece(const Piece& piece) {
        const std::size_t first_point = data_.soup.points.size(), first_cell = cells_.size();
        read_points(piece);
        if (document_.polygons) {
            read_polygons(piece, Part::Verts, kVertices, first_point);
            read_polygons(piece, Part::Lines, kLines, first_point);
            read_polygons(piece, Part::Polys, kPolygons, first_point);
            read_polygons(piece, Part::Strips, kStrips, first_point);
        } else {
            read_cells(piece, first_point);
        }
        read_labels(piece, cells_.size() - first_cell);
        if (fields_ != Fields::Read) return;
        const bool first = &piece == &document_.pieces.front();
        read_fields(point_fields_, piece.of(Part::PointData), data_.soup.points.size() - first_point, first);
        read_fields(cell_fields_, piece.of(Part::CellData), cells_.size() - first_cell, first);
    }

    void read_points(const Piece& piece) {
        const std::size_t n = piece.count(Part::Points);
        const std::vector<DataArray>& arrays = piece.of(Part::Points);
        if (arrays.empty() && n == 0) return;
        if (arrays.empty()) throw IoError(path_, piece.line, "the piece has no Points");
        const DataArray& array = arrays.front();
        const std::vector<double> x = arrays_.reals(array);
        if (array.components != 3 && n > 0)
            arrays_.fail(array, "has " + std::to_string(array.components) + " components; points have 3");
        check_size(array, x.size(), 3 * n);
        if (data_.soup.points.size() + n > static_cast<std::size_t>(std::numeric_limits<int>::max()))
            arrays_.fail(array, "has too many points");
        for (std::size_t i = 0; i < n; ++i) {
            const Eigen::Vector3d point(x[3 * i], x[3 * i + 1], x[3 * i + 2]);
            if (!point.allFinite())
                arrays_.fail(array, "has a coordinate that is not finite, of point " + std::to_string(i));
            data_.soup.points.push_back(point);
        }
    }

    const DataArray& array_called(const Piece& piece, Part part, std::string_view name) const {
        for (const DataArray& array : piece.of(part))
            if (array.name == name) return array;
        throw IoError(
            path_, piece.line,
            std::string(kParts[static_cast<std::size_t>(part)]) + " of the piece have no array " + quoted(name));
    }

    void check_size(const DataArray& array, std::size_t found, std::size_t expected) const {
        if (found != expected)
            arrays_.fail(array, "has " + std::to_string(found) + " numbers, expected " + std::to_string(expected));
    }

    void read_cells(const Piece& piece, std::size_t first_point) {
        if (piece.count(Part::Cells) == 0) return;
        const DataArray& array = array_called(piece, Part::Cells, "types");
        const std::vector<std::int64_t> types = arrays_.integers(array);
        check_size(array, types.size(), piece.count(Part::Cells));
        const Nodes nodes = read_nodes(piece, Part::Cells);
        for (std::size_t c = 0; c < types.size(); ++c) add_cell(nodes, c, kind_of(array, types[c]), first_point);
    }

    const CellKind& kind_of(const DataArray& array, std::int64_t type) const {
        for (const CellKind& kind : kKinds) {
            if (kind.type != type) continue;
            if (kind.shape == Shape::Volume)
                throw IoError(path_, array.line, std::string("holds ") + kind.name + "; give a surface mesh");
            return kind;
        }
        arrays_.fail(array, "has cells of type " + std::to_string(type) + ", which are not supported");
    }

    void read_polygons(const Piece& piece, Part part, const CellKind& kind, std::size_t first_point) {
        if (piece.count(part) == 0) return;
        const Nodes nodes = read_nodes(piece, part);
        for (std::size_t c = 0; c < nodes.ends.size(); ++c) add_cell(nodes, c, kind, first_point);
    }

    /// Nodes of all cells of a part, and where those of each end.
    struct Nodes {
        const DataArray& array;
        const DataArray& ends_array;
        std::size_t num_points;
        std::vector<std::int64_t> all, ends;
    };

    Nodes read_nodes(const Piece& piece, Part part) const {
        const DataArray& array = array_called(piece, part, "connectivity");
        const DataArray& ends = array_called(piece, part, "offsets");
        Nodes nodes{array, ends, piece.count(Part::Points), arrays_.integers(array), arrays_.integers(ends)};
        check_size(ends, nodes.ends.size(), piece.count(part));
        std::int64_t previous = 0;
        for (const std::int64_t end : nodes.ends) {
            if (end < previous || end > static_cast<std::int64_t>(nodes.all.size()))
                arrays_.fail(ends, "is out of order or range: " + std::to_string(end) + " after " +
                                       std::to_string(previous) + ", there are " + std::to_string(nodes.all.size()) +
                                       " entries in connectivity");
            previous = end;
        }
        check_size(array, nodes.all.size(), static_cast<std::size_t>(previous));
        return nodes;
    }

    void add_cell(const Nodes& nodes, std::size_t cell, const CellKind& kind, std::size_t first_point) {
        const auto begin = static_cast<std::size_t>(cell == 0 ? 0 : nodes.ends[cell - 1]),
                   end = static_cast<std::size_t>(nodes.ends[cell]);
        const bool fits = kind.nodes == 0 ? end - begin >= static_cast<std::size_t>(kind.corners)
                                          : end - begin == static_cast<std::size_t>(kind.nodes);
        if (!fits)
            arrays_.fail(nodes.ends_array, "gives cell " + std::to_string(cell) + " " + std::to_string(end - begin) +
                                               " nodes, but it is one of the " + kind.name + " with " +
                                               std::to_string(kind.nodes == 0 ? kind.corners : kind.nodes) +
                                               (kind.nodes == 0 ? " or more" : ""));
        points_.clear();
        for (std::size_t i = begin; i < end; ++i) {
            const std::int64_t point = nodes.all[i];
            if (point < 0 || point >= static_cast<std::int64_t>(nodes.num_points))
                arrays_.fail(nodes.array, "names point " + std::to_string(point) +
                                              ", which is out of range; there are " + std::to_string(nodes.num_points) +
                                              ", numbered from 0");
            points_.push_back(static_cast<int>(point + static_cast<std::int64_t>(first_point)));
        }
        cells_.add(data_.soup, kind, points_);
    }

    /// The field that write_mesh keeps labels in.
    void read_labels(const Piece& piece, std::size_t count) {
        const auto& arrays = piece.of(Part::CellData);
        const auto label = std::find_if(arrays.begin(), arrays.end(), [](const DataArray& array) {
            return array.name == kLabelField && array.components == 1 && Arrays::is_integer(array);
        });
        if (label == arrays.end()) all_labelled_ = false;
        if (!all_labelled_) return;
        const std::vector<std::int64_t> labels = arrays_.integers(*label);
        check_size(*label, labels.size(), count);
        for (const std::int64_t l : labels) {
            if (l != static_cast<int>(l)) arrays_.fail(*label, "is out of range: " + std::to_string(l));
            cell_labels_.push_back(static_cast<int>(l));
        }
    }

    void set_labels(std::vector<int>& labels, const std::vector<int>& cells) const {
        for (const int cell : cells) labels.push_back(cell_labels_[static_cast<std::size_t>(cell)]);
        drop_if_zero(labels);
    }

    /// Fields are kept that all pieces have. What is no number (texts, bits) is passed over.
    void read_fields(std::vector<Field>& fields, const std::vector<DataArray>& arrays, std::size_t count,
                     bool first) const {
        std::vector<Field> read;
        for (const DataArray& array : arrays) {
            const bool twice =
                std::any_of(read.begin(), read.end(), [&](const Field& field) { return field.name == array.name; });
            if (!Arrays::is_known(array) || array.name.empty() || twice) continue;
            Field field{array.name, array.components, arrays_.reals(array), Arrays::is_integer(array)};
            check_size(array, field.values.size(), count * static_cast<std::size_t>(array.components));
            read.push_back(std::move(field));
        }
        if (first) return static_cast<void>(fields = std::move(read));
        const auto missing = [&](Field& field) {
            for (const Field& more : read) {
                if (more.name != field.name || more.components != field.components) continue;
                field.values.insert(field.values.end(), more.values.begin(), more.values.end());
                return false;
            }
            return true;
        };
        fields.erase(std::remove_if(fields.begin(), fields.end(), missing), fields.end());
    }

    const std::string& path_;
    const Document& document_;
    Fields fields_;
    Budget budget_;  ///< of all arrays, which may share appended data
    Arrays arrays_;
    MeshData data_;
    SurfaceCells cells_;
    std::vector<Field> point_fields_, cell_fields_;  ///< the latter on cells
    bool all_labelled_ = true;
    std::vector<int> cell_labels_;
    std::vector<int> points_;  ///< of the cell at hand
};

}  // namespace

MeshData parse_vtk_xml(const std::string& path, std::string_view contents, Fields fields) {
    const Document document = DocumentParser(path, contents).parse();
    return Reader(path, contents, document, fields).read();
}

}  // namespace gradus::io
