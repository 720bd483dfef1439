// Stanford PLY: text and binary of both byte orders, properties of any type in any order, further elements passed over.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

#include "budget.hpp"
#include "bytes.hpp"
#include "formats.hpp"
#include "polygons.hpp"
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
enum class Use { None, X, Y, Z, Corners, Label, Field };

struct Property {
    Type type = Type::Float;
    std::optional<Type> count;  ///< type of the length of a list
    Use use = Use::None;
    std::optional<std::size_t> field = {};  ///< of the element, that its values are
};

/// Properties that a comment declares to be the components of one field.
struct Group {
    std::size_t first = 0;  ///< scalar field
    std::size_t components = 1;
    std::string name;
};
constexpr std::string_view kGroup = "gradus field ";  ///< then the number of components, and the name

struct Element {
    std::string name;
    std::size_t count = 0;
    std::vector<Property> properties;
    std::vector<Field> fields;  ///< without values, one for each property
    std::vector<Group> groups;
};

struct Header {
    Encoding encoding = Encoding::Text;
    std::vector<Element> elements;
};

// Header
// ---------------------------------------------------------------------------------------------------------------

Type read_type(Scanner& in) {
    in.at_line_end();
    const char* where = in.position();
    const std::string_view word = in.word("a type");
    for (const TypeName& type : kTypes)
        if (word == type.name || word == type.other) return type.type;
    in.fail_at(where, "unknown type " + quoted(word));
}

Use use_of(const Element& element, std::string_view property) {
    if (element.name == "vertex")
        return property == "x" ? Use::X : property == "y" ? Use::Y : property == "z" ? Use::Z : Use::None;
    if (element.name != "face") return Use::None;
    if (property == kLabelField) return Use::Label;
    return property == "vertex_indices" || property == "vertex_index" ? Use::Corners : Use::None;
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
    if (property.use == Use::Label && (property.count || !is_integer(property.type))) property.use = Use::None;
    const bool fits = property.use == Use::None || (property.use == Use::Corners) == property.count.has_value();
    if (!fits || (property.use == Use::Corners && !is_integer(property.type)))
        in.fail_at(where, "coordinates must be scalars, and the corners of a face a list of integers");
    for (const Property& other : element.properties)
        if (other.use == property.use && other.use != Use::None && other.use != Use::Field)
            in.fail_at(where, "a coordinate, the corners or the label of a face come twice");
    const bool rides_along = (property.use == Use::None || property.use == Use::Label) && !property.count &&
                             (element.name == "vertex" || element.name == "face");
    const bool is_new = std::none_of(element.fields.begin(), element.fields.end(),
                                     [&](const Field& field) { return field.name == name; });
    if (fields == Fields::Read && rides_along && is_new) {
        if (property.use == Use::None) property.use = Use::Field;
        property.field = element.fields.size();
        element.fields.push_back({std::string(name), 1, {}, is_integer(property.type)});
    }
    element.properties.push_back(property);
}

