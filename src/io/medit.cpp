// Medit's format, text and binary. The grammar and the keyword numbers are those of libMeshb; sections are read by one
// set of functions from either kind of source.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "bytes.hpp"
#include "formats.hpp"
#include "gradus/mesh/edge.hpp"
#include "scanner.hpp"
#include "text_writer.hpp"

namespace gradus::io {
namespace {

enum class Keyword : int {
    Dimension = 3,
    Vertices = 4,
    Edges = 5,
    Triangles = 6,
    Quadrilaterals = 7,
    Corners = 13,
    Ridges = 14,
    RequiredVertices = 15,
    RequiredEdges = 16,
    RequiredTriangles = 17,
    VerticesOnGeometricTriangles = 42,
    End = 54,
    SolAtVertices = 62
};

constexpr std::string_view kParametersName = "VerticesOnGeometricTriangles";

constexpr std::pair<std::string_view, Keyword> kKeywords[] = {
    {"Dimension", Keyword::Dimension},
    {"Vertices", Keyword::Vertices},
    {"Edges", Keyword::Edges},
    {"Triangles", Keyword::Triangles},
    {"Quadrilaterals", Keyword::Quadrilaterals},
    {"Corners", Keyword::Corners},
    {"Ridges", Keyword::Ridges},
    {"RequiredVertices", Keyword::RequiredVertices},
    {"RequiredEdges", Keyword::RequiredEdges},
    {"RequiredTriangles", Keyword::RequiredTriangles},
    {kParametersName, Keyword::VerticesOnGeometricTriangles},
    {"End", Keyword::End},
    {"SolAtVertices", Keyword::SolAtVertices},
};

// Sources: text and binary
// ---------------------------------------------------------------------------------------------

bool starts_keyword(std::string_view word) {
    std::string start(word.substr(0, 3));
    for (char& c : start) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return !word.empty() && std::isalpha(static_cast<unsigned char>(word[0])) && start != "nan" && start != "inf";
}

class TextSource {
  public:
    using Where = const char*;

    TextSource(const std::string& path, std::string_view text) : in_(path, text, '#') {
        const Where start = in_.position();
        if (in_.peek() != "MeshVersionFormatted")
            in_.fail_at(start, "is not a Medit file: expected MeshVersionFormatted, found " + quoted(in_.peek()));
        in_.word("MeshVersionFormatted");
        const std::int64_t version = in_.integer("the version");
        if (version < 0 || version > 4) in_.fail("unknown version " + std::to_string(version));
    }

    /// The next keyword of interest; other sections are passed over. Nothing at the end.
    std::optional<Keyword> keyword() {
        while (!ended_ && !in_.at_end()) {
            const Where start = in_.position();
            const std::string_view word = in_.word("a keyword");
            if (!starts_keyword(word))
                in_.fail_at(start, "expected a keyword, found " + quoted(word) + " (more entries than announced?)");
            for (const auto& [name, keyword] : kKeywords)
                if (word == name) return keyword == Keyword::End ? keyword_after_end() : std::optional(keyword);
            skip_section();
        }
        return std::nullopt;
    }

    Where where() {
        in_.at_end();
        return in_.position();
    }
    double real(const char* what) { return in_.real(what); }
    double real_or_inf(const char* what) { return in_.real_or_inf(what); }
    double any_real(const char* what) { return in_.any_real(what); }
    std::int64_t integer(const char* what) { return in_.integer(what); }
    std::size_t count(const char* what, std::size_t reals, std::size_t integers) {
        return in_.count(what, 2 * (reals + integers) - 1);
    }
    [[noreturn]] void fail_at(Where where, const std::string& what) const { in_.fail_at(where, what); }

  private:
    /// The section that medit_text writes as comments; whatever else follows the end is not part of the file.
    std::optional<Keyword> keyword_after_end() {
        ended_ = true;
        in_.read_comments();
        if (in_.peek() != kParametersName) return std::nullopt;
        in_.word("a keyword");
        return Keyword::VerticesOnGeometricTriangles;
    }

    void skip_section() {
        while (!in_.at_end() && !starts_keyword(in_.peek())) {
            const std::string_view word = in_.word("a value");
            if (word[0] != '"' || (word.size() > 1 && word.back() == '"')) continue;
            while (!in_.at_end() && in_.word("a value").back() != '"') {
            }
        }
    }

