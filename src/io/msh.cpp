// Gmsh's format, versions 2.2 and 4.1, text and binary. In binary files the names of sections and some counts are text.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "budget.hpp"
#include "bytes.hpp"
#include "cells.hpp"
#include "formats.hpp"
#include "scanner.hpp"
#include "text_writer.hpp"

namespace gradus::io {
namespace {

/// Elements by their number in the format; the corners come first in all of them.
constexpr CellKind kKinds[] = {
    {1, Shape::Lines, 2, 2, "lines"},         {2, Shape::Polygon, 3, 3, "triangles"},
    {3, Shape::Polygon, 4, 4, "quads"},       {4, Shape::Volume, 4, 4, "tetrahedra"},
    {5, Shape::Volume, 8, 8, "hexahedra"},    {6, Shape::Volume, 6, 6, "prisms"},
    {7, Shape::Volume, 5, 5, "pyramids"},     {8, Shape::Lines, 2, 3, "lines"},
    {9, Shape::Polygon, 3, 6, "triangles"},   {10, Shape::Polygon, 4, 9, "quads"},
    {11, Shape::Volume, 4, 10, "tetrahedra"}, {12, Shape::Volume, 8, 27, "hexahedra"},
    {13, Shape::Volume, 6, 18, "prisms"},     {14, Shape::Volume, 5, 14, "pyramids"},
    {15, Shape::Nothing, 1, 1, "points"},     {16, Shape::Polygon, 4, 8, "quads"},
    {17, Shape::Volume, 8, 20, "hexahedra"},  {18, Shape::Volume, 6, 15, "prisms"},
    {19, Shape::Volume, 5, 13, "pyramids"},   {20, Shape::Polygon, 3, 9, "triangles"},
    {21, Shape::Polygon, 3, 10, "triangles"}, {22, Shape::Polygon, 3, 12, "triangles"},
    {23, Shape::Polygon, 3, 15, "triangles"}, {24, Shape::Polygon, 3, 15, "triangles"},
    {25, Shape::Polygon, 3, 21, "triangles"}, {26, Shape::Lines, 2, 4, "lines"},
    {27, Shape::Lines, 2, 5, "lines"},        {28, Shape::Lines, 2, 6, "lines"},
    {29, Shape::Volume, 4, 20, "tetrahedra"}, {30, Shape::Volume, 4, 35, "tetrahedra"},
    {31, Shape::Volume, 4, 56, "tetrahedra"}, {36, Shape::Polygon, 4, 16, "quads"},
    {37, Shape::Polygon, 4, 25, "quads"},     {38, Shape::Polygon, 4, 36, "quads"},
    {92, Shape::Volume, 8, 64, "hexahedra"},  {93, Shape::Volume, 8, 125, "hexahedra"},
};
constexpr std::size_t kMostNodes = 125;

// Source: text or binary
// -----------------------------------------------------------------------------------------------

class Source {
  public:
    Source(const std::string& path, std::string_view contents)
        : start_(contents.data()), text_(path, contents, '\0'), bytes_(path, contents) {}

    Scanner& text() {
        if (in_bytes_) text_.advance(bytes_.offset() - text_offset());
        in_bytes_ = false;
        return text_;
    }
    bool binary() const { return binary_; }
    int version() const { return version_; }

    /// $MeshFormat up to its end.
    void read_format() {
        const char* where = text_.position();
        const std::string_view word = text_.peek();
        if (word != "$MeshFormat")
            text_.fail_at(where, "is not a Gmsh file: expected $MeshFormat, found " + quoted(word));
        text_.word("$MeshFormat");
        text_.at_end();
        where = text_.position();
        const double version = text_.real("the version");
        version_ = version >= 2 && version < 3 ? 2 : version == 4.1 ? 4 : 0;
        if (version_ == 0)
            text_.fail_at(where, "has version " + tick(version) + " of Gmsh's format; 2.2 and 4.1 are read");
        text_.at_end();
        where = text_.position();
        const std::int64_t type = text_.integer("0 for text or 1 for binary");
        if (type != 0 && type != 1)
            text_.fail_at(where, "expected 0 for text or 1 for binary, found " + std::to_string(type));
        text_.at_end();
        where = text_.position();
        const std::int64_t size = text_.integer("the size of a number");
        if (size != 8)
            text_.fail_at(where, "numbers of " + std::to_string(size) + " bytes are not supported, only of 8");
        binary_ = type == 1;
        if (binary_) {
            begin_data();
            const auto one = bytes_.get<std::int32_t>("the number 1 that tells the byte order");
            if (one == 0x01000000)
                bytes_.swap_bytes();
            else if (one != 1)
                bytes_.fail_at(bytes_.offset() - 4, "expected the number 1 that tells the byte order");
        }
        end_section("$MeshFormat");
    }