/// A comment may say that the properties after it are one field.
void read_group(std::string_view comment, Element& element) {
    while (!comment.empty() && is_space(comment.front())) comment.remove_prefix(1);
    while (!comment.empty() && is_space(comment.back())) comment.remove_suffix(1);
    if (!comment.starts_with(kGroup)) return;
    comment.remove_prefix(kGroup.size());
    Group group{element.fields.size(), 0, ""};
    const auto [end, error] = std::from_chars(comment.data(), comment.data() + comment.size(), group.components);
    const auto digits = static_cast<std::size_t>(end - comment.data());
    if (error != std::errc{} || group.components < 1 || digits + 1 >= comment.size() || comment[digits] != ' ') return;
    group.name = comment.substr(digits + 1);
    element.groups.push_back(std::move(group));
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
        if (element.name == "vertex" && (vertices || coordinates != 3))
            in.fail("expected one element vertex with x, y and z");
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
        if (word == "comment" && !header.elements.empty()) {
            read_group(in.line(), header.elements.back());
            continue;
        }
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

// Body: text and binary
// ------------------------------------------------------------------------------------------------

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
    void check_count(std::uint64_t count, std::size_t values) {
        in_.check_count(count, values, "the number of entries");
    }
    void finish() {
        if (in_.remaining() > 0)
            in_.fail("expected the end of the file, found " + std::to_string(in_.remaining()) + " bytes more");
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
        if (index < 0 || index > std::numeric_limits<int>::max())
            in.fail_at(where, "vertex " + std::to_string(index) + " out of range");
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

/// Fields of one component each, those of a group made one.
std::vector<Field> joined(std::vector<Field> fields, const std::vector<Group>& groups) {
    std::vector<Field> result;
    auto group = groups.begin();
    for (std::size_t i = 0; i < fields.size();) {
        while (group != groups.end() && group->first < i) ++group;
        const bool starts = group != groups.end() && group->first == i && group->components <= fields.size() - i;
        const std::size_t n = starts ? group->components : 1;
        if (n == 1) {
            if (starts) fields[i].name = group->name;
            result.push_back(std::move(fields[i++]));
            continue;
        }
        Field& field = result.emplace_back(
            Field{group->name, static_cast<int>(n), std::vector<double>(n * fields[i].values.size()), true});
        for (std::size_t k = 0; k < n; ++k, ++i) {
            field.integer = field.integer && fields[i].integer;
            for (std::size_t row = 0; row < fields[i].values.size(); ++row)
                field.values[n * row + k] = fields[i].values[row];
            fields[i].values = {};
        }
    }
    return result;
}

template <class Body>
int read_label(Body& in, Type type) {
    const auto where = in.where();
    const std::int64_t label = in.integer(type);
    if (label != static_cast<int>(label)) in.fail_at(where, "label " + std::to_string(label) + " is out of range");
    return static_cast<int>(label);
}

template <class Body>
MeshData read_body(const std::string& path, Body in, const Header& header, Budget budget) {
    MeshData data;
    TriangleSoup& soup = data.soup;
    LargestIndex<typename Body::Where> largest;
    std::vector<Fan> fans;
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
            std::optional<int> label;
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
                        if (const std::size_t made = soup.triangles.size() - first_triangle; made > 1)
                            fans.push_back({first_triangle, made});
                        break;
                    case Use::Label:
                        label = read_label(in, property.type);
                        if (property.field) values[*property.field] = *label;
                        break;
                    case Use::Field:
                        values[*property.field] = in.any_real(property.type);
                        break;
                    case Use::None:
                        skip_property(in, property);
                        break;
                }
            }
            if (element.name == "vertex") soup.points.push_back(point);
            if (label) soup.labels.resize(soup.triangles.size(), *label);
            const std::size_t repeats = element.name == "vertex" ? 1 : soup.triangles.size() - first_triangle;
            budget.take(fields.size() * repeats);
            add_values(fields, values, repeats);
        }
        if (element.name == "vertex") data.point_fields = joined(std::move(fields), element.groups);
        if (element.name == "face") data.cell_fields = joined(std::move(fields), element.groups);
    }
    in.finish();
    if (largest.index >= static_cast<std::int64_t>(soup.points.size()))
        in.fail_at(largest.where, "vertex " + std::to_string(largest.index) + " out of range; there are " +
                                      std::to_string(soup.points.size()) + ", numbered from 0");
    clip_ears(path, soup, fans);
    return data;
}

/// A column of numbers to write.
struct Column {
    std::string property;
    Type type = Type::Double;
    const Field* field;
    std::size_t component;

    double value(std::size_t i) const {
        return field->values[i * static_cast<std::size_t>(field->components) + component];
    }
};

struct Columns {
    std::vector<Column> all;
    std::string header;
};

Type type_of(const Field& field) {
    if (!holds_integers(field)) return Type::Double;
    const auto within = [&](double low, double high) {
        return std::all_of(field.values.begin(), field.values.end(), [&](double x) { return x >= low && x <= high; });
    };
    if (within(0, 255)) return Type::UInt8;
    return within(std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max()) ? Type::Int32
                                                                                                      : Type::Double;
}