    Scanner in_;
    bool ended_ = false;
};

class BinarySource {
  public:
    using Where = std::size_t;

    BinarySource(const std::string& path, std::string_view bytes) : in_(path, bytes) {
        const auto code = in_.get<std::int32_t>("the code 1 of a binary Medit file");
        if (code == 0x01000000) in_.swap_bytes();
        if (code != 1 && code != 0x01000000)
            in_.fail_at(0, "is not a binary Medit file: expected the code 1, found " + std::to_string(code));
        version_ = in_.get<std::int32_t>("the version");
        if (version_ < 1 || version_ > 4) in_.fail_at(4, "unknown version " + std::to_string(version_));
        next_ = in_.offset();
    }

    std::optional<Keyword> keyword() {
        while (true) {
            if (read_ && in_.offset() != next_)
                in_.fail("the section ends at byte " + std::to_string(next_) + ", which does not agree with its count");
            in_.seek(next_, "a keyword");
            if (in_.remaining() == 0) return std::nullopt;
            const std::size_t start = in_.offset();
            const auto keyword = in_.get<std::int32_t>("a keyword");
            if (keyword == static_cast<int>(Keyword::End)) return std::nullopt;
            const std::int64_t next = version_ < 3 ? in_.get<std::int32_t>("the end of a section")
                                                   : in_.get<std::int64_t>("the end of a section");
            if (next <= static_cast<std::int64_t>(start))
                in_.fail_at(start, "the section ends before it starts, at byte " + std::to_string(next));
            next_ = static_cast<std::size_t>(next);
            const auto* known = std::find_if(std::begin(kKeywords), std::end(kKeywords), [&](const auto& entry) {
                return static_cast<int>(entry.second) == keyword;
            });
            read_ = known != std::end(kKeywords);
            if (read_) return known->second;
        }
    }

    Where where() const { return in_.offset(); }
    double real_or_inf(const char* what) {
        return version_ == 1 ? static_cast<double>(in_.get<float>(what)) : in_.get<double>(what);
    }
    double any_real(const char* what) { return real_or_inf(what); }
    double real(const char* what) {
        const Where start = where();
        const double value = real_or_inf(what);
        if (!std::isfinite(value))
            in_.fail_at(start, std::string("expected ") + what + ", found a number that is not finite");
        return value;
    }
    std::int64_t integer(const char* what) {
        return version_ < 4 ? in_.get<std::int32_t>(what) : in_.get<std::int64_t>(what);
    }
    /// The dimension is a single word in all versions.
    std::int64_t word(const char* what) { return in_.get<std::int32_t>(what); }
    std::size_t count(const char* what, std::size_t reals, std::size_t integers) {
        const std::int64_t value = integer(what);
        in_.check_count(static_cast<std::uint64_t>(value),
                        reals * (version_ == 1 ? 4 : 8) + integers * (version_ < 4 ? 4 : 8), what);
        return static_cast<std::size_t>(value);
    }
    [[noreturn]] void fail_at(Where where, const std::string& what) const { in_.fail_at(where, what); }

  private:
    ByteReader in_;
    int version_ = 0;
    std::size_t next_ = 0;  ///< where the section ends
    bool read_ = false;     ///< whether the section was read, not passed over
};

std::int64_t read_dimension_number(TextSource& in) { return in.integer("the dimension"); }
std::int64_t read_dimension_number(BinarySource& in) { return in.word("the dimension"); }

template <class Source>
int read_dimension(Source& in) {
    const auto where = in.where();
    const std::int64_t dimension = read_dimension_number(in);
    if (dimension != 2 && dimension != 3)
        in.fail_at(where, "the dimension is " + std::to_string(dimension) + ", but must be 2 or 3");
    return static_cast<int>(dimension);
}

// Sections
// -------------------------------------------------------------------------------------------------------------

/// Sections come in any order, so indices are compared with the number of entries when all is read.
template <class Source>
class IndexReader {
  public:
    explicit IndexReader(const char* what) : what_(what) {}

    int read(Source& in) {
        const auto where = in.where();
        const std::int64_t index = in.integer(what_);
        if (index < 1 || index > std::numeric_limits<int>::max())
            in.fail_at(where, message(index) + "; indices start at 1");
        if (index > largest_) {
            largest_ = index;
            where_ = where;
        }
        return static_cast<int>(index) - 1;
    }