    /// The name of the next section. Nothing at the end.
    std::optional<std::string_view> section() {
        if (text().at_end()) return std::nullopt;
        const std::string_view word = text_.peek();
        if (!word.starts_with('$') || word.starts_with("$End"))
            text_.fail("expected the start of a section, found " + quoted(word) + " (more entries than announced?)");
        text_.word("a section");
        return word;
    }
    void skip_section(std::string_view name) {
        const std::string end = "$End" + std::string(name.substr(1));
        const std::string_view rest(text().position(), text_.remaining());
        const std::size_t at = rest.find(end);
        if (at == std::string_view::npos) text_.fail(std::string(name) + " has no " + end);
        text_.advance(at + end.size());
    }
    void end_section(std::string_view name) {
        const std::string end = "$End" + std::string(name.substr(1));
        if (text().peek() != end) text_.fail_expected(end.c_str());
        text_.word("the end of the section");
    }

    /// Where the cursor is. Passes nothing, so binary data may start in the next line.
    std::size_t here() const { return in_bytes_ ? bytes_.offset() : text_offset(); }

    /// What follows the line is binary, if the file is.
    void begin_data() {
        if (!binary_) return;
        if (!text().at_line_end()) text_.fail("expected the end of the line, found " + quoted(text_.peek()));
        text_.next_line();
        bytes_.seek(text_offset(), "data");
        in_bytes_ = true;
    }

    // Data: binary if the file is.
    std::size_t where() {
        if (in_bytes_) return bytes_.offset();
        text_.at_end();
        return text_offset();
    }
    std::size_t remaining() const { return in_bytes_ ? bytes_.remaining() : text_.remaining(); }
    std::int64_t integer(const char* what) { return in_bytes_ ? bytes_.get<std::int32_t>(what) : text_.integer(what); }
    /// A number or a count that has 8 bytes in version 4.1.
    std::int64_t tag(const char* what) {
        return in_bytes_ && version_ == 4 ? bytes_.get<std::int64_t>(what) : integer(what);
    }
    /// A count of things with so many integers and reals each.
    std::size_t count(const char* what, std::size_t integers, std::size_t reals) {
        const std::size_t least = 2 * (integers + reals) - 1;
        if (!in_bytes_) return text_.count(what, std::max<std::size_t>(least, 1));
        const auto n = bytes_.get<std::uint64_t>(what);
        bytes_.check_count(n, std::max<std::size_t>(4 * integers + 8 * reals, 1), what);
        return static_cast<std::size_t>(n);
    }
    double any_real(const char* what) { return in_bytes_ ? bytes_.get<double>(what) : text_.any_real(what); }
    double real(const char* what) {
        const std::size_t at = where();
        const double value = any_real(what);
        if (!std::isfinite(value)) fail_at(at, std::string(what) + " is not finite");
        return value;
    }
    [[noreturn]] void fail_at(std::size_t where, const std::string& what) const {
        if (binary_) bytes_.fail_at(where, what);
        text_.fail_at(start_ + where, what);
    }

  private:
    std::size_t text_offset() const { return static_cast<std::size_t>(text_.position() - start_); }
    static std::string tick(double version) {
        TextWriter out(8);
        out << version;
        return out.take();
    }