/// @param taken  names of other properties of the element
Columns columns_of(const std::vector<Field>& fields, std::set<std::string> taken) {
    Columns columns;
    for (const Field& field : fields) {
        std::string word = field.name, name = field.name;
        std::replace_if(
            word.begin(), word.end(), [](char c) { return c <= ' ' || c > '~'; }, '_');
        std::replace_if(
            name.begin(), name.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
        std::string properties;
        bool renamed = field.components > 1;
        for (int k = 0; k < field.components; ++k) {
            std::string property = field.components == 1 ? word : word + "_" + std::to_string(k);
            while (!taken.insert(property).second) property += '_';
            renamed = renamed || property != field.name;
            const Type type = type_of(field);
            properties.append("property ")
                .append(kTypes[static_cast<int>(type)].name)
                .append(" ")
                .append(property)
                .append("\n");
            columns.all.push_back({property, type, &field, static_cast<std::size_t>(k)});
        }
        if (renamed)
            columns.header.append("comment ")
                .append(kGroup)
                .append(std::to_string(field.components))
                .append(" ")
                .append(name)
                .append("\n");
        columns.header += properties;
    }
    return columns;
}

/// What is written of a mesh, and how.
struct Layout {
    std::vector<Field> cell_fields;
    Columns vertex, face;

    explicit Layout(const MeshData& data)
        : cell_fields(cell_fields_of(data)),
          vertex(columns_of(data.point_fields, {"x", "y", "z"})),
          face(columns_of(cell_fields, {"vertex_indices", "vertex_index", std::string(kLabelField)})) {}
    Layout(const Layout&) = delete;
    Layout& operator=(const Layout&) = delete;

    std::string header(const TriangleSoup& soup, std::string_view format) const {
        TextWriter out(512 + vertex.header.size() + face.header.size());
        out << "ply\nformat " << format << " 1.0\nelement vertex " << soup.points.size()
            << "\nproperty double x\nproperty double y\nproperty double z\n"
            << vertex.header << "element face " << soup.triangles.size()
            << "\nproperty list uchar int vertex_indices\n";
        if (!soup.labels.empty()) out << "property int " << kLabelField << '\n';
        out << face.header << "end_header\n";
        return out.take();
    }
};

void append_values(TextWriter& out, const Columns& columns, std::size_t i) {
    for (const Column& column : columns.all) {
        out << ' ';
        if (column.type == Type::Double)
            out << column.value(i);
        else
            out << static_cast<int>(column.value(i));
    }
}

void append_values(std::string& bytes, const Columns& columns, std::size_t i) {
    for (const Column& column : columns.all) {
        const double value = column.value(i);
        if (column.type == Type::UInt8)
            append_bytes(bytes, static_cast<std::uint8_t>(value));
        else if (column.type == Type::Int32)
            append_bytes(bytes, static_cast<std::int32_t>(value));
        else
            append_bytes(bytes, value);
    }
}

}  // namespace

MeshData parse_ply(const std::string& path, std::string_view contents, Fields fields) {
    Scanner in(path, contents, '\0');
    const Header header = read_header(in, fields);
    const Budget budget(path, kNumbersPerByte * contents.size());
    if (header.encoding == Encoding::Text) return read_body(path, TextBody(in), header, budget);
    ByteReader bytes(path, contents);
    bytes.skip(static_cast<std::size_t>(in.position() - contents.data()), "the header");
    if (header.encoding == Encoding::BigEndian) bytes.swap_bytes();
    return read_body(path, BinaryBody(bytes), header, budget);
}

std::string ply_text(const MeshData& data) {
    const TriangleSoup& soup = data.soup;
    const Layout layout(data);
    TextWriter out((64 + 20 * layout.vertex.all.size()) * soup.points.size() +
                   (40 + 20 * layout.face.all.size()) * soup.triangles.size() + 1024);
    out << layout.header(soup, "ascii");
    for (std::size_t v = 0; v < soup.points.size(); ++v) {
        const Eigen::Vector3d& p = soup.points[v];
        out << p[0] << ' ' << p[1] << ' ' << p[2];
        append_values(out, layout.vertex, v);
        out << '\n';
    }
    for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
        const auto& [a, b, c] = soup.triangles[t];
        out << "3 " << a << ' ' << b << ' ' << c;
        if (!soup.labels.empty()) out << ' ' << soup.labels[t];
        append_values(out, layout.face, t);
        out << '\n';
    }
    return out.take();
}

std::string ply_binary(const MeshData& data) {
    const TriangleSoup& soup = data.soup;
    const Layout layout(data);
    std::string bytes = layout.header(soup, "binary_little_endian");
    bytes.reserve(bytes.size() + (24 + 8 * layout.vertex.all.size()) * soup.points.size() +
                  (17 + 8 * layout.face.all.size()) * soup.triangles.size());
    for (std::size_t v = 0; v < soup.points.size(); ++v) {
        for (int i = 0; i < 3; ++i) append_bytes(bytes, soup.points[v][i]);
        append_values(bytes, layout.vertex, v);
    }
    for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
        append_bytes(bytes, std::uint8_t{3});
        for (const int vertex : soup.triangles[t]) append_bytes(bytes, std::int32_t{vertex});
        if (!soup.labels.empty()) append_bytes(bytes, std::int32_t{soup.labels[t]});
        append_values(bytes, layout.face, t);
    }
    return bytes;
}

}  // namespace gradus::io