    void check(const Source& in, std::size_t count) const {
        if (largest_ > static_cast<std::int64_t>(count))
            in.fail_at(where_, message(largest_) + "; there are " + std::to_string(count));
    }

  private:
    std::string message(std::int64_t index) const {
        return std::string("index out of range: ") + what_ + " " + std::to_string(index);
    }

    const char* what_;
    std::int64_t largest_ = 0;
    typename Source::Where where_{};
};

template <class Source>
struct Reading {
    explicit Reading(Source& source) : in(source) {}

    Source& in;
    TriangleSoup soup;
    int dimension = 3;
    bool has_vertices = false;
    bool has_triangles = false;
    IndexReader<Source> vertex{"vertex"};
    IndexReader<Source> edge{"edge"};
    IndexReader<Source> triangle{"triangle"};
    std::vector<int> ridges, required_edges;  // entries of soup.edges
    std::vector<int> required_triangles;      // entries under Triangles, which quadrilaterals may come between
    std::vector<std::array<std::size_t, 2>>
        triangle_sections;  // entries before each, and triangles of the soup before it
    std::size_t num_triangle_entries = 0;
};

template <class Source>
int read_reference(Source& in) {
    const auto where = in.where();
    const std::int64_t reference = in.integer("a reference");
    if (reference != static_cast<int>(reference))
        in.fail_at(where, "reference out of range: " + std::to_string(reference));
    return static_cast<int>(reference);
}

template <class Source>
void read_vertices(Reading<Source>& r) {
    const auto where = r.in.where();
    if (r.has_vertices) r.in.fail_at(where, "a second Vertices section");
    r.has_vertices = true;
    const std::size_t n = r.in.count("the number of vertices", static_cast<std::size_t>(r.dimension), 1);
    r.soup.points.resize(n, Eigen::Vector3d::Zero());
    for (Eigen::Vector3d& point : r.soup.points) {
        for (int i = 0; i < r.dimension; ++i) point[i] = r.in.real("a coordinate");
        read_reference(r.in);
    }
}

template <class Source>
void read_triangles(Reading<Source>& r) {
    r.has_triangles = true;
    const std::size_t n = r.in.count("the number of triangles", 0, 4);
    r.triangle_sections.push_back({r.num_triangle_entries, r.soup.triangles.size()});
    r.num_triangle_entries += n;
    r.soup.triangles.reserve(r.soup.triangles.size() + n);
    r.soup.labels.reserve(r.soup.labels.size() + n);
    for (std::size_t i = 0; i < n; ++i) {
        Triangle triangle;
        for (int& vertex : triangle) vertex = r.vertex.read(r.in);
        r.soup.triangles.push_back(triangle);
        r.soup.labels.push_back(read_reference(r.in));
    }
}

template <class Source>
void read_quadrilaterals(Reading<Source>& r) {
    r.has_triangles = true;
    const std::size_t n = r.in.count("the number of quadrilaterals", 0, 5);
    for (std::size_t i = 0; i < n; ++i) {
        std::array<int, 4> q;
        for (int& vertex : q) vertex = r.vertex.read(r.in);
        r.soup.triangles.push_back({q[0], q[1], q[2]});
        r.soup.triangles.push_back({q[0], q[2], q[3]});
        r.soup.labels.insert(r.soup.labels.end(), 2, read_reference(r.in));
    }
}

template <class Source>
void read_edges(Reading<Source>& r) {
    const std::size_t n = r.in.count("the number of edges", 0, 3);
    for (std::size_t i = 0; i < n; ++i) {
        std::array<int, 2> edge;
        for (int& vertex : edge) vertex = r.vertex.read(r.in);
        r.soup.edges.push_back(edge);
        r.soup.edge_labels.push_back(read_reference(r.in));
    }
}

template <class Source>
void read_numbers(Reading<Source>& r, IndexReader<Source>& index, const char* what, std::vector<int>& numbers) {
    const std::size_t n = r.in.count(what, 0, 1);
    for (std::size_t i = 0; i < n; ++i) numbers.push_back(index.read(r.in));
}

// A planar domain is drawn by its edges alone.
template <class Source>
bool is_domain(const Reading<Source>& r) {
    return r.dimension == 2 && !r.has_triangles && !r.soup.edges.empty();
}

// Entries of Edges that are required, and those that are features: all but those that are only required.
template <class Source>
void divide_edges(Reading<Source>& r) {
    if (r.required_edges.empty()) return;
    std::vector<char> is_feature(r.soup.edges.size(), 1);
    for (const int e : r.required_edges) {
        is_feature[e] = 0;
        r.soup.required.edges.push_back(r.soup.edges[e]);
    }
    for (const int e : r.ridges) is_feature[e] = 1;
    if (is_domain(r)) return;
    std::size_t kept = 0;
    for (std::size_t e = 0; e < is_feature.size(); ++e) {
        if (!is_feature[e]) continue;
        r.soup.edge_labels[kept] = r.soup.edge_labels[e];
        r.soup.edges[kept++] = r.soup.edges[e];
    }
    r.soup.edges.resize(kept);
    r.soup.edge_labels.resize(kept);
}

template <class Source>
void number_required_triangles(Reading<Source>& r) {
    for (const int entry : r.required_triangles) {
        auto section = r.triangle_sections.size();
        while (r.triangle_sections[--section][0] > static_cast<std::size_t>(entry)) continue;
        const auto [entries, triangles] = r.triangle_sections[section];
        r.soup.required.triangles.push_back(static_cast<int>(triangles + static_cast<std::size_t>(entry) - entries));
    }
}

template <class Source>
void read_parameters(Reading<Source>& r) {
    const std::size_t n = r.in.count("the number of vertices on geometric triangles", 3, 2);
    for (std::size_t i = 0; i < n; ++i) {
        TriangleSoup::Parameters entry;
        entry.vertex = r.vertex.read(r.in);
        // The patches are not in the file, so there is no count to compare with.
        entry.at.patch = IndexReader<Source>("patch").read(r.in);
        entry.at.uv[0] = r.in.real("u");
        entry.at.uv[1] = r.in.real("v");
        r.in.real("a distance");
        r.soup.parameters.push_back(entry);
    }
}

template <class Source>
TriangleSoup parse(Source in) {
    Reading<Source> r(in);
    while (const std::optional<Keyword> keyword = in.keyword()) {
        switch (*keyword) {
            case Keyword::Dimension:
                r.dimension = read_dimension(in);
                break;
            case Keyword::Vertices:
                read_vertices(r);
                break;
            case Keyword::Triangles:
                read_triangles(r);
                break;
            case Keyword::Quadrilaterals:
                read_quadrilaterals(r);
                break;
            case Keyword::Edges:
                read_edges(r);
                break;
            case Keyword::Ridges:
                read_numbers(r, r.edge, "the number of ridges", r.ridges);
                break;
            case Keyword::Corners:
                read_numbers(r, r.vertex, "the number of corners", r.soup.corners);
                break;
            case Keyword::RequiredVertices:
                read_numbers(r, r.vertex, "the number of required vertices", r.soup.required.vertices);
                break;
            case Keyword::RequiredEdges:
                read_numbers(r, r.edge, "the number of required edges", r.required_edges);
                break;
            case Keyword::RequiredTriangles:
                read_numbers(r, r.triangle, "the number of required triangles", r.required_triangles);
                break;
            case Keyword::VerticesOnGeometricTriangles:
                read_parameters(r);
                break;
            case Keyword::SolAtVertices:
                in.fail_at(in.where(), "holds sizes, not a mesh (SolAtVertices)");
            case Keyword::End:
                break;
        }
    }
    if (!r.has_vertices) in.fail_at(in.where(), "has no Vertices");
    if (!r.has_triangles && !is_domain(r))
        in.fail_at(in.where(), r.dimension == 2 ? "has no Triangles, Quadrilaterals or Edges"
                                                : "has no Triangles or Quadrilaterals");
    r.vertex.check(in, r.soup.points.size());
    r.edge.check(in, r.soup.edges.size());
    r.triangle.check(in, r.num_triangle_entries);
    divide_edges(r);
    number_required_triangles(r);
    drop_if_zero(r.soup.labels);
    drop_if_zero(r.soup.edge_labels);
    r.soup.dimension = r.dimension;
    return std::move(r.soup);
}

TriangleSoup with_triangles(const std::string& path, TriangleSoup soup) {
    if (soup.dimension == 3 || !soup.triangles.empty()) return soup;
    PlanarGraph graph;
    for (const Eigen::Vector3d& p : soup.points) graph.points.emplace_back(p.x(), p.y());
    graph.segments = std::move(soup.edges);
    graph.labels = std::move(soup.edge_labels);
    graph.corners = std::move(soup.corners);
    graph.required = std::move(soup.required);
    graph.first_number = 1;
    return triangulated(path, graph);
}

/// The values under SolAtVertices, after the count: the number of fields and the kind of each.
template <class Source>
std::vector<double> read_size_values(Source& in, std::size_t count, std::optional<std::size_t> expected_count,
                                     typename Source::Where where) {
    if (expected_count && count != *expected_count)
        in.fail_at(where, "holds " + std::to_string(count) + " sizes, but " + std::to_string(*expected_count) +
                              " are expected, one per vertex");
    const auto kind = in.where();
    const std::int64_t fields = in.integer("the number of fields");
    const std::int64_t type = fields == 1 ? in.integer("the kind of the field") : 0;
    if (fields != 1 || type != 1) in.fail_at(kind, "expected one scalar per vertex (1 1), found other fields");
    std::vector<double> sizes(count);
    for (double& size : sizes) {
        const auto start = in.where();
        size = in.real_or_inf("a size");
        if (!(size > 0)) in.fail_at(start, "a size must be > 0, found " + std::to_string(size));
    }
    return sizes;
}

template <class Source>
std::vector<double> parse_sizes(Source in, std::optional<std::size_t> expected_count) {
    std::optional<std::vector<double>> sizes;
    while (const std::optional<Keyword> keyword = in.keyword()) {
        const auto where = in.where();
        if (*keyword == Keyword::Dimension) {
            read_dimension(in);
        } else if (*keyword == Keyword::SolAtVertices) {
            if (sizes) in.fail_at(where, "a second SolAtVertices section");
            const std::size_t count = in.count("the number of sizes", 1, 0);
            sizes = read_size_values(in, count, expected_count, where);
        } else {
            in.fail_at(where, "holds a mesh, not sizes");
        }
    }
    if (!sizes) in.fail_at(in.where(), "has no SolAtVertices");
    return *sizes;
}

/// Numbers per vertex of a kind of field; 0: unknown.
int components_of(std::int64_t kind, int dimension) {
    switch (kind) {
        case 1:
            return 1;
        case 2:
            return dimension;
        case 3:
            return dimension * (dimension + 1) / 2;
        case 4:
            return dimension * dimension;
        default:
            return 0;
    }
}

constexpr double kMostAspect = 1e6;  // of the sizes of a metric

/// One metric per vertex, of symmetric matrices or of sizes.
template <class Source>
std::vector<Tensor> read_metric_values(Source& in, std::size_t count, int dimension) {
    const auto at = in.where();
    const std::int64_t fields = in.integer("the number of fields");
    const std::int64_t kind = fields == 1 ? in.integer("the kind of the field") : 0;
    if (fields != 1 || (kind != 1 && kind != 3))
        in.fail_at(at, "expected one symmetric matrix (1 3) or one size (1 1) per vertex, found other fields");
    std::vector<Tensor> metrics;
    for (std::size_t v = 0; v < count; ++v) {
        const auto where = in.where();
        const auto fail = [&](const std::string& what) {
            in.fail_at(where, "the metric of vertex " + std::to_string(v + 1) + " " + what);
        };
        Tensor metric;
        if (kind == 1) {
            const double h = in.any_real("a size");
            if (!(h > 0) || !std::isfinite(h)) fail("is of a size that is not > 0");
            metric = round_metric(h);
        } else {
            for (int k = 0; k < components_of(kind, dimension); ++k) metric.v[k] = in.any_real("an entry of a metric");
            if (dimension == 2) metric = planar_tensor(metric.v[0], metric.v[1], metric.v[2]);
        }
        if (!is_positive_definite(metric)) fail("is not positive definite");
        const Eigen::Vector3d values = axes_of(metric).values;
        if (!(std::sqrt(values[2] / values[0]) <= kMostAspect))
            fail("has one size that is more than 1e6 times another");
        metrics.push_back(metric);
    }
    return metrics;
}

template <class Source>
std::vector<Tensor> parse_metrics_of(Source in, std::optional<std::size_t> expected_count) {
    std::optional<std::vector<Tensor>> metrics;
    int dimension = 3;
    while (const std::optional<Keyword> keyword = in.keyword()) {
        const auto where = in.where();
        if (*keyword == Keyword::Dimension) {
            dimension = read_dimension(in);
        } else if (*keyword == Keyword::SolAtVertices) {
            if (metrics) in.fail_at(where, "a second SolAtVertices section");
            const std::size_t count = in.count("the number of metrics", 1, 0);
            if (expected_count && count != *expected_count)
                in.fail_at(where, "holds " + std::to_string(count) + " metrics, but " +
                                      std::to_string(*expected_count) + " are expected, one per vertex");
            metrics = read_metric_values(in, count, dimension);
        } else {
            in.fail_at(where, "holds a mesh, not metrics");
        }
    }
    if (!metrics) in.fail_at(in.where(), "has no SolAtVertices");
    return *metrics;
}

template <class Source>
std::vector<Field> read_fields(Source& in, std::size_t count, int dimension) {
    const auto where = in.where();
    const std::int64_t number = in.integer("the number of fields");
    if (number < 1) in.fail_at(where, "the number of fields is " + std::to_string(number));
    std::vector<Field> fields;
    for (std::int64_t i = 0; i < number; ++i) {
        const auto at = in.where();
        const std::int64_t kind = in.integer("the kind of a field");
        const int components = components_of(kind, dimension);
        if (components == 0)
            in.fail_at(at, "unknown kind of a field: " + std::to_string(kind) +
                               "; known are 1 scalar, 2 vector, 3 symmetric matrix, 4 matrix");
        fields.push_back({"", components});
    }
    // Memory grows with what is read: counts alone may promise more than the file holds.
    for (std::size_t v = 0; v < count; ++v)
        for (Field& field : fields)
            for (int k = 0; k < field.components; ++k) field.values.push_back(in.any_real("a value"));
    return fields;
}

template <class Source>
std::vector<Field> parse_fields(Source in, std::optional<std::size_t> expected_count) {
    std::optional<std::vector<Field>> fields;
    int dimension = 3;
    while (const std::optional<Keyword> keyword = in.keyword()) {
        const auto where = in.where();
        if (*keyword == Keyword::Dimension) {
            dimension = read_dimension(in);
        } else if (*keyword == Keyword::SolAtVertices) {
            if (fields) in.fail_at(where, "a second SolAtVertices section");
            const std::size_t count = in.count("the number of vertices", 1, 0);
            if (expected_count && count != *expected_count)
                in.fail_at(where, "holds values at " + std::to_string(count) + " vertices, but the mesh has " +
                                      std::to_string(*expected_count));
            fields = read_fields(in, count, dimension);
        } else {
            in.fail_at(where, "holds a mesh, not a solution");
        }
    }
    if (!fields) in.fail_at(in.where(), "has no SolAtVertices");
    return *fields;
}

// Writing
// --------------------------------------------------------------------------------------------------------------

std::string_view header_of(int dimension) {
    return dimension == 2 ? "MeshVersionFormatted 2\nDimension 2\n" : "MeshVersionFormatted 2\nDimension 3\n";
}

int label_of(const TriangleSoup& soup, std::size_t triangle) { return soup.labels.empty() ? 0 : soup.labels[triangle]; }
int edge_label_of(const TriangleSoup& soup, std::size_t edge) {
    return edge < soup.edge_labels.size() ? soup.edge_labels[edge] : 0;
}

/// Sections of a binary file. Each starts with its keyword and the byte where it ends.
class BinarySections {
  public:
    BinarySections(int version, std::size_t expected, int dimension) : version_(version) {
        bytes_.reserve(expected);
        append_bytes(bytes_, std::int32_t{1});
        append_bytes(bytes_, std::int32_t{version});
        begin(Keyword::Dimension, 4);
        integer(dimension);
    }

