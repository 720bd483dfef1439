// Stanford PLY: text and binary of both byte orders, properties of any type in any order, further elements passed over.
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "budget.hpp"
#include "bytes.hpp"
#include "formats.hpp"
#include "scanner.hpp"
#include "text_writer.hpp"

namespace gradus::io {
namespace {

enum class Type { Int8, UInt8, Int16, UInt16, Int32, UInt32, Float, Double };
enum class Encoding { Text, LittleEndian, BigEndian };

struct TypeName {
    std::string_view name, other;
    Type type;
    std::size_t size;
};
constexpr TypeName kTypes[] = {
    {"char", "int8", Type::Int8, 1},       {"uchar", "uint8", Type::UInt8, 1},     {"short", "int16", Type::Int16, 2},
    {"ushort", "uint16", Type::UInt16, 2}, {"int", "int32", Type::Int32, 4},       {"uint", "uint32", Type::UInt32, 4},
    {"float", "float32", Type::Float, 4},  {"double", "float64", Type::Double, 8},
};

std::size_t size_of(Type type) { return kTypes[static_cast<int>(type)].size; }
bool is_integer(Type type) { return type != Type::Float && type != Type::Double; }

/// What the reader does with a property.
enum class Use { None, X, Y, Z, Corners, Field };

struct Property {
    Type type = Type::Float;
    std::optional<Type> count;  ///< type of the length of a list
    Use use = Use::None;
    std::size_t field = 0;  ///< if it is used as one: which of the element
};

struct Element {
    std::string name;
    std::size_t count = 0;
    std::vector<Property> properties;
    std::vector<Field> fields;  ///< without values
};

struct Header {
    Encoding encoding = Encoding::Text;
    std::vector<Element> elements;
};

// Header ---------------------------------------------------------------------------------------------------------------

Type read_type(Scanner& in) {
    in.at_line_end();
    const char* where = in.position();
    const std::string_view word = in.word("a type");
    for (const TypeName& type : kTypes)
        if (word == type.name || word == type.other) return type.type;
    in.fail_at(where, "unknown type " + quoted(word));
}

Use use_of(const Element& element, std::string_view property) {
    if (element.name == "vertex") return property == "x" ? Use::X : property == "y" ? Use::Y : property == "z" ? Use::Z : Use::None;
    const bool corners = element.name == "face" && (property == "vertex_indices" || property == "vertex_index");
    return corners ? Use::Corners : Use::None;
}

void read_property(Scanner& in, Element& element, Fields fields) {
    const char* where = in.position();
    Property property;
    in.at_line_end();
    if (in.peek() == "list") {
        in.word("list");
        property.count = read_type(in);
        if (!is_integer(*property.count)) in.fail_at(where, "the length of a list must be an integer");
    }
    property.type = read_type(in);
    const std::string_view name = in.word("the name of a property");
    property.use = use_of(element, name);
    const bool fits = property.use == Use::None || (property.use == Use::Corners) == property.count.has_value();
    if (!fits || (property.use == Use::Corners && !is_integer(property.type)))
        in.fail_at(where, "coordinates must be scalars, and the corners of a face a list of integers");
    for (const Property& other : element.properties)
        if (other.use == property.use && other.use != Use::None && other.use != Use::Field)
            in.fail_at(where, "a coordinate or the corners of a face come twice");
    const bool rides_along = property.use == Use::None && !property.count && (element.name == "vertex" || element.name == "face");
    if (fields == Fields::Read && rides_along) {
        property.use = Use::Field;
        property.field = element.fields.size();
        element.fields.push_back({std::string(name)});
    }
    element.properties.push_back(property);
}

Encoding read_encoding(Scanner& in) {
    in.at_line_end();
    const char* where = in.position();
    const std::string_view word = in.word("a format");
    if (in.word("the version 1.0") != "1.0") in.fail_at(where, "expected version 1.0");
    if (word == "ascii") return Encoding::Text;
    if (word == "binary_little_endian") return Encoding::LittleEndian;
    if (word == "binary_big_endian") return Encoding::BigEndian;
    in.fail_at(where, "unknown format " + quoted(word));
}

/// Counts are compared with the size of the file before anything is reserved: every entry takes a byte at least.
Element read_element(Scanner& in) {
    Element element;
    in.at_line_end();
    element.name = in.word("the name of an element");
    element.count = in.count("the number of entries", 1);
    return element;
}

void check_header(const Scanner& in, const Header& header) {
    bool vertices = false, faces = false;
    for (const Element& element : header.elements) {
        std::size_t coordinates = 0, corners = 0;
        for (const Property& property : element.properties) {
            corners += property.use == Use::Corners;
            coordinates += property.use == Use::X || property.use == Use::Y || property.use == Use::Z;
        }
        if (element.name == "vertex" && (vertices || coordinates != 3)) in.fail("expected one element vertex with x, y and z");
        if (element.name == "face" && (faces || corners != 1)) in.fail("expected one element face with vertex_indices");
        vertices |= element.name == "vertex";
        faces |= element.name == "face";
    }
    if (!vertices || !faces) in.fail(vertices ? "has no element face" : "has no element vertex");
}

Header read_header(Scanner& in, Fields fields) {
    if (in.line() != "ply") in.fail_at(in.position() - 1, "is not a PLY file: expected ply in the first line");
    Header header;
    bool has_format = false;
    while (true) {
        if (in.at_end()) in.fail_expected("end_header");
        const char* where = in.position();
        const std::string_view word = in.word("a header line");
        if (word == "end_header") break;
        if (word == "comment" || word == "obj_info") {
            in.next_line();
            continue;
        }
        if (word == "format") {
            header.encoding = read_encoding(in);
            has_format = true;
        } else if (word == "element") {
            header.elements.push_back(read_element(in));
        } else if (word == "property" && !header.elements.empty()) {
            read_property(in, header.elements.back(), fields);
        } else {
            in.fail_at(where, "unexpected header line " + quoted(word));
        }
        if (!in.at_line_end()) in.fail("expected the end of the header line, found " + quoted(in.peek()));
    }
    in.next_line();
    if (!has_format) in.fail("has no format line");
    check_header(in, header);
    return header;
}

// Body: text and binary ------------------------------------------------------------------------------------------------

class TextBody {
  public:
    using Where = const char*;