    const char* start_;
    Scanner text_;
    ByteReader bytes_;
    bool in_bytes_ = false, binary_ = false;
    int version_ = 0;
};

/// Finds things by the numbers a file gives them, which may have gaps and come in any order.
class Numbering {
  public:
    void add(std::int64_t number) { numbers_.push_back({number, static_cast<int>(numbers_.size())}); }
    std::size_t size() const { return numbers_.size(); }

    /// To be called before find. @returns a number that came twice
    std::optional<std::int64_t> sort() {
        in_order_ = true;
        for (std::size_t i = 0; i < numbers_.size() && in_order_; ++i)
            in_order_ =
                i == 0 || (numbers_[i - 1].first < numbers_[i].first && numbers_[i - 1].first == numbers_[i].first - 1);
        if (in_order_) return std::nullopt;
        std::sort(numbers_.begin(), numbers_.end());
        const auto twice = std::adjacent_find(numbers_.begin(), numbers_.end(),
                                              [](const auto& a, const auto& b) { return a.first == b.first; });
        return twice == numbers_.end() ? std::nullopt : std::optional(twice->first);
    }
    /// Index in the order of add, -1 if there is none.
    int find(std::int64_t number) const {
        if (numbers_.empty() || number < numbers_.front().first || number > numbers_.back().first) return -1;
        if (in_order_) return static_cast<int>(number - numbers_.front().first);
        const auto at = std::lower_bound(numbers_.begin(), numbers_.end(), std::pair(number, 0));
        return at->first == number ? at->second : -1;
    }

  private:
    std::vector<std::pair<std::int64_t, int>> numbers_;
    bool in_order_ = false;
};

// Reading
// --------------------------------------------------------------------------------------------------------------

/// What is known of an element besides its nodes.
struct Tags {
    std::optional<int> physical;
    int entity = 0;
};

class Reader {
  public:
    Reader(const std::string& path, std::string_view contents, Fields fields)
        : in_(path, contents), fields_(fields), budget_(path, kNumbersPerByte * contents.size()) {}

    MeshData read();

  private:
    enum class Entities { Whole, Partitioned };
    void read_entities(Entities entities);
    void read_entity(int dimension, Entities entities);
    void read_nodes();
    void read_node_blocks();
    void read_point();
    void add_node_number();
    void read_elements();
    void read_element_blocks();
    void read_element(const CellKind& kind, std::int64_t number, const Tags& tags);
    const CellKind& read_kind();
    int read_label(const char* what);
    void read_data(std::string_view section);
    Field read_field(std::string_view section, const Numbering& rows_of, std::size_t rows);
    void set_labels();