    /// @param size  bytes of the section after its start
    void begin(Keyword keyword, std::size_t size) {
        append_bytes(bytes_, static_cast<std::int32_t>(keyword));
        position(keyword == Keyword::End ? 0 : bytes_.size() + position_size() + size);
    }
    void begin_entries(Keyword keyword, std::size_t count, std::size_t entry_size, std::size_t extra = 0) {
        begin(keyword, 4 + extra + count * entry_size);
        integer(static_cast<int>(count));
    }
    void integer(int value) { append_bytes(bytes_, static_cast<std::int32_t>(value)); }
    void real(double value) { append_bytes(bytes_, value); }

    std::string take() {
        begin(Keyword::End, 0);
        return std::move(bytes_);
    }

  private:
    std::size_t position_size() const { return version_ < 3 ? 4 : 8; }
    void position(std::size_t value) {
        if (version_ < 3)
            append_bytes(bytes_, static_cast<std::int32_t>(value));
        else
            append_bytes(bytes_, static_cast<std::int64_t>(value));
    }

    std::string bytes_;
    int version_;
};

/// Version 2 has 32-bit positions, so larger files need version 3.
int version_for(std::size_t bytes) { return bytes < (std::size_t{1} << 31) ? 2 : 3; }

}  // namespace

TriangleSoup parse_medit(const std::string& path, std::string_view text) {
    return with_triangles(path, parse(TextSource(path, text)));
}
TriangleSoup parse_medit_binary(const std::string& path, std::string_view bytes) {
    return with_triangles(path, parse(BinarySource(path, bytes)));
}

std::vector<double> parse_sol(const std::string& path, std::string_view text,
                              std::optional<std::size_t> expected_count) {
    return parse_sizes(TextSource(path, text), expected_count);
}
std::vector<double> parse_sol_binary(const std::string& path, std::string_view bytes,
                                     std::optional<std::size_t> expected_count) {
    return parse_sizes(BinarySource(path, bytes), expected_count);
}

std::vector<Field> parse_solution(const std::string& path, std::string_view text,
                                  std::optional<std::size_t> expected_count) {
    return parse_fields(TextSource(path, text), expected_count);
}
std::vector<Field> parse_solution_binary(const std::string& path, std::string_view bytes,
                                         std::optional<std::size_t> expected_count) {
    return parse_fields(BinarySource(path, bytes), expected_count);
}

namespace {

/// The sections of edges: features first, then what is required and no feature.
struct EdgeSections {
    std::vector<std::array<int, 2>> edges;
    std::vector<int> required;  ///< entries of edges