    explicit TextBody(Scanner in) : in_(in) {}

    Where where() {
        in_.at_end();
        return in_.position();
    }
    double real(Type) { return in_.real("a coordinate"); }
    double any_real(Type) { return in_.any_real("a value"); }
    std::int64_t integer(Type) { return in_.integer("an integer"); }
    void skip(Type) { in_.word("a value"); }
    void check_count(std::uint64_t count, std::size_t values) {
        if (count > in_.remaining() / (2 * values) + 1)
            fail_at(where(), "expected " + std::to_string(count) + " more entries, found the end of the file");
    }
    void finish() {
        if (!in_.at_end()) in_.fail("expected the end of the file, found " + quoted(in_.peek()));
    }
    [[noreturn]] void fail_at(Where where, const std::string& what) const { in_.fail_at(where, what); }

  private:
    Scanner in_;
};

class BinaryBody {
  public:
    using Where = std::size_t;

    explicit BinaryBody(const ByteReader& in) : in_(in) {}

    Where where() const { return in_.offset(); }
    double real(Type type) {
        const Where start = where();
        const double value = any_real(type);
        if (!std::isfinite(value)) in_.fail_at(start, "a coordinate is not finite");
        return value;
    }
    double any_real(Type type) {
        return type == Type::Double  ? in_.get<double>("a number")
               : type == Type::Float ? static_cast<double>(in_.get<float>("a number"))
                                     : static_cast<double>(integer(type));
    }
    std::int64_t integer(Type type) {
        switch (type) {
            case Type::Int8:
                return in_.get<std::int8_t>("an integer");
            case Type::UInt8:
                return in_.get<std::uint8_t>("an integer");
            case Type::Int16:
                return in_.get<std::int16_t>("an integer");
            case Type::UInt16:
                return in_.get<std::uint16_t>("an integer");
            case Type::Int32:
                return in_.get<std::int32_t>("an integer");
            case Type::UInt32:
                return in_.get<std::uint32_t>("an integer");
            case Type::Float:
            case Type::Double:
                break;
        }
        in_.fail("expected an integer type");
    }
    void skip(Type type) { in_.skip(size_of(type), "a value"); }
    void check_count(std::uint64_t count, std::size_t values) { in_.check_count(count, values, "the number of entries"); }
    void finish() {
        if (in_.remaining() > 0) in_.fail("expected the end of the file, found " + std::to_string(in_.remaining()) + " bytes more");
    }
    [[noreturn]] void fail_at(Where where, const std::string& what) const { in_.fail_at(where, what); }

