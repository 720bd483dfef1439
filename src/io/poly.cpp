// Shewchuk's .poly: points, segments, holes and regions of a planar domain; its points may be in the .node file beside
// it.
#include <cmath>
#include <filesystem>
#include <limits>

#include "formats.hpp"
#include "gradus/io/error.hpp"
#include "gradus/io/input_file.hpp"
#include "gradus/plane/planar_graph.hpp"
#include "scanner.hpp"

namespace gradus::io {
namespace {

// The rest of a line, as many numbers as there are.
void pass_line(Scanner& in) {
    while (!in.at_line_end()) in.real_here("a number");
}

class PolyReader {
  public:
    PolyReader(const std::string& path, std::string_view text) : path_(path), in_(path, text, '#') {}

    PlanarGraph read() {
        const char* const start = (in_.at_end(), in_.position());
        if (const std::size_t points = read_points_header(in_); points > 0) {
            read_points(in_, points);
        } else {
            const std::string beside = std::filesystem::path(path_).replace_extension(".node").string();
            if (!std::filesystem::exists(beside)) in_.fail_at(start, "has no points, and there is no " + beside);
            const std::string text = read_file(beside);
            Scanner nodes(beside, text, '#');
            read_points(nodes, read_points_header(nodes));
        }
        read_segments();
        graph_.holes.emplace();
        if (in_.at_end()) return std::move(graph_);
        read_holes();
        if (!in_.at_end()) read_regions();
        return std::move(graph_);
    }

  private:
    // "points dimension attributes markers"
    std::size_t read_points_header(Scanner& in) {
        const std::size_t count = in.count("the number of points", 3);
        if (in.integer_in_line("the dimension") != 2) in.fail("the dimension must be 2");
        pass_line(in);
        return count;
    }

    // "number x y ...": attributes and markers are passed over.
    void read_points(Scanner& in, std::size_t count) {
        for (std::size_t i = 0; i < count; ++i) {
            in.at_end();
            const char* const where = in.position();
            const std::int64_t number = in.integer_in_line("the number of a point");
            if (i == 0 && (number == 0 || number == 1)) graph_.first_number = static_cast<int>(number);
            if (number != static_cast<std::int64_t>(i) + graph_.first_number)
                in.fail_at(where, "points must be numbered one after the other, from 0 or 1");
            const double x = in.real_in_line("x");
            graph_.points.emplace_back(x, in.real_in_line("y"));
            pass_line(in);
        }
    }

    int read_point(const char* what) {
        in_.at_line_end();
        const char* const where = in_.position();
        const std::int64_t number = in_.integer_here(what) - graph_.first_number;
        if (number < 0 || number >= std::ssize(graph_.points))
            in_.fail_at(where, "point " + std::to_string(number + graph_.first_number) + " out of range; there are " +
                                   std::to_string(graph_.points.size()));
        return static_cast<int>(number);
    }

    // "number a b marker"
    void read_segments() {
        const std::size_t count = in_.count("the number of segments", 5);
        const bool has_markers = !in_.at_line_end() && in_.integer_here("whether there are markers") > 0;
        for (std::size_t i = 0; i < count; ++i) {
            in_.at_end();
            in_.integer_in_line("the number of a segment");
            const int a = read_point("a point of a segment"), b = read_point("a point of a segment");
            graph_.segments.push_back({a, b});
            if (has_markers) graph_.labels.push_back(in_.int_in_line("a marker"));
            pass_line(in_);
        }
    }

    void read_holes() {
        const std::size_t count = in_.count("the number of holes", 5);
        for (std::size_t i = 0; i < count; ++i) {
            in_.at_end();
            in_.integer_in_line("the number of a hole");
            const double x = in_.real_in_line("x");
            graph_.holes->emplace_back(x, in_.real_in_line("y"));
            pass_line(in_);
        }
    }

    // "number x y label area": largest areas are for other programs.
    void read_regions() {
        const std::size_t count = in_.count("the number of regions", 7);
        for (std::size_t i = 0; i < count; ++i) {
            in_.at_end();
            in_.integer_in_line("the number of a region");
            const double x = in_.real_in_line("x"), y = in_.real_in_line("y");
            const char* const where = in_.position();
            const double label = in_.real_in_line("a label");
            if (std::abs(label) > std::numeric_limits<int>::max() || label != std::trunc(label))
                in_.fail_at(where, "the label of a region must be a whole number");
            graph_.regions.push_back({{x, y}, static_cast<int>(label)});
            pass_line(in_);
        }
    }

    const std::string& path_;
    Scanner in_;
    PlanarGraph graph_;
};

}  // namespace

TriangleSoup triangulated(const std::string& path, const PlanarGraph& graph) {
    try {
        return triangulate(graph, InnerPoints::Added);
    } catch (const std::invalid_argument& error) {
        throw IoError(path, 0, error.what());
    }
}

TriangleSoup parse_poly(const std::string& path, std::string_view text) {
    return triangulated(path, PolyReader(path, text).read());
}

}  // namespace gradus::io