    explicit EdgeSections(const TriangleSoup& soup) : edges(soup.edges) {
        if (soup.required.edges.empty()) return;
        std::map<std::array<int, 2>, int> entry;
        for (std::size_t e = 0; e < edges.size(); ++e)
            entry.emplace(edge_between(edges[e][0], edges[e][1]), static_cast<int>(e));
        for (const auto& edge : soup.required.edges) {
            const auto [at, is_new] = entry.emplace(edge_between(edge[0], edge[1]), static_cast<int>(edges.size()));
            if (is_new) edges.push_back(edge);
            required.push_back(at->second);
        }
    }
};

}  // namespace

std::string medit_text(const TriangleSoup& soup) {
    const EdgeSections sections(soup);
    TextWriter out(64 * soup.points.size() + 32 * soup.triangles.size() + 64 * soup.parameters.size() + 256);
    out << header_of(soup.dimension) << "\nVertices\n" << soup.points.size() << '\n';
    for (const Eigen::Vector3d& p : soup.points) {
        out << p[0] << ' ' << p[1];
        if (soup.dimension == 3) out << ' ' << p[2];
        out << " 0\n";
    }
    const auto write_numbers = [&](const char* keyword, const std::vector<int>& numbers) {
        if (numbers.empty()) return;
        out << '\n' << keyword << '\n' << numbers.size() << '\n';
        for (const int number : numbers) out << number + 1 << '\n';
    };
    write_numbers("Corners", soup.corners);
    write_numbers("RequiredVertices", soup.required.vertices);
    if (!sections.edges.empty()) {
        out << "\nEdges\n" << sections.edges.size() << '\n';
        for (std::size_t e = 0; e < sections.edges.size(); ++e)
            out << sections.edges[e][0] + 1 << ' ' << sections.edges[e][1] + 1 << ' ' << edge_label_of(soup, e) << '\n';
    }
    if (!soup.edges.empty()) {
        out << "\nRidges\n" << soup.edges.size() << '\n';
        for (std::size_t e = 1; e <= soup.edges.size(); ++e) out << e << '\n';
    }
    write_numbers("RequiredEdges", sections.required);
    out << "\nTriangles\n" << soup.triangles.size() << '\n';
    for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
        const auto& [a, b, c] = soup.triangles[t];
        out << a + 1 << ' ' << b + 1 << ' ' << c + 1 << ' ' << label_of(soup, t) << '\n';
    }
    write_numbers("RequiredTriangles", soup.required.triangles);
    out << "\nEnd\n";
    // As comments: meshio, for one, refuses a text file with a keyword it does not know, even behind the end.
    if (!soup.parameters.empty()) {
        out << "\n# " << kParametersName << "\n# " << soup.parameters.size() << '\n';
        for (const auto& [vertex, at] : soup.parameters)
            out << "# " << vertex + 1 << ' ' << at.patch + 1 << ' ' << at.uv[0] << ' ' << at.uv[1] << " 0\n";
    }
    return out.take();
}