  private:
    ByteReader in_;
};

/// Faces may come before the vertices, so indices are compared with their number at the end.
template <class Where>
struct LargestIndex {
    std::int64_t index = -1;
    Where where{};
};

template <class Body>
void read_corners(Body& in, const Property& property, TriangleSoup& soup, LargestIndex<typename Body::Where>& largest) {
    const auto start = in.where();
    const std::int64_t corners = in.integer(*property.count);
    if (corners < 3) in.fail_at(start, "a face needs at least 3 vertices, found " + std::to_string(corners));
    int first = 0, previous = 0;
    for (std::int64_t i = 0; i < corners; ++i) {
        const auto where = in.where();
        const std::int64_t index = in.integer(property.type);
        if (index < 0 || index > std::numeric_limits<int>::max()) in.fail_at(where, "vertex " + std::to_string(index) + " out of range");
        if (index > largest.index) largest = {index, where};
        const int vertex = static_cast<int>(index);
        if (i == 0) first = vertex;
        if (i > 1) soup.triangles.push_back({first, previous, vertex});
        previous = vertex;
    }
}

template <class Body>
void skip_property(Body& in, const Property& property) {
    const auto where = in.where();
    const std::int64_t values = property.count ? in.integer(*property.count) : 1;
    if (values < 0) in.fail_at(where, "a list of negative length");
    for (std::int64_t i = 0; i < values; ++i) in.skip(property.type);
}

/// @param at  the values of one entry, which is a vertex or `repeats` triangles
void add_values(std::vector<Field>& fields, const std::vector<double>& at, std::size_t repeats) {
    for (std::size_t i = 0; i < fields.size(); ++i) fields[i].values.insert(fields[i].values.end(), repeats, at[i]);
}

template <class Body>
MeshData read_body(Body in, const Header& header, Budget budget) {
    MeshData data;
    TriangleSoup& soup = data.soup;
    LargestIndex<typename Body::Where> largest;
    for (const Element& element : header.elements) {
        if (element.properties.empty()) continue;
        in.check_count(element.count, element.properties.size());
        if (element.name == "vertex") soup.points.reserve(element.count);
        if (element.name == "face") soup.triangles.reserve(element.count);
        std::vector<Field> fields = element.fields;
        std::vector<double> values(fields.size());
        for (std::size_t i = 0; i < element.count; ++i) {
            Eigen::Vector3d point(0, 0, 0);
            const std::size_t first_triangle = soup.triangles.size();
            for (const Property& property : element.properties) {
                switch (property.use) {
                    case Use::X:
                        point[0] = in.real(property.type);
                        break;
                    case Use::Y:
                        point[1] = in.real(property.type);
                        break;
                    case Use::Z:
                        point[2] = in.real(property.type);
                        break;
                    case Use::Corners:
                        read_corners(in, property, soup, largest);
                        break;
                    case Use::Field:
                        values[property.field] = in.any_real(property.type);
                        break;
                    case Use::None:
                        skip_property(in, property);
                        break;
                }
            }
            if (element.name == "vertex") soup.points.push_back(point);
            const std::size_t repeats = element.name == "vertex" ? 1 : soup.triangles.size() - first_triangle;
            budget.take(fields.size() * repeats);
            add_values(fields, values, repeats);
        }
        if (element.name == "vertex") data.point_fields = std::move(fields);
        if (element.name == "face") data.cell_fields = std::move(fields);
    }
    in.finish();
    if (largest.index >= static_cast<std::int64_t>(soup.points.size()))
        in.fail_at(largest.where, "vertex " + std::to_string(largest.index) + " out of range; there are " +
                                      std::to_string(soup.points.size()) + ", numbered from 0");
    return data;
}

void write_header(TextWriter& out, const TriangleSoup& soup, std::string_view format) {
    out << "ply\nformat " << format << " 1.0\nelement vertex " << soup.points.size()
        << "\nproperty double x\nproperty double y\nproperty double z\nelement face " << soup.triangles.size()
        << "\nproperty list uchar int vertex_indices\nend_header\n";
}

}  // namespace

MeshData parse_ply(const std::string& path, std::string_view contents, Fields fields) {
    Scanner in(path, contents, '\0');
    const Header header = read_header(in, fields);
    const Budget budget(path, kNumbersPerByte * contents.size());
    if (header.encoding == Encoding::Text) return read_body(TextBody(in), header, budget);
    ByteReader bytes(path, contents);
    bytes.skip(static_cast<std::size_t>(in.position() - contents.data()), "the header");
    if (header.encoding == Encoding::BigEndian) bytes.swap_bytes();
    return read_body(BinaryBody(bytes), header, budget);
}

std::string ply_text(const TriangleSoup& soup) {
    TextWriter out(64 * soup.points.size() + 32 * soup.triangles.size() + 256);
    write_header(out, soup, "ascii");
    for (const Eigen::Vector3d& p : soup.points) out << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
    for (const auto& [a, b, c] : soup.triangles) out << "3 " << a << ' ' << b << ' ' << c << '\n';
    return out.take();
}

std::string ply_binary(const TriangleSoup& soup) {
    TextWriter out(24 * soup.points.size() + 13 * soup.triangles.size() + 256);
    write_header(out, soup, "binary_little_endian");
    std::string bytes = out.take();
    for (const Eigen::Vector3d& p : soup.points)
        for (int i = 0; i < 3; ++i) append_bytes(bytes, p[i]);
    for (const Triangle& triangle : soup.triangles) {
        append_bytes(bytes, std::uint8_t{3});
        for (const int vertex : triangle) append_bytes(bytes, std::int32_t{vertex});
    }
    return bytes;
}

}  // namespace gradus::io
