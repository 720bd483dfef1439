// Wavefront OBJ: `v` and `f` are read, with negative indices, v/vt/vn forms and lines continued by a backslash; the rest is
// passed over.
#include <cstdlib>
#include <limits>

#include "formats.hpp"
#include "scanner.hpp"
#include "polygons.hpp"
#include "text_writer.hpp"

namespace gradus::io {
namespace {

class ObjReader {
  public:
    ObjReader(const std::string& path, std::string_view text) : path_(path), in_(path, text, '#', true) {}

    TriangleSoup read() {
        for (; in_.remaining() > 0; in_.next_line()) {
            if (in_.at_line_end()) continue;
            const char* word = in_.position();
            if (!is_space_at(word + 1)) continue;  // vt, vn, usemtl ...
            if (*word == 'v') read_vertex();
            if (*word == 'f') read_face();
        }
        if (soup_.points.empty()) in_.fail_at(in_.position(), "has no vertex (no line `v x y z`)");
        if (largest_ >= soup_.points.size())
            in_.fail_at(largest_where_,
                        "vertex " + std::to_string(largest_ + 1) + " out of range; there are " + std::to_string(soup_.points.size()));
        clip_ears(path_, soup_, fans_);
        return std::move(soup_);
    }

  private:
    bool is_space_at(const char* at) const { return at == in_.position() + in_.remaining() || is_space(*at) || *at == '\\'; }

    void read_vertex() {
        in_.advance(1);
        Eigen::Vector3d point;
        for (int i = 0; i < 3; ++i) {
            in_.at_line_end();
            point[i] = in_.real_here("a coordinate");
        }
        // A weight or a colour may follow.
        while (!in_.at_line_end()) in_.real_here("a number");
        soup_.points.push_back(point);
    }

    void read_face() {
        in_.advance(1);
        const char* start = in_.position();
        int first = 0, previous = 0, corners = 0;
        while (!in_.at_line_end()) {
            const int vertex = read_corner();
            if (corners == 0) first = vertex;
            if (corners > 1) soup_.triangles.push_back({first, previous, vertex});
            previous = vertex;
            ++corners;
        }
        if (corners > 3) fans_.push_back({soup_.triangles.size() - static_cast<std::size_t>(corners - 2), static_cast<std::size_t>(corners - 2)});
        if (corners < 3) in_.fail_at(start, "a face needs at least 3 vertices, found " + std::to_string(corners));
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    int read_corner() {
        const char* where = in_.position();
        const char* const end = where + in_.remaining();
        const char* at = where;
        const std::int64_t index = read_index(at, end);
        for (int slashes = 0; slashes < 2 && at != end && *at == '/'; ++slashes) {
            ++at;
            const bool absent = slashes == 0 && at != end && *at == '/';
            if (!absent && (at == end || is_space(*at))) break;  // `1/` is written by some
            if (!absent) read_index(at, end);
        }
        if (at != end && !is_space(*at) && *at != '#' && *at != '\\') in_.fail_expected("a vertex of a face");
        in_.advance(static_cast<std::size_t>(at - where));
        return resolve(index, where);
    }

    std::int64_t read_index(const char*& at, const char* end) {
        const bool negative = at != end && *at == '-';
        if (negative || (at != end && *at == '+')) ++at;
        const char* first = at;
        std::int64_t value = 0;
        for (; at != end && *at >= '0' && *at <= '9'; ++at)
            if (value <= std::numeric_limits<int>::max()) value = 10 * value + (*at - '0');
        if (at == first) in_.fail_expected("a vertex of a face");
        return negative ? -value : value;
    }

    /// From 1 on, or from -1 backwards from the last vertex so far. Vertices may come later: compared at the end.
    int resolve(std::int64_t index, const char* where) {
        const auto n = static_cast<std::int64_t>(soup_.points.size());
        const std::int64_t vertex = index < 0 ? n + index : index - 1;
        if (index == 0 || vertex < 0 || vertex > std::numeric_limits<int>::max() - 1)
            in_.fail_at(where, "vertex " + std::to_string(index) + " out of range; there are " + std::to_string(n) + " so far");
        if (vertex >= n && static_cast<std::size_t>(vertex) > largest_) {
            largest_ = static_cast<std::size_t>(vertex);
            largest_where_ = where;
        }
        return static_cast<int>(vertex);
    }

    const std::string& path_;
    Scanner in_;
    TriangleSoup soup_;
    std::vector<Fan> fans_;
    std::size_t largest_ = 0;  ///< largest vertex used before it was there
    const char* largest_where_ = nullptr;
};

}  // namespace

TriangleSoup parse_obj(const std::string& path, std::string_view text) { return ObjReader(path, text).read(); }

std::string obj_text(const TriangleSoup& soup) {
    TextWriter out(64 * soup.points.size() + 32 * soup.triangles.size());
    for (const Eigen::Vector3d& p : soup.points) out << "v " << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
    for (const auto& [a, b, c] : soup.triangles) out << "f " << a + 1 << ' ' << b + 1 << ' ' << c + 1 << '\n';
    return out.take();
}

}  // namespace gradus::io