std::string medit_binary(const TriangleSoup& soup) {
    const EdgeSections sections(soup);
    const RequiredElements& required = soup.required;
    const std::size_t size = 256 + 28 * soup.points.size() + 4 * soup.corners.size() + 16 * sections.edges.size() +
                             16 * soup.triangles.size() + 32 * soup.parameters.size() +
                             4 * (required.vertices.size() + required.edges.size() + required.triangles.size());
    BinarySections out(version_for(size), size, soup.dimension);
    out.begin_entries(Keyword::Vertices, soup.points.size(), soup.dimension == 2 ? 20 : 28);
    for (const Eigen::Vector3d& p : soup.points) {
        for (int i = 0; i < soup.dimension; ++i) out.real(p[i]);
        out.integer(0);
    }
    const auto write_numbers = [&](Keyword keyword, const std::vector<int>& numbers) {
        if (numbers.empty()) return;
        out.begin_entries(keyword, numbers.size(), 4);
        for (const int number : numbers) out.integer(number + 1);
    };
    write_numbers(Keyword::Corners, soup.corners);
    write_numbers(Keyword::RequiredVertices, required.vertices);
    if (!sections.edges.empty()) {
        out.begin_entries(Keyword::Edges, sections.edges.size(), 12);
        for (std::size_t e = 0; e < sections.edges.size(); ++e) {
            for (const int v : sections.edges[e]) out.integer(v + 1);
            out.integer(edge_label_of(soup, e));
        }
    }
    if (!soup.edges.empty()) {
        out.begin_entries(Keyword::Ridges, soup.edges.size(), 4);
        for (std::size_t e = 1; e <= soup.edges.size(); ++e) out.integer(static_cast<int>(e));
    }
    write_numbers(Keyword::RequiredEdges, sections.required);
    out.begin_entries(Keyword::Triangles, soup.triangles.size(), 16);
    for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
        for (const int vertex : soup.triangles[t]) out.integer(vertex + 1);
        out.integer(label_of(soup, t));
    }
    write_numbers(Keyword::RequiredTriangles, required.triangles);
    if (!soup.parameters.empty()) {
        out.begin_entries(Keyword::VerticesOnGeometricTriangles, soup.parameters.size(), 32);
        for (const auto& [vertex, at] : soup.parameters) {
            out.integer(vertex + 1);
            out.integer(at.patch + 1);
            out.real(at.uv[0]);
            out.real(at.uv[1]);
            out.real(0);
        }
    }
    return out.take();
}