    Source in_;
    Fields fields_;
    Budget budget_;  ///< of values
    MeshData data_;
    SurfaceCells cells_;
    bool has_nodes_ = false, has_elements_ = false;
    Numbering nodes_, elements_;
    std::map<int, Tags> curves_, surfaces_;
    std::vector<Tags> tags_of_triangle_, tags_of_edge_;
};

int Reader::read_label(const char* what) {
    const std::size_t where = in_.where();
    const std::int64_t label = in_.integer(what);
    if (label != static_cast<int>(label))
        in_.fail_at(where, std::string(what) + " is out of range: " + std::to_string(label));
    return static_cast<int>(label);
}

/// Version 4.1: keeps the tags of curves and surfaces. Partitioned ones take the place of the entities they are parts
/// of.
void Reader::read_entities(Entities entities) {
    in_.begin_data();
    if (entities == Entities::Partitioned) {
        in_.tag("the number of partitions");
        const std::size_t ghosts = in_.count("the number of ghost entities", 2, 0);
        for (std::size_t g = 0; g < 2 * ghosts; ++g) in_.integer("a ghost entity");
    }
    std::array<std::size_t, 4> counts;
    for (std::size_t& n : counts) n = in_.count("the number of entities", 2, 3);
    for (int dimension = 0; dimension < 4; ++dimension)
        for (std::size_t i = 0; i < counts[static_cast<std::size_t>(dimension)]; ++i) read_entity(dimension, entities);
}

void Reader::read_entity(int dimension, Entities entities) {
    const int tag = read_label("an entity");
    Tags tags{std::nullopt, tag};
    if (entities == Entities::Partitioned) {
        in_.integer("the dimension of an entity");
        tags.entity = read_label("an entity");
        const std::size_t partitions = in_.count("the number of partitions", 1, 0);
        for (std::size_t p = 0; p < partitions; ++p) in_.integer("a partition");
    }
    for (int k = 0; k < (dimension == 0 ? 3 : 6); ++k) in_.any_real("a bound of an entity");
    const std::size_t groups = in_.count("the number of physical groups", 1, 0);
    for (std::size_t g = 0; g < groups; ++g) {
        const int group = read_label("a physical group");
        if (g == 0) tags.physical = group;
    }
    const std::size_t bounding = dimension == 0 ? 0 : in_.count("the number of bounding entities", 1, 0);
    for (std::size_t b = 0; b < bounding; ++b) in_.integer("a bounding entity");
    if (dimension == 1) curves_[tag] = tags;
    if (dimension == 2) surfaces_[tag] = tags;
}

void Reader::read_point() {
    Eigen::Vector3d point;
    for (int i = 0; i < 3; ++i) point[i] = in_.real("a coordinate");
    data_.soup.points.push_back(point);
}

void Reader::add_node_number() {
    const std::size_t where = in_.where();
    const std::int64_t number = in_.tag("the number of a node");
    if (number < 0) in_.fail_at(where, "the number of a node is negative: " + std::to_string(number));
    nodes_.add(number);
}

void Reader::read_nodes() {
    const std::size_t n = in_.text().count("the number of nodes", 8);
    in_.begin_data();
    data_.soup.points.reserve(n);
    for (std::size_t i = 0; i < n; ++i) {
        add_node_number();
        read_point();
    }
}

void Reader::read_node_blocks() {
    in_.begin_data();
    const std::size_t start = in_.where();
    const std::size_t blocks = in_.count("the number of blocks", 4, 0), total = in_.count("the number of nodes", 1, 3);
    for (const char* what : {"the least number of a node", "the greatest number of a node"}) in_.tag(what);
    data_.soup.points.reserve(total);
    for (std::size_t b = 0; b < blocks; ++b) {
        const std::size_t where = in_.where();
        const std::int64_t dimension = in_.integer("the dimension of an entity");
        if (dimension < 0 || dimension > 3)
            in_.fail_at(where, "the dimension of an entity is " + std::to_string(dimension));
        in_.integer("an entity");
        const bool parametric = in_.integer("whether there are parameters") != 0;
        const std::size_t n = in_.count("the number of nodes in a block", 1, 3);
        for (std::size_t i = 0; i < n; ++i) add_node_number();
        for (std::size_t i = 0; i < n; ++i) {
            read_point();
            for (std::int64_t k = 0; parametric && k < dimension; ++k) in_.any_real("a parameter");
        }
    }
    if (data_.soup.points.size() != total)
        in_.fail_at(start, std::to_string(total) + " nodes are announced, but the blocks hold " +
                               std::to_string(data_.soup.points.size()));
}

const CellKind& Reader::read_kind() {
    const std::size_t where = in_.where();
    const std::int64_t type = in_.integer("the type of an element");
    for (const CellKind& kind : kKinds) {
        if (kind.type != type) continue;
        if (kind.shape == Shape::Volume)
            in_.fail_at(where, std::string("holds ") + kind.name + "; give a surface mesh");
        return kind;
    }
    in_.fail_at(where, "elements of type " + std::to_string(type) + " are not supported");
}

void Reader::read_element(const CellKind& kind, std::int64_t number, const Tags& tags) {
    std::array<int, kMostNodes> nodes;
    for (int i = 0; i < kind.nodes; ++i) {
        const std::size_t where = in_.where();
        const std::int64_t node = in_.tag("a node of an element");
        nodes[static_cast<std::size_t>(i)] = nodes_.find(node);
        if (nodes[static_cast<std::size_t>(i)] < 0)
            in_.fail_at(where, "node " + std::to_string(node) + " is not among the nodes");
    }
    cells_.add(data_.soup, kind, std::span(nodes).first(static_cast<std::size_t>(kind.nodes)));
    tags_of_triangle_.resize(data_.soup.triangles.size(), tags);
    tags_of_edge_.resize(data_.soup.edges.size(), tags);
    if (fields_ == Fields::Read) elements_.add(number);
}

void Reader::read_elements() {
    const std::size_t total = in_.text().count("the number of elements", 7);
    in_.begin_data();
    for (std::size_t done = 0; done < total;) {
        // Text: number, type, tags, nodes. Binary: a header with type, how many and tags; then number, tags, nodes of
        // each.
        const std::size_t where = in_.where();
        std::int64_t number = in_.binary() ? 0 : in_.integer("the number of an element");
        const CellKind& kind = read_kind();
        const std::int64_t n = in_.binary() ? in_.integer("the number of elements that follow") : 1;
        if (n < 1 || n > static_cast<std::int64_t>(total - done))
            in_.fail_at(where,
                        std::to_string(n) + " elements follow, but " + std::to_string(total - done) + " are left");
        const std::int64_t num_tags = in_.integer("the number of tags");
        if (num_tags < 0) in_.fail_at(where, "the number of tags is negative: " + std::to_string(num_tags));
        for (std::int64_t i = 0; i < n; ++i, ++done) {
            if (in_.binary()) number = in_.integer("the number of an element");
            Tags tags;
            for (std::int64_t k = 0; k < num_tags; ++k) {
                const int tag = read_label("a tag");
                if (k == 0 && tag != 0) tags.physical = tag;
                if (k == 1) tags.entity = tag;
            }
            read_element(kind, number, tags);
        }
    }
}

void Reader::read_element_blocks() {
    in_.begin_data();
    const std::size_t start = in_.where();
    const std::size_t blocks = in_.count("the number of blocks", 4, 0),
                      total = in_.count("the number of elements", 2, 0);
    for (const char* what : {"the least number of an element", "the greatest number of an element"}) in_.tag(what);
    for (std::size_t b = 0; b < blocks; ++b) {
        const std::int64_t dimension = in_.integer("the dimension of an entity");
        Tags tags{std::nullopt, read_label("an entity")};
        for (const auto& [of, known] : {std::pair(1, &curves_), std::pair(2, &surfaces_)})
            if (const auto found = known->find(tags.entity); dimension == of && found != known->end())
                tags = found->second;
        const CellKind& kind = read_kind();
        const std::size_t n = in_.count("the number of elements in a block", 2, 0);
        for (std::size_t i = 0; i < n; ++i) {
            const std::int64_t number = in_.tag("the number of an element");
            read_element(kind, number, tags);
        }
    }
    if (cells_.size() != total)
        in_.fail_at(start, std::to_string(total) + " elements are announced, but the blocks hold " +
                               std::to_string(cells_.size()));
}

/// A row of values per thing that has some, not-a-number for the others.
Field Reader::read_field(std::string_view section, const Numbering& rows_of, std::size_t rows) {
    Scanner& text = in_.text();
    Field field;
    const std::size_t strings = text.count("the number of names", 2);
    for (std::size_t i = 0; i < strings; ++i) {
        if (text.at_end()) text.fail_expected("a name");
        std::string_view name = text.line();
        while (!name.empty() && is_space(name.back())) name.remove_suffix(1);
        if (name.size() >= 2 && name.front() == '"' && name.back() == '"') name = name.substr(1, name.size() - 2);
        if (i == 0) field.name = name;
    }
    if (field.name.empty()) field.name = "field";
    const std::size_t reals = text.count("the number of real tags", 1);
    for (std::size_t i = 0; i < reals; ++i) text.real("a real tag");
    text.at_end();
    const char* where = text.position();
    const std::size_t integers = text.count("the number of integer tags", 1);
    if (integers < 3) text.fail_at(where, "expected a step, the number of components and the number of entries");
    text.integer("a step");
    const std::int64_t components = text.integer("the number of components");
    if (components < 1 || components > kMostComponents)
        text.fail_at(where, "the number of components is " + std::to_string(components));
    const std::size_t entries = text.count("the number of entries", 2 * static_cast<std::size_t>(components));
    for (std::size_t i = 3; i < integers; ++i) text.integer("an integer tag");

    field.components = static_cast<int>(components);
    budget_.take(rows * static_cast<std::size_t>(components));
    field.values.assign(rows * static_cast<std::size_t>(components), std::numeric_limits<double>::quiet_NaN());
    in_.begin_data();
    for (std::size_t i = 0; i < entries; ++i) {
        const std::size_t at = in_.where();
        const std::int64_t number = in_.integer("the number of a node or an element");
        const int row = rows_of.find(number);
        if (row < 0)
            in_.fail_at(at, std::string(section.substr(1)) + " is for " + std::to_string(number) +
                                ", which is not in the mesh");
        for (std::int64_t k = 0; k < components; ++k)
            field.values[static_cast<std::size_t>(row * components + k)] = in_.any_real("a value");
    }
    return field;
}

/// A later step of a field replaces an earlier one.
void add_field(std::vector<Field>& fields, Field field) {
    for (Field& other : fields)
        if (other.name == field.name) return static_cast<void>(other = std::move(field));
    fields.push_back(std::move(field));
}

void Reader::read_data(std::string_view section) {
    if (!has_nodes_ || !has_elements_) in_.fail_at(in_.here(), std::string(section) + " comes before the mesh");
    if (section == "$NodeData") {
        add_field(data_.point_fields, read_field(section, nodes_, nodes_.size()));
    } else {
        const Field on_elements = read_field(section, elements_, elements_.size());
        budget_.take(data_.soup.triangles.size() * static_cast<std::size_t>(on_elements.components));
        const Field field = cells_.on_triangles(on_elements);
        const bool all_missing =
            std::all_of(field.values.begin(), field.values.end(), [](double x) { return std::isnan(x); });
        if (!all_missing) add_field(data_.cell_fields, field);
    }
}

/// No labels if nothing tells the faces apart: no physical group, and one entity. Those of edges are groups alone:
/// where one curve of a file ends and another goes on need not be a corner.
void Reader::set_labels() {
    std::vector<int>& edge_labels = data_.soup.edge_labels;
    for (const Tags& tags : tags_of_edge_) edge_labels.push_back(tags.physical.value_or(0));
    drop_if_zero(edge_labels);
    bool any_physical = false, entities = false;
    for (const Tags& tags : tags_of_triangle_) {
        any_physical |= tags.physical.has_value();
        entities |= tags.entity != tags_of_triangle_[0].entity;
    }
    if (!any_physical && !entities) return;
    std::vector<int>& labels = data_.soup.labels;
    for (const Tags& tags : tags_of_triangle_) labels.push_back(tags.physical.value_or(tags.entity));
    drop_if_zero(labels);
}

MeshData Reader::read() {
    in_.read_format();
    while (const std::optional<std::string_view> section = in_.section()) {
        const std::size_t where = in_.here();
        const bool four = in_.version() == 4;
        if (*section == "$Entities" && four) {
            read_entities(Entities::Whole);
        } else if (*section == "$PartitionedEntities" && four) {
            read_entities(Entities::Partitioned);
        } else if (*section == "$Nodes") {
            if (has_nodes_) in_.fail_at(where, "a second $Nodes section");
            has_nodes_ = true;
            four ? read_node_blocks() : read_nodes();
            if (const auto twice = nodes_.sort()) in_.fail_at(where, "node " + std::to_string(*twice) + " comes twice");
        } else if (*section == "$Elements") {
            if (has_elements_ || !has_nodes_)
                in_.fail_at(where, has_nodes_ ? "a second $Elements section" : "$Elements come before $Nodes");
            has_elements_ = true;
            four ? read_element_blocks() : read_elements();
            elements_.sort();  // An element in several physical groups may come several times.
        } else if (fields_ == Fields::Read && (*section == "$NodeData" || *section == "$ElementData")) {
            read_data(*section);
        } else {
            in_.skip_section(*section);
            continue;
        }
        in_.end_section(*section);
    }
    if (!has_nodes_ || !has_elements_) in_.fail_at(in_.where(), has_nodes_ ? "has no $Elements" : "has no $Nodes");
    set_labels();
    cells_.drop_middles(data_);
    return std::move(data_);
}

// Writing
// --------------------------------------------------------------------------------------------------------------

/// A curve or a surface for each label. Its tag is the label if all can be tags; the label is its physical group in any
/// case.
struct Entity {
    int tag;
    std::optional<int> group;
    std::vector<std::size_t> items;  ///< edges or triangles
};

std::vector<Entity> entities_of(std::size_t count, const std::vector<int>& labels) {
    std::map<int, std::vector<std::size_t>> by_label;
    for (std::size_t i = 0; i < count; ++i) by_label[labels.empty() ? 1 : labels[i]].push_back(i);
    const bool labels_are_tags = !by_label.empty() && by_label.begin()->first > 0;
    std::vector<Entity> entities;
    for (auto& [label, items] : by_label) {
        const int tag = labels_are_tags ? label : static_cast<int>(entities.size()) + 1;
        entities.push_back({tag, labels.empty() ? std::nullopt : std::optional(label), std::move(items)});
    }
    return entities;
}

struct Entities {
    std::vector<Entity> curves, surfaces;
};

Entities entities_of(const TriangleSoup& soup) {
    Entities entities{entities_of(soup.edges.size(), soup.edge_labels),
                      entities_of(soup.triangles.size(), soup.labels)};
    // Nodes are on an entity, even if there are no triangles.
    if (entities.surfaces.empty()) entities.surfaces.push_back({1, std::nullopt, {}});
    // Some readers (meshio) want all entities in groups or none.
    if (!soup.labels.empty() || !soup.edge_labels.empty())
        for (auto* list : {&entities.curves, &entities.surfaces})
            for (Entity& entity : *list) entity.group = entity.group.value_or(1);
    return entities;
}

void write_bounds(TextWriter& out, const TriangleSoup& soup, const std::vector<int>& vertices) {
    Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = low;
    if (!vertices.empty()) low = high = soup.points[static_cast<std::size_t>(vertices[0])];
    for (const int v : vertices) {
        low = low.cwiseMin(soup.points[static_cast<std::size_t>(v)]);
        high = high.cwiseMax(soup.points[static_cast<std::size_t>(v)]);
    }
    for (const Eigen::Vector3d& p : {low, high}) out << ' ' << p[0] << ' ' << p[1] << ' ' << p[2];
}

template <class Item>
void write_entity(TextWriter& out, const TriangleSoup& soup, const Entity& entity, const std::vector<Item>& items) {
    std::vector<int> vertices;
    for (const std::size_t i : entity.items) vertices.insert(vertices.end(), items[i].begin(), items[i].end());
    out << entity.tag;
    write_bounds(out, soup, vertices);
    if (entity.group)
        out << " 1 " << *entity.group << " 0\n";
    else
        out << " 0 0\n";
}

void write_entities(TextWriter& out, const TriangleSoup& soup, const Entities& entities) {
    out << "$Entities\n0 " << entities.curves.size() << ' ' << entities.surfaces.size() << " 0\n";
    for (const Entity& curve : entities.curves) write_entity(out, soup, curve, soup.edges);
    for (const Entity& surface : entities.surfaces) write_entity(out, soup, surface, soup.triangles);
    out << "$EndEntities\n";
}

void write_nodes(TextWriter& out, const TriangleSoup& soup, const Entity& surface) {
    const std::size_t n = soup.points.size();
    out << "$Nodes\n" << (n == 0 ? 0 : 1) << ' ' << n << ' ' << (n == 0 ? 0 : 1) << ' ' << n << '\n';
    if (n > 0) out << "2 " << surface.tag << " 0 " << n << '\n';
    for (std::size_t i = 1; i <= n; ++i) out << i << '\n';
    for (const Eigen::Vector3d& p : soup.points) out << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
    out << "$EndNodes\n";
}

/// Elements are numbered as the triangles of the soup; edges come behind.
void write_elements(TextWriter& out, const TriangleSoup& soup, const Entities& entities) {
    const std::size_t total = soup.edges.size() + soup.triangles.size();
    const std::size_t blocks = entities.curves.size() + (soup.triangles.empty() ? 0 : entities.surfaces.size());
    out << "$Elements\n" << blocks << ' ' << total << ' ' << (total == 0 ? 0 : 1) << ' ' << total << '\n';
    for (const Entity& curve : entities.curves) {
        out << "1 " << curve.tag << " 1 " << curve.items.size() << '\n';
        for (const std::size_t e : curve.items)
            out << soup.triangles.size() + e + 1 << ' ' << soup.edges[e][0] + 1 << ' ' << soup.edges[e][1] + 1 << '\n';
    }
    for (const Entity& surface : entities.surfaces) {
        if (surface.items.empty()) continue;
        out << "2 " << surface.tag << " 2 " << surface.items.size() << '\n';
        for (const std::size_t t : surface.items) {
            const auto& [a, b, c] = soup.triangles[t];
            out << t + 1 << ' ' << a + 1 << ' ' << b + 1 << ' ' << c + 1 << '\n';
        }
    }
    out << "$EndElements\n";
}

}  // namespace

MeshData parse_msh(const std::string& path, std::string_view contents, Fields fields) {
    return Reader(path, contents, fields).read();
}

namespace {

/// Head of a section of values.
void begin_data(TextWriter& out, std::string_view section, std::string_view name, int components, std::size_t count) {
    std::string line(name);
    std::replace_if(
        line.begin(), line.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
    out << '$' << section << "\n1\n\"" << line << "\"\n1\n0\n3\n0\n" << components << '\n' << count << '\n';
}

void write_row(TextWriter& out, std::size_t number, std::span<const double> values) {
    out << number;
    for (const double x : values) out << ' ' << x;
    out << '\n';
}

void write_node_data(TextWriter& out, std::string_view name, int components, std::span<const double> values) {
    const auto n = static_cast<std::size_t>(components);
    begin_data(out, "NodeData", name, components, values.size() / n);
    for (std::size_t i = 0; i < values.size() / n; ++i) write_row(out, i + 1, values.subspan(i * n, n));
    out << "$EndNodeData\n";
}

/// In the order of write_elements, edges too: some readers (meshio) pass over the numbers.
void write_element_data(TextWriter& out, const TriangleSoup& soup, const Entities& entities, const Field& field) {
    const auto n = static_cast<std::size_t>(field.components);
    begin_data(out, "ElementData", field.name, field.components, soup.edges.size() + soup.triangles.size());
    const std::vector<double> none(n, std::numeric_limits<double>::quiet_NaN());
    for (const Entity& curve : entities.curves)
        for (const std::size_t e : curve.items) write_row(out, soup.triangles.size() + e + 1, none);
    for (const Entity& surface : entities.surfaces)
        for (const std::size_t t : surface.items) write_row(out, t + 1, std::span(field.values).subspan(t * n, n));
    out << "$EndElementData\n";
}

}  // namespace

std::string msh_text(const TriangleSoup& soup) { return msh_text(MeshData{soup}); }

std::string msh_text(const MeshData& data) {
    const TriangleSoup& soup = data.soup;
    TextWriter out(80 * soup.points.size() + 40 * soup.triangles.size() + 40 * soup.edges.size() + 1024);
    const Entities entities = entities_of(soup);
    out << "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
    write_entities(out, soup, entities);
    write_nodes(out, soup, entities.surfaces.front());
    write_elements(out, soup, entities);
    for (const Field& field : data.point_fields) write_node_data(out, field.name, field.components, field.values);
    for (const Field& field : cell_fields_of(data)) write_element_data(out, soup, entities, field);
    return out.take();
}

std::string msh_node_data(std::string_view name, std::span<const double> values) {
    TextWriter out(32 * values.size() + 128);
    write_node_data(out, name, 1, values);
    return out.take();
}

}  // namespace gradus::io