std::vector<Tensor> parse_metrics(const std::string& path, std::string_view text,
                                  std::optional<std::size_t> expected_count) {
    return parse_metrics_of(TextSource(path, text), expected_count);
}
std::vector<Tensor> parse_metrics_binary(const std::string& path, std::string_view bytes,
                                         std::optional<std::size_t> expected_count) {
    return parse_metrics_of(BinarySource(path, bytes), expected_count);
}

std::string sol_text(std::span<const double> values, int components, int dimension) {
    TextWriter out(20 * values.size() + 128);
    out << header_of(dimension) << "\nSolAtVertices\n" << values.size() / components;
    out << (components == 1 ? "\n1 1\n\n" : "\n1 3\n\n");
    for (std::size_t i = 0; i < values.size(); ++i) out << values[i] << ((i + 1) % components == 0 ? '\n' : ' ');
    out << "\nEnd\n";
    return out.take();
}

std::string sol_binary(std::span<const double> values, int components, int dimension) {
    const std::size_t size = 8 * values.size() + 128;
    BinarySections out(version_for(size), size, dimension);
    out.begin_entries(Keyword::SolAtVertices, values.size() / components, 8 * components, 8);
    out.integer(1);
    out.integer(components == 1 ? 1 : 3);
    for (const double value : values) out.real(value);
    return out.take();
}

}  // namespace gradus::io
